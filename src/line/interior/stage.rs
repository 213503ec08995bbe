//! Interior lines in a drawing.

use crate::line::contours::coverage::covered;
use crate::line::contours::medium::in_medium;
use crate::line::drawing::{Drawn, is_drawn};
use crate::line::interior::{InteriorLayer, cpu};
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Lines inside surfaces. They follow contours, which they join and do not double.
pub(crate) static INTERIOR: Stage = Stage {
    takes: |_| vec![Product::Silhouette, Product::Contours],
    depends_on: |plan| {
        let params = plan.drawing.as_ref().map(|params| params.interior);
        format!(
            "{params:?} {} {:?}",
            plan.available.in_sequence,
            plan.background()
        )
    },
    makes: Makes::Drawing,
    name: "interior",
    steps: &[step("interior", &[Product::Interior], decide)],
    cpu: draw,
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    is_drawn(plan, |params| match params.interior {
        Some(interior) => Verdict::runs(format!(
            "valleys, ridges and suggestive contours{} at a detail of {}",
            match interior.has_shadows() {
                true => ", edges of cast shadows",
                false => "",
            },
            interior.detail
        )),
        None => Verdict::left_out("none are asked for"),
    })
}

fn draw(run: &mut Execution) {
    let plan = run.plan;
    let params = plan.drawing.as_ref().expect("lines are of a drawing");
    let key = plan.key_without_scene(INTERIOR.name);
    let layer = run.copied_or(INTERIOR.name, key, follow);
    run.made.outcome.line_levels = layer.levels;
    let covered = in_medium(layer.covered, run.frame, &params.strokes);
    run.canvas_mut().interior = Some((covered, layer.lines));
}

fn follow(run: &mut Execution) -> InteriorLayer {
    run.timed_on(INTERIOR.name, |run| {
        let params = run.plan.drawing.as_ref().and_then(|params| params.interior);
        let params = params.expect("interior lines are asked for");
        let contours = run.canvas().contours.as_ref();
        let contours = contours.map_or(&[][..], |(_, lines)| lines);
        let (fades, memory) = (run.plan.available.in_sequence, run.memory);
        let options = &run.runner.options;
        let drawn = Drawn::of(run);
        let around = (contours, run.canvas().background.as_ref());
        let (lines, levels) = cpu::interior(&drawn, around, &params, fades, options, memory);
        InteriorLayer {
            covered: covered(&lines, &drawn.frame.mask, memory),
            lines,
            levels,
        }
    })
}
