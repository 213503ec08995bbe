//! The part of a frame, and of the inputs beside it, that a region depends on.

use crate::engine::inputs::Inputs;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene, Vector2Planes, Vector3Planes, Window};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::plan::Plan;

/// A region with a margin of the plan's reach.
pub(crate) struct Part {
    pub(crate) frame: Frame,
    /// Mask and points cropped to this part; the scene behind and around is whole.
    specular: Option<SpecularScene>,
    motion: Option<Vector2Planes>,
}

impl Part {
    /// # Errors
    /// [`Error::Unfit`] for a region that is not inside the frame, and for inputs that do not fit the plan.
    pub(crate) fn around(
        region: Window,
        plan: &Plan,
        frame: &Frame,
        inputs: Inputs,
    ) -> Result<Self> {
        let whole = frame.data_window;
        if region.common(&whole) != Some(region) {
            return Err(Error::Unfit {
                found: format!("the region is {region}, and the frame {whole}"),
                remedy: "give a region inside the frame",
            });
        }
        inputs.check(plan, frame)?;
        let reach = i32::try_from(plan.reach()).unwrap_or(i32::MAX);
        let around = Window {
            x0: region.x0.saturating_sub(reach),
            y0: region.y0.saturating_sub(reach),
            x1: region.x1.saturating_add(reach),
            y1: region.y1.saturating_add(reach),
        };
        let around = around.common(&whole).unwrap_or(region);
        let motion = inputs.sequence.and_then(|sequence| sequence.motion);
        Ok(Self {
            frame: frame.crop(around),
            specular: inputs
                .specular
                .map(|scene| specular_in(scene, whole, around)),
            motion: motion.map(|Vector2Planes { x, y }| Vector2Planes {
                x: x.crop(whole, around),
                y: y.crop(whole, around),
            }),
        })
    }

    /// The inputs of the whole frame, restricted to this part.
    pub(crate) fn inputs<'p>(&'p self, of_whole: Inputs<'p>) -> Inputs<'p> {
        Inputs {
            specular: self.specular.as_ref(),
            sequence: of_whole.sequence.map(|sequence| SequenceInputs {
                motion: self.motion.as_ref(),
                ..sequence
            }),
            ..of_whole
        }
    }
}

/// A scene whose per-pixel planes are cropped to a part of the frame.
fn specular_in(scene: &SpecularScene, whole: Window, part: Window) -> SpecularScene {
    let points = scene.hit_position.as_ref();
    SpecularScene {
        mask: scene.mask.as_ref().map(|mask| mask.crop(whole, part)),
        hit_position: points.map(|Vector3Planes { x, y, z }| Vector3Planes {
            x: x.crop(whole, part),
            y: y.crop(whole, part),
            z: z.crop(whole, part),
        }),
        ..scene.clone()
    }
}
