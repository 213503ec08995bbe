//! Hatching: stroke textures cut and pasted along a field of directions.
//!
//! Theory: [LA] sections 6.2 and 6.3. Directions are quantised to levels over half a turn; at each level the stroke
//! texture is rotated to the level's angle (equation 8), neighbouring levels are blended by tent weights, and several
//! sets of levels, each offset by its share of a level, are overlaid. Changes: not grey values but tones are blended. A
//! layer of weight w gets the share w of the optical density wanted, -ln(1 - darkness), and layers are printed over one
//! another, so the white of the paper is the product of the layers': (1 - d)^(sum of w). Means are exact, ink stays
//! black, and toward the border of a partition strokes drop out one by one where an average would fade all to grey.
//! Each level has its own offset in the texture; rotated about one point, all would coincide there.
//!
//! Practice: pixels are processed in batches along a row, where neighbours share a level, in loops that are vectorised
//! except for the loads of texels.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu_texture;
pub(crate) mod stage;

use super::random::Random;
use super::response::Response;
use super::stroke_texture::{BATCH, Places};
use super::tonal_art_map::{MAX_DENSITY, TonalArtMap};
use crate::params::StrokeParams;
use glam::Vec2;
use std::f32::consts::PI;

/// Pixels to be hatched: the first `count` of each array.
#[derive(Debug)]
pub struct Pixels {
    /// Number of pixels.
    pub count: usize,
    /// Pixel coordinates, rows down, in the texture's fixed frame.
    pub place: [[f32; BATCH]; 2],
    /// Angles that strokes follow, 0..pi, counterclockwise.
    pub angle: [f32; BATCH],
    /// Optical density that is wanted in all: minus the logarithm of tone.
    pub wanted: [f32; BATCH],
    /// The share of it that the next strokes give.
    pub density: [f32; BATCH],
    /// Share of the paper left white, 0..1.
    pub white: [f32; BATCH],
    scratch: LevelScratch,
}

/// Scratch memory of one level.
#[derive(Debug)]
struct LevelScratch {
    /// The two levels next to each angle, and their tent weights.
    level: [[u32; BATCH]; 2],
    weight: [[f32; BATCH]; 2],
    /// Thresholds, with their entries in the response.
    entry: [u32; BATCH],
    threshold: [f32; BATCH],
    /// Rotation of the texture: cosine, sine, and offset across and down.
    turned: [[f32; BATCH]; 4],
    places: Places,
}

impl Default for LevelScratch {
    fn default() -> Self {
        Self {
            level: [[0; BATCH]; 2],
            weight: [[0.0; BATCH]; 2],
            entry: [0; BATCH],
            threshold: [0.0; BATCH],
            turned: [[0.0; BATCH]; 4],
            places: Places::default(),
        }
    }
}

impl Default for Pixels {
    fn default() -> Self {
        Self {
            count: 0,
            place: [[0.0; BATCH]; 2],
            angle: [0.0; BATCH],
            wanted: [0.0; BATCH],
            density: [0.0; BATCH],
            white: [1.0; BATCH],
            scratch: LevelScratch::default(),
        }
    }
}

impl Pixels {
    /// Pixels that fit.
    pub const MOST: usize = BATCH;

    /// Sets the density to the share of one of `families` families of strokes: all of the tone with one family, and for
    /// a second, crossing it, half of the excess over a third of the ink.
    #[inline(always)]
    pub fn share(&mut self, family: usize, families: usize) {
        let wanted = &self.wanted[..self.count];
        for (density, &wanted) in self.density.iter_mut().zip(wanted) {
            *density = share(wanted, family, families);
        }
    }
}

/// Share of one of `families` families of strokes in the optical density wanted: see [`Pixels::share`].
#[inline(always)]
pub(crate) fn share(wanted: f32, family: usize, families: usize) -> f32 {
    share_from(CROSSED_FROM, wanted, family, families)
}

/// The same with another density from which strokes are crossed.
#[inline(always)]
pub(crate) fn share_from(from: f32, wanted: f32, family: usize, families: usize) -> f32 {
    let crossed = (0.5 * (wanted - from)).max(0.0);
    match (families, family) {
        (1, _) => wanted,
        (_, 0) => wanted - crossed,
        _ => crossed,
    }
}

/// Density from which strokes are crossed by others, which get half of the excess: a third of the paper is inked by
/// then.
pub(crate) const CROSSED_FROM: f32 = 0.4;

/// A texture rotated to a level's angle: maps pixel coordinates, rows down, to texture coordinates.
#[derive(Debug, Clone, Copy)]
struct Turned {
    cos: f32,
    sin: f32,
    offset: Vec2,
}

/// Strokes ready to be pasted at any angle.
#[derive(Debug)]
pub struct Hatching<'a> {
    map: &'a TonalArtMap,
    levels: usize,
    sets: usize,
    /// Level by level, set by set.
    turned: Vec<Turned>,
}

