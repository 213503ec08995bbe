//! A tonal art map of strokes, told by where each texel turns from paper to ink.

use super::hatching::BATCH;
use super::random::Random;
use super::stroke_synthesis::Canvas;

/// Texels by the thresholds between which they take ink: a square that repeats.
#[derive(Debug, Clone)]
pub(super) struct StrokeTexture {
    /// Texels along a side, a power of two.
    pub(super) side: usize,
    /// Where each texel begins to take ink, and where it is full, both in 0..1 times [`STEPS`]. Rows are a
    /// texel longer than the side, and end with their first.
    ramps: Vec<[u16; 2]>,
}

/// What thresholds are counted in.
pub(super) const STEPS: f32 = 65535.0;

/// Fewest steps from paper to ink: what a division by their number still bears.
const NARROWEST: f32 = 16.0;

/// Places at which coverage is measured.
const MEASURED: usize = 1 << 16;

/// Thresholds at which it is.
const BINS: usize = 4096;

impl StrokeTexture {
    pub(super) fn new(canvas: &Canvas) -> Self {
        let steps = |[begin, full]: [f32; 2]| {
            let begin = (STEPS * begin).clamp(0.0, STEPS - NARROWEST);
            let full = (STEPS * full).clamp(begin + NARROWEST, STEPS);
            [begin.round() as u16, full.round() as u16]
        };
        let side = canvas.side;
        let rows = canvas.ramps.chunks_exact(side);
        let ramps = rows.flat_map(|row| row.iter().chain(&row[..1]).copied().map(steps));
        Self {
            side,
            ramps: ramps.collect(),
        }
    }

    /// Takes from `white` what is inked at positions `at` (texels across and down), at thresholds.
    #[inline(always)]
    pub(super) fn cover(
        &self,
        white: &mut [f32],
        at: &[[f32; BATCH]; 2],
        threshold: &[f32; BATCH],
    ) {
        let count = white.len().min(BATCH);
        let mut texels = Texels::default();
        texels.find(self, at, count);
        for (i, white) in white[..count].iter_mut().enumerate() {
            let [begin, full] = texels.ramp(i);
            let ink = ((threshold[i] - begin) / (full - begin)).clamp(0.0, 1.0);
            *white *= 1.0 - ink;
        }
    }

    /// The mean ink at even steps of the threshold, measured as a drawing has it: anywhere between texels.
    pub(super) fn mean_inks(&self, random: &mut Random) -> Vec<f64> {
        // Ink rises over each ramp by the same amount per step: its second differences are at the ends.
        let mut bends = vec![0.0_f64; BINS + 2];
        let mut bend = |at: f32, by: f64| {
            let at = at / STEPS * BINS as f32;
            let bin = (at as usize).min(BINS - 1);
            let share = f64::from(at - bin as f32);
            bends[bin] += by * (1.0 - share);
            bends[bin + 1] += by * share;
        };
        let side = self.side as f32;
        let mut texels = Texels::default();
        for _ in 0..MEASURED / BATCH {
            let places = [(); 2].map(|()| [(); BATCH].map(|()| side * random.unit()));
            texels.find(self, &places, BATCH);
            for i in 0..BATCH {
                let [begin, full] = texels.ramp(i);
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

/// The texels around places, and where between them the places are.
struct Texels {
    /// Index of the texel left above, and of the one below that.
    left: [[u32; BATCH]; 2],
    /// Left above, right above, left below, right below: begin and full.
    corners: [[[u16; BATCH]; 4]; 2],
    across: [f32; BATCH],
    down: [f32; BATCH],
}

impl Default for Texels {
    fn default() -> Self {
        Self {
            left: [[0; BATCH]; 2],
            corners: [[[0; BATCH]; 4]; 2],
            across: [0.0; BATCH],
            down: [0.0; BATCH],
        }
    }
}

impl Texels {
    #[inline(always)]
    fn find(&mut self, map: &StrokeTexture, at: &[[f32; BATCH]; 2], count: usize) {
        let (wrap, stride) = (map.side as i32 - 1, map.side as i32 + 1);
        let [upper, lower] = &mut self.left;
        for i in 0..count {
            let (x, y) = (at[0][i], at[1][i]);
            let (column, row) = (x.floor(), y.floor());
            self.across[i] = x - column;
            self.down[i] = y - row;
            let (column, row) = (column as i32 & wrap, row as i32);
            upper[i] = ((row & wrap) * stride + column) as u32;
            lower[i] = (((row + 1) & wrap) * stride + column) as u32;
        }
        let [begin, full] = &mut self.corners;
        for i in 0..count {
            for (k, left) in [upper[i] as usize, lower[i] as usize]
                .into_iter()
                .enumerate()
            {
                let pair = &map.ramps[left..left + 2];
                [begin[2 * k][i], full[2 * k][i]] = pair[0];
                [begin[2 * k + 1][i], full[2 * k + 1][i]] = pair[1];
            }
        }
    }

    /// Where the i-th place begins to take ink and where it is full.
    #[inline(always)]
    fn ramp(&self, i: usize) -> [f32; 2] {
        let (across, down) = (self.across[i], self.down[i]);
        std::array::from_fn(|k| {
            let corner = |j: usize| f32::from(self.corners[k][j][i]);
            let upper = corner(0) + across * (corner(1) - corner(0));
            let lower = corner(2) + across * (corner(3) - corner(2));
            upper + down * (lower - upper)
        })
    }
}
