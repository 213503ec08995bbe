//! Contours in a drawing.

use crate::frame::Plane;
use crate::line::contours::Contour;
use crate::line::contours::coverage::covered;
use crate::line::contours::cpu;
use crate::line::contours::medium::in_medium;
use crate::line::drawing::{Drawn, is_drawn};
use crate::params::ContourParams;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Lines along silhouettes and creases. They come first: strokes do not consume the weights of edges.
pub(crate) static CONTOURS: Stage = Stage {
    takes: |_| vec![Product::Silhouette, Product::Crease],
    depends_on: |plan| format!("{:?} {:?}", plan.contours(), plan.background()),
    makes: Makes::Drawing,
    name: "contours",
    steps: &[step("contours", &[Product::Contours], decide)],
    cpu: draw,
    ..Stage::DEFAULT
};

fn decide(plan: &Plan) -> Verdict {
    is_drawn(plan, |params| match params.contours {
        Some(contours) => Verdict::runs(format!(
            "lines of {} px along silhouettes and creases",
            contours.width_px
        )),
        None => Verdict::left_out("none are asked for"),
    })
}

fn draw(run: &mut Execution) {
    let plan = run.plan;
    let params = plan.drawing.as_ref().expect("contours are of a drawing");
    let contours = plan.contours().expect("contours are asked for");
    let key = plan.key_without_scene(CONTOURS.name);
    let (covered, lines) = run.copied_or(CONTOURS.name, key, |run| follow_edges(run, &contours));
    run.canvas_mut().contours = Some((in_medium(covered, run.frame, &params.strokes), lines));
}

fn follow_edges(run: &mut Execution, params: &ContourParams) -> (Plane, Vec<Contour>) {
    run.timed_on(CONTOURS.name, |run| {
        let background = run.canvas().background.as_ref();
        let lines = cpu::contours(&Drawn::of(run), background, &run.plan.shape, params);
        (covered(&lines, &run.frame.mask, run.memory), lines)
    })
}
