//! Parameters of the surface's own curvature directions, the same on every backend.

use crate::frame::{Frame, Plane, SightLines};
use crate::line::normal_rays::ROUNDING_DEVIATION;
use crate::plan::{Plan, Points};

/// Factor to the next step after one that found no direction.
pub(crate) const STEP_GROWTH: usize = 4;

/// Largest rounding error of an f32 of size 1, as a share of it.
const F32_ROUNDING: f64 = f32::EPSILON as f64 / 2.0;

/// Settings for normal rays in a frame.
pub(crate) struct RaySetting<'a> {
    pub(crate) sight: SightLines,
    /// Depth, where points are taken from it.
    pub(crate) depth: Option<&'a Plane>,
    /// Deviation of a component of a normal.
    pub(crate) normal_noise: f64,
    /// Deviation of a point, as a share of its depth.
    pub(crate) offset_noise: f64,
    /// The least and the greatest step.
    pub(crate) steps_px: [usize; 2],
}

impl<'a> RaySetting<'a> {
    pub(crate) fn new(plan: &Plan, frame: &'a Frame) -> Self {
        let depth = match plan.points {
            Points::Depth => frame.depth.as_ref(),
            Points::Normals => None,
        };
        let rounding = f64::from(frame.source.normal_rounding);
        Self {
            sight: SightLines::of(frame),
            depth,
            normal_noise: ROUNDING_DEVIATION * rounding.max(F32_ROUNDING),
            // A point is off by its depth's rounding.
            offset_noise: ROUNDING_DEVIATION * F32_ROUNDING,
            steps_px: plan.direction_steps_px,
        }
    }
}
