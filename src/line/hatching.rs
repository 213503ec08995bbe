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
//!
//! Practice: pixels are worked on in batches along a row, where neighbours share a level, in loops that are
//! vectorised but for the loads of texels.

use super::random::Random;
use super::tonal_art_map::{MAX_DENSITY, TonalArtMap};
use crate::params::StrokeParams;
use glam::Vec2;
use std::f32::consts::PI;
use std::ops::Range;

/// Pixels that are worked on together.
pub const BATCH: usize = 64;

/// Pixels to be hatched: the first `count` of each array.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// How many.
    pub count: usize,
    /// Pixel coordinates, rows down, in which the texture lies still.
    pub place: [[f32; BATCH]; 2],
    /// Angles that strokes follow, 0..pi, counterclockwise.
    pub angle: [f32; BATCH],
    /// Optical density that is wanted in all: minus the logarithm of tone.
    pub wanted: [f32; BATCH],
    /// What of it the strokes to be drawn next give.
    pub density: [f32; BATCH],
    /// How much of the paper stays white, 0..1.
    pub white: [f32; BATCH],
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
        }
    }
}

impl Pixels {
    /// Asks one of `families` families of strokes for its share: all of the tone of one, and of a second,
    /// laid across it, what is darker than [`CROSSED_FROM`].
    #[inline(always)]
    pub fn share(&mut self, family: usize, families: usize) {
        let wanted = &self.wanted[..self.count];
        for (density, &wanted) in self.density.iter_mut().zip(wanted) {
            let crossed = (0.5 * (wanted - CROSSED_FROM)).max(0.0);
            *density = match (families, family) {
                (1, _) => wanted,
                (_, 0) => wanted - crossed,
                _ => crossed,
            };
        }
    }
}

/// Density from which on strokes are crossed by others, which give half of what is beyond: a third of the
/// paper is inked by then.
const CROSSED_FROM: f32 = 0.4;

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
    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        [
            self.cos * x - self.sin * y + self.offset.x,
            self.sin * x + self.cos * y + self.offset.y,
        ]
    }
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
    /// Hatching by the strokes of `map`; `family` keeps families of strokes over one another apart.
    pub fn new(map: &'a TonalArtMap, params: &StrokeParams, family: usize) -> Self {
        let (levels, sets) = (params.levels as usize, params.sets as usize);
        let mut random = Random::new(params.seed.wrapping_add(1 + family as u64));
        let scale = map.texels_per_px();
        let [width, height] = map.period().map(|texels| texels as f32);
        let turned = (0..levels * sets)
            .map(|i| {
                let (set, level) = (i / levels, i % levels);
                let angle = (level as f32 + set as f32 / sets as f32) * PI / levels as f32;
                Turned {
                    cos: scale * angle.cos(),
                    sin: scale * angle.sin(),
                    offset: Vec2::new(width * random.unit(), height * random.unit()),
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

    /// Draws over what is white so far.
    #[inline(always)]
    pub fn draw(&self, pixels: &mut Pixels) {
        let count = pixels.count;
        let mut level = Levels::default();
        for set in 0..self.sets {
            level.find(
                &pixels.angle[..count],
                self.levels,
                set as f32 / self.sets as f32,
            );
            let mut from = 0;
            while from < count {
                let below = level.below[from];
                let same = level.below[from..count].iter().take_while(|&&l| l == below);
                let run = from..from + same.count();
                from = run.end;
                let below = below as usize;
                let above = if below + 1 == self.levels {
                    0
                } else {
                    below + 1
                };
                let of_set = &self.turned[set * self.levels..][..self.levels];
                self.paste(&of_set[below], &level.weight[0], run.clone(), pixels);
                self.paste(&of_set[above], &level.weight[1], run, pixels);
            }
        }
        let (white, wanted) = (&mut pixels.white[..count], &pixels.wanted[..count]);
        for (white, &wanted) in white.iter_mut().zip(wanted) {
            *white = if wanted >= MAX_DENSITY { 0.0 } else { *white };
        }
    }

    /// Pastes one level's strokes over a run of pixels.
    #[inline(always)]
    fn paste(
        &self,
        turned: &Turned,
        weight: &[f32; BATCH],
        run: Range<usize>,
        pixels: &mut Pixels,
    ) {
        let count = run.len();
        let share = 1.0 / self.sets as f32;
        let mut threshold = [0.0; BATCH];
        let mut any = 0.0_f32;
        let (weight, density) = (&weight[run.clone()], &pixels.density[run.clone()]);
        for (i, threshold) in threshold[..count].iter_mut().enumerate() {
            *threshold = self.map.threshold(weight[i] * share * density[i]);
            any = any.max(*threshold);
        }
        if any <= 0.0 {
            return;
        }
        let mut at = [[0.0; BATCH]; 2];
        let (x, y) = (&pixels.place[0][run.clone()], &pixels.place[1][run.clone()]);
        let [u, v] = &mut at;
        for i in 0..count {
            [u[i], v[i]] = turned.at(x[i], y[i]);
        }
        self.map.cover(&mut pixels.white[run], &at, &threshold);
    }
}

/// The two levels next to each angle and their tent weights.
struct Levels {
    below: [u32; BATCH],
    weight: [[f32; BATCH]; 2],
}

impl Default for Levels {
    fn default() -> Self {
        Self {
            below: [0; BATCH],
            weight: [[0.0; BATCH]; 2],
        }
    }
}

impl Levels {
    /// Among `levels` over half a turn, all of them `offset` of one further on. Past the last comes the
    /// first again.
    #[inline(always)]
    fn find(&mut self, angles: &[f32], levels: usize, offset: f32) {
        let (count, last) = (levels as f32, levels as f32 - 1.0);
        let [below_weight, above_weight] = &mut self.weight;
        for (i, &angle) in angles.iter().enumerate() {
            let at = angle * (count / PI) - offset;
            let at = if at < 0.0 { at + count } else { at };
            let below = at.floor().min(last);
            let away = (at - below).min(1.0);
            self.below[i] = below as i32 as u32;
            below_weight[i] = 1.0 - away;
            above_weight[i] = away;
        }
    }
}
