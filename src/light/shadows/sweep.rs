//! Horizons along one azimuth, by sweeps away from the light.
//!
//! Sweeps are lines `y = k + m x` with |m| at most 1, in a picture turned so that light comes from the left: all lines are
//! at the same share of a row between two pixels of a column. So neighbours are swept side by side, as one vector.

use super::hull::{Abreast, HullStacks, Hulls, LINES};
use super::strips::{Around, Heights};
use crate::frame::Plane;
use crate::kernel::simd::wide;
use crate::shape::occlusion::NOTHING;
use rayon::prelude::*;
use std::ops::{AddAssign, Range};

/// Columns whose heights are gathered at a time, so that hulls do not wait for memory.
const GATHERED: usize = 32;

/// Columns between two points of a hull at least: over less the rounding of heights would count as slope.
const APART: f32 = 0.02;

/// Change of the height per row: the smaller of those to both sides, so that it is that of the pixel's own surface beside a
/// step, and none where they differ in sign.
#[inline(always)]
fn tilt(above: f32, own: f32, below: f32) -> f32 {
    let (to, from) = (own - above, below - own);
    let has_above = above > NOTHING && own > NOTHING;
    let has_below = below > NOTHING && own > NOTHING;
    let least = if to.abs() < from.abs() { to } else { from };
    let of_both = if to * from > 0.0 { least } else { 0.0 };
    match (has_above, has_below) {
        (true, true) => of_both,
        (true, false) => to,
        (false, true) => from,
        (false, false) => 0.0,
    }
}

/// The way that light comes along.
pub(super) struct Azimuth {
    /// Whether it comes along the columns of the picture rather than its rows.
    pub(super) is_transposed: bool,
    /// Whether it comes from the last column.
    is_mirrored: bool,
    /// Rows down per column, away from the light.
    drift: f64,
    /// The slope of a rise of 1 per column.
    per_column: f32,
}

impl Azimuth {
    /// Of light from `azimuth`, counterclockwise from the right, over pixels `shape` times as wide as high. Lengths are in
    /// pixels of the mean size.
    pub(super) fn of(azimuth: f64, shape: f32) -> Self {
        let size = f64::from(shape).sqrt();
        // Columns to the right and rows down per unit toward the light.
        let (columns, rows) = (azimuth.cos() / size, -azimuth.sin() * size);
        let is_transposed = rows.abs() > columns.abs();
        let [along, across] = match is_transposed {
            true => [rows, columns],
            false => [columns, rows],
        };
        Self {
            is_transposed,
            is_mirrored: along > 0.0,
            drift: -across / along.abs(),
            per_column: along.abs() as f32,
        }
    }

    /// Sweeps heights; `see` turns slopes per column, of a unit of which it gets the slope, into what pixels are added.
    /// Either both pixels of a column look at their horizon, each by the lines on its two sides, so that the edge of a shadow
    /// is exact; or the nearer one does, by this line alone: half the looks, for sums over several azimuths.
    pub(super) fn sweep<T: AddAssign + Copy + Default + Send + Sync>(
        &self,
        heights: &Heights,
        looks_both: bool,
        see: impl Fn(&mut [f32], f32, &mut [T]) + Sync,
        found: &mut Plane<T>,
    ) {
        let Heights { columns, rows, .. } = *heights;
        let course = Course::new(self, [columns, rows], looks_both);
        let Some(&last) = course.down.last() else {
            return;
        };
        // With looks from both sides, the first line of a swath is the last of the one before.
        let shared = usize::from(course.looks_both);
        let step = (LINES - shared) as isize;
        let first = -1 - last.max(0) - shared as isize;
        let swaths = rows as isize - last.min(0) - first;
        let swaths = (0..(swaths + step - 1) / step).into_par_iter();
        let room = || (HullStacks::new(columns), vec![0.0; columns * LINES]);
        let swaths = swaths.map_init(room, |(stacks, slopes), i| {
            let line = first + i * step;
            let mut swath = Swath {
                line,
                columns: course.within(line),
                seen: Vec::new(),
            };
            let slopes = &mut slopes[..swath.columns.len() * LINES];
            wide!(swath.sweep(&course, heights, stacks, slopes));
            swath.seen.resize(slopes.len(), T::default());
            see(slopes, self.per_column, &mut swath.seen);
            swath
        });
        let swaths: Vec<Swath<T>> = swaths.collect();
        found.each_row(|at, found| {
            let x = course.swept(at);
            let mut y = 0;
            while y < found.len() {
                let line = y as isize - course.looking(x) - first - shared as isize;
                let swath = &swaths[line.div_euclid(step) as usize];
                let lane = shared + line.rem_euclid(step) as usize;
                let seen = &swath.seen[(x - swath.columns.start) * LINES..][lane..LINES];
                let pairs = found[y..].iter_mut().zip(seen);
                pairs.for_each(|(found, &seen)| *found += seen);
                y += seen.len();
            }
        });
    }
}

/// Whether the lower pixel is the nearer one to a line with this share.
#[inline(always)]
fn is_lower(share: f32) -> bool {
    share >= 0.5
}

/// The course that all lines take.
struct Course<'a> {
    azimuth: &'a Azimuth,
    looks_both: bool,
    rows: usize,
    /// By column: rows below that in which a line began.
    down: Vec<isize>,
    /// By column: the share of the lower pixel.
    share: Vec<f32>,
    /// By column: where between the one before and it lines pass through a row, if they do so apart from both; else 0.
    crossing: Vec<f32>,
}

