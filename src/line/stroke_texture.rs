//! A tonal art map of strokes: the thresholds between which each texel turns from paper to ink.

use super::random::Random;
use super::stroke_synthesis::DrawnTexels;

/// Pixels that are worked on together.
pub(crate) const BATCH: usize = 64;

/// Texels by the thresholds between which they take ink: a repeating square.
#[derive(Debug, Clone)]
pub(super) struct StrokeTexture {
    /// Texels along a side, a power of two.
    pub(super) side: usize,
    /// Thresholds at which each texel begins to take ink, and is full, both in 0..1 times [`STEPS`]. Rows are a texel
    /// longer than the side, and end with a copy of their first.
    ramps: Vec<u8>,
}

/// The type of thresholds: bytes keep the texture in the cache, and two texels in one load.
pub(super) const STEPS: f32 = 255.0;

/// Bytes of a texel.
const RAMP: usize = 2;

/// Number of positions at which coverage is measured.
const MEASURED: usize = 1 << 16;

/// Number of thresholds at which coverage is measured.
const BINS: usize = 4096;

impl StrokeTexture {
    pub(super) fn new(canvas: &DrawnTexels) -> Self {
        let steps = |[begin, full]: [f32; 2]| -> [u8; RAMP] {
            let begin = (STEPS * begin).clamp(0.0, STEPS - 1.0).floor();
            let full = (STEPS * full).clamp(begin + 1.0, STEPS).round();
            [begin as u8, full as u8]
        };
        let side = canvas.side;
        let rows = canvas.ramps.chunks_exact(side);
        let ramps = rows.flat_map(|row| row.iter().chain(&row[..1]).copied().flat_map(steps));
        Self {
            side,
            ramps: ramps.collect(),
        }
    }

    /// Removes from `white` the ink at positions `at` (texels across and down), at thresholds.
    #[inline(always)]
    pub(super) fn cover(&self, white: &mut [f32], at: &mut Places, threshold: &[f32; BATCH]) {
        let count = white.len().min(BATCH);
        self.find(at, count);
        for (i, white) in white[..count].iter_mut().enumerate() {
            let [begin, full] = at.ramp(i);
            let ink = ((threshold[i] - begin) / (full - begin)).clamp(0.0, 1.0);
            *white *= 1.0 - ink;
        }
    }

    /// Fetches the texels around places.
    #[inline(always)]
    fn find(&self, at: &mut Places, count: usize) {
        let (wrap, stride) = (self.side as i32 - 1, self.side as i32 + 1);
        let Places { x, y, upper, lower } = at;
        for i in 0..count {
            let (column, row) = (x[i].floor(), y[i].floor());
            x[i] -= column;
            y[i] -= row;
            let (column, row) = (column as i32 & wrap, row as i32);
            upper[i] = (RAMP as i32 * ((row & wrap) * stride + column)) as u32;
            lower[i] = (RAMP as i32 * (((row + 1) & wrap) * stride + column)) as u32;
        }
        for i in 0..count {
            upper[i] = self.pair(upper[i]);
            lower[i] = self.pair(lower[i]);
        }
    }

    /// The texel at byte `at` and the one right of it.
    #[inline(always)]
    fn pair(&self, at: u32) -> u32 {
        let bytes = &self.ramps[at as usize..at as usize + 2 * RAMP];
        u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    /// Every texel with the one right of it, row by row.
    #[cfg(feature = "gpu")]
    pub(super) fn pairs(&self) -> impl Iterator<Item = u32> {
        let (side, stride) = (self.side, self.side + 1);
        let places =
            (0..side).flat_map(move |row| (0..side).map(move |column| row * stride + column));
        places.map(|place| self.pair((RAMP * place) as u32))
    }

    /// The mean ink at even steps of the threshold, measured as a drawing has it: anywhere between texels.
    pub(super) fn mean_inks(&self, random: &mut Random) -> Vec<f64> {
        // Ink rises linearly over each ramp, so its second differences are at the ends.
        let mut bends = vec![0.0_f64; BINS + 2];
        let mut bend = |at: f32, by: f64| {
            let at = at / STEPS * BINS as f32;
            let bin = (at as usize).min(BINS - 1);
            let share = f64::from(at - bin as f32);
            bends[bin] += by * (1.0 - share);
            bends[bin + 1] += by * share;
        };
        let side = self.side as f32;
        let mut places = Places::default();
        for _ in 0..MEASURED / BATCH {
            places.x.fill_with(|| side * random.unit());
            places.y.fill_with(|| side * random.unit());
            self.find(&mut places, BATCH);
            for i in 0..BATCH {
                let [begin, full] = places.ramp(i);
                let slope = f64::from(STEPS) / BINS as f64 / f64::from(full - begin);
                bend(begin, slope);
                bend(full, -slope);
            }
        }
        let (mut rise, mut ink) = (0.0, 0.0);
        let inks = bends[..=BINS].iter().map(|bend| {
            let here = ink / MEASURED as f64;
            rise += bend;
            ink += rise;
            here
        });
        inks.collect()
    }
}

/// Positions in a texture, in texels across and down, then the texels there.
#[derive(Debug)]
pub(crate) struct Places {
    /// Across; after texels are fetched, from the left ones to the right ones.
    pub(super) x: [f32; BATCH],
    /// Down; likewise.
    pub(super) y: [f32; BATCH],
    /// The two texels above, and the two below.
    upper: [u32; BATCH],
    lower: [u32; BATCH],
}

impl Default for Places {
    fn default() -> Self {
        Self {
            x: [0.0; BATCH],
            y: [0.0; BATCH],
            upper: [0; BATCH],
            lower: [0; BATCH],
        }
    }
}

impl Places {
    /// Thresholds at which the i-th position begins to take ink and is full.
    #[inline(always)]
    fn ramp(&self, i: usize) -> [f32; RAMP] {
        let (across, down) = (self.x[i], self.y[i]);
        let upper = ramp_between(self.upper[i], across);
        let lower = ramp_between(self.lower[i], across);
        std::array::from_fn(|k| upper[k] + down * (lower[k] - upper[k]))
    }
}

/// Thresholds at which a texel begins to take ink and is full, from two bytes of a word.
#[inline(always)]
pub(crate) fn ramp_of(word: u32) -> [f32; RAMP] {
    let byte = |k: usize| (word >> (8 * k) & 0xff) as i32 as f32;
    [byte(0), byte(1)]
}

/// Between the two texels of a word.
#[inline(always)]
pub(crate) fn ramp_between(word: u32, across: f32) -> [f32; RAMP] {
    let (left, right) = (ramp_of(word), ramp_of(word >> 16));
    std::array::from_fn(|k| left[k] + across * (right[k] - left[k]))
}
