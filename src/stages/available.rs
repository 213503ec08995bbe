//! What a plan finds in a frame and in new light.

use crate::frame::{DepthKind, Frame};
use crate::light::lights::Illumination;
use crate::light::occlusion_grain::is_grainy;
use crate::plan::{Available, LightAvailable};
use crate::shape::bends::bends;

impl Available {
    /// The inputs that `frame` holds.
    pub fn in_frame(frame: &Frame) -> Self {
        Self {
            depth: frame.depth.is_some(),
            bends: bends(frame),
            is_flat: frame.is_flat_work(),
            color: frame.color.is_some(),
            albedo: frame.albedo.is_some(),
            gloss: frame.light.gloss.is_some(),
            occlusion: frame.occlusion.is_some(),
            importance: frame.importance.is_some(),
            object_angles: frame.stroke_fallback.is_some(),
            image_height: frame.display_window.height(),
            image_width: frame.display_window.width(),
            positions: frame.depth.is_some()
                && frame.camera.is_some()
                && frame.source.depth_kind != DepthKind::Relative,
            grainy_occlusion: is_grainy(frame),
            is_map: frame.is_map(),
            normal_rounding: frame.source.normal_rounding,
            light: LightAvailable::of(&frame.light),
            ..Self::default()
        }
    }

    /// The same inputs, and new light.
    #[must_use]
    pub fn lit_by(self, light: &Illumination) -> Self {
        Self {
            new_light: light.kinds(),
            ..self
        }
    }
}
