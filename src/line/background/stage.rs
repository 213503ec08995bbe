//! The background of a drawing.

use super::Backdrop;
use crate::line::drawing::is_drawn;
use crate::params;
use crate::plan::Plan;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// The planes that the subject of a drawing stands on or before.
pub(crate) static BACKGROUND: Stage = Stage {
    makes: Makes::Drawing,
    name: "background",
    steps: &[step("background", &[Product::Strokes], |plan| {
        is_drawn(plan, |params| match params.tone.background {
            params::Background::Strokes => Verdict::left_out("it is drawn like the subject"),
            _ if !plan.shows_shape && !params.lines_only => {
                Verdict::left_out("the tone is that of light alone")
            }
            _ => match without_planes(plan) {
                Some(why) => Verdict::left_out(why),
                None => Verdict::runs("planes that the subject stands on or before"),
            },
        })
    })],
    depends_on: |plan| format!("{} {:?}", plan.resolution_factor, plan.background()),
    reads_normals: false,
    cpu: find,
    ..Stage::DEFAULT
};

/// Whether planes are looked for in a drawing whose tone shows the shape.
pub(crate) fn seeks_planes(plan: &Plan) -> bool {
    without_planes(plan).is_none()
}

/// Why planes are not looked for in a frame.
fn without_planes(plan: &Plan) -> Option<&'static str> {
    let moves = plan.available.in_sequence || plan.available.moving;
    if plan.specular.is_some() {
        Some("mirrors show others")
    } else if moves {
        Some("planes could come and go from frame to frame")
    } else {
        (!plan.available.depth).then_some("planes show in depth, and there is none")
    }
}

fn find(run: &mut Execution) {
    let key = run.plan.key_without_scene(BACKGROUND.name);
    run.canvas_mut().background = run.copied_or(BACKGROUND.name, key, |run| {
        let factor = run.plan.resolution_factor as f32;
        run.timed(BACKGROUND.name, || Backdrop::of(run.frame, factor))
    });
}
