//! The tone of a drawing that shows the shape.

use super::cpu::{ToneOf, densities};
use super::halo::leave_bare;
use super::key_light;
use crate::line::background::stage::seeks_planes;
use crate::line::drawing::is_drawn;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};
use crate::product::Product;

/// Tone by a key light and by the picture, spread from ink to paper.
pub(crate) static SHAPE_TONE: Stage = Stage {
    takes: |_| vec![Product::Silhouette, Product::Conductance, Product::Trace],
    makes: Makes::Drawing,
    name: "shape-tone",
    steps: &[step("shape-tone", &[Product::Strokes], |plan| {
        is_drawn(plan, |params| match plan.shows_shape {
            true => Verdict::runs(format!("a key light for {} of it", params.tone.key_share)),
            false => Verdict::left_out("the tone is that of light alone"),
        })
    })],
    cpu: find,
    #[cfg(feature = "gpu")]
    gpu_lacks: |_| Some("tones that show the shape"),
    ..Stage::DEFAULT
};

fn find(run: &mut Execution) {
    let (density, levels) = run.timed_on(SHAPE_TONE.name, |run| {
        let (plan, frame, memory) = (run.plan, run.frame, run.memory);
        let params = plan.drawing.as_ref().expect("tones are of a drawing");
        let (shape, light) = (&run.made.outcome.shape, run.illumination());
        let given = light.and_then(|light| light.directional.first());
        let there = "tones are planned with their shape";
        let of = ToneOf {
            frame,
            conductance: shape.conductance.as_ref().expect(there),
            silhouette: shape.silhouette.as_ref(),
            curvature: (shape.trace.as_ref().expect(there), run.gain()),
            picture: run.made.outcome.color.as_ref().or(frame.color.as_ref()),
            to_key: given.map_or_else(key_light, |light| light.to_light),
            params: &params.tone,
            background: run.canvas().background.as_ref(),
            seeks_planes: seeks_planes(plan),
        };
        let cells = densities(&of, &run.runner.options, memory);
        let mut density = cells.of_pixels(&frame.mask, memory);
        if let Some(silhouette) = &shape.silhouette {
            let halo = (plan.shape.silhouette, params.tone.halo);
            leave_bare(&mut density, frame, silhouette, halo, of.background);
        }
        (density, cells.levels)
    });
    run.made.outcome.tone_levels = Some(levels);
    if run.read_last.contains(&Product::Trace) {
        // Strokes take the tone alone.
        run.made.outcome.color = None;
    }
    run.canvas_mut().density = Some(density);
}
