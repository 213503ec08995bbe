//! What an ideal pass would move and compute, per covered pixel: the model behind the shares of
//! bandwidth and arithmetic.
//!
//! Every plane that a stage needs is read once and every one that it makes is written once, 4 bytes a
//! sample; neighbours come from the cache. Additions, multiplications, comparisons and square roots count
//! as one operation, divisions as one, and a logarithm, power, sine or arc tangent as twenty.

use crate::params::ShapeParams;
use crate::plan::Sweeps;

/// Bytes and operations per covered pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Work {
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
/// What flows into a sample: 4 differences, 4 products, 3 sums.
const FLUX: f64 = 11.0;

/// The work of the stage that the backend times under `name`; `None` for one without a model.
pub fn of_stage(name: &str, shape: &ShapeParams, sweeps: &Sweeps) -> Option<Work> {
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
        // Normal, length, depth; two weights and the conductance. Four dihedral angles of a cross and a
        // dot product, a root and an arc tangent; the logarithm of depth and its Sobel slope.
        "edges" => planes(
            5,
            3,
            4.0 * (9.0 + 5.0 + 6.0 + FUNCTION) + FUNCTION + SOBEL + 10.0,
        ),
        "gradient" => planes(3, 2, 5.0 + power),
        "diffusion" => of_diffusion(sweeps),
        // Gradient and conductance; two Sobel derivatives and their sum.
        "trace" => planes(3, 1, 2.0 * SOBEL + 8.0),
        "hessian" => planes(3, 3, 2.0 * SOBEL + 8.0),
        "curvatures" => planes(3, 3, 12.0),
        "directions" => planes(3, 2, 3.0 * FUNCTION + 8.0),
        // Trace and conductance; a filter and a selection.
        "auto-gain" => planes(2, 0, 6.0),
        "display" => planes(2, 3, FUNCTION + 20.0),
        "radiance-scaling" => planes(4, 3, 2.0 * FUNCTION + 25.0),
        "auto-white" => planes(3, 0, 8.0),
        _ => return None,
    })
}

/// Both components in one pass, so that the faces (2 planes) are read once: per component a step reads
/// g and writes it; a link of the recurrence reads two terms and the sum and writes one and the sum.
fn of_diffusion(sweeps: &Sweeps) -> Work {
    let (planes, operations) = match sweeps {
        Sweeps::Explicit { .. } => (2.0, FLUX + 2.0),
        Sweeps::Chebyshev(_) => (5.0, FLUX + 6.0),
    };
    let count = sweeps.count() as f64;
    Work {
        bytes: count * SAMPLE * (2.0 + 2.0 * planes),
        operations: count * 2.0 * operations,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffusion_grows_with_the_sweeps() {
        let shape = ShapeParams::default();
        let steps = |count| Sweeps::Explicit {
            count,
            time_step: 0.2,
        };
        let ten = of_stage("diffusion", &shape, &steps(10)).unwrap();
        // g of two components in and out, two faces: 6 planes of 4 bytes, ten times.
        assert_eq!((ten.bytes, ten.operations), (240.0, 260.0));
        let none = of_stage("diffusion", &shape, &steps(0)).unwrap();
        assert_eq!((none.bytes, none.operations), (0.0, 0.0));
    }

    #[test]
    fn every_stage_of_the_backend_has_a_model() {
        use crate::report::{scenes::Scene, timing};
        let frame = Scene::waves(8, 8).frame;
        for goal in [crate::plan::Goal::Layers, crate::plan::Goal::Display] {
            let plan = timing::plan(goal, &frame, ShapeParams::default()).unwrap();
            for (name, _) in crate::backend::cpu::run(&plan, &frame).timings {
                assert!(
                    of_stage(name, &plan.shape, &plan.sweeps).is_some(),
                    "{name}"
                );
            }
        }
    }
}
