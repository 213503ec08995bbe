//! Points on the paper, by cell.

use glam::Vec2;
use std::ops::RangeInclusive;

/// A point of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) at: Vec2,
    pub(super) line: u32,
    /// Index in its line.
    pub(super) index: i32,
    /// The point of its cell that came before, as [`Placed::last`] has it.
    before: u32,
}

/// The points placed so far.
pub(super) struct Placed {
    pub(super) points: Vec<Point>,
    /// The last point of every cell, counted from 1, or 0: memory of zeros is mapped only where points are.
    last: Vec<u32>,
    size: [usize; 2],
    /// Cells to a pixel.
    per_px: f32,
}

impl Placed {
    /// None, on paper of such a size, in cells of such a side.
    pub(super) fn new(size: [usize; 2], side: f32) -> Self {
        let size = size.map(|length| (length as f32 / side) as usize + 1);
        Self {
            points: Vec::new(),
            last: vec![0; size[0] * size[1]],
            size,
            per_px: side.recip(),
        }
    }

    /// The column and row of the cell at a place, or of the nearest one.
    #[inline]
    fn cell(&self, at: Vec2) -> [usize; 2] {
        // A cast of less than 0 is 0.
        let along = |at: f32, count: usize| ((at * self.per_px) as usize).min(count - 1);
        [along(at.x, self.size[0]), along(at.y, self.size[1])]
    }

    #[inline]
    fn last(&mut self, at: Vec2) -> &mut u32 {
        let [x, y] = self.cell(at);
        &mut self.last[y * self.size[0] + x]
    }

    #[inline]
    pub(super) fn add(&mut self, at: Vec2, line: u32, index: i32) {
        let number = self.points.len() as u32 + 1;
        let before = std::mem::replace(self.last(at), number);
        self.points.push(Point {
            at,
            line,
            index,
            before,
        });
    }

    /// Removes the points placed last, all but the first `count`.
    pub(super) fn keep(&mut self, count: usize) {
        while self.points.len() > count {
            if let Some(Point { at, before, .. }) = self.points.pop() {
                *self.last(at) = before;
            }
        }
    }

    /// The point of this number, counted from 1, with its number, counted from 0.
    #[inline]
    fn point(&self, number: u32) -> Option<(usize, &Point)> {
        let number = (number as usize).wrapping_sub(1);
        Some((number, self.points.get(number)?))
    }

    /// The points in a row of cells with their numbers, cell by cell, the last placed first.
    #[inline]
    fn row(
        &self,
        y: usize,
        columns: RangeInclusive<usize>,
    ) -> impl Iterator<Item = (usize, &Point)> {
        let row = &self.last[y * self.size[0]..][columns];
        row.iter().flat_map(move |&newest| {
            let before = |(_, point): &(usize, &Point)| self.point(point.before);
            std::iter::successors(self.point(newest), before)
        })
    }

    /// The points in the cells from one place to another with their numbers, row by row.
    #[inline]
    pub(super) fn between(&self, from: Vec2, to: Vec2) -> impl Iterator<Item = (usize, &Point)> {
        let ([left, top], [right, bottom]) = (self.cell(from), self.cell(to));
        (top..=bottom).flat_map(move |y| self.row(y, left..=right))
    }

    /// The points closer to a place than a distance, in the same order.
    #[inline]
    pub(super) fn near(&self, at: Vec2, distance: f32) -> impl Iterator<Item = &Point> {
        let points = self
            .between(at - distance, at + distance)
            .map(|(_, point)| point);
        points.filter(move |point| point.at.distance_squared(at) < distance * distance)
    }

    /// Whether no point that `counts` is closer than `distance`; the nearest rows first, as most questions end there.
    #[inline]
    pub(super) fn is_free(&self, at: Vec2, distance: f32, counts: impl Fn(&Point) -> bool) -> bool {
        !self.near(at, distance).any(counts)
    }

    /// Distances of the nearest other lines on both sides; `spacing` where there is none within half as much again.
    pub(super) fn room(&self, at: Vec2, along: Vec2, spacing: f32, line: u32) -> [f32; 2] {
        // One ahead is not a neighbour.
        let least_across = 0.7 * along.length();
        let mut squares = [f32::INFINITY; 2];
        let others = self
            .near(at, 1.5 * spacing)
            .filter(|point| point.line != line);
        others.for_each(|point| {
            let way = point.at - at;
            let (across, square) = (along.perp_dot(way), way.length_squared());
            if across.abs() > least_across * square.sqrt() {
                let least = &mut squares[usize::from(across > 0.0)];
                *least = least.min(square);
            }
        });
        squares.map(|square| {
            if square.is_finite() {
                square.sqrt()
            } else {
                spacing
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_that_to_the_nearest_of_all_points_on_either_side() {
        // Points of eight lines all over the paper; distances by looking at every one of them.
        let mut placed = Placed::new([97, 61], 3.7);
        let mut state = 1_u32;
        let mut random = |most: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            most * (state >> 8) as f32 / (1 << 24) as f32
        };
        for i in 0..700 {
            let at = Vec2::new(random(97.0), random(61.0));
            placed.add(at, random(8.0) as u32, i);
        }
        for i in 0..500 {
            let (at, along) = (placed.points[i].at, Vec2::from_angle(random(6.0)));
            let (line, spacing) = (placed.points[i].line, 0.5 + random(20.0));
            let mut nearest = [f32::INFINITY; 2];
            for other in placed.points.iter().filter(|other| other.line != line) {
                let offset = other.at - at;
                let across = along.perp_dot(offset);
                let is_near = offset.length_squared() < (1.5 * spacing) * (1.5 * spacing);
                if is_near && across.abs() > 0.7 * along.length() * offset.length() {
                    let side = &mut nearest[usize::from(across > 0.0)];
                    *side = side.min(offset.length());
                }
            }
            let expected = nearest.map(|room| if room.is_finite() { room } else { spacing });
            assert_eq!(placed.room(at, along, spacing, line), expected);
        }
    }
}
