//! Regions of cells: distances to them, gaps closed, details taken away, and the pieces that they fall into.

use crate::frame::{Mask, Plane, pieces};
use std::collections::HashMap;

/// Distances of cells, in cells, from the nearest one of a region; infinite beyond `most`.
pub(super) fn distances(region: &Plane<bool>, most: f32) -> Plane {
    let (width, height) = (region.width(), region.height());
    // Along columns first: the least sum of squares over a row is that over the picture. All are whole numbers, and exact.
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
    Plane::of_rows(width, height, |y, row| {
        let lowest = lowest_distances(along.row(y), most);
        let mut after = lowest.iter().skip(1).peekable();
        let Some(mut here) = lowest.first() else {
            return row.fill(f32::INFINITY);
        };
        for (x, distance) in row.iter_mut().enumerate() {
            while let Some(next) = after.next_if(|next| next.from <= x as f32) {
                here = next;
            }
            let across = x.abs_diff(here.place) as f32;
            let square = here.height * here.height + across * across;
            *distance = match square <= most * most {
                true => square.sqrt(),
                false => f32::INFINITY,
            };
        }
    })
}

/// The parabola of squared distances from a cell of a row, across it from the nearest one of a region in its column.
struct CellDistance {
    place: usize,
    height: f32,
    /// From where on it is the lowest.
    from: f32,
}

/// The parabolas of a row that are the lowest anywhere, from left to right [Felzenszwalb and Huttenlocher 2012, Distance
/// Transforms of Sampled Functions, section 2.1].
fn lowest_distances(heights: &[f32], most: f32) -> Vec<CellDistance> {
    let mut lowest: Vec<CellDistance> = Vec::new();
    let near = heights.iter().enumerate();
    for (place, &height) in near.filter(|(_, height)| **height <= most) {
        let constant = |place: usize, height: f32| (place * place) as f32 + height * height;
        let mut from = f32::NEG_INFINITY;
        while let Some(last) = lowest.last() {
            let higher = constant(place, height) - constant(last.place, last.height);
            let meet = 0.5 * higher / (place - last.place) as f32;
            if meet > last.from {
                from = meet;
                break;
            }
            lowest.pop();
        }
        lowest.push(CellDistance {
            place,
            height,
            from,
        });
    }
    lowest
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::random::Random;

    #[test]
    fn distances_are_those_to_the_nearest_cell() {
        let mut random = Random::new(1);
        for share in [0.0, 0.002, 0.02, 0.3, 1.0] {
            let region = Plane::from_fn(61, 47, |_, _| random.unit() < share);
            let found = distances(&region, 20.0);
            let cells: Vec<[usize; 2]> = (0..47)
                .flat_map(|y| (0..61).map(move |x| [x, y]))
                .filter(|&[x, y]| region.at(x, y))
                .collect();
            for (x, y) in (0..47_usize).flat_map(|y| (0..61_usize).map(move |x| (x, y))) {
                let square = |&[i, k]: &[usize; 2]| x.abs_diff(i).pow(2) + y.abs_diff(k).pow(2);
                let least = cells.iter().map(square).min();
                let expected = least
                    .filter(|&square| square <= 400)
                    .map_or(f32::INFINITY, |square| (square as f32).sqrt());
                assert_eq!(found.at(x, y), expected, "{share} at {x}, {y}");
            }
        }
    }
}
