//! Regions of cells: distances to them, gaps closed, details taken away, and the pieces that they fall into.

use crate::frame::{Mask, Plane, pieces};
use std::collections::HashMap;

/// Distances of cells, in cells, from the nearest one of a region; infinite beyond `most`.
pub(super) fn distances(region: &Plane<bool>, most: f32) -> Plane {
    let (width, height) = (region.width(), region.height());
    // Along columns first: the least sum of squares over a row is that over the picture.
    let mut along = Plane::filled(width, height, f32::INFINITY);
    for rows in [true, false] {
        for step in 0..height {
            let y = if rows { step } else { height - 1 - step };
            let before = if rows {
                y.checked_sub(1)
            } else {
                Some(y + 1).filter(|&y| y < height)
            };
            for x in 0..width {
                let next = before.map_or(f32::INFINITY, |before| along.at(x, before) + 1.0);
                let here = if region.at(x, y) { 0.0 } else { next };
                let sample = &mut along.row_mut(y)[x];
                *sample = sample.min(here);
            }
        }
    }
    Plane::of_pixels(width, height, |x, y| {
        let along = along.row(y);
        let mut least = along[x] * along[x];
        let mut by = 1;
        while ((by * by) as f32) < least && by as f32 <= most {
            let beside = [x.checked_sub(by), Some(x + by).filter(|&x| x < width)];
            for x in beside.into_iter().flatten() {
                least = least.min(along[x] * along[x] + (by * by) as f32);
            }
            by += 1;
        }
        match least <= most * most {
            true => least.sqrt(),
            false => f32::INFINITY,
        }
    })
}

/// A region with all cells within a distance of it.
fn grown(region: &Plane<bool>, by: f32) -> Plane<bool> {
    distances(region, by).map(|distance| distance <= by)
}

/// A region without the cells that something else is within a distance of; what is beyond the picture is nothing else.
fn shrunk(region: &Plane<bool>, by: f32) -> Plane<bool> {
    grown(&region.map(|within| !within), by).map(|outside| !outside)
}

/// A region whose gaps up to twice this wide are closed.
pub(super) fn closed(region: &Plane<bool>, by: f32) -> Plane<bool> {
    shrunk(&grown(region, by), by)
}

/// A region without parts up to twice this wide.
pub(super) fn opened(region: &Plane<bool>, by: f32) -> Plane<bool> {
    grown(&shrunk(region, by), by)
}

/// The pieces of a region that have more than so many cells.
pub(super) fn large_pieces(region: &Plane<bool>, cells: f32) -> Plane<bool> {
    kept_pieces(region, |_, count| count as f32 > cells)
}

/// The pieces of a region that lie on the border of the picture, or have more than so many cells.
pub(super) fn outer_pieces(region: &Plane<bool>, cells: f32) -> Plane<bool> {
    kept_pieces(region, |on_border, count| {
        on_border > 0 || count as f32 > cells
    })
}

/// The cells of a region.
pub(super) fn count(region: &Plane<bool>) -> f32 {
    region.samples().iter().filter(|&&within| within).count() as f32
}

/// The cells of a region on the border of the picture.
pub(super) fn on_border(region: &Plane<bool>) -> usize {
    let (width, height) = (region.width(), region.height());
    let rows = (0..width).map(|x| [region.at(x, 0), region.at(x, height - 1)]);
    let columns = (0..height).map(|y| [region.at(0, y), region.at(width - 1, y)]);
    rows.chain(columns)
        .flatten()
        .filter(|&within| within)
        .count()
}

fn kept_pieces(region: &Plane<bool>, keeps: impl Fn(usize, usize) -> bool) -> Plane<bool> {
    let (width, height) = (region.width(), region.height());
    let within = region.map(|within| f32::from(u8::from(within)));
    let piece = pieces(&within, &Mask::full(width, height));
    let mut sizes: HashMap<u32, (usize, usize)> = HashMap::new();
    for (i, piece) in piece.iter().enumerate() {
        let (x, y) = (i % width, i / width);
        let is_border = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
        let (on_border, count) = sizes.entry(*piece).or_default();
        *on_border += usize::from(is_border);
        *count += 1;
    }
    Plane::from_fn(width, height, |x, y| {
        let (on_border, count) = sizes[&piece[y * width + x]];
        region.at(x, y) && keeps(on_border, count)
    })
}
