//! Directions of the surface's own curvature: the distance between the normals compared, and their rounding.

use super::precision::{Stored, rounded};
use crate::Result;
use crate::frame::Vector2Planes;
use crate::params::{Adaptive, Scale, ShapeParams};
use crate::plan::Goal;
use crate::report::asked::On;
use crate::report::compare::{Angles, Tally, pixels};
use crate::report::engine::Layers;
use crate::report::scenes::Scene;
use crate::report::scenes::angle_deg;
use crate::report::timing::{self, Effort, Times, measure};
use glam::DVec2;
use serde::Serialize;

/// Steps tried, in pixels, besides the automatic one.
pub(crate) const STEPS_PX: [u8; 5] = [1, 2, 4, 8, 16];

/// Results of one step for normals of one rounding.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct DirectionRow {
    pub stored: Stored,
    /// The given step, in pixels; `None` for the automatic one.
    pub step_px: Option<u8>,
    /// The smallest and largest step used, in pixels.
    pub steps_px: [usize; 2],
    /// Errors.
    #[serde(flatten)]
    pub error: Angles,
    pub stage: Times,
    pub megapixels_per_second: f64,
}

/// All steps and roundings on one scene.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Sweep {
    #[serde(flatten)]
    pub on: On,
    pub about: String,
    /// Number of pixels compared, with known directions.
    pub pixels: usize,
    pub rows: Vec<DirectionRow>,
}

/// Tries every step on `scene` with normals of every rounding.
pub(crate) fn sweep(scene: &Scene, effort: Effort) -> Result<Sweep> {
    let mask = &scene.frame.mask;
    let mut sweep = Sweep {
        on: On::new(scene.name, mask),
        about: scene.about.into(),
        pixels: 0,
        rows: Vec::new(),
    };
    let steps = STEPS_PX.map(Some).into_iter().chain([None]);
    let tried = Stored::ALL
        .into_iter()
        .flat_map(|stored| steps.clone().map(move |step| (stored, step)));
    for (stored, step_px) in tried {
        let frame = rounded(&scene.frame, stored);
        let shape = ShapeParams {
            scale: Scale::Iterations(0),
            direction_step: step_px.map_or(Adaptive::Auto, |px| Adaptive::Fixed(px.into())),
            ..ShapeParams::default()
        };
        let plan = timing::plan(Goal::Layers, &frame, shape)?;
        let (outcome, timed) = measure(&plan, &frame, effort);
        let tally = angles(scene, &Layers::of(outcome).direction);
        sweep.pixels = tally.pixels();
        let stage = timed.stage("normal-rays").expect("layers take normal rays");
        sweep.rows.push(DirectionRow {
            stored,
            step_px,
            steps_px: plan.direction_steps_px,
            error: Angles::of(tally),
            stage,
            megapixels_per_second: stage.megapixels_per_second(mask.width() * mask.height()),
        });
    }
    Ok(sweep)
}

/// Angles in degrees between found and exact directions, where these are known.
fn angles(scene: &Scene, found: &Vector2Planes) -> Tally {
    let mut tally = Tally::default();
    for [x, y] in pixels(&found.x) {
        if let Some(exact) = scene.exact_direction(x, y) {
            tally.add([x, y], angle_deg(vector_at(found, [x, y]), exact));
        }
    }
    tally
}

/// The vector of a field at a pixel.
pub(crate) fn vector_at(field: &Vector2Planes, [x, y]: [usize; 2]) -> DVec2 {
    DVec2::new(field.x.at(x, y).into(), field.y.at(x, y).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_directions_are_the_same_and_none_is_wrong() {
        let [x, up] = [DVec2::X, DVec2::Y];
        let turned = DVec2::from_angle(0.1);
        for (found, exact, angle) in [
            (x, -x, 0.0),
            (x, up, 90.0),
            (-turned, x, 0.1_f64.to_degrees()),
            (DVec2::ZERO, x, 90.0),
        ] {
            assert!((angle_deg(found, exact) - angle).abs() < 1e-12, "{found}");
        }
    }
}
