//! The part of a frame, and of the inputs beside it, that a region depends on.

use crate::engine::inputs::PlanInputs;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene, Vector2Planes, Window};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::plan::Plan;

/// A region with a margin of the plan's reach.
pub(crate) struct FramePart {
    pub(crate) frame: Frame,
    /// The plan for it, which counts no repetition of a tile.
    pub(crate) plan: Plan,
    /// Mask and points cropped to this part; the scene behind and around is whole.
    specular: Option<SpecularScene>,
    motion: Option<Vector2Planes>,
}

impl FramePart {
    /// # Errors
    /// [`Error::Unfit`] for a region that is not inside the frame, and for inputs that do not fit the plan.
    pub(crate) fn around(
        region: Window,
        plan: &Plan,
        frame: &Frame,
        inputs: PlanInputs,
    ) -> Result<Self> {
        let whole = frame.data_window;
        if region.common(&whole) != Some(region) {
            return Err(Error::Unfit {
                found: format!("the region is {region}, and the frame {whole}"),
                remedy: "give a region inside the frame",
            });
        }
        inputs.check(plan, frame)?;
        let plan = match frame.is_tile() {
            true => plan.clone().of_tile(whole, frame.wraps),
            false => plan.clone(),
        };
        let around = match plan.tile {
            // Some stages take all of a tile: whatever the region, all of it is run.
            Some(tile) => tile.grown(plan.reach()),
            None => region.grown(plan.reach()).common(&whole).unwrap_or(region),
        };
        let motion = inputs.sequence.and_then(|sequence| sequence.motion);
        Ok(Self {
            frame: match frame.is_tile() {
                true => frame.repeated(around),
                false => frame.crop(around),
            },
            plan,
            specular: inputs
                .specular
                .map(|scene| specular_in(scene, whole, around)),
            motion: motion.map(|motion| motion.mapped(|plane| plane.repeated(whole, around))),
        })
    }

    /// The inputs of the whole frame, restricted to this part.
    pub(crate) fn inputs<'p>(&'p self, of_whole: PlanInputs<'p>) -> PlanInputs<'p> {
        PlanInputs {
            specular: self.specular.as_ref(),
            sequence: of_whole.sequence.map(|sequence| SequenceInputs {
                motion: self.motion.as_ref(),
                ..sequence
            }),
            ..of_whole
        }
    }
}

/// A scene with the samples of a part of the frame, or of its repetition.
fn specular_in(scene: &SpecularScene, whole: Window, part: Window) -> SpecularScene {
    let points = scene.hit_position.as_ref();
    SpecularScene {
        mask: scene.mask.as_ref().map(|mask| mask.repeated(whole, part)),
        hit_position: points.map(|points| points.mapped(|plane| plane.repeated(whole, part))),
        ..scene.clone()
    }
}
