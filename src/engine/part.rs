//! The part of a frame, and of the inputs beside it, that a region depends on.

use crate::engine::inputs::Inputs;
use crate::error::{Error, Result};
use crate::frame::{Frame, SpecularScene, Vector2Planes, Vector3Planes, Window};
use crate::line::texture_coordinates::cpu::SequenceInputs;
use crate::plan::Plan;

/// A region with a margin of the plan's reach.
pub(crate) struct Part {
    pub(crate) frame: Frame,
    /// The plan for it, which counts no repetition of a tile.
    pub(crate) plan: Plan,
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
        let around = around(region, whole, plan.reach(), frame.wraps);
        let motion = inputs.sequence.and_then(|sequence| sequence.motion);
        Ok(Self {
            frame: match frame.is_tile() {
                true => frame.repeated(around),
                false => frame.crop(around),
            },
            plan: match frame.is_tile() {
                true => plan.clone().of_tile(whole, frame.wraps),
                false => plan.clone(),
            },
            specular: inputs
                .specular
                .map(|scene| specular_in(scene, whole, around)),
            motion: motion.map(|Vector2Planes { x, y }| Vector2Planes {
                x: x.repeated(whole, around),
                y: y.repeated(whole, around),
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

/// The pixels within `reach` of a region: across a border of the frame only where it wraps.
fn around(region: Window, whole: Window, reach: usize, wraps: [bool; 2]) -> Window {
    let reach = i32::try_from(reach).unwrap_or(i32::MAX);
    let bounds = |wraps: bool, from: i32, to: i32| match wraps {
        true => (i32::MIN, i32::MAX),
        false => (from, to),
    };
    let (x0, x1) = bounds(wraps[0], whole.x0, whole.x1);
    let (y0, y1) = bounds(wraps[1], whole.y0, whole.y1);
    Window {
        x0: region.x0.saturating_sub(reach).max(x0),
        y0: region.y0.saturating_sub(reach).max(y0),
        x1: region.x1.saturating_add(reach).min(x1),
        y1: region.y1.saturating_add(reach).min(y1),
    }
}

/// A scene with the samples of a part of the frame, or of its repetition.
fn specular_in(scene: &SpecularScene, whole: Window, part: Window) -> SpecularScene {
    let points = scene.hit_position.as_ref();
    SpecularScene {
        mask: scene.mask.as_ref().map(|mask| mask.repeated(whole, part)),
        hit_position: points.map(|Vector3Planes { x, y, z }| Vector3Planes {
            x: x.repeated(whole, part),
            y: y.repeated(whole, part),
            z: z.repeated(whole, part),
        }),
        ..scene.clone()
    }
}
