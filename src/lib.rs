//! relievo brings out the shape of surfaces in pictures, from images alone.
//!
//! A [`frame::Frame`] is a surface seen from one viewpoint: view-space normals and, if available, depth, a mask, a camera
//! and the picture. [`Frame::builder`](frame::Frame::builder) makes one from samples in memory, [`io::load`] from a
//! renderer's layers or from a photo with its normal map. A [`engine::Request`] names the result wanted, with the
//! [`params::Params`] of the command line; an
//! [`engine::Engine`] computes it on the CPU or a GPU, and an [`engine::Session`] repeats it on one frame as parameters
//! change. A [`plan::Plan`] lists the stages that a request needs, and why.
//!
//! From slices to a picture, with the shape of a ball brought out:
//!
//! ```
//! use relievo::engine::{Engine, Request, Run};
//! use relievo::frame::{Frame, Normals};
//! use relievo::params::Params;
//!
//! # fn main() -> relievo::Result<()> {
//! let (width, height) = (64, 64);
//! let mut normals = vec![0.0_f32; 3 * width * height];
//! let mut rgb = vec![0.0_f32; 3 * width * height];
//! for i in 0..width * height {
//!     let (x, y) = ((i % width) as f32 / 32.0 - 1.0, 1.0 - (i / width) as f32 / 32.0);
//!     let z = (1.0 - x * x - y * y).max(0.0).sqrt();
//!     if z > 0.0 {
//!         normals[3 * i..][..3].copy_from_slice(&[x, y, z]);
//!         rgb[3 * i..][..3].fill(z);
//!     }
//! }
//!
//! # std::env::set_current_dir(std::env::temp_dir()).unwrap();
//! let frame = Frame::builder(width, height)
//!     .normals(Normals::view(&normals))
//!     .color(&rgb)
//!     .build()?;
//! let request = Request::enhance(Params::default());
//! let outcome = Engine::auto().run(&request, &frame, &Run::new())?;
//! let picture = outcome.picture().expect("enhancing gives a picture");
//! outcome.save("enhanced.png", &frame)?; // or .exr; of a drawing also .svg
//!
//! let red = picture.r.view(); // an ndarray view, [row, column]
//! assert!(red[[32, 32]] > rgb[3 * (32 * width + 32)]); // convex: brighter
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//!
//! `default-features = false` leaves the library: no command line (`cli`). `scenes` has surfaces with exact answers. `gpu`
//! adds the wgpu backend, `view` the window, `libdeflate` a quicker ZIP in C, `host` the commands of the command line on
//! frames in memory, for programs that offer them in turn.
//!
//! # Conventions
//!
//! View space has x right, y **up** and z toward the viewer; rows of a picture run down. Curvature is
//! per pixel, or per pixel of a [reference height](params::ShapeParams::reference_height). In the
//! Hessian and its eigenvalues convex is **negative** ([LW]); the mapped curvature kappa in -1..1 is
//! **positive** where convex ([RS]), and [`shape::curvature::mapped_curvature`] is the only place where
//! the sign flips. Directions are modulo pi.
//!
//! Data flow one way, `io -> frame -> shape -> {light, line} -> io`; `plan` decides, `engine` runs. The public functions of
//! [`shape`], [`light`] and [`line`] take one pixel's samples and can be called from any renderer. [`trace`] follows sight
//! lines through mirrors and lenses, for light and lines alike. With the feature `scenes`, [`scenes`] has surfaces
//! with exact answers, to test other implementations against.
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
//! - **\[Sec\]** A. Secord: *Weighted Voronoi Stippling*. Non-Photorealistic Animation and Rendering, 2002.
//!   <https://doi.org/10.1145/508530.508537>
//! - **\[FS\]** R. W. Floyd, L. Steinberg: *An Adaptive Algorithm for Spatial Greyscale*. Proceedings of the Society
//!   for Information Display 17(2), 1976.
//! - **\[CM\]** J. Friedman, A. C. Jones: *Fully Automatic ID Mattes with Support for Motion Blur and Transparency*.
//!   SIGGRAPH 2015 posters. <https://github.com/Psyop/Cryptomatte>
//! - **\[MC\]** P. Debevec: *A Median Cut Algorithm for Light Probe Sampling*. SIGGRAPH 2005 posters.
//!   <https://vgl.ict.usc.edu/Research/MedianCut/>

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
mod command;
pub mod engine;
pub mod error;
pub mod frame;
#[cfg(feature = "gpu")]
mod gpu;
#[cfg(feature = "host")]
pub mod host;
pub mod io;
mod kernel;
pub mod light;
pub mod line;
pub mod params;
pub mod plan;
pub mod product;
#[cfg(feature = "cli")]
mod report;
#[cfg(any(test, feature = "scenes"))]
pub mod scenes;
pub mod shape;
mod srgb;
mod stages;
pub mod trace;
mod untrusted;
#[cfg(feature = "view")]
pub mod view;
#[cfg(feature = "cli")]
mod work;

pub use error::{Error, Result};
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub use stages::kernels::kernel_sources;
