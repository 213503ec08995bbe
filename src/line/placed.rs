//! The points of lines placed so far, by cell.

use crate::kernel::simd::wide;
use glam::Vec2;

/// A point of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) at: Vec2,
    pub(super) line: u32,
    /// Index in its line, counted from the seed.
    pub(super) index: i32,
    /// The point of its cell that came before, as [`Placed::last`] has it.
    before: u32,
}

/// The points placed so far.
pub(super) struct Placed {
    points: Vec<Point>,
    /// The last point of every cell, counted from 1, or 0: memory of zeros is mapped only where points are.
    last: Vec<u32>,
    size: [usize; 2],
    side: f32,
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
            side,
            per_px: side.recip(),
        }
    }

    /// The column or row of cells, of so many, at a coordinate.
    #[inline]
    fn along(&self, at: f32, count: usize) -> usize {
        // A cast of less than 0 is 0.
        ((at * self.per_px) as usize).min(count - 1)
    }

    #[inline]
    fn column(&self, at: f32) -> usize {
        self.along(at, self.size[0])
    }

    #[inline]
    fn row(&self, at: f32) -> usize {
        self.along(at, self.size[1])
    }

    #[inline]
    fn last(&mut self, at: Vec2) -> &mut u32 {
        let (x, y) = (self.column(at.x), self.row(at.y));
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

    /// The point of this number, counted from 1.
    #[inline]
    fn point(&self, number: u32) -> Option<&Point> {
        self.points.get((number as usize).wrapping_sub(1))
    }

    /// Number of points.
    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// Whether any point within some distance `counts`; the nearest rows first, as most questions end there.
    #[inline]
    fn any(&self, at: Vec2, distance: f32, counts: impl Fn(&Point) -> bool) -> bool {
        let [first, last] = [-distance, distance].map(|d| self.column(at.x + d));
        let square = distance * distance;
        let [top, own, bottom] = [-distance, 0.0, distance].map(|d| self.row(at.y + d));
        let mut found = false;
        outward([top, own, bottom], |y| {
            let row = y * self.size[0];
            for &newest in &self.last[row + first..=row + last] {
                let mut number = newest;
                while let Some(point) = self.point(number) {
                    if point.at.distance_squared(at) < square && counts(point) {
                        found = true;
                        return false;
                    }
                    number = point.before;
                }
            }
            true
        });
        found
    }

    /// Whether no point that `counts` is closer than `distance`.
    #[inline]
    pub(super) fn is_free(&self, at: Vec2, distance: f32, counts: impl Fn(&Point) -> bool) -> bool {
        !self.any(at, distance, counts)
    }

    /// The points in the order of their cells, for many questions when no more are added.
    pub(super) fn by_cell(&self) -> PointsByCell<'_> {
        let room = || Vec::with_capacity(self.points.len() + LANES);
        let (mut x, mut y) = (room(), room());
        let mut lines = Vec::with_capacity(self.points.len() + LANES);
        let mut starts = Vec::with_capacity(self.last.len() + 1);
        for &newest in &self.last {
            starts.push(lines.len() as u32);
            let mut number = newest;
            while let Some(point) = self.point(number) {
                x.push(point.at.x);
                y.push(point.at.y);
                lines.push(point.line);
                number = point.before;
            }
        }
        starts.push(lines.len() as u32);
        // So that the last slices end in whole vectors, too.
        for axis in [&mut x, &mut y] {
            axis.resize(lines.len() + LANES, f32::INFINITY);
        }
        lines.resize(lines.len() + LANES, 0);
        PointsByCell {
            placed: self,
            x,
            y,
            lines,
            starts,
        }
    }
}

/// Points that are looked at together.
const LANES: usize = 16;

/// Points with their lines, cell by cell and row by row, so that neighbouring cells of a row are one slice.
pub(super) struct PointsByCell<'a> {
    placed: &'a Placed,
    /// Places and lines of points, and of a few at infinity after the last.
    x: Vec<f32>,
    y: Vec<f32>,
    lines: Vec<u32>,
    /// The first point of every cell, and the number of points.
    starts: Vec<u32>,
}

/// A point of a line, and how near others are looked for on both sides.
pub(crate) struct Beside {
    pub(crate) at: [f32; 2],
    /// The way of the line, of any length.
    pub(crate) along: [f32; 2],
    pub(crate) line: u32,
    /// The least that a point is to the side, as a share of its distance, times the length of the way: one ahead is not
    /// a neighbour.
    pub(crate) least_across: f32,
    /// Square of the distance beyond which points do not count.
    pub(crate) limit: f32,
}

