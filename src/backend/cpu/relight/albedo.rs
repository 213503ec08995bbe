//! The albedo of a frame, estimated from its picture.

use crate::backend::cpu::memory::Memory;
use crate::backend::cpu::{light, passes, statistics};
use crate::frame::{ColorPlanes, Frame};
use crate::light::albedo::{FittedShading, ShadingFit};
use rayon::prelude::*;

/// Luminance that the white level of the albedo is brought to: of paper.
const BRIGHT: f32 = 0.8;

/// The picture over its best-fitting shading, so bright that all but a few pixels are darker than paper.
/// White where the picture is black.
pub(in crate::backend) fn estimated(
    frame: &Frame,
    weights: [f32; 3],
    memory: &Memory,
) -> ColorPlanes {
    let color = frame.color.as_ref().expect("an estimate takes a picture");
    let mask = &frame.mask;
    let (n, alpha) = (&frame.normal, frame.alpha.as_ref());
    // Colour is premultiplied.
    let bare = |x: usize, y: usize| {
        let cover = alpha.map_or(1.0, |alpha| alpha.at(x, y));
        let per_cover = if cover > 0.0 { 1.0 / cover } else { 0.0 };
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y) * per_cover)
    };
    let normal = |x: usize, y: usize| [n.x.at(x, y), n.y.at(x, y), n.z.at(x, y)];
    let rows = (0..mask.height()).into_par_iter().map(|y| {
        let mut fit = ShadingFit::default();
        let covered = mask.row(y);
        for x in mask.span(y).filter(|&x| covered[x]) {
            fit.add(normal(x, y), light::luminance(bare(x, y), weights));
        }
        fit
    });
    // Added row after row: the same bits for any number of threads.
    let fits: Vec<ShadingFit> = rows.collect();
    let fit = fits
        .into_iter()
        .fold(ShadingFit::default(), ShadingFit::merged);
    let shading = fit.solved();
    let albedo = |shading: FittedShading, x, y| {
        let per_light = 1.0 / shading.at(normal(x, y));
        bare(x, y).map(|channel| channel * per_light)
    };
    let [r, g, b] = passes::map_covered(mask, memory, |y| {
        move |x| match shading {
            Some(shading) => albedo(shading, x, y),
            None => [1.0; 3],
        }
    });
    let mut albedo = ColorPlanes { r, g, b };
    let factor = BRIGHT / statistics::white_level(&albedo, weights, mask);
    for plane in [&mut albedo.r, &mut albedo.g, &mut albedo.b] {
        let samples = plane.samples_mut().par_iter_mut();
        samples.for_each(|v| *v = (*v * factor).clamp(0.0, 1.0));
    }
    albedo
}
