//! Creases: the ridges of their weight, and the lines along these.

use crate::frame::{Frame, Mask, Plane};
use crate::line::contours::ground::Ground;
use crate::line::contours::log_depth_of;
use crate::line::contours::network::{Line, Spot};
use crate::line::contours::ridge::Bands;
use crate::line::contours::smoothing::Smoothing;
use crate::params::ContourParams;
use rayon::prelude::*;

/// Distance of the centre of a crease's weights from the crease, in pixels of the frame before it was enlarged.
const MIDDLE: f32 = 0.5;

/// The pixels that have a weight and are free of `silhouettes`, in order.
fn pixels(weight: &Plane, mask: &Mask, silhouettes: &Ground) -> Vec<u32> {
    let rows = (0..mask.height()).into_par_iter().with_min_len(16);
    let pixels = rows.flat_map_iter(|y| {
        let row = weight.row(y);
        let marked = mask.span(y).filter(move |&x| row[x] > 0.0);
        let pixels = marked.map(move |x| y * mask.width() + x);
        pixels
            .filter(|&pixel| silhouettes.is_free(pixel))
            .map(|pixel| pixel as u32)
    });
    pixels.collect()
}

/// The lines along creases that keep away from silhouettes.
pub(crate) fn lines(
    weight: &Plane,
    silhouettes: &Ground,
    frame: &Frame,
    params: &ContourParams,
) -> Vec<Line> {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let pixels = pixels(weight, &frame.mask, silhouettes);
    if pixels.is_empty() {
        return Vec::new();
    }
    let bands = Bands {
        width,
        height,
        pixels: &pixels,
        weight: weight.samples(),
    };
    let spot = |pixel: u32| {
        let i = pixel as usize;
        Spot {
            at: bands.middle(pixel),
            strength: weight.samples()[i],
            log_depth: log_depth_of(frame, i).unwrap_or(0.0),
            is_beside: false,
        }
    };
    bands.lines(spot, Smoothing::of(params, MIDDLE))
}
