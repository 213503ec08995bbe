//! Strokes that are dots.

use super::cpu::{Stippled, stippled};
use crate::line::drawing::{DrawnTone, finish, has_strokes};
use crate::params::Style;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Tone in dots.
pub(crate) static STIPPLING: Stage = Stage {
    makes: Makes::Drawing,
    name: "stippling",
    steps: &[step("stippling", &[Product::Strokes], |plan| {
        has_strokes(plan, |params| match params.strokes.style {
            Style::Stipple => Verdict::runs("tone is in dots"),
            _ => Verdict::left_out("strokes are no dots"),
        })
    })],
    cpu: lay,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("dots"),
    ..Stage::DEFAULT
};

fn lay(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = DrawnTone::taken(run);
    let densities = tone.densities(frame, &params.tone);
    let factor = plan.resolution_factor as f32;
    let sequence = run.inputs.sequence;
    let Stippled {
        dots,
        laid,
        covered,
    } = run.timed(STIPPLING.name, || {
        stippled(&densities, &params.strokes, factor, sequence, frame, memory)
    });
    drop(densities);
    if let Some(coordinates) = &mut run.canvas_mut().coordinates {
        coordinates.dots = laid;
    }
    finish(run, tone, covered, Vec::new());
    if let Some(drawing) = &mut run.made.outcome.drawing {
        drawing.dots = dots;
    }
}
