//! The albedo of a frame, estimated from its picture.

#[cfg(feature = "gpu")]
use crate::frame::ColorPlanes;
#[cfg(feature = "gpu")]
use crate::frame::memory::Memory;
use crate::frame::percentile::percentile;
#[cfg(feature = "gpu")]
use crate::frame::rows::map_covered;
use crate::frame::{Frame, Vector3Planes, luminance};
use crate::light::albedo::{AlbedoEstimate, FittedShading, ShadingFit};
use crate::shape::auto_levels::cpu as statistics;
use rayon::prelude::*;
use std::ops::Range;

/// Luminance that the albedo's white level is mapped to: that of paper.
pub(super) const BRIGHT: f32 = 0.8;

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
pub(super) fn fitted(
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
pub(super) fn luminance_over(
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
