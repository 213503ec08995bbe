//! Foreshortening and the floor of n_z near silhouettes: on a ball with a closed-form answer, and on the frame itself.

use super::Measuring;
use crate::Result;
use crate::frame::Frame;
use crate::params::{Scale, ShapeParams, Solver};
use crate::plan::Goal;
use crate::report::compare::{Errors, Tally};
use crate::report::engine::layers;
use crate::report::scenes::{RIM_RADIUS, Scene, ball_trace};
use crate::report::timing;
use serde::Serialize;

/// Foreshortenings tried.
pub(crate) const FORESHORTENINGS: [f32; 4] = [0.0, 0.4, 1.0, 2.0];
/// Floors of n_z tried.
pub(crate) const FLOORS: [f32; 4] = [0.02, 0.05, 0.1, 0.2];
/// Bands of n_z, from the rim inward; adjacent bands share a bound.
pub(crate) const BANDS: [f64; 7] = [0.03, 0.05, 0.08, 0.12, 0.2, 0.35, 0.6];

/// Error on the ball by band of n_z.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct BallRow {
    pub foreshortening: f32,
    pub min_nz: f32,
    /// Error of the undiffused trace relative to the closed form, one per band of [`BANDS`].
    pub bands: Vec<Errors>,
}

/// Results of one pair of foreshortening and floor on the frame.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct FrameRow {
    pub foreshortening: f32,
    pub min_nz: f32,
    pub steepest: f64,
    /// Applications of the operator needed for the tolerance.
    pub applications: usize,
    /// Error of the diffused gradient, relative to the largest |g|.
    pub gradient: Errors,
    /// How far it exceeds its range before diffusion, relative to the same.
    pub overshoot: f64,
}

/// All pairs of a foreshortening and a floor.
fn pairs() -> impl Iterator<Item = (f32, f32)> {
    FORESHORTENINGS
        .into_iter()
        .flat_map(|f| FLOORS.map(|floor| (f, floor)))
}

/// Errors on the rim of the ball.
pub(crate) fn on_ball() -> Result<Vec<BallRow>> {
    let frame = Scene::rim().frame;
    pairs()
        .map(|(foreshortening, min_nz)| {
            let shape = ShapeParams {
                foreshortening,
                min_nz,
                scale: Scale::Iterations(0),
                ..ShapeParams::default()
            };
            let found = layers(&frame, shape)?;
            let mut tallies: Vec<_> = BANDS[1..].iter().map(|_| Tally::default()).collect();
            // The rim's own pixels are a silhouette, and flat by definition; at the picture's border rows repeat.
            for (x, y) in (1..32).flat_map(|y| (1..1023).map(move |x| (x, y))) {
                let nz = f64::from(frame.normal.z.at(x, y));
                let band = BANDS.windows(2).position(|b| b[0] <= nz && nz < b[1]);
                if let (Some(band), true) = (band, found.conductance.at(x, y) == 1.0) {
                    let exact = ball_trace(RIM_RADIUS, nz, f64::from(foreshortening));
                    tallies[band].add([x, y], 2.0 * f64::from(found.mean.at(x, y)) / exact - 1.0);
                }
            }
            let bands = tallies.into_iter().map(Tally::errors).collect();
            Ok(BallRow {
                foreshortening,
                min_nz,
                bands,
            })
        })
        .collect()
}

/// Errors on `frame` at the scale and tolerance of `shape`, by expansion: the steeper the slopes, the tighter its
/// relative tolerance.
pub(crate) fn on_frame(frame: &Frame, shape: &ShapeParams) -> Result<Vec<FrameRow>> {
    let scale = Scale::Sigma(shape.scale_px() as f32);
    pairs()
        .map(|(foreshortening, min_nz)| {
            let shape = ShapeParams {
                foreshortening,
                min_nz,
                scale,
                solver: Solver::Chebyshev,
                ..*shape
            };
            let measuring = Measuring::new(frame, shape)?;
            let gradient = layers(frame, shape)?.gradient;
            let plan = timing::plan(Goal::Layers, frame, shape)?;
            Ok(FrameRow {
                foreshortening,
                min_nz,
                steepest: measuring.steepest,
                applications: plan.sweeps.count(),
                gradient: measuring.gradient_errors(&gradient, &measuring.diffused(scale)),
                overshoot: measuring.overshoot(&gradient),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn above_its_floor_the_ball_is_met_and_below_it_flattened() {
        let rows = on_ball().unwrap();
        for row in &rows {
            assert_eq!(row.bands.len(), BANDS.len() - 1);
            for (band, errors) in BANDS.windows(2).zip(&row.bands) {
                assert!(
                    errors.pixels > 20 && errors.non_finite == 0,
                    "{band:?} {errors:?}"
                );
                // One pixel more than the floor's own band, for the three columns of the derivative.
                // Truncation: (1 / R n_z^2)^2 per pixel^2, times a factor of the fourth derivative.
                if band[0] >= 2.0 * f64::from(row.min_nz) {
                    let f = f64::from(row.foreshortening);
                    let truncation = (1.0 + f).powi(4) / (RIM_RADIUS * band[0].powi(2)).powi(2);
                    assert!(errors.max < truncation + 0.02, "{row:?} {band:?}");
                }
                // Entirely below the floor the slope grows only like n_xy: by far too little.
                if band[1] <= 0.8 * f64::from(row.min_nz) && row.foreshortening >= 1.0 {
                    assert!(errors.mean > 0.5, "{row:?} {band:?}");
                }
            }
        }
        // Without foreshortening the floor has no effect.
        let spread: Vec<_> = rows[..4].iter().map(|row| row.bands[0].mean).collect();
        assert!(spread.iter().all(|&e| e == spread[0]));
    }
}
