//! The texture of strokes in a drawing.

use crate::line::drawing::has_texture;
use crate::line::tonal_art_map::cached::ArtMapCache;
use crate::params::Style;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};

/// The texture of strokes.
pub(crate) static TONAL_ART_MAP: Stage = Stage {
    makes: Makes::Drawing,
    name: "tonal-art-map",
    steps: &[step("tonal-art-map", &[], |plan| {
        has_texture(plan, |params| {
            Verdict::runs(format!("seed {}", params.strokes.seed))
        })
    })],
    cpu: make,
    ..Stage::DEFAULT
};

fn make(run: &mut Execution) {
    let plan = run.plan;
    let params = plan.drawing.as_ref().expect("strokes are of a drawing");
    let (strokes, factor) = (&params.strokes, plan.resolution_factor as f32);
    if strokes.style == Style::Pictures {
        return;
    }
    let kept = &run.runner.caches.of::<ArtMapCache>();
    let map = kept.of(strokes, factor, |make| run.timed(TONAL_ART_MAP.name, make));
    run.canvas_mut().art_map = Some(map);
}
