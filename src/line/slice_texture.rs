//! A tonal art map as slices: pictures from the lightest to the darkest.

use super::stroke_texture::Places;
use crate::frame::Plane;
use crate::line::stroke_texture::BATCH;

/// Pictures of one texture at several tones: rectangles that repeat, paper first and ink last.
#[derive(Debug, Clone)]
pub(super) struct SliceTexture {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Ink of each texel of each slice, 0..1.
    slices: Vec<Vec<f32>>,
}

impl SliceTexture {
    /// The texture of pictures of one size, as ink 0..1, in any order.
    pub(super) fn new(pictures: &[Plane]) -> Self {
        let first = &pictures[0];
        let (width, height) = (first.width(), first.height());
        let texels = width * height;
        let ink = |plane: &Plane| {
            plane
                .samples()
                .iter()
                .map(|&v| if v > 0.0 { v.min(1.0) } else { 0.0 })
                .collect()
        };
        let mut slices: Vec<Vec<f32>> = pictures.iter().map(ink).collect();
        slices.push(vec![0.0; texels]);
        slices.push(vec![1.0; texels]);
        slices.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        Self {
            width,
            height,
            slices,
        }
    }

    /// Ink of each texel of each slice, row by row.
    #[cfg(feature = "gpu")]
    pub(super) fn samples(&self) -> impl Iterator<Item = f32> {
        self.slices.iter().flatten().copied()
    }

    /// The threshold of the last slice.
    pub(super) fn top(&self) -> f32 {
        (self.slices.len() - 1) as f32
    }

    /// As [`super::stroke_texture::StrokeTexture::cover`], with thresholds that are slice numbers plus a fraction of
    /// the way to the next.
    #[inline(always)]
    pub(super) fn cover(&self, white: &mut [f32], at: &Places, threshold: &[f32; BATCH]) {
        for (i, white) in white.iter_mut().enumerate() {
            *white *= 1.0 - self.ink(at.x[i], at.y[i], threshold[i]);
        }
    }

    #[inline(always)]
    fn ink(&self, x: f32, y: f32, threshold: f32) -> f32 {
        let (left, right, across) = within(x, self.width);
        let (top, bottom, down) = within(y, self.height);
        let slice = (threshold as usize).min(self.slices.len() - 2);
        let of_slice = |slice: &[f32]| {
            let (top, bottom) = (top * self.width, bottom * self.width);
            let upper = mix(slice[top + left], slice[top + right], across);
            let lower = mix(slice[bottom + left], slice[bottom + right], across);
            mix(upper, lower, down)
        };
        let share = (threshold - slice as f32).clamp(0.0, 1.0);
        mix(
            of_slice(&self.slices[slice]),
            of_slice(&self.slices[slice + 1]),
            share,
        )
    }

    /// The mean ink at even steps of the threshold.
    pub(super) fn mean_inks(&self) -> Vec<f64> {
        let means: Vec<f64> = self.slices.iter().map(|slice| mean(slice)).collect();
        let steps = means.len() - 1;
        let at = |i: usize| {
            let (slice, share) = (i / STEPS, (i % STEPS) as f64 / STEPS as f64);
            let next = means[(slice + 1).min(steps)];
            means[slice] + share * (next - means[slice])
        };
        (0..=steps * STEPS).map(at).collect()
    }
}

/// The texels before and after a position along a side of a repeating texture, and the fraction of the way between
/// them.
#[inline(always)]
pub(crate) fn within(at: f32, size: usize) -> (usize, usize, f32) {
    let at = at.rem_euclid(size as f32);
    let first = (at as usize).min(size - 1);
    (first, (first + 1) % size, at - first as f32)
}

#[inline(always)]
pub(crate) fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + share * (b - a)
}

/// Steps of ink from a slice to the next.
const STEPS: usize = 64;

fn mean(slice: &[f32]) -> f64 {
    slice.iter().map(|&v| f64::from(v)).sum::<f64>() / slice.len() as f64
}
