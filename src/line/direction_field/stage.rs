//! The directions of strokes in a drawing.

use crate::line::canvas::Canvas;
use crate::line::direction_field::cpu::stroke_fields;
use crate::line::direction_field::patches::Patches;
use crate::line::drawing::has_strokes;
use crate::params::Style;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// The directions that strokes follow.
pub(crate) static DIRECTION_FIELD: Stage = Stage {
    takes: |_| vec![Product::Conductance],
    depends_on: |plan| {
        let params = plan
            .drawing
            .as_ref()
            .map(|params| (params.field, params.directions, params.tone.background));
        format!("{} {params:?}", plan.resolution_factor)
    },
    makes: Makes::Drawing,
    name: "direction-field",
    steps: &[step("direction-field", &[Product::Strokes], |plan| {
        has_strokes(plan, |params| match params.strokes.style {
            Style::Stipple => Verdict::left_out("dots have no direction"),
            _ => Verdict::runs("strokes follow the curvature"),
        })
    })],
    cpu: find,
    ..Stage::DEFAULT
};

fn find(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let canvas = std::mem::take(run.canvas_mut());
    let mut shape = std::mem::take(&mut run.made.outcome.shape);
    let is_last = run.read_last.contains(&Product::Conductance);
    // Strokes that are laid one by one also follow where they lay before.
    let sequence = run
        .inputs
        .sequence
        .filter(|_| params.strokes.style.is_laid());
    let make = || {
        let own = shape.conductance.as_ref();
        let (drawn, conductance, given) = match &canvas.seen {
            Some((seen, edges)) => (&seen.frame, &edges.conductance, Some(&seen.directions[..])),
            None => (frame, own.expect("strokes stop at edges"), None),
        };
        let (field, wanted) = (&params.field, params.directions);
        let patches = Patches::new(drawn, conductance, field.cell_px as usize);
        if is_last {
            memory.recycle(shape.conductance.take());
        }
        let led = (given, canvas.background.as_ref(), sequence);
        stroke_fields(plan, field, wanted, drawn, &patches, led, memory)
    };
    let key = plan.key_without_scene(DIRECTION_FIELD.name);
    let key = key.filter(|_| sequence.is_none());
    let directions = run.copied_or(DIRECTION_FIELD.name, key, |run| {
        run.timed(DIRECTION_FIELD.name, make)
    });
    run.made.outcome.shape = shape;
    *run.canvas_mut() = Canvas {
        directions,
        ..canvas
    };
}
