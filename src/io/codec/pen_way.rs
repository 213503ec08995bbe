//! Path of a plotter's pen: an order and direction of lines with little travel in the air.
//!
//! The pen repeatedly goes to the nearest end of a line, found in a grid of ends; then stretches of the path are
//! reversed if that shortens it (2-opt), among lines close to each other in the order. Both take time linear in the
//! number of lines.

use glam::Vec2;

/// A line by its number, and whether it is drawn from its last point to its first.
pub(crate) type PenLine = (usize, bool);

/// Rings of cells searched for the nearest end; beyond them the pen goes to the next cell with any.
const MOST_RINGS: usize = 12;

/// Ends in a cell, on average.
const ENDS_PER_CELL: f32 = 2.0;

/// Largest distance in the order between the ends of a reversed stretch, and number of passes over all lines.
const REACH: usize = 32;
const ROUNDS: usize = 2;

/// Drawing order of lines, given by both their ends, for a pen starting at `from`.
pub(crate) fn pen_way(ends: &[[Vec2; 2]], from: Vec2) -> Vec<PenLine> {
    let mut way = nearest_first(ends, from);
    for _ in 0..ROUNDS {
        if !shorten(&mut way, ends, from) {
            break;
        }
    }
    way
}

/// Travel in the air, from `from` to the last line, and the pen's final position.
pub(crate) fn in_the_air(way: &[PenLine], ends: &[[Vec2; 2]], from: Vec2) -> (f64, Vec2) {
    way.iter().fold((0.0, from), |(length, at), &drawn| {
        let [start, end] = ends_of(drawn, ends);
        (length + f64::from(at.distance(start)), end)
    })
}

/// Start and end of a line as drawn.
fn ends_of((number, is_reversed): PenLine, ends: &[[Vec2; 2]]) -> [Vec2; 2] {
    let [first, last] = ends[number];
    match is_reversed {
        true => [last, first],
        false => [first, last],
    }
}

fn nearest_first(ends: &[[Vec2; 2]], from: Vec2) -> Vec<PenLine> {
    let mut grid = Ends::new(ends);
    let mut at = from;
    let mut way = Vec::with_capacity(ends.len());
    while let Some(drawn) = grid.nearest(at) {
        grid.remove(drawn.0);
        way.push(drawn);
        at = ends_of(drawn, ends)[1];
    }
    way
}

/// Reverses stretches of the path; returns whether that shortened it.
fn shorten(way: &mut [PenLine], ends: &[[Vec2; 2]], from: Vec2) -> bool {
    let mut is_shorter = false;
    let mut before = from;
    for first in 0..way.len() {
        let start = ends_of(way[first], ends)[0];
        let gained = |last: usize| {
            let end = ends_of(way[last], ends)[1];
            // The last line of all is followed by none.
            let next = way.get(last + 1).map(|&next| ends_of(next, ends)[0]);
            let gap = |at: Vec2| next.map_or(0.0, |next| at.distance(next));
            before.distance(start) + gap(end) - before.distance(end) - gap(start)
        };
        let last = (first + REACH).min(way.len());
        let best = (first..last).map(|last| (gained(last), last));
        let best = best.fold((LEAST_GAIN_PX, None), |best, (gain, last)| {
            if gain > best.0 {
                (gain, Some(last))
            } else {
                best
            }
        });
        if let (_, Some(last)) = best {
            is_shorter = true;
            way[first..=last].reverse();
            for (_, is_reversed) in &mut way[first..=last] {
                *is_reversed = !*is_reversed;
            }
        }
        before = ends_of(way[first], ends)[1];
    }
    is_shorter
}

/// Least gain of a reversal, above rounding.
const LEAST_GAIN_PX: f32 = 1e-3;

/// The ends of lines not yet drawn, by cell.
struct Ends<'a> {
    ends: &'a [[Vec2; 2]],
    cells: Vec<Vec<PenLine>>,
    size: [usize; 2],
    corner: Vec2,
    side: f32,
    /// Cells before it are empty.
    first: usize,
}

impl<'a> Ends<'a> {
    fn new(ends: &'a [[Vec2; 2]]) -> Self {
        let all = || ends.iter().flatten();
        let corner = all().fold(Vec2::INFINITY, |a, &b| a.min(b));
        let extent = all().fold(Vec2::NEG_INFINITY, |a, &b| a.max(b)) - corner;
        let per_cell = extent.max(Vec2::ONE) / (2 * ends.len().max(1)) as f32;
        let side = (ENDS_PER_CELL * extent.max(Vec2::ONE).x * per_cell.y).sqrt();
        let size = [extent.x, extent.y].map(|length| (length.max(0.0) / side) as usize + 1);
        let mut grid = Self {
            ends,
            cells: vec![Vec::new(); size[0] * size[1]],
            size,
            corner,
            side,
            first: 0,
        };
        for (number, &[first, last]) in ends.iter().enumerate() {
            for (at, is_reversed) in [(first, false), (last, true)] {
                let [x, y] = grid.cell(at);
                grid.cells[y * size[0] + x].push((number, is_reversed));
            }
        }
        grid
    }

