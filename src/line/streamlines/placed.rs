//! The points of lines placed so far, by cell.

use glam::Vec2;

/// A point of a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) at: Vec2,
    pub(super) line: u32,
    /// Index in its line, counted from the seed.
    pub(super) index: i32,
    /// The point of its cell that came before.
    before: u32,
}

/// No point.
const NONE: u32 = u32::MAX;

/// The points placed so far.
pub(super) struct Placed {
    points: Vec<Point>,
    /// The last point of every cell.
    last: Vec<u32>,
    size: [usize; 2],
    side: f32,
}

impl Placed {
    /// None, on paper of such a size, in cells of such a side.
    pub(super) fn new(size: [usize; 2], side: f32) -> Self {
        let size = size.map(|length| (length as f32 / side) as usize + 1);
        Self {
            points: Vec::new(),
            last: vec![NONE; size[0] * size[1]],
            size,
            side,
        }
    }

    #[inline]
    fn cell(&self, at: Vec2) -> [usize; 2] {
        let cell = |at: f32, count: usize| ((at / self.side).max(0.0) as usize).min(count - 1);
        [cell(at.x, self.size[0]), cell(at.y, self.size[1])]
    }

    #[inline]
    fn last(&mut self, at: Vec2) -> &mut u32 {
        let [x, y] = self.cell(at);
        &mut self.last[y * self.size[0] + x]
    }

    #[inline]
    pub(super) fn add(&mut self, at: Vec2, line: u32, index: i32) {
        let number = self.points.len() as u32;
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

    /// Number of points.
    pub(super) fn count(&self) -> usize {
        self.points.len()
    }

    /// Whether any point within some distance `counts`.
    #[inline]
    fn any(&self, at: Vec2, distance: f32, mut counts: impl FnMut(&Point) -> bool) -> bool {
        let [first, last] = [-distance, distance].map(|d| self.cell(at + d));
        let square = distance * distance;
        for y in first[1]..=last[1] {
            let row = y * self.size[0];
            for &newest in &self.last[row + first[0]..=row + last[0]] {
                let mut number = newest;
                while let Some(point) = self.points.get(number as usize) {
                    if point.at.distance_squared(at) < square && counts(point) {
                        return true;
                    }
                    number = point.before;
                }
            }
        }
        false
    }

    /// Whether no point that `counts` is closer than `distance`.
    #[inline]
    pub(super) fn is_free(&self, at: Vec2, distance: f32, counts: impl Fn(&Point) -> bool) -> bool {
        !self.any(at, distance, counts)
    }

    /// Distances of the nearest other lines on both sides; `spacing` where there is none within half as much again.
    pub(super) fn room(&self, at: Vec2, along: Vec2, spacing: f32, line: u32) -> [f32; 2] {
        let mut room = [f32::INFINITY; 2];
        self.any(at, 1.5 * spacing, |other| {
            let offset = other.at - at;
            let across = along.perp_dot(offset);
            // A point ahead is not a neighbour.
            let is_beside = across.abs() > 0.7 * along.length() * offset.length();
            if other.line != line && is_beside {
                let side = &mut room[usize::from(across > 0.0)];
                *side = side.min(offset.length());
            }
            false
        });
        room.map(|room| if room.is_finite() { room } else { spacing })
    }
}
