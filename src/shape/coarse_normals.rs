//! Normals of the form under the detail: at several scales, by diffusion that stops at edges.
//!
//! A normal is two numbers here: its place in Lambert's azimuthal map of equal areas (J. H. Lambert: Anmerkungen und
//! Zusätze zur Entwerfung der Land- und Himmelscharten, 1772) about the direction to the viewer. They spread as slopes do,
//! in two thirds of the time that three components take. Up to 60 degrees from the viewer the map stretches distances by
//! 15 % at most, so the mean of places is near that of directions; slopes grow without bound toward silhouettes, and
//! components alone would turn a slanted rough surface to the viewer.

use crate::frame::rows::ROWS_PER_TASK;
use crate::frame::{Vector2Planes, Vector3Planes, parallel_rows};
use crate::params::MAX_SIGMA_PX;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::shape::diffusion::stage::spread;
use crate::shape::diffusion::sweeps::DiffusionSchedule;
use crate::shape::edges::stage::EDGES;
use rayon::prelude::*;

/// Largest error of a place: a tenth of a degree.
const TOLERANCE: f64 = 2e-3;

/// The least 1 + n_z: behind it, places stay on their side.
const FARTHEST: f32 = 1e-6;

/// The place of a unit normal in the map.
#[inline(always)]
fn place_of([x, y, z]: [f32; 3]) -> [f32; 2] {
    let scale = (2.0 / (1.0 + z).max(FARTHEST)).sqrt();
    [scale * x, scale * y]
}

/// The unit normal at a place of the map.
#[inline(always)]
pub(crate) fn normal_at([x, y]: [f32; 2]) -> [f32; 3] {
    let square = x * x + y * y;
    let scale = (1.0 - 0.25 * square).max(0.0).sqrt();
    [scale * x, scale * y, 1.0 - 0.5 * square]
}

/// The sweeps that spread normals to these sigmas, in pixels of the reference.
pub(crate) fn sweeps(plan: &Plan, sigmas_px: &[f32]) -> DiffusionSchedule {
    let factor = plan.resolution_factor as f32;
    let sigmas = sigmas_px
        .iter()
        .map(|sigma| (factor * sigma).min(MAX_SIGMA_PX));
    DiffusionSchedule::to_sigmas(&sigmas.collect::<Vec<_>>(), TOLERANCE)
}

/// The places of the normals at each of these scales, sigmas in pixels of the reference.
pub(crate) fn coarse_normals(
    run: &mut Execution,
    normal: &Vector3Planes,
    sigmas_px: &[f32],
) -> Vec<Vector2Planes> {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let key = format!(
        "{} {sigmas_px:?} {}",
        plan.key(EDGES.name),
        plan.resolution_factor
    );
    run.copied_or(NAME, Some(&key), |run| {
        let places = places(normal, memory.vectors(&frame.mask));
        spread(run, NAME, places, &sweeps(plan, sigmas_px))
    })
}

/// Its name in timings and in a session.
const NAME: &str = "coarse-normals";

fn places(normal: &Vector3Planes, mut places: Vector2Planes) -> Vector2Planes {
    parallel_rows([&mut places.x, &mut places.y])
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(y, [to_x, to_y])| {
            let from = [&normal.x, &normal.y, &normal.z].map(|plane| plane.row(y));
            for x in 0..to_x.len() {
                [to_x[x], to_y[x]] = place_of([from[0][x], from[1][x], from[2][x]]);
            }
        });
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_place_is_that_of_one_normal() {
        for i in 0..1000 {
            let (turn, z) = (2.4 * i as f32, 1.0 - 1.9 * i as f32 / 1000.0);
            let across = (1.0 - z * z).sqrt();
            let n = Vec3::new(across * turn.cos(), across * turn.sin(), z);
            let back = Vec3::from_array(normal_at(place_of(n.to_array())));
            assert!((back - n).length() < 2e-6, "{n}");
        }
        assert_eq!(normal_at(place_of([0.0, 0.0, 1.0])), [0.0, 0.0, 1.0]);
        let behind = normal_at(place_of([0.0, 0.0, -1.0]));
        assert!(behind.iter().all(|c| c.is_finite()));
    }

    #[test]
    fn the_mean_of_slanted_normals_stays_slanted() {
        // Facets at 30 and 90 degrees lie at 2 sin 15 and 2 sin 45: their mean at 2 sin 28.9, a normal of 57.8 degrees. That
        // of components, 0.5 and 1, would be asin(.75), 48.6.
        let facet =
            |degrees: f32| place_of([degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()]);
        let mean = 0.5 * (facet(30.0)[0] + facet(90.0)[0]);
        let [x, _, z] = normal_at([mean, 0.0]);
        assert!((x.atan2(z).to_degrees() - 57.77).abs() < 0.02);
    }
}
