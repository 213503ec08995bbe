//! Strokes as lines.

use crate::engine::cpu::run::Run;
use crate::line::drawing::{Tone, finish, has_strokes};
use crate::line::streamlines::cpu::{inked, lines};
use crate::params::Style;
use crate::plan::stage::{Stage, Step, Verdict};
use crate::product::Product;

/// Strokes that are lines of their own ([JL]).
pub(crate) static STREAMLINES: Stage = Stage {
    name: "streamlines",
    steps: &[Step {
        name: "streamlines",
        gives: &[Product::Strokes],
        decide: |plan| {
            has_strokes(plan, |params| match params.strokes.style {
                Style::Lines => Verdict::runs("every stroke is a line of its own"),
                Style::Engraving => Verdict::runs("lines swell with tone"),
                Style::Stipple => Verdict::left_out("strokes are dots"),
                _ => Verdict::left_out("strokes come from a texture"),
            })
        },
    }],
    cpu: lay,
    #[cfg(feature = "gpu")]
    gpu_lacks: |plan| {
        let style = plan.drawing.as_ref().map(|params| params.strokes.style);
        (style == Some(Style::Engraving)).then_some("engraved lines")
    },
    ..Stage::DEFAULT
};

fn lay(run: &mut Run) {
    let (plan, frame, memory) = (run.plan, run.frame, &run.runner.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = Tone::taken(run);
    let densities = tone.densities(frame, &params.tone);
    let canvas = std::mem::take(&mut run.canvas);
    let shape = std::mem::take(&mut run.outcome.shape);
    let own = shape.conductance.as_ref();
    let (drawn, conductance) = match &canvas.seen {
        Some((seen, edges)) => (&seen.frame, &edges.conductance),
        None => (frame, own.expect("strokes stop at edges")),
    };
    let (directions, factor) = (&canvas.directions, plan.resolution_factor as f32);
    let (ink, laid) = run.timed(STREAMLINES.name, || {
        let strokes = &params.strokes;
        let laid = lines(
            &densities,
            directions,
            conductance,
            strokes,
            factor,
            drawn,
            memory,
        );
        (inked(&laid, strokes.style, frame, memory), laid)
    });
    drop(densities);
    (run.canvas, run.outcome.shape) = (canvas, shape);
    finish(run, tone, ink, laid);
}
