//! State shared by all batches of a relit frame.

use crate::frame::{ColorPlanes, Frame, Gloss, Mask, Plane, SightLines, Vector2Planes};
use crate::light::albedo::AlbedoEstimate;
use crate::light::lights::PointLight;
use crate::light::prepared_environment::Illuminants;
use crate::light::relight::curvature::CurvedBy;
use crate::light::relight::mirrors::Mirrors;
use crate::light::relight::setting::Relighting;
use crate::light::shadows::cast::CastShadows;
use crate::light::sum::{Directed, Shading};
use crate::params::{Magnitudes, Quantisation, RelightParams};
use std::borrow::Cow;

/// State shared by all batches.
pub(crate) struct LitScene<'a> {
    pub(super) frame: &'a Frame,
    pub(super) relighting: &'a Relighting,
    /// Curvature, if needed.
    pub(super) curvature: Option<CurvedBy<'a>>,
    /// Grain direction in the picture, if it follows the curvature.
    pub(super) grain: Option<&'a Vector2Planes>,
    /// The planes that the albedo is, or is estimated from; `None` for white.
    pub(super) albedo: Option<&'a ColorPlanes>,
    pub(super) estimate: Option<AlbedoEstimate>,
    /// Curvature gain.
    pub(super) gain: f32,
    pub(super) magnitudes: Magnitudes,
    pub(super) invariant_point: f32,
    pub(super) luminance: [f32; 3],
    /// Shading by single lights; `None` if none are summed.
    pub(super) shading: Option<Shading>,
    /// Light that the albedo does not tell of.
    pub(super) gloss: Option<&'a Gloss>,
    /// Shading of what mirrors single lights by its own gloss.
    pub(super) mirror_shading: Option<Shading>,
    /// Whether the scene mirrored in the render stays.
    pub(super) keeps_mirrored: bool,
    /// Whether anything adds to specular light.
    pub(super) is_glossy: bool,
    pub(super) lights: Vec<Directed>,
    /// Lamps that cast shadows; those far away are in place of these lights.
    pub(super) shadows: CastShadows,
    /// The lights that stand for the environment.
    pub(super) around_lights: Vec<Directed>,
    /// Those that stand for its diffuse light alone.
    pub(super) base_lights: Vec<Directed>,
    /// The share of light from all around that arrives by a layer, without its grain.
    pub(super) occlusion: Option<Cow<'a, Plane>>,
    /// The turn of lamps about the view axis, as cosine and sine, if they rake by region.
    pub(super) turns: Option<Vector2Planes>,
    /// How lights are turned to the form, if they are.
    pub(super) aligned: Option<Aligned>,
    pub(super) points: &'a [PointLight],
    pub(super) sight: SightLines,
    pub(super) around: Illuminants<'a>,
    /// The scene seen in mirrors and lenses, if it is more than the environment.
    pub(super) mirrors: Option<Mirrors<'a>>,
    /// The pixels to light.
    pub(super) lit: &'a Mask,
    /// Direction to the eye per column and row, scaled to z = 1; `None` for parallel sight lines.
    pub(super) eye: Option<[Vec<f32>; 2]>,
    /// The tones, and the last of them.
    pub(super) tones: Option<(Quantisation, f32)>,
}

/// Light turned to the form.
pub(crate) struct Aligned {
    /// Places of the normals at coarser scales.
    pub(super) coarse: Vec<Vector2Planes>,
    pub(super) strength: f32,
    /// The gain that keeps the mean of the light.
    pub(super) gain: f32,
}

impl LitScene<'_> {
    pub(super) fn params(&self) -> &RelightParams {
        &self.relighting.params
    }
}