/// Lowers the squares of distances on both sides to the least of those of points of other lines.
#[inline(always)]
pub(crate) fn nearest_beside(
    squares: &mut [f32; 2],
    points: [&[[f32; LANES]]; 2],
    lines: &[[u32; LANES]],
    beside: &Beside,
) {
    let lesser = |a: f32, b: f32| if a < b { a } else { b };
    let [x, y] = points;
    let (at, along) = (beside.at, beside.along);
    let mut by_lane = [[f32::INFINITY; LANES]; 2];
    for ((x, y), lines) in x.iter().zip(y).zip(lines) {
        for lane in 0..LANES {
            let (right, down) = (x[lane] - at[0], y[lane] - at[1]);
            let square = right * right + down * down;
            let across = along[0] * down - along[1] * right;
            let counts = (square < beside.limit)
                & (lines[lane] != beside.line)
                & (across.abs() > beside.least_across * square.sqrt());
            let square = if counts { square } else { f32::INFINITY };
            let is_after = across > 0.0;
            let [before, after] = &mut by_lane;
            before[lane] = lesser(if is_after { f32::INFINITY } else { square }, before[lane]);
            after[lane] = lesser(if is_after { square } else { f32::INFINITY }, after[lane]);
        }
    }
    for (least, lanes) in squares.iter_mut().zip(&mut by_lane) {
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                lanes[lane] = lesser(lanes[lane], lanes[lane + half]);
            }
            half /= 2;
        }
        *least = lesser(*least, lanes[0]);
    }
}

impl PointsByCell<'_> {
    /// Distances of the nearest other lines on both sides; `spacing` where there is none within half as much again.
    pub(super) fn room(&self, at: Vec2, along: Vec2, spacing: f32, line: u32) -> [f32; 2] {
        let reach = 1.5 * spacing;
        let mut beside = Beside {
            at: at.to_array(),
            along: along.to_array(),
            line,
            least_across: 0.7 * along.length(),
            limit: reach * reach,
        };
        let mut squares = [f32::INFINITY; 2];
        let [first, own, last] = [-reach, 0.0, reach].map(|d| self.placed.row(at.y + d));
        outward([first, own, last], |row| {
            let away = self.away(row, at.y);
            let across = beside.limit - away * away;
            if across <= 0.0 {
                return true;
            }
            let [from, to] = self.cells(at, across.sqrt(), row);
            // Whole vectors: the points after the last are of other cells, where any that is near counts as well.
            let to = from + (to - from).next_multiple_of(LANES);
            let [x, y] = [&self.x, &self.y].map(|axis| axis[from..to].as_chunks().0);
            let lines = self.lines[from..to].as_chunks().0;
            wide!(nearest_beside(&mut squares, [x, y], lines, &beside));
            // No point farther than those found is nearer.
            beside.limit = beside.limit.min(squares[0].max(squares[1]));
            true
        });
        squares.map(|square| {
            if square.is_finite() {
                square.sqrt()
            } else {
                spacing
            }
        })
    }

    /// At most the distance of a row of cells from a height: less by as much as rounding may have moved a point to the
    /// next cell.
    #[inline]
    fn away(&self, row: usize, y: f32) -> f32 {
        let side = self.placed.side;
        let [above, below] = [row, row + 1].map(|border| border as f32 * side);
        ((above - y).max(y - below) - ROUNDING * side).max(0.0)
    }

    /// Where the points begin and end of the cells in row `y` that are within `reach` of a position along the row.
    #[inline]
    fn cells(&self, at: Vec2, reach: f32, y: usize) -> [usize; 2] {
        let row = y * self.placed.size[0];
        let reach = reach + ROUNDING * self.placed.side;
        let [first, last] = [-reach, reach].map(|d| row + self.placed.column(at.x + d));
        [self.starts[first], self.starts[last + 1]].map(|place| place as usize)
    }
}

/// Visits the rows from `first` to `last`, those nearest to `own` first, as long as `visit` wants more of them.
#[inline(always)]
fn outward([first, own, last]: [usize; 3], mut visit: impl FnMut(usize) -> bool) {
    let (mut above, mut below) = (own, own);
    let mut goes_on = visit(own);
    while goes_on && (above > first || below < last) {
        if above > first {
            above -= 1;
            goes_on = visit(above);
        }
        if goes_on && below < last {
            below += 1;
            goes_on = visit(below);
        }
    }
}

/// Error of the border between cells, in sides.
const ROUNDING: f32 = 1e-2;

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
        let by_cell = placed.by_cell();
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
            assert_eq!(by_cell.room(at, along, spacing, line), expected);
        }
    }
}
