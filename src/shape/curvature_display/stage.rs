//! The curvature display as a picture.

use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;
use crate::shape::curvature_display::curvature_display;

/// The coloured curvature display of [LW] figure 6.
pub(crate) static CURVATURE_DISPLAY: Stage = Stage {
    takes: |_| vec![Product::Trace, Product::Conductance],
    makes: Makes::Picture,
    name: "display",
    steps: &[step(
        "curvature-display",
        &[Product::Picture],
        |plan| match plan.display {
            true => Verdict::runs("a picture of the descriptor"),
            false => plan.left_out("no display is asked for"),
        },
    )],
    cpu: display,
    #[cfg(feature = "gpu")]
    gpu: Some(super::gpu::display),
    ..Stage::DEFAULT
};

fn display(run: &mut Execution) {
    let (mask, memory, gain) = (&run.frame.mask, run.memory, run.gain());
    let shape = std::mem::take(&mut run.made.outcome.shape);
    let there = "the display takes curvature";
    let trace = shape.trace.as_ref().expect(there);
    let conductance = shape.conductance.as_ref().expect(there);
    let color = run.timed(CURVATURE_DISPLAY.name, || {
        curvature_display(trace, conductance, mask, gain, memory)
    });
    run.made.outcome.color = Some(color);
    run.made.outcome.shape = shape;
}
