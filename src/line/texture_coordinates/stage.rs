//! Strokes that move with the surface, in a frame of a sequence.

use crate::line::drawing::has_strokes;
use crate::line::texture_coordinates::cpu::TextureCoordinates;
use crate::plan::execution::Execution;
use crate::plan::stage::{Makes, Stage, Verdict, step};

/// Placement of the stroke texture as the surface moves.
pub(crate) static TEXTURE_COORDINATES: Stage = Stage {
    // A frame of a sequence may come with a plan that was made for a still.
    also_runs: |plan| plan.drawing.is_some_and(|params| !params.lines_only),
    makes: Makes::Drawing,
    name: "texture-coordinates",
    steps: &[step("texture-coordinates", &[], |plan| {
        has_strokes(plan, |_| match plan.available.moving {
            true => Verdict::runs("strokes move with the surface"),
            false => Verdict::left_out("strokes lie still in the picture"),
        })
    })],
    cpu: place,
    ..Stage::DEFAULT
};

fn place(run: &mut Execution) {
    let (frame, memory) = (run.frame, run.memory);
    let sequence = run.inputs.sequence;
    run.canvas_mut().coordinates = sequence.map(|sequence| {
        run.timed(TEXTURE_COORDINATES.name, || {
            TextureCoordinates::of(frame, sequence, memory)
        })
    });
}
