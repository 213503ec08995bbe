//! The table of twins.

use super::domains::*;
use super::twin::{Tolerance, Twin};
use super::words::UNSPECIFIED;
use crate::fast_math::circular::{ATAN, rest_of_tangent};
use crate::fast_math::exponential::{EXP, LN, split_exp};
use crate::fast_math::{self, polynomial, power_of_two};
use crate::frame::luminance;
use crate::frame::sampling::{finer_side, lattice_place, scattered};
use crate::frame::{Projection, SightLines};
use crate::light::batch::BATCH;
use crate::light::brdf::{
    self, AshikhminShirley, Cosines, entering, fifth_power, passed, share_seen,
};
use crate::light::cosines::{at_most_1, positive, scalar_product};
use crate::light::environment::equirectangular_position;
use crate::light::light_warping::{
    MOST_BRIGHTENED, SIXTH, Warp, bounded_entry, contrast, half_vector, scale_factor,
};
use crate::light::radiance_scaling::{ScalingCurve, scaled, scaling};
use crate::light::relight::gpu::RELIGHT;
use crate::light::relight::shade::premultiplied;
use crate::light::sum::exponent::Exponent;
use crate::light::sum::terms;
use crate::light::texels::mixed;
use crate::light::tones::tone_factor;
use crate::line::hatching::gpu::{PICTURE_STROKES, STROKES};
use crate::line::hatching::share;
use crate::line::normal_rays::gpu::NORMAL_RAYS;
use crate::line::normal_rays::{Difference, Local, NormalRay, Slopes};
use crate::line::slice_texture::{mix, within};
use crate::line::stroke_texture::{ramp_between, ramp_of};
use crate::line::texture_coordinates::{
    in_texture, is_joined, is_one_depth, is_one_motion, jacobian, slope,
};
use crate::params::{Quantisation, ShapeParams, SoftThreshold};
use crate::shape::auto_levels::gpu::{COUNT, NARROW, key_of, value_of};
use crate::shape::conductance::face_conductance;
use crate::shape::crease::{CreaseDetector, angle_within};
use crate::shape::curvature::gpu::{CURVATURES, HESSIAN};
use crate::shape::curvature::{
    mapped_curvature, mapped_curvature_toward, principal_curvatures, principal_direction,
};
use crate::shape::diffusion::gpu::DIFFUSION;
use crate::shape::diffusion::{Update, flux, through};
use crate::shape::edges::gpu::EDGES;
use crate::shape::gradient::{depth_gradient, facing};
use crate::shape::hessian::{fitted, in_the_open, plane_fit};
use crate::shape::silhouette::jump_weight;
use crate::shape::sobel;
use glam::{DVec2, DVec3, Vec3};

/// A pair: the name in WGSL, the path of the Rust function, checked by the compiler, and a kernel that contains the
/// WGSL.
macro_rules! twin {
    ($name:ident, $path:path, $kernel:ident, $rust:expr) => {{
        let _ = $path;
        Twin::new(stringify!($name), stringify!($path), &$kernel, $rust)
    }};
}

mod light;
mod line;
mod shape;

/// All pairs.
pub(super) fn twins() -> Vec<Twin> {
    let rooms = [shape::twins(), light::twins(), line::twins()];
    rooms.into_iter().flatten().collect()
}
