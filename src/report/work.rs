//! Bytes and operations of an ideal pass, per covered pixel: the model for shares of bandwidth and arithmetic.
//!
//! Every plane that a stage needs is read once and every plane it produces is written once, 4 bytes per sample;
//! neighbours come from the cache. Additions, multiplications, comparisons, square roots and divisions count as one
//! operation, and a logarithm, power, sine or arc tangent as twenty.

use crate::params::ShapeParams;
use crate::shape::diffusion::sweeps::{DiffusionSchedule, Readout, Recurrence};

/// Bytes and operations per covered pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Work {
    /// Bytes moved between memory and the processor.
    pub bytes: f64,
    /// Operations.
    pub operations: f64,
}

/// Bytes of a sample.
const SAMPLE: f64 = 4.0;
/// Operations of a logarithm, power, sine or arc tangent.
const FUNCTION: f64 = 20.0;
/// Sobel's two derivatives: 4 additions and 2 multiplications each, a division, a difference.
const SOBEL: f64 = 16.0;
/// Flux into a sample: 4 differences, 4 products, 3 sums.
const FLUX: f64 = 11.0;

/// The work of the stage with the timing name `name`; `None` for a stage without a model.
pub(crate) fn of_stage(
    name: &str,
    shape: &ShapeParams,
    sweeps: &DiffusionSchedule,
) -> Option<Work> {
    let planes = |read: u32, written: u32, operations: f64| Work {
        bytes: SAMPLE * f64::from(read + written),
        operations,
    };
    let power = if [0.0, 1.0].contains(&shape.foreshortening) {
        1.0
    } else {
        FUNCTION
    };
    Some(match name {
        // Normal, length, depth; conductance and gradient. Six cosines of neighbouring normals, the logarithm
        // of depth and its Sobel slope.
        "edges-and-gradient" => planes(5, 3, 6.0 * 7.0 + FUNCTION + SOBEL + 15.0 + power),
        "diffusion" => of_diffusion(sweeps),
        // Gradient and conductance; two Sobel derivatives and their sum.
        "trace" => planes(3, 1, 2.0 * SOBEL + 8.0),
        "hessian" => planes(3, 3, 2.0 * SOBEL + 8.0),
        "curvatures" => planes(3, 3, 12.0),
        "directions" => planes(3, 2, 3.0 * FUNCTION + 8.0),
        // Normal, depth, conductance and direction; four rays in double precision and an eigenvector.
        "normal-rays" => planes(5, 2, 4.0 * 40.0 + 3.0 * FUNCTION),
        // Per scale as a Hessian, curvatures and their map.
        "more-scales" => planes(3, 4, 2.0 * SOBEL + 20.0 + FUNCTION),
        // Trace and conductance; a filter and a selection.
        "auto-gain" => planes(2, 0, 6.0),
        "display" => planes(2, 3, FUNCTION + 20.0),
        "radiance-scaling" => planes(4, 3, 2.0 * FUNCTION + 25.0),
        // For two lobes with direct light, indirect light and colour: 18 planes, the picture and the trace.
        "light-lobes" => planes(22, 3, 3.0 * FUNCTION + 90.0),
        // For two groups of one direction: 6 planes, the picture, the normal and the trace.
        "light-groups" => planes(13, 3, 3.0 * FUNCTION + 70.0),
        "ambient-occlusion" => planes(5, 3, 2.0 * FUNCTION + 20.0),
        "auto-white" => planes(3, 0, 8.0),
        _ => return None,
    })
}

/// Gradient and conductance are read and the result is written once, whatever the number of sweeps: the rows in flight
/// are in the cache. A link of the recurrence adds its term to the sum.
fn of_diffusion(sweeps: &DiffusionSchedule) -> Work {
    let operations = match sweeps.recurrence {
        Recurrence::Explicit(_) => FLUX + 2.0,
        Recurrence::Chebyshev => FLUX + 6.0,
    };
    let results = match &sweeps.readout {
        Readout::Sums(sums) => sums.len() as f64,
        Readout::Last | Readout::ByImportance(_) => 1.0,
    };
    let count = sweeps.count() as f64;
    Work {
        bytes: SAMPLE * (3.0 + 2.0 * results),
        operations: count * 2.0 * operations,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Scale, Solver};
    use crate::plan::Goal;
    use crate::report::engine::{Inputs, Session};
    use crate::report::{scenes::Scene, timing};

    #[test]
    fn diffusion_grows_with_the_sweeps() {
        let work = |count| {
            let shape = ShapeParams {
                scale: Scale::Iterations(count),
                solver: Solver::Explicit,
                ..ShapeParams::default()
            };
            let frame = Scene::waves(8, 8).frame;
            let plan = timing::plan(Goal::Display, &frame, shape).unwrap();
            of_stage("diffusion", &shape, &plan.sweeps).unwrap()
        };
        // g with two components in and out and the conductance: 5 planes of 4 bytes. Ten times two components with 11
        // operations for the flux, a product and a sum.
        assert_eq!((work(10).bytes, work(10).operations), (20.0, 260.0));
        assert_eq!(work(20).operations, 520.0);
    }

    #[test]
    fn every_stage_of_the_backend_has_a_model() {
        let frame = Scene::waves(8, 8).frame;
        for goal in [Goal::Layers, Goal::Display] {
            let plan = timing::plan(goal, &frame, ShapeParams::default()).unwrap();
            let outcome = Session::default().run(&plan, &frame, Inputs::default());
            for (name, _) in outcome.timings {
                assert!(
                    of_stage(name, &plan.shape, &plan.sweeps).is_some(),
                    "{name}"
                );
            }
        }
    }
}
