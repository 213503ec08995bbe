//! The inputs that a plan is made for.

use crate::frame::{DepthKind, Frame};
use crate::light::enhancement::LightAvailable;
use crate::light::lights::{Illumination, LightKinds};
use crate::light::occlusion_grain::is_grainy;
use crate::params::{SpecularParams, Style};
use crate::shape::bends::bends;

/// The inputs that a plan is made for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Available {
    /// Depth.
    pub depth: bool,
    /// Whether the surface bends, and is not all flat faces between edges.
    pub bends: bool,
    /// Whether the surface is flat work: relief that faces the viewer.
    pub is_flat: bool,
    /// A picture.
    pub color: bool,
    /// The albedo of the surface.
    pub albedo: bool,
    /// Light that the albedo does not tell of.
    pub gloss: bool,
    /// An occlusion map or alpha.
    pub occlusion: bool,
    /// A map of importance, which varies the scale from pixel to pixel.
    pub importance: bool,
    /// Objects with a stroke direction of their own where curvature gives none.
    pub object_angles: bool,
    /// Height in pixels of the whole picture, its display window: independent of crops and overscan.
    pub image_height: usize,
    /// Width of the display window in pixels.
    pub image_width: usize,
    /// Depth and a camera, which together give positions.
    pub positions: bool,
    /// Whether the layer of ambient occlusion has the grain of few samples.
    pub grainy_occlusion: bool,
    /// Whether it is a photo or a map of a surface without gaps: no depth but heights, and no passes of light.
    pub is_map: bool,
    /// Largest rounding error of a component of the normals.
    pub normal_rounding: f32,
    /// How specular pixels are traced, if the scene they show is known; not set by [`in_frame`](Available::in_frame).
    pub specular: Option<SpecularParams>,
    /// The kinds of new light that are given; none in [`in_frame`](Available::in_frame).
    pub new_light: LightKinds,
    /// Light layers to scale.
    pub light: LightAvailable,
    /// Whether this is a frame of a sequence whose strokes move with the surface; false in [`in_frame`](Available::in_frame).
    pub moving: bool,
    /// Whether this is a frame of a sequence, in which lines fade in and out; false in [`in_frame`](Available::in_frame).
    pub in_sequence: bool,
}

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

    /// The style of a drawing of these: [`Style::Auto`] is an engraving of surfaces that bend, where depth tells them from
    /// what is behind them. Photos and flat faces are clearer in pen, and its strokes move best.
    pub fn style(&self, style: Style) -> Style {
        let is_still = !self.moving && !self.in_sequence;
        match style {
            Style::Auto if self.depth && self.bends && is_still => Style::Engraving,
            Style::Auto => Style::Pen,
            named => named,
        }
    }

    /// The size of the picture in pixels: the root of its area.
    pub(crate) fn image_size_px(&self) -> f32 {
        (self.image_width as f32 * self.image_height as f32).sqrt()
    }
}
