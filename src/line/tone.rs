//! From the luminance of a picture to the optical density of the drawing.

use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::rows::map_rows;
use crate::engine::cpu::simd::Simd;
use crate::engine::cpu::simd::widened;
use crate::frame::luminance;
use crate::frame::{ColorPlanes, Frame, Mask, Plane};
use crate::line::density::{LEAST_ALPHA, STEPS, density_table};
use crate::line::hatching::BATCH;
use crate::params::ToneParams;
use crate::shape::auto_levels::cpu as statistics;
use std::ops::Range;

/// The picture whose luminance is a drawing's tone.
#[derive(Clone, Copy)]
pub(crate) enum ToneOf<'a> {
    /// A picture, by the weights of its primaries.
    Picture(&'a ColorPlanes, [f32; 3]),
    /// The luminance itself.
    Luminance(&'a Plane),
}

impl<'a> ToneOf<'a> {
    /// A high percentile of the luminance of the covered pixels; 1 where none has any.
    pub(crate) fn white_level(self, mask: &Mask) -> f32 {
        match self {
            Self::Picture(color, weights) => statistics::white_level(color, weights, mask),
            Self::Luminance(plane) => statistics::white_level_of(plane, mask),
        }
    }

    /// Three planes, zeros for missing ones, and the weights that make them the luminance.
    fn planes(self) -> ([Option<&'a Plane>; 3], [f32; 3]) {
        match self {
            Self::Picture(color, weights) => ([&color.r, &color.g, &color.b].map(Some), weights),
            Self::Luminance(plane) => ([Some(plane), None, None], [1.0, 0.0, 0.0]),
        }
    }
}

/// Samples of a missing plane.
static ZEROS: [f32; BATCH] = [0.0; BATCH];

/// The optical densities that are drawn.
pub(crate) enum Densities<'a> {
    /// Densities of a picture.
    OfPicture(PictureDensities<'a>),
    /// These.
    Found(&'a Plane),
}

impl Densities<'_> {
    /// The densities of `columns` of row `y`, at most a batch.
    pub(crate) fn row(&self, out: &mut [f32], y: usize, columns: Range<usize>, simd: Simd) {
        match self {
            Self::OfPicture(densities) => densities.row(out, y, columns, simd),
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
        let simd = Simd::widest();
        let [mapped] = map_rows(&frame.mask, memory, |y, [out]| {
            let sample = row(y);
            for run in frame.mask.runs(y) {
                for from in run.clone().step_by(BATCH) {
                    let columns = from..(from + BATCH).min(run.end);
                    self.row(&mut out[columns.clone()], y, columns.clone(), simd);
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
    planes: [Option<&'a Plane>; 3],
    frame: &'a Frame,
    weights: [f32; 3],
    /// Luminance of paper white.
    white: f32,
    /// Densities at even steps of the square root of luminance, from 0 to white.
    table: Vec<f32>,
}

impl<'a> PictureDensities<'a> {
    pub(crate) fn new(tone: ToneOf<'a>, frame: &'a Frame, white: f32, params: &ToneParams) -> Self {
        let (planes, weights) = tone.planes();
        Self {
            planes,
            frame,
            weights,
            white,
            table: density_table(params),
        }
    }

    fn row(&self, out: &mut [f32], y: usize, columns: Range<usize>, simd: Simd) {
        let color = self.planes.map(|plane| match plane {
            Some(plane) => &plane.row(y)[columns.clone()],
            None => &ZEROS[..columns.len()],
        });
        let alpha = self.frame.alpha.as_ref();
        let alpha = alpha.map(|plane| &plane.row(y)[columns.clone()]);
        simd.density_row(out, color, alpha, self);
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

widened! {
    fn density_row(
        out: &mut [f32],
        color: [&[f32]; 3],
        alpha: Option<&[f32]>,
        densities: &PictureDensities,
    );
}
