//! Strokes of a texture.

use crate::engine::cpu::execution::Execution;
use crate::line::drawing::{Tone, finish, has_texture};
use crate::line::hatching::cpu::hatched;
use crate::plan::stage::{Makes, Stage, Step, Verdict};
use crate::product::Product;

/// Strokes cut from a texture and pasted along the directions ([LA] section 6).
pub(crate) static HATCHING: Stage = Stage {
    makes: Makes::Drawing,
    name: "hatching",
    steps: &[Step {
        name: "hatching",
        gives: &[Product::Strokes],
        decide: |plan| {
            has_texture(plan, |params| {
                let strokes = &params.strokes;
                Verdict::runs(format!("{} levels, {} sets", strokes.levels, strokes.sets))
            })
        },
    }],
    cpu: hatch,
    #[cfg(feature = "gpu")]
    after_gpu: Some(super::gpu::hatch),
    ..Stage::DEFAULT
};

fn hatch(run: &mut Execution) {
    let (plan, frame, memory) = (run.plan, run.frame, run.memory);
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let tone = Tone::taken(run);
    let densities = tone.densities(frame, &params.tone);
    let canvas = std::mem::take(&mut run.canvas);
    let map = canvas.art_map.as_deref().or(run.inputs.art_map);
    let map = map.expect("strokes of pictures come with them");
    let coordinates = canvas.coordinates.as_ref();
    let (directions, strokes) = (&canvas.directions, &params.strokes);
    let ink = run.timed(HATCHING.name, || {
        hatched(
            &densities,
            directions,
            coordinates,
            map,
            strokes,
            frame,
            memory,
        )
    });
    drop(densities);
    run.canvas = canvas;
    finish(run, tone, ink, Vec::new());
}
