//! The inputs that a plan is made for.

use crate::frame::LightLayers;
use crate::params::{SpecularParams, Style};

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
    /// Whether it is a photo or a map of a surface without gaps: no depth but heights, no passes of light, and no perspective
    /// that is known.
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

/// The light layers available for scaling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LightAvailable {
    /// Lobes of diffuse light.
    pub diffuse: bool,
    /// Whether some diffuse light from other surfaces is a separate layer.
    pub diffuse_indirect: bool,
    /// Lobes of specular light.
    pub specular: bool,
    /// Light groups with directions.
    pub groups: bool,
    /// Ambient occlusion.
    pub occlusion: bool,
    /// Whether that is found from the shape, not a layer.
    pub occlusion_is_computed: bool,
    /// Whether the picture is itself ambient occlusion.
    pub picture_is_occlusion: bool,
}

impl LightAvailable {
    /// No layers, only the picture.
    pub const NONE: Self = Self {
        diffuse: false,
        diffuse_indirect: false,
        specular: false,
        groups: false,
        occlusion: false,
        occlusion_is_computed: false,
        picture_is_occlusion: false,
    };

    /// The layers present in `light`.
    pub fn of(light: &LightLayers) -> Self {
        let mut diffuse = light.lobes.iter().filter(|l| l.lobe.is_diffuse());
        Self {
            diffuse: diffuse.clone().next().is_some(),
            diffuse_indirect: diffuse.any(|l| l.indirect.is_some()),
            specular: light.lobes.iter().any(|l| !l.lobe.is_diffuse()),
            groups: !light.groups.is_empty(),
            occlusion: light.occlusion.is_some(),
            occlusion_is_computed: false,
            picture_is_occlusion: light.picture_is_occlusion,
        }
    }

    /// With the occlusion that the shape has, in place of a layer.
    #[must_use]
    pub fn with_computed_occlusion(self) -> Self {
        Self {
            occlusion: true,
            occlusion_is_computed: true,
            ..self
        }
    }
}

/// The kinds of light present.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LightKinds {
    /// Directional lights, area lights included.
    pub directional: bool,
    /// Point lights.
    pub points: bool,
    /// An environment.
    pub environment: bool,
    /// Lit spheres: one, or two for convexities and concavities.
    pub lit_spheres: u8,
    /// Whether a directional light is raking: above the picture plane, by less than 45 degrees.
    pub raking: bool,
}

impl LightKinds {
    /// No light.
    pub const NONE: Self = Self {
        directional: false,
        points: false,
        environment: false,
        lit_spheres: 0,
        raking: false,
    };
}