impl<'a> Hatching<'a> {
    /// Hatching by the strokes of `map`; `family` distinguishes overlaid families of strokes.
    pub fn new(map: &'a TonalArtMap, params: &StrokeParams, family: usize) -> Self {
        let (levels, sets) = (params.levels as usize, params.sets as usize);
        let mut random = Random::new(params.seed.wrapping_add(1 + family as u64));
        let scale = map.texels_per_px();
        let [width, height] = map.period().map(|texels| texels as f32);
        let mut at = |period: f32| (period * random.unit()).floor() + BETWEEN;
        let turned = (0..levels * sets)
            .map(|i| {
                let (set, level) = (i / levels, i % levels);
                let angle = (level as f32 + set as f32 / sets as f32) * PI / levels as f32;
                Turned {
                    cos: scale * angle.cos(),
                    sin: scale * angle.sin(),
                    offset: Vec2::new(at(width), at(height)),
                }
            })
            .collect();
        Self {
            map,
            levels,
            sets,
            turned,
        }
    }

    /// Transform of the texture at every level, set by set: cosine and sine of its rotation, times texels per pixel,
    /// and its offset across and down.
    #[cfg(feature = "gpu")]
    pub(crate) fn turned(&self) -> impl Iterator<Item = [f32; 4]> {
        let turned = self.turned.iter();
        turned.map(|turned| [turned.cos, turned.sin, turned.offset.x, turned.offset.y])
    }

    /// Draws over the paper left white so far.
    #[inline(always)]
    pub fn draw(&self, pixels: &mut Pixels) {
        let Pixels {
            count,
            place,
            angle,
            wanted,
            density,
            white,
            scratch,
        } = pixels;
        let count = *count;
        for set in 0..self.sets {
            scratch.find(&angle[..count], self.levels, set as f32 / self.sets as f32);
            let of_set = &self.turned[set * self.levels..][..self.levels];
            for side in 0..2 {
                if !self.thresholds(scratch, side, &density[..count]) {
                    continue;
                }
                scratch.turn(side, of_set, place, count);
                let LevelScratch {
                    places, threshold, ..
                } = scratch;
                self.map.cover(&mut white[..count], places, threshold);
            }
        }
        for (white, &wanted) in white[..count].iter_mut().zip(&wanted[..count]) {
            *white = if wanted >= MAX_DENSITY { 0.0 } else { *white };
        }
    }

    /// The thresholds that give weighted shares of densities, on one side of each angle; whether any gives ink.
    #[inline(always)]
    fn thresholds(&self, scratch: &mut LevelScratch, side: usize, density: &[f32]) -> bool {
        let (weight, entry, threshold) = (
            &scratch.weight[side],
            &mut scratch.entry,
            &mut scratch.threshold,
        );
        let share = 1.0 / self.sets as f32;
        let count = density.len().min(BATCH);
        for i in 0..count {
            entry[i] = Response::entry(weight[i] * share * density[i]);
        }
        let mut most = 0.0_f32;
        for i in 0..count {
            threshold[i] = self.map.response.threshold(entry[i]);
            most = most.max(threshold[i]);
        }
        most > 0.0
    }
}

/// Position of the first pixel's centre between texels, plus its own half: a level along the axes has all pixels there.
/// On texels lines are darker than on average, midway lighter; at a quarter neither.
const BETWEEN: f32 = 0.75;

impl LevelScratch {
    /// Finds the places at the levels on one side of each angle. [LA] equation 8, for angles counterclockwise: along the
    /// angle only the first coordinate grows.
    #[inline(always)]
    fn turn(&mut self, side: usize, of_set: &[Turned], [x, y]: &[[f32; BATCH]; 2], count: usize) {
        let count = count.min(BATCH);
        let [cos, sin, across, down] = &mut self.turned;
        for (i, &level) in self.level[side][..count].iter().enumerate() {
            let turned = of_set[level as usize];
            (cos[i], sin[i]) = (turned.cos, turned.sin);
            (across[i], down[i]) = (turned.offset.x, turned.offset.y);
        }
        for i in 0..count {
            self.places.x[i] = cos[i] * x[i] - sin[i] * y[i] + across[i];
            self.places.y[i] = sin[i] * x[i] + cos[i] * y[i] + down[i];
        }
    }

    /// Among `levels` over half a turn, all of them `offset` of one further on. Past the last comes the
    /// first again.
    #[inline(always)]
    fn find(&mut self, angles: &[f32], levels: usize, offset: f32) {
        let (count, last) = (levels as f32, levels as f32 - 1.0);
        let ([below, above], [below_weight, above_weight]) = (&mut self.level, &mut self.weight);
        for (i, &angle) in angles.iter().enumerate() {
            let at = angle * (count / PI) - offset;
            let at = if at < 0.0 { at + count } else { at };
            let level = at.floor().min(last);
            let next = if level == last { 0.0 } else { level + 1.0 };
            // A level that is alone has no other to share with.
            let away = if last == 0.0 {
                0.0
            } else {
                (at - level).min(1.0)
            };
            below[i] = level as i32 as u32;
            above[i] = next as i32 as u32;
            below_weight[i] = 1.0 - away;
            above_weight[i] = away;
        }
    }
}