impl<'a> Course<'a> {
    fn new(azimuth: &'a Azimuth, [width, rows]: [usize; 2], looks_both: bool) -> Self {
        let drift = azimuth.drift;
        let place = |x: usize| drift * x as f64;
        let whole = |x: usize| place(x).floor();
        let crossing = |x: usize| {
            let before = x.saturating_sub(1);
            let row = whole(x).max(whole(before));
            let share = ((row - place(before)) / drift) as f32;
            let is_apart = share > APART && share < 1.0 - APART;
            let crosses = whole(x) != whole(before) && is_apart;
            if crosses { share } else { 0.0 }
        };
        Self {
            // Lines through pixels have the upper ones alone.
            looks_both: looks_both && drift != 0.0,
            rows,
            azimuth,
            down: (0..width).map(|x| whole(x) as isize).collect(),
            share: (0..width).map(|x| (place(x) - whole(x)) as f32).collect(),
            crossing: (0..width).map(crossing).collect(),
        }
    }

    /// The column of the picture that is swept as this one, or the other way round.
    fn swept(&self, x: usize) -> usize {
        match self.azimuth.is_mirrored {
            true => self.down.len() - 1 - x,
            false => x,
        }
    }

    /// By column: rows below that in which a line began, of the pixel that looks along it.
    fn looking(&self, x: usize) -> isize {
        let is_next = !self.looks_both && is_lower(self.share[x]);
        self.down[x] + isize::from(is_next)
    }

    /// Passes the row between column `x` and the one before, by the heights around lines in both.
    #[inline(always)]
    fn cross(&self, hulls: &mut Hulls, before: &Around, own: &Around, x: usize) {
        let share = self.crossing[x];
        let [from, to] = match self.azimuth.drift > 0.0 {
            true => [&before[2], &own[1]],
            false => [&before[1], &own[2]],
        };
        let mut crossed = [NOTHING; LINES];
        for l in 0..LINES {
            crossed[l] = between(from[l], to[l], share).unwrap_or(NOTHING);
        }
        hulls.add(x as f32 - 1.0 + share, &crossed);
    }

    /// Passes column `x`, of which the first line has this row above it: slopes to the horizons of the upper pixels, or of
    /// the nearer ones.
    #[inline(always)]
    fn pass(&self, hulls: &mut Hulls, [a, b, c, d]: &Around, x: usize, row: isize) -> Abreast {
        let (at, w) = (x as f32, self.share[x]);
        let [mut upper, mut lower, mut middle] = [[0.0; LINES]; 3];
        for l in 0..LINES {
            upper[l] = b[l] + w * tilt(a[l], b[l], c[l]);
            lower[l] = c[l] + (w - 1.0) * tilt(b[l], c[l], d[l]);
            let [nearest, plane] = match is_lower(w) {
                true => [c[l], lower[l]],
                false => [b[l], upper[l]],
            };
            // Beside [`NOTHING`] a pixel's own plane reaches half way.
            let alone = if nearest > NOTHING { plane } else { NOTHING };
            middle[l] = between(b[l], c[l], w).unwrap_or(alone);
        }
        let mut slopes = match !self.looks_both && is_lower(w) {
            true => hulls.slopes(at, &lower),
            false => hulls.slopes(at, &upper),
        };
        if self.looks_both {
            let above = hulls.slopes(at, &lower);
            for l in 1..LINES {
                let row = row + l as isize;
                // No surface is above the first row, and none below the last.
                let both = slopes[l] + w * (above[l - 1] - slopes[l]);
                let is_last = row + 1 == self.rows as isize;
                let with_above = if is_last { above[l - 1] } else { both };
                slopes[l] = if row > 0 { with_above } else { slopes[l] };
            }
        }
        hulls.add(at, &middle);
        slopes
    }

    /// The columns in which lines from this one on have pixels of the picture on a side.
    fn within(&self, line: isize) -> Range<usize> {
        let rows = -(LINES as isize)..self.rows as isize;
        let is_inside = |x: &usize| rows.contains(&(line + self.down[*x]));
        let width = self.down.len();
        let start = (0..width).find(is_inside).unwrap_or(width);
        let end = (start..width).find(|x| !is_inside(x)).unwrap_or(width);
        start..end
    }
}

/// Lines that are swept side by side.
struct Swath<T> {
    /// The first of them, by the row that it begins in.
    line: isize,
    columns: Range<usize>,
    /// What is seen along them, column by column.
    seen: Vec<T>,
}

impl<T> Swath<T> {
    /// Sweeps the lines: slopes to the horizons of the upper pixels, or of the nearer ones.
    #[inline(always)]
    fn sweep(&self, course: &Course, heights: &Heights, room: &mut HullStacks, to: &mut [f32]) {
        let mut hulls = Hulls::new(room);
        let mut around = [[[0.0; LINES]; 4]; GATHERED + 1];
        let blocks = to.as_chunks_mut().0.chunks_mut(GATHERED);
        for (i, slopes) in blocks.enumerate() {
            let first = self.columns.start + i * GATHERED;
            // The column before comes first.
            let before = first.saturating_sub(1);
            for (around, x) in around.iter_mut().zip(before..first + slopes.len()) {
                *around = heights.around(self.line + course.down[x], course.swept(x));
            }
            for (slopes, x) in slopes.iter_mut().zip(first..) {
                let own = x - before;
                if course.crossing[x] > 0.0 {
                    course.cross(&mut hulls, &around[own - 1], &around[own], x);
                }
                let row = self.line + course.down[x];
                *slopes = course.pass(&mut hulls, &around[own], x, row);
            }
        }
    }
}

/// The height between two, if there are both.
#[inline(always)]
fn between(a: f32, b: f32, share: f32) -> Option<f32> {
    let is_surface = a > NOTHING && b > NOTHING;
    is_surface.then_some(a + share * (b - a))
}
