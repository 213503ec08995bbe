//! Strokes of a texture.

use crate::line::drawing::{DrawnTone, finish, has_texture};
use crate::line::hatching::cpu::hatched;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Strokes cut from a texture and pasted along the directions ([LA] section 6).
pub(crate) static HATCHING: Stage = Stage {
    makes: Makes::Drawing,
    name: "hatching",
    steps: &[step("hatching", &[Product::Strokes], |plan| {
        has_texture(plan, |params| {
            let strokes = &params.strokes;
            Verdict::runs(format!("{} levels, {} sets", strokes.levels, strokes.sets))
        })
    })],
    cpu: hatch,
    #[cfg(feature = "gpu")]
    after_gpu: Some(super::gpu::hatch),
    ..Stage::DEFAULT
};

fn hatch(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = DrawnTone::taken(run);
    let densities = tone.densities(frame, &params.tone);
    let ink = run.timed_on(HATCHING.name, |run| {
        let map = run.canvas().art_map.as_deref().or(run.given_art_map());
        let map = map.expect("strokes of pictures come with them");
        hatched(
            &densities,
            run.canvas(),
            map,
            &params.strokes,
            frame,
            memory,
        )
    });
    drop(densities);
    finish(run, tone, ink, Vec::new());
}
