//! Tonal art maps: how much ink a place of the paper takes at each tone.
//!
//! Theory: a tonal art map is a volume, tone by two dimensions, whose darker slices keep all strokes of the
//! lighter ones ([LA] section 6, after Praun et al.). So each texel turns from paper to ink once, as tone
//! darkens, and a volume of strokes is stored as where that begins and ends: two numbers a texel in place of a
//! stack of slices, every tone its own slice, nested without exception. A stroke takes longer to reach its
//! rim and its ends, so it swells as it darkens. Coverage of texels is in the numbers: lines are
//! anti-aliased, and between texels it is the numbers that are interpolated, so lines stay sharp where a
//! picture of them would blur. A user's own pictures make an ordinary stack.
//!
//! Practice: thresholds are in no unit; the darkness wanted is turned into one by measured coverage, so the
//! mean of a drawn tone is that tone.

pub(crate) mod cached;
pub(crate) mod stage;

#[cfg(feature = "gpu")]
pub(crate) use super::response::ENTRIES;
pub(crate) use super::response::MAX_DENSITY;

use super::random::Random;
use super::response::Response;
use super::slice_texture::SliceTexture;
use super::stroke_synthesis::Canvas;
use super::stroke_texture::{Places, STEPS, StrokeTexture};
use crate::frame::Plane;
use crate::line::stroke_texture::BATCH;
use crate::params::{Stroke, Style};

/// How much ink a place of the paper takes at each tone: a rectangle that repeats.
#[derive(Debug, Clone)]
pub struct TonalArtMap {
    texture: Texture,
    /// Texels per output pixel.
    texels_per_px: f32,
    response: Response,
}

#[derive(Debug, Clone)]
enum Texture {
    Strokes(StrokeTexture),
    Slices(SliceTexture),
}

/// The texels of a map, row by row.
#[cfg(feature = "gpu")]
#[derive(Debug)]
pub(crate) enum Texels {
    /// Of each texel, from the lowest byte up, where it begins to take ink and where it is full, and both of the one
    /// right of it.
    Strokes(Vec<u32>),
    /// How much ink each holds, slice by slice from paper to black.
    Slices(Vec<f32>),
}

impl TonalArtMap {
    /// The map of strokes drawn along x one by one, chosen by `seed`.
    pub fn of_strokes(stroke: &Stroke, style: Style, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let canvas = Canvas::drawn(stroke, style, &mut random);
        let texture = StrokeTexture::new(&canvas);
        Self {
            response: Response::of(&texture.mean_inks(&mut random), STEPS),
            texels_per_px: canvas.texels_per_px,
            texture: Texture::Strokes(texture),
        }
    }

    /// The map of `pictures` of one texture at several tones, as ink from 0, paper, to 1, black, in any
    /// order, strokes along x. They repeat without a seam if their borders meet; paper and black are added.
    ///
    /// # Panics
    /// If there are none, or they differ in size.
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

    /// All thresholds, from density 0 to [`MAX_DENSITY`].
    #[cfg(feature = "gpu")]
    pub(crate) fn thresholds(&self) -> &[f32] {
        self.response.thresholds()
    }

    /// The texels of the map, as kernels on a device take them.
    #[cfg(feature = "gpu")]
    pub(crate) fn texels(&self) -> Texels {
        match &self.texture {
            Texture::Strokes(texture) => Texels::Strokes(texture.pairs().collect()),
            Texture::Slices(texture) => Texels::Slices(texture.samples().collect()),
        }
    }

    /// Where [`TonalArtMap::threshold`] looks a density up: minus the logarithm of what stays white.
    #[inline(always)]
    pub(crate) fn entry(&self, density: f32) -> u32 {
        Response::entry(density)
    }

    /// The threshold at which as much of the paper is inked as the density says.
    #[inline(always)]
    pub(crate) fn threshold(&self, entry: u32) -> f32 {
        self.response.threshold(entry)
    }

    /// Takes from `white` what is inked at places, at thresholds.
    #[inline(always)]
    pub(crate) fn cover(&self, white: &mut [f32], at: &mut Places, threshold: &[f32; BATCH]) {
        match &self.texture {
            Texture::Strokes(texture) => texture.cover(white, at, threshold),
            Texture::Slices(texture) => texture.cover(white, at, threshold),
        }
    }
}
