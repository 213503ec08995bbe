//! Hatching: stroke textures cut and pasted along a field of directions.
//!
//! Theory: [LA] sections 6.2 and 6.3. Directions are quantised to levels over half a turn; at each level the
//! stroke texture is turned to the level's angle (equation 8), neighbouring levels are blended by tent
//! weights, and several sets of levels, each offset by its share of a level, are laid over one another.
//! Changes: what is blended is not grey values but tone. A layer of weight w gets the share w of the optical
//! density that is wanted, -ln(1 - darkness), and layers are printed over one another, so paper stays white
//! with the product of what each leaves white: (1 - d)^(sum of w). Means are exact, ink stays black, and toward
//! the border of a partition strokes drop out one by one where an average would fade all to grey. Each level
//! has a place of its own in the texture; turned about one point, all would agree there.

use super::random::Random;
use super::tonal_art_map::{MAX_DENSITY, TonalArtMap};
use crate::params::StrokeParams;
use glam::Vec2;
use std::f32::consts::PI;

/// A texture turned to a level's angle: texture coordinates of pixel coordinates, rows down.
#[derive(Debug, Clone, Copy)]
struct Turned {
    cos: f32,
    sin: f32,
    offset: Vec2,
}

impl Turned {
    /// [LA] equation 8, for angles counterclockwise: along the angle only the first coordinate grows.
    #[inline(always)]
    fn at(&self, p: Vec2) -> Vec2 {
        Vec2::new(
            self.cos * p.x - self.sin * p.y,
            self.sin * p.x + self.cos * p.y,
        ) + self.offset
    }
}

/// Strokes ready to be pasted at any angle.
#[derive(Debug)]
pub struct Hatching<'a> {
    map: &'a TonalArtMap,
    levels: usize,
    /// Level by level, set by set.
    turned: Vec<Turned>,
    sets: usize,
}

/// Families of strokes: along one principal direction, and for the dark along the other.
pub const MAX_FAMILIES: usize = 2;

impl<'a> Hatching<'a> {
    /// Hatching by the strokes of `map`; `family` keeps two families over one another apart.
    pub fn new(map: &'a TonalArtMap, params: &StrokeParams, family: usize) -> Self {
        let (levels, sets) = (params.levels as usize, params.sets as usize);
        let mut random = Random::new(params.seed.wrapping_add(1 + family as u64));
        let scale = map.texels_per_px();
        let side = map.side() as f32;
        let turned = (0..levels * sets)
            .map(|i| {
                let (set, level) = (i / levels, i % levels);
                let angle = (level as f32 + set as f32 / sets as f32) * PI / levels as f32;
                Turned {
                    cos: scale * angle.cos(),
                    sin: scale * angle.sin(),
                    offset: Vec2::new(side * random.unit(), side * random.unit()),
                }
            })
            .collect();
        Self {
            map,
            levels,
            turned,
            sets,
        }
    }

    /// How much of the paper stays white, 0..1, at pixel coordinates `p` (rows down) where strokes follow
    /// the angle `angle`, 0..pi counterclockwise, and `density` is wanted.
    #[inline]
    pub fn white(&self, p: Vec2, angle: f32, density: f32) -> f32 {
        if density <= 0.0 {
            return 1.0;
        }
        if density >= MAX_DENSITY {
            return 0.0;
        }
        let mut white = 1.0;
        let share = density / self.sets as f32;
        let at = angle * (self.levels as f32 / PI);
        for set in 0..self.sets {
            // 0..levels, past the last level the first again.
            let at = at - set as f32 / self.sets as f32;
            let at = if at < 0.0 {
                at + self.levels as f32
            } else {
                at
            };
            let below = (at as usize).min(self.levels - 1);
            let above = if below + 1 == self.levels {
                0
            } else {
                below + 1
            };
            let away = (at - below as f32).clamp(0.0, 1.0);
            let of_set = &self.turned[set * self.levels..][..self.levels];
            for (level, weight) in [(below, 1.0 - away), (above, away)] {
                let threshold = self.map.threshold(weight * share);
                if threshold > 0.0 {
                    let t = of_set[level].at(p);
                    white *= 1.0 - self.map.ink(t.x, t.y, threshold);
                }
            }
        }
        white
    }
}
