//! What all batches of a frame in new light share.

use crate::frame::{ColorPlanes, Frame, Mask, SightLines, Vector2Planes};
use crate::light::lights::{DirectionalLight, PointLight};
use crate::light::prepared_environment::Illuminants;
use crate::light::relight::curvature::Curvature;
use crate::light::relight::mirrors::Mirrors;
use crate::light::sum::Shading;
use crate::params::{Magnitudes, Quantisation, RelightParams};
use crate::plan::Relighting;

/// Which of [`crate::light::batch::Pixels::curves`] scales a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Term {
    Ambient,
    Diffuse,
    Specular,
}

/// Everything that all batches share.
pub(crate) struct Scene<'a> {
    pub(super) frame: &'a Frame,
    pub(super) relighting: &'a Relighting,
    /// Curvature, where it is needed.
    pub(super) curvature: Option<Curvature<'a>>,
    /// Grain in the picture, where it follows the curvature.
    pub(super) grain: Option<&'a Vector2Planes>,
    pub(super) albedo: Option<&'a ColorPlanes>,
    /// Curvature gain.
    pub(super) gain: f32,
    pub(super) magnitudes: Magnitudes,
    pub(super) invariant_point: f32,
    pub(super) luminance: [f32; 3],
    /// How single lights act; `None` where none are summed.
    pub(super) shading: Option<Shading>,
    /// Whether anything adds to specular light.
    pub(super) is_glossy: bool,
    pub(super) lights: &'a [DirectionalLight],
    pub(super) points: &'a [PointLight],
    pub(super) sight: SightLines,
    pub(super) around: Illuminants<'a>,
    /// What mirrors and lenses show, where that is more than the environment.
    pub(super) mirrors: Option<Mirrors<'a>>,
    /// The pixels that are lit.
    pub(super) lit: &'a Mask,
    /// Direction to the eye per column and row, of z 1; `None` for parallel sight lines.
    pub(super) eye: Option<[Vec<f32>; 2]>,
    pub(super) tones: Option<Quantisation>,
}

impl Scene<'_> {
    pub(super) fn params(&self) -> &RelightParams {
        &self.relighting.params
    }
}
