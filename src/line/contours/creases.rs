//! Creases: the ridges of their weight, and the lines along these.

use crate::frame::{Frame, Mask, Plane};
use crate::kernel::fast_math::ln;
use crate::line::contours::ground::Ground;
use crate::line::contours::lattice::Path;
use crate::line::contours::network;
use crate::line::contours::network::{Line, Spot, smooth};
use crate::line::contours::ridge::Bands;
use crate::params::ContourParams;
use glam::Vec2;
use rayon::prelude::*;

/// A crease that ends within this many pixels of the border of the picture continues beyond it.
const RIM: usize = 2;

/// Distance of the centre of a crease's weights from the crease.
const MIDDLE_PX: f32 = 0.5;

/// The pixels that have a weight and are free of `silhouettes`, in order.
fn pixels(weight: &Plane, mask: &Mask, silhouettes: &Ground) -> Vec<u32> {
    let pixels: Vec<Vec<u32>> = (0..mask.height())
        .into_par_iter()
        .with_min_len(16)
        .map(|y| {
            let row = weight.row(y);
            let covered = mask.span(y).filter(|&x| row[x] > 0.0);
            let pixels = covered.map(|x| y * mask.width() + x);
            let free = pixels.filter(|&pixel| silhouettes.is_free(pixel));
            free.map(|pixel| pixel as u32).collect()
        })
        .collect();
    pixels.concat()
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
    let ridges = bands.ridges();
    let place = |pixel: u32| {
        let [x, y] = ridges.place(pixel);
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5)
    };
    let spot = |&pixel: &u32| {
        let i = pixel as usize;
        let log_depth = frame
            .depth
            .as_ref()
            .map_or(0.0, |depth| ln(depth.samples()[i]));
        Spot {
            at: bands.middle(pixel),
            strength: weight.samples()[i],
            log_depth: if log_depth.is_finite() {
                log_depth
            } else {
                0.0
            },
            is_beside: false,
        }
    };
    let spots = |path: &Path| {
        let ends_in_junction = |node: &u32| ridges.degree(*node) > 2;
        let inner = path.nodes.iter().enumerate().filter(|(i, node)| {
            let is_end = *i == 0 || *i + 1 == path.nodes.len();
            path.closed || !is_end || !ends_in_junction(node)
        });
        inner.map(|(_, node)| spot(node)).collect()
    };
    network::lines(&ridges, place, spots, RIM, |lines: &mut [Line]| {
        smooth(lines, params, MIDDLE_PX)
    })
}