    fn cell(&self, at: Vec2) -> [usize; 2] {
        let place = ((at - self.corner) / self.side).max(Vec2::ZERO);
        let within = |at: f32, count: usize| (at as usize).min(count - 1);
        [within(place.x, self.size[0]), within(place.y, self.size[1])]
    }

    /// The nearest end, that of the line with the lower number of two as near.
    fn nearest(&mut self, at: Vec2) -> Option<PenLine> {
        let mut found: Option<(f32, PenLine)> = None;
        for ring in 0..=MOST_RINGS {
            // Rings farther out hold only farther ends.
            if found.is_some_and(|(distance, _)| distance < (ring as f32 - 1.0) * self.side) {
                break;
            }
            self.in_ring(at, ring, |distance, drawn| {
                if found.is_none_or(|(nearest, other)| (distance, drawn) < (nearest, other)) {
                    found = Some((distance, drawn));
                }
            });
        }
        found.map(|(_, drawn)| drawn).or_else(|| self.any())
    }

    /// The ends in the cells that are `ring` cells from a place, with their distances.
    fn in_ring(&self, at: Vec2, ring: usize, mut see: impl FnMut(f32, PenLine)) {
        let [x, y] = self.cell(at).map(|place| place as isize);
        let (ring, [width, height]) = (ring as isize, self.size.map(|count| count as isize));
        for row in (y - ring).max(0)..=(y + ring).min(height - 1) {
            let is_rim = (row - y).abs() == ring;
            let step = if is_rim || ring == 0 {
                1
            } else {
                2 * ring as usize
            };
            for column in (x - ring..=x + ring).step_by(step) {
                if (0..width).contains(&column) {
                    for &drawn in &self.cells[(row * width + column) as usize] {
                        see(at.distance(ends_of(drawn, self.ends)[0]), drawn);
                    }
                }
            }
        }
    }

    /// An end in the first cell that has any.
    fn any(&mut self) -> Option<PenLine> {
        while self.cells.get(self.first)?.is_empty() {
            self.first += 1;
        }
        self.cells[self.first].first().copied()
    }

    fn remove(&mut self, number: usize) {
        for at in self.ends[number] {
            let [x, y] = self.cell(at);
            self.cells[y * self.size[0] + x].retain(|&(other, _)| other != number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines up and down, `count` of them a pixel apart, in an order that jumps about.
    fn ruled(count: usize) -> Vec<[Vec2; 2]> {
        let line = |i: usize| {
            let x = ((i * 37) % count) as f32;
            [Vec2::new(x, 0.0), Vec2::new(x, 100.0)]
        };
        (0..count).map(line).collect()
    }

    #[test]
    fn ruled_lines_are_drawn_to_and_fro() {
        // Starting at the left, every line begins a pixel from the end of the previous one.
        let ends = ruled(101);
        let way = pen_way(&ends, Vec2::ZERO);
        assert_eq!(
            in_the_air(&way, &ends, Vec2::ZERO),
            (100.0, Vec2::new(100.0, 100.0))
        );
    }

    #[test]
    fn every_line_is_drawn_once_and_a_way_is_never_longer_than_as_laid() {
        let at = |i: usize| Vec2::new((i * 7919 % 1009) as f32, (i * 104_729 % 997) as f32);
        for count in [0, 1, 2, 500] {
            let ends: Vec<_> = (0..count).map(|i| [at(2 * i), at(2 * i + 1)]).collect();
            let way = pen_way(&ends, Vec2::ZERO);
            let mut numbers: Vec<_> = way.iter().map(|&(number, _)| number).collect();
            numbers.sort_unstable();
            assert!(numbers.into_iter().eq(0..count));
            let laid: Vec<_> = (0..count).map(|number| (number, false)).collect();
            let [short, long] = [way, laid].map(|way| in_the_air(&way, &ends, Vec2::ZERO).0);
            assert!(short <= long, "{short} of {long}");
            // For 500 lines across 1000 pixels the nearest of 1000 ends is some 20 pixels away, a random one 500.
            assert!(count < 500 || short < 0.15 * long, "{short} of {long}");
        }
    }
}
