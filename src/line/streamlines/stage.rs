//! Strokes as lines.

use crate::frame::Plane;
use crate::line::drawing::{Drawn, DrawnTone, finish, has_strokes};
use crate::line::streamlines::cpu::{inked, lines};
#[cfg(feature = "gpu")]
use crate::params::StrokeDirections;
use crate::params::Style;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Strokes that are lines of their own ([JL]).
pub(crate) static STREAMLINES: Stage = Stage {
    takes: |_| vec![Product::Conductance],
    makes: Makes::Drawing,
    name: "streamlines",
    steps: &[step("streamlines", &[Product::Strokes], |plan| {
        has_strokes(plan, |params| match params.strokes.style {
            Style::Lines => Verdict::runs("every stroke is a line of its own"),
            Style::Engraving => Verdict::runs("lines swell with tone"),
            Style::Stipple => Verdict::left_out("strokes are dots"),
            _ => Verdict::left_out("strokes come from a texture"),
        })
    })],
    cpu: lay,
    #[cfg(feature = "gpu")]
    gpu_lacks: |plan| {
        let params = plan.drawing.as_ref()?;
        match params.strokes.style {
            Style::Engraving => Some("engraved lines"),
            Style::Lines if plan.available.moving => Some("lines that move"),
            Style::Lines if params.directions == StrokeDirections::Both => Some("crossed lines"),
            _ => None,
        }
    },
    ..Stage::DEFAULT
};

fn lay(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = DrawnTone::taken(run);
    let densities = tone.densities(frame, &params.tone);
    let (ink, lines, laid) = run.timed_on(STREAMLINES.name, |run| {
        let (drawn, factor) = (Drawn::of(run), plan.resolution_factor as f32);
        let (sequence, strokes) = (run.inputs.sequence, &params.strokes);
        let fields = &run.canvas().directions;
        let (lines, laid) = lines(
            &densities, fields, sequence, &drawn, strokes, factor, memory,
        );
        let ink = match plan.inks_strokes {
            false => Plane::filled(frame.mask.width(), frame.mask.height(), 0.0),
            true => inked(&lines, frame, memory),
        };
        (ink, lines, laid)
    });
    drop(densities);
    let canvas = run.canvas_mut();
    if let Some(coordinates) = &mut canvas.coordinates {
        coordinates.lines = laid;
        coordinates.directions = std::mem::take(&mut canvas.directions);
    }
    finish(run, tone, ink, lines);
}
