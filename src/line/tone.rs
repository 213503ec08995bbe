//! From the luminance of a picture to the optical density of the drawing.

use crate::frame::memory::Memory;
use crate::frame::rows::map_rows;
use crate::frame::{ColorPlanes, Frame, Plane, luminance};
use crate::kernel::simd::wide;
use crate::line::density::{LEAST_ALPHA, STEPS};
use crate::line::stroke_texture::BATCH;
use std::ops::Range;

/// The optical densities that are drawn.
pub(crate) enum Densities<'a> {
    /// Densities of a picture.
    OfPicture(PictureDensities<'a>),
    /// These.
    Found(&'a Plane),
}

impl Densities<'_> {
    /// The densities of `columns` of row `y`, at most a batch.
    pub(crate) fn row(&self, out: &mut [f32], y: usize, columns: Range<usize>) {
        match self {
            Self::OfPicture(densities) => densities.row(out, y, columns),
            Self::Found(plane) => out.copy_from_slice(&plane.row(y)[columns]),
        }
    }

    /// `row(y)(x, density)` for the densities of the covered pixels; 0 elsewhere.
    pub(crate) fn mapped<Sample: Fn(usize, f32) -> f32>(
        &self,
        frame: &Frame,
        memory: &Memory,
        row: impl Fn(usize) -> Sample + Sync,
    ) -> Plane {
        let [mapped] = map_rows(&frame.mask, memory, |y, [out]| {
            let sample = row(y);
            for run in frame.mask.runs(y) {
                for from in run.clone().step_by(BATCH) {
                    let columns = from..(from + BATCH).min(run.end);
                    self.row(&mut out[columns.clone()], y, columns.clone());
                    let samples = columns.clone().zip(&mut out[columns]);
                    samples.for_each(|(x, density)| *density = sample(x, *density));
                }
            }
        });
        mapped
    }
}

/// The optical density of a picture, -ln(tone), looked up by luminance.
pub(crate) struct PictureDensities<'a> {
    pub(crate) color: &'a ColorPlanes,
    pub(crate) frame: &'a Frame,
    pub(crate) weights: [f32; 3],
    /// Luminance of paper white.
    pub(crate) white: f32,
    /// Densities at even steps of the square root of luminance, from 0 to white.
    pub(crate) table: Vec<f32>,
}

impl PictureDensities<'_> {
    fn row(&self, out: &mut [f32], y: usize, columns: Range<usize>) {
        let ColorPlanes { r, g, b } = self.color;
        let color = [r, g, b].map(|plane| &plane.row(y)[columns.clone()]);
        let alpha = self.frame.alpha.as_ref();
        let alpha = alpha.map(|plane| &plane.row(y)[columns.clone()]);
        wide!(density_row(out, color, alpha, self));
    }
}

/// The optical densities of a batch of colours, premultiplied by alpha.
#[inline(always)]
pub(crate) fn density_row(
    out: &mut [f32],
    [r, g, b]: [&[f32]; 3],
    alpha: Option<&[f32]>,
    densities: &PictureDensities,
) {
    let count = out.len().min(BATCH);
    let (r, g, b) = (&r[..count], &g[..count], &b[..count]);
    let mut share = [0.0; BATCH];
    for i in 0..count {
        share[i] = luminance([r[i], g[i], b[i]], densities.weights) / densities.white;
    }
    if let Some(alpha) = alpha {
        // A rim that covers half a pixel is as light as the rest.
        for (share, &alpha) in share[..count].iter_mut().zip(alpha) {
            *share /= alpha.clamp(LEAST_ALPHA, 1.0);
        }
    }
    let mut step = [0_u32; BATCH];
    for i in 0..count {
        // A NaN is black.
        let seen = if share[i] > 0.0 {
            share[i].min(1.0)
        } else {
            0.0
        };
        let at = STEPS as f32 * seen.sqrt();
        let floor = at.floor().min(STEPS as f32 - 1.0);
        step[i] = floor as i32 as u32;
        share[i] = at - floor;
    }
    for (i, out) in out[..count].iter_mut().enumerate() {
        let step = step[i] as usize;
        let (a, b) = (densities.table[step], densities.table[step + 1]);
        *out = a + share[i] * (b - a);
    }
}
