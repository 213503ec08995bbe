//! The albedo of a frame, estimated from its picture.

#[cfg(feature = "gpu")]
use crate::engine::cpu::memory::Memory;
use crate::engine::cpu::percentile::{PercentileSearch, percentile};
#[cfg(feature = "gpu")]
use crate::engine::cpu::rows::map_covered;
#[cfg(feature = "gpu")]
use crate::frame::ColorPlanes;
use crate::frame::{Extent, Frame, Vector3Planes, luminance};
use crate::light::albedo::{AlbedoEstimate, FittedShading, ShadingFit};
use crate::shape::auto_levels::cpu as statistics;
use rayon::prelude::*;
use std::ops::Range;

/// Luminance that the albedo's white level is mapped to: that of paper.
const BRIGHT: f32 = 0.8;

/// The estimate: the picture divided by its best-fitting shading, scaled so that all but a few pixels are darker than
/// paper. White where the picture is black.
pub(crate) fn estimate(frame: &Frame, normal: &Vector3Planes, weights: [f32; 3]) -> AlbedoEstimate {
    let mask = &frame.mask;
    let rows = 0..mask.height();
    let shading = fitted(ShadingFit::default(), frame, normal, weights, rows).solved();
    let bright = luminance_over(shading, frame, normal, weights);
    let white = percentile(mask, statistics::WHITE_PERCENT, bright);
    AlbedoEstimate {
        shading,
        factor: BRIGHT / statistics::white_of(white),
    }
}

/// The albedo of every pixel, for devices.
#[cfg(feature = "gpu")]
pub(crate) fn by_estimate(
    frame: &Frame,
    estimate: &AlbedoEstimate,
    memory: &Memory,
) -> ColorPlanes {
    let bare = bare(frame);
    let [r, g, b] = map_covered(&frame.mask, memory, |y| {
        let bare = &bare;
        move |x| estimate.at(vector(&frame.normal, x, y), bare(x, y))
    });
    ColorPlanes { r, g, b }
}

/// A search for the estimate in a picture that comes some rows at a time, from top to bottom: once for the shading, and
/// as often as a [`PercentileSearch`] looks for the white level over it.
#[derive(Debug, Clone)]
pub(crate) struct AlbedoSearch {
    fit: ShadingFit,
    /// The fitted shading, and the search for the white level over it.
    white: Option<(Option<FittedShading>, PercentileSearch)>,
}

impl AlbedoSearch {
    pub(crate) fn new() -> Self {
        Self {
            fit: ShadingFit::default(),
            white: None,
        }
    }

    /// Takes in the rows `rows` of a strip whose first row is row `top` of the picture.
    pub(crate) fn add(&mut self, strip: &Frame, weights: [f32; 3], rows: Range<usize>, top: usize) {
        match &mut self.white {
            None => self.fit = fitted(self.fit, strip, &strip.normal, weights, rows),
            Some((shading, search)) => {
                let bright = luminance_over(*shading, strip, &strip.normal, weights);
                search.add(&strip.mask, rows, top, bright);
            }
        }
    }

    /// Solves for the shading, and begins to search the white level, in a picture with this extent.
    pub(crate) fn begin_white(&mut self, extent: &Extent) {
        let mut search = PercentileSearch::new(statistics::WHITE_PERCENT);
        search.begin(extent);
        self.white = Some((self.fit.solved(), search));
    }

    /// The search for the white level.
    pub(crate) fn white_search(&mut self) -> Option<&mut PercentileSearch> {
        self.white.as_mut().map(|(_, search)| search)
    }

    /// The estimate, at the end.
    pub(crate) fn found(self) -> Option<AlbedoEstimate> {
        let (shading, search) = self.white?;
        Some(AlbedoEstimate {
            shading,
            factor: BRIGHT / statistics::white_of(search.found()),
        })
    }
}

/// The colour of a pixel divided by its coverage.
fn bare(frame: &Frame) -> impl Fn(usize, usize) -> [f32; 3] + Sync + '_ {
    let color = frame.color.as_ref().expect("an estimate takes a picture");
    let alpha = frame.alpha.as_ref();
    move |x, y| {
        let cover = alpha.map_or(1.0, |alpha| alpha.at(x, y));
        let per_cover = if cover > 0.0 { 1.0 / cover } else { 0.0 };
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y) * per_cover)
    }
}

fn vector(planes: &Vector3Planes, x: usize, y: usize) -> [f32; 3] {
    [planes.x.at(x, y), planes.y.at(x, y), planes.z.at(x, y)]
}

/// `fit` with the pixels of some rows added.
fn fitted(
    fit: ShadingFit,
    frame: &Frame,
    normal: &Vector3Planes,
    weights: [f32; 3],
    rows: Range<usize>,
) -> ShadingFit {
    let (mask, bare) = (&frame.mask, bare(frame));
    let rows = rows.into_par_iter().map(|y| {
        let mut fit = ShadingFit::default();
        let covered = mask.row(y);
        for x in mask.span(y).filter(|&x| covered[x]) {
            fit.add(vector(normal, x, y), luminance(bare(x, y), weights));
        }
        fit
    });
    // Merged in row order: the same bits for any number of threads and strips.
    let fits: Vec<ShadingFit> = rows.collect();
    fits.into_iter().fold(fit, ShadingFit::merged)
}

/// The luminance of a pixel of the picture divided by a shading; of white without one.
fn luminance_over(
    shading: Option<FittedShading>,
    frame: &Frame,
    normal: &Vector3Planes,
    weights: [f32; 3],
) -> impl Fn(usize, usize) -> Option<f32> + Sync {
    let bare = bare(frame);
    move |x, y| {
        let albedo = match shading {
            Some(shading) => shading.under(vector(normal, x, y), bare(x, y)),
            None => [1.0; 3],
        };
        Some(luminance(albedo, weights))
    }
}
