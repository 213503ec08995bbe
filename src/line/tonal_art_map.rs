//! Tonal art maps: how much ink a place of the paper takes at each tone.
//!
//! Theory: a tonal art map is a volume, tone by two dimensions, whose darker slices keep all strokes of the
//! lighter ones ([LA] section 6, after Praun et al.). So each texel turns from paper to ink once, as tone
//! darkens, and the volume is told by where that begins and ends: two numbers a texel in place of a stack of
//! slices, every tone its own slice, nested without exception. Strokes drawn one by one are spread so that
//! each lies where the paper is emptiest; a stroke takes longer to reach its rim and its ends, so it swells
//! as it darkens. Coverage of texels is in the numbers: lines are anti-aliased, and between texels it is
//! the numbers that are interpolated, so lines stay sharp where a picture of them would blur.
//!
//! Practice: thresholds are in no unit; [`TonalArtMap::threshold`] turns the darkness wanted into one, by
//! measured coverage, so the mean of a drawn tone is that tone.

use super::random::Random;
use crate::params::{Stroke, Style};

/// How much ink a place of the paper takes at each tone: a square that repeats.
#[derive(Debug, Clone)]
pub struct TonalArtMap {
    /// Texels along a side, a power of two.
    side: usize,
    /// Texels per output pixel.
    texels_per_px: f32,
    /// Where each texel begins to take ink, and where it is full, both in 0..1 times [`STEPS`].
    ramps: Vec<[u16; 2]>,
    response: Response,
}

/// What thresholds are counted in.
const STEPS: f32 = 65535.0;

/// Most texels along a side: a quarter of a million in all.
const MAX_SIDE: usize = 512;

impl TonalArtMap {
    /// The map of strokes drawn along x, one after another, chosen by `seed`.
    pub fn of_strokes(stroke: &Stroke, style: Style, seed: u64) -> Self {
        let canvas = super::stroke_synthesis::Canvas::drawn(stroke, style, seed, MAX_SIDE);
        Self::new(canvas.side, canvas.texels_per_px, canvas.ramps, seed)
    }

    fn new(side: usize, texels_per_px: f32, ramps: Vec<[f32; 2]>, seed: u64) -> Self {
        let steps = |[begin, full]: [f32; 2]| {
            let begin = (STEPS * begin).clamp(0.0, STEPS - NARROWEST);
            let full = (STEPS * full).clamp(begin + NARROWEST, STEPS);
            [begin.round() as u16, full.round() as u16]
        };
        let ramps = ramps.into_iter().map(steps).collect();
        let mut map = Self {
            side,
            texels_per_px,
            ramps,
            response: Response::identity(),
        };
        map.response = Response::of(&map, seed);
        map
    }

    /// Texels per output pixel.
    pub fn texels_per_px(&self) -> f32 {
        self.texels_per_px
    }

    /// Texels along a side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// The threshold at which as much of the paper is inked as `density` (minus the logarithm of what
    /// stays white) says.
    #[inline]
    pub fn threshold(&self, density: f32) -> f32 {
        self.response.threshold(density)
    }

    /// Ink, 0..1, at a position in texels, at a threshold.
    #[inline(always)]
    pub fn ink(&self, x: f32, y: f32, threshold: f32) -> f32 {
        let [begin, full] = self.ramp(x, y);
        ((threshold - begin) / (full - begin)).clamp(0.0, 1.0)
    }

    /// Where a place begins to take ink and where it is full.
    #[inline(always)]
    fn ramp(&self, x: f32, y: f32) -> [f32; 2] {
        let (column, row) = (x.floor(), y.floor());
        let (across, down) = (x - column, y - row);
        let wrap = self.side - 1;
        let (left, top) = (column as i32 as usize & wrap, row as i32 as usize & wrap);
        let (right, bottom) = ((left + 1) & wrap, (top + 1) & wrap);
        let (top, bottom) = (top * self.side, bottom * self.side);
        let at = |i: usize| self.ramps[i].map(f32::from);
        let (a, b) = (at(top + left), at(top + right));
        let (c, d) = (at(bottom + left), at(bottom + right));
        std::array::from_fn(|k| {
            let upper = a[k] + across * (b[k] - a[k]);
            let lower = c[k] + across * (d[k] - c[k]);
            upper + down * (lower - upper)
        })
    }
}

/// Fewest steps from paper to ink: what a division by their number still bears.
const NARROWEST: f32 = 16.0;

/// From the density wanted to the threshold that gives it, by measurement.
#[derive(Debug, Clone)]
struct Response {
    thresholds: Vec<f32>,
}

/// Entries of the response, and the density of the last one.
const ENTRIES: usize = 1024;
/// Density past which paper is black: 0.2 % stay white.
pub const MAX_DENSITY: f32 = 6.0;

/// Places at which coverage is measured.
const MEASURED: usize = 1 << 16;

impl Response {
    fn identity() -> Self {
        Self {
            thresholds: vec![0.0; ENTRIES + 1],
        }
    }

    /// Measures the mean ink of `map` at every threshold, at places as the drawing has them: anywhere
    /// between texels.
    fn of(map: &TonalArtMap, seed: u64) -> Self {
        // Ink rises over each ramp by the same amount per step: its second differences are at the ends.
        let mut bends = vec![0.0_f64; BINS + 2];
        let mut random = Random::new(seed ^ 0x5eed);
        let side = map.side as f32;
        let mut bend = |at: f32, by: f64| {
            let at = at / STEPS * BINS as f32;
            let bin = (at as usize).min(BINS - 1);
            let share = f64::from(at - bin as f32);
            bends[bin] += by * (1.0 - share);
            bends[bin + 1] += by * share;
        };
        for _ in 0..MEASURED {
            let [begin, full] = map.ramp(side * random.unit(), side * random.unit());
            let slope = f64::from(STEPS) / BINS as f64 / f64::from(full - begin);
            bend(begin, slope);
            bend(full, -slope);
        }
        let (mut rise, mut ink) = (0.0, 0.0);
        let inks: Vec<f64> = (0..=BINS)
            .map(|bin| {
                let here = ink / MEASURED as f64;
                rise += bends[bin];
                ink += rise;
                here
            })
            .collect();
        Self {
            thresholds: inverted(&inks),
        }
    }

    #[inline(always)]
    fn threshold(&self, density: f32) -> f32 {
        let at = (density * (ENTRIES as f32 / MAX_DENSITY)).clamp(0.0, ENTRIES as f32);
        let entry = (at as usize).min(ENTRIES - 1);
        let (a, b) = (self.thresholds[entry], self.thresholds[entry + 1]);
        a + (at - entry as f32) * (b - a)
    }
}

/// Bins of thresholds.
const BINS: usize = 4096;

/// The thresholds at which the mean ink, told per bin and rising, reaches that of each density.
fn inverted(inks: &[f64]) -> Vec<f32> {
    let mut bin = 0;
    (0..=ENTRIES)
        .map(|entry| {
            let density = f64::from(MAX_DENSITY) * entry as f64 / ENTRIES as f64;
            let wanted = -(-density).exp_m1();
            while bin + 1 < BINS && inks[bin + 1] < wanted {
                bin += 1;
            }
            let (low, high) = (inks[bin], inks[bin + 1]);
            let share = ((wanted - low) / (high - low).max(1e-12)).clamp(0.0, 1.0);
            ((bin as f64 + share) / BINS as f64) as f32 * STEPS
        })
        .collect()
}
