//! Tonal art maps: the ink at a position of the paper for each tone.
//!
//! Theory: a tonal art map is a volume, tone by two dimensions, whose darker slices keep all strokes of the lighter
//! ones ([LA] section 6, after Praun et al.). So each texel turns from paper to ink once, as tone darkens, and a volume
//! of strokes is stored as the beginning and end of that: two numbers a texel instead of a stack of slices, with a
//! slice of its own for every tone, and perfect nesting. A stroke reaches its rim and its ends later, so it swells as
//! it darkens. The numbers include partial coverage of texels: lines are anti-aliased, and between texels the numbers
//! are interpolated, so lines stay sharp where a picture of them would blur. A user's own pictures make an ordinary
//! stack.
//!
//! Practice: thresholds have no unit; the darkness wanted is converted to one by measured coverage, so the mean of a
//! drawn tone is that tone.

pub(crate) mod cached;
pub(crate) mod stage;

#[cfg(feature = "gpu")]
pub(crate) use super::response::ENTRIES;
pub(crate) use super::response::MAX_DENSITY;

use super::random::Random;
use super::response::Response;
use super::slice_texture::SliceTexture;
use super::stroke_synthesis::DrawnTexels;
use super::stroke_texture::{Places, STEPS, StrokeTexture};
use crate::frame::Plane;
use crate::line::stroke_texture::BATCH;
use crate::params::{Stroke, Style};

/// The ink at a position of the paper for each tone: a repeating rectangle.
#[derive(Debug, Clone)]
pub struct TonalArtMap {
    texture: Texture,
    /// Texels per output pixel.
    texels_per_px: f32,
    pub(super) response: Response,
}

#[derive(Debug, Clone)]
enum Texture {
    Strokes(StrokeTexture),
    Slices(SliceTexture),
}

/// The texels of a map, row by row.
#[cfg(feature = "gpu")]
#[derive(Debug)]
pub(crate) enum MapTexels {
    /// For each texel, from the lowest byte up: the thresholds at which it begins to take ink and is full, and both of
    /// its right neighbour.
    Strokes(Vec<u32>),
    /// Ink of each texel, slice by slice from paper to black.
    Slices(Vec<f32>),
}

impl TonalArtMap {
    /// The map of strokes drawn along x one by one, chosen by `seed`.
    pub fn of_strokes(stroke: &Stroke, style: Style, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let canvas = DrawnTexels::drawn(stroke, style, &mut random);
        let texture = StrokeTexture::new(&canvas);
        Self {
            response: Response::of(&texture.mean_inks(&mut random), STEPS),
            texels_per_px: canvas.texels_per_px,
            texture: Texture::Strokes(texture),
        }
    }

    /// The map of `pictures` of one texture at several tones, as ink from 0, paper, to 1, black, in any order, strokes
    /// along x. They repeat without a seam if their borders meet; paper and black are added.
    ///
    /// # Panics
    /// If there are no pictures, or they differ in size.
    pub fn of_pictures(pictures: &[Plane], texels_per_px: f32) -> Self {
        let size = |p: &Plane| (p.width(), p.height());
        assert!(
            pictures
                .windows(2)
                .all(|pair| size(&pair[0]) == size(&pair[1])),
            "pictures of a tonal art map have one size"
        );
        let texture = SliceTexture::new(pictures);
        Self {
            response: Response::of(&texture.mean_inks(), texture.top()),
            texels_per_px,
            texture: Texture::Slices(texture),
        }
    }

    /// Texels per output pixel.
    pub fn texels_per_px(&self) -> f32 {
        self.texels_per_px
    }

    /// Texels across and down after which the map repeats.
    pub fn period(&self) -> [usize; 2] {
        match &self.texture {
            Texture::Strokes(texture) => [texture.side; 2],
            Texture::Slices(texture) => [texture.width, texture.height],
        }
    }

    /// The texels of the map, in the form used by kernels on a device.
    #[cfg(feature = "gpu")]
    pub(crate) fn texels(&self) -> MapTexels {
        match &self.texture {
            Texture::Strokes(texture) => MapTexels::Strokes(texture.pairs().collect()),
            Texture::Slices(texture) => MapTexels::Slices(texture.samples().collect()),
        }
    }

    /// Removes from `white` the ink at positions, at thresholds.
    #[inline(always)]
    pub(crate) fn cover(&self, white: &mut [f32], at: &mut Places, threshold: &[f32; BATCH]) {
        match &self.texture {
            Texture::Strokes(texture) => texture.cover(white, at, threshold),
            Texture::Slices(texture) => texture.cover(white, at, threshold),
        }
    }
}
