//! relievo brings out the shape of surfaces in pictures, from images alone.
//!
//! A [`frame::Frame`] is a surface seen from one viewpoint: view-space normals and, where there are
//! any, depth, a mask, a camera, and the picture made of it. [`io::load`] makes one of a renderer's
//! layers or of a photo with its normal map. A [`plan::Plan`] names the stages that a goal needs and no
//! others; [`backend::cpu::run`] runs it, and a [`backend::cpu::Runner`] runs many in the same memory.
//!
//! ```
//! use relievo::backend::cpu;
//! use relievo::io::{self, Needs, inputs::Inputs};
//! use relievo::params::{ScalingParams, ShapeParams};
//! use relievo::plan::{Available, Goal, Plan};
//!
//! # fn main() -> relievo::Result<()> {
//! let inputs = Inputs { picture: "fixtures/bust.exr".into(), ..Inputs::default() };
//! let frame = io::load(&inputs, Needs { color: true, ..Needs::default() })?.frame;
//! let plan = Plan::new(
//!     Goal::Enhance,
//!     Available::in_frame(&frame),
//!     ShapeParams::default(),
//!     ScalingParams::default(),
//! )?;
//! let enhanced = cpu::run(&plan, &frame).color.expect("enhancing gives a picture");
//! assert_eq!(enhanced.r.width(), 480);
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! View space has x right, y **up** and z toward the viewer; rows of a picture run down. Curvature is
//! per pixel, or per pixel of a [reference height](params::ShapeParams::reference_height). In the
//! Hessian and its eigenvalues convex is **negative** ([LW]); the mapped curvature kappa in -1..1 is
//! **positive** where convex ([RS]), and [`shape::curvature::mapped_curvature`] is the only place where
//! the sign turns. Directions are modulo pi.
//!
//! Data flow one way, `io -> frame -> shape -> {light, line} -> io`; `plan` decides, `backend` runs. The
//! kernels in [`shape`], [`light`] and [`line`] are plain functions of samples and rows, to be called
//! from any renderer. [`trace`] follows sight lines through mirrors and lenses, for light and lines alike.
//!
//! # References
//!
//! - **\[LW\]** R. Vergne, R. Pacanowski, P. Barla, X. Granier, C. Schlick: *Light Warping for Enhanced
//!   Surface Depiction*. ACM Transactions on Graphics 28(3), SIGGRAPH 2009.
//!   <https://doi.org/10.1145/1531326.1531331>
//! - **\[RS\]** R. Vergne, R. Pacanowski, P. Barla, X. Granier, C. Schlick: *Improving Shape Depiction
//!   under Arbitrary Rendering*. IEEE Transactions on Visualization and Computer Graphics 17(8), 2011.
//!   <https://doi.org/10.1109/TVCG.2010.252>
//! - **\[LA\]** Y. Kim, J. Yu, X. Yu, S. Lee: *Line-Art Illustration of Dynamic and Specular Surfaces*.
//!   ACM Transactions on Graphics 27(5), SIGGRAPH Asia 2008.
//!   <https://doi.org/10.1145/1409060.1409109>
//! - **\[JL\]** B. Jobard, W. Lefer: *Creating Evenly-Spaced Streamlines of Arbitrary Density*.
//!   Visualization in Scientific Computing, 1997. <https://doi.org/10.1007/978-3-7091-6876-9_5>
//! - **\[MC\]** P. Debevec: *A Median Cut Algorithm for Light Probe Sampling*. SIGGRAPH 2005 posters.
//!   <https://vgl.ict.usc.edu/Research/MedianCut/>

pub mod backend;
#[cfg(feature = "cli")]
pub mod cli;
pub mod error;
pub mod fast_math;
pub mod frame;
pub mod io;
pub mod light;
pub mod line;
pub mod params;
pub mod plan;
#[cfg(feature = "report")]
pub mod report;
pub mod shape;
pub mod trace;
#[cfg(feature = "view")]
pub mod view;

pub use error::{Error, Result};
