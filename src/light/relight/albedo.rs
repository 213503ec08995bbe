//! The albedo of a frame, estimated from its picture.

#[cfg(feature = "gpu")]
use crate::frame::ColorPlanes;
#[cfg(feature = "gpu")]
use crate::frame::memory::Memory;
#[cfg(feature = "gpu")]
use crate::frame::rows::map_covered;
use crate::frame::{Frame, Vector3Planes, luminance};
#[cfg(feature = "gpu")]
use crate::light::albedo::AlbedoEstimate;
use crate::light::albedo::{FittedShading, ShadingFit};
use crate::plan::search::ChosenFrom;
use rayon::prelude::*;

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

/// `fit` with pixels added, whose normals these are.
pub(super) fn fitted(fit: ShadingFit, from: &ChosenFrom, normal: &Vector3Planes) -> ShadingFit {
    let (mask, bare) = (&from.mask, bare(from.frame));
    let weights = from.frame.luminance_weights();
    let rows = from.strip.rows.clone().into_par_iter().map(|y| {
        let mut fit = ShadingFit::default();
        let covered = mask.row(y);
        for x in mask.span(y).filter(|&x| covered[x]) {
            if let Some([x, y]) = from.place(x, y) {
                fit.add(vector(normal, x, y), luminance(bare(x, y), weights));
            }
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
) -> impl Fn(usize, usize) -> Option<f32> + Sync {
    let (bare, weights) = (bare(frame), frame.luminance_weights());
    move |x, y| {
        let albedo = match shading {
            Some(shading) => shading.under(vector(normal, x, y), bare(x, y)),
            None => [1.0; 3],
        };
        Some(luminance(albedo, weights))
    }
}
