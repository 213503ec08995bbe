//! Parameters of the field of stroke directions.

use crate::frame::{DepthKind, Frame, Projection, SightLines};
use crate::line::direction::{fixed_direction, fixed_second_direction};
use crate::line::direction_field::halved;
use crate::line::normal_rays::ROUNDING_DEVIATION;
use crate::params::{Fallback, FieldParams};
use crate::plan::Plan;
use glam::{DVec3, Vec2};

/// Conductance of an open pixel, at least: the middle of the soft steps of silhouettes and creases.
pub(crate) const OPEN: f32 = 0.5;

/// Distance over which curvature tensors are averaged before directions are taken from them, in pixels of a field of a
/// quarter of the picture's size: facets and the rounding of normals cancel there, with their signs. More rounds off
/// shapes of that size.
pub(crate) const FORM_REACH: f32 = 2.5;

/// Turn of the normal, in radians per pixel, that counts half: 17 degrees over a thousand pixels.
const FLAT_TURN: f64 = 3e-4;

/// Pixels over which the turn of normals is measured, for any size of cells: the distance over which tensors are
/// averaged.
const TURN_PX: f64 = 8.0;

/// Standard deviations of the noise of curvature, measured over as many pixels, that count half.
const NOISE: f64 = 3.0;

/// Cosine between normal and sight line below which directions, foreshortened, count less.
pub(crate) const FACING: f64 = 0.35;

/// Confidence of the fallback where curvature gives no direction, and the confidence of curvature from which the
/// fallback does not bend it. Higher values bend more; lower ones follow rounding over a ball.
pub(crate) const FALLBACK: f32 = 0.005;
pub(crate) const FREE: f32 = 4.0 * FALLBACK;

/// Reach of the surroundings that lead where directions disagree, as a multiple of that of a pass, and their number of
/// passes.
pub(crate) const SURROUNDINGS: f32 = 4.0;
pub(crate) const SURROUNDING_PASSES: u32 = 2;

/// Largest and smallest factor by which depth changes the radius.
pub(crate) const NEAR: f32 = 2.0;
pub(crate) const FAR: f32 = 0.25;

/// Distance over which pixels in no patch, on edges and in specks between them, take directions from their neighbours,
/// in pixels: several times the widest of both. Beyond it the fallback is used.
pub(crate) const REST_REACH_PX: usize = 32;

/// Settings for computing a field in a frame.
pub(crate) struct FieldSetting {
    /// The fallback if it is constant, and its perpendicular.
    pub(crate) fixed: Option<[Vec2; 2]>,
    pub(crate) sight: SightLines,
    /// Pixels per unit of length, at a distance of 1 in perspective.
    pub(crate) pixels: f64,
    /// Cells of the field per pixel of one of a quarter of the reference's size.
    pub(crate) cells: f32,
    /// The turn of normals, in radians per pixel, that counts half.
    pub(crate) doubt: f64,
    /// Whether the radius is inversely proportional to depth.
    pub(crate) is_by_depth: bool,
}

impl FieldSetting {
    pub(crate) fn new(plan: &Plan, params: &FieldParams, frame: &Frame) -> Self {
        let projection = frame.camera.map(|camera| camera.projection);
        let is_parallel = |p| matches!(p, Projection::Orthographic { .. });
        let cell_px = f64::from(params.cell_px);
        let rounding = f64::from(frame.source.normal_rounding);
        let factor = plan.resolution_factor;
        let noise = NOISE * ROUNDING_DEVIATION * rounding / TURN_PX;
        let fixed = match params.fallback {
            Fallback::Angle(degrees) => {
                let first = Vec2::from_angle((degrees % 180.0).to_radians());
                Some([first, first.perp()])
            }
            Fallback::Surface => None,
        };
        Self {
            fixed,
            sight: SightLines::of(frame),
            pixels: projection.map_or(1.0, scale),
            cells: (4.0 * factor / cell_px) as f32,
            doubt: noise.hypot(FLAT_TURN / factor),
            is_by_depth: !projection.is_some_and(is_parallel)
                && frame.source.depth_kind != DepthKind::Relative,
        }
    }

    /// The fallback at a place, of the first field made or the second.
    pub(crate) fn fallback(&self, x: f64, y: f64, normal: DVec3, order: usize) -> Vec2 {
        match (self.fixed, order) {
            (Some(fixed), _) => fixed[order],
            (None, 0) => fixed_direction(normal, &self.sight, x, y),
            (None, _) => fixed_second_direction(normal, &self.sight, x, y),
        }
    }

    /// The setting on an object with a fallback of its `own`, as [`Frame::stroke_fallback`] holds it.
    pub(crate) fn on_object(&self, own: DVec3) -> Self {
        let twice = own.truncate().as_vec2();
        let fixed = match (own.z > 0.5, twice.length() > 0.5) {
            (true, _) => None,
            (false, true) => {
                let first = Vec2::from(halved(twice.to_array()));
                Some([first, first.perp()])
            }
            (false, false) => self.fixed,
        };
        Self { fixed, ..*self }
    }
}

/// Pixels per unit of length, at a distance of 1 in perspective.
fn scale(projection: Projection) -> f64 {
    match projection {
        Projection::Perspective { fx, fy, .. } => (fx * fy).abs().sqrt(),
        Projection::Orthographic { sx, sy, .. } => (sx * sy).abs().sqrt(),
    }
}
