//! Horizons along one azimuth, by sweeps away from the light.
//!
//! Sweeps are lines `y = k + m x` with |m| at most 1, in a picture turned so that light comes from the left: all lines are
//! at the same share of a row between two pixels of a column. A line that leaves the picture at one side enters it at the
//! other as a new one, so that lines are as many as rows and as long as these.

use crate::frame::Plane;
use crate::kernel::simd::wide;
use crate::shape::occlusion::NOTHING;
use rayon::prelude::*;
use std::ops::Range;

/// Lines per task. One more is swept for each task: the first one's neighbour.
const LINES: usize = 32;

/// The slope to a horizon where nothing is toward the light.
const NO_HORIZON: f32 = -1e6;

/// Columns between two points of a hull at least: over less the rounding of heights would count as slope.
const APART: f32 = 0.02;

/// How a picture is turned so that light comes from the left and changes rows no faster than columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Way {
    is_transposed: bool,
    is_mirrored: bool,
}

impl Way {
    pub(super) const ALL: [Self; 4] = [
        Self::new(false, false),
        Self::new(false, true),
        Self::new(true, false),
        Self::new(true, true),
    ];

    const fn new(is_transposed: bool, is_mirrored: bool) -> Self {
        Self {
            is_transposed,
            is_mirrored,
        }
    }

    /// A plane, turned.
    pub(super) fn turned(self, plane: &Plane) -> Plane {
        let turned = match self.is_transposed {
            true => transposed(plane),
            false => plane.clone(),
        };
        self.mirrored(turned)
    }

    /// A turned plane as it was.
    pub(super) fn turned_back<T: Copy + Default + Send + Sync>(self, plane: Plane<T>) -> Plane<T> {
        let plane = self.mirrored(plane);
        match self.is_transposed {
            true => transposed(&plane),
            false => plane,
        }
    }

    fn mirrored<T: Copy + Send>(self, mut plane: Plane<T>) -> Plane<T> {
        if self.is_mirrored {
            plane.each_row(|_, row| row.reverse());
        }
        plane
    }
}

/// Pixels on a side of the squares that are transposed together.
const SQUARE: usize = 16;

fn transposed<T: Copy + Default + Send + Sync>(plane: &Plane<T>) -> Plane<T> {
    let (width, height) = (plane.width(), plane.height());
    let mut turned = Plane::filled(height, width, T::default());
    let bands = turned
        .samples_mut()
        .par_chunks_mut((SQUARE * height).max(1));
    bands.enumerate().for_each(|(band, rows)| {
        for top in (0..height).step_by(SQUARE) {
            for (i, row) in rows.chunks_mut(height).enumerate() {
                let square = row.iter_mut().enumerate().skip(top).take(SQUARE);
                square.for_each(|(y, sample)| *sample = plane.at(band * SQUARE + i, y));
            }
        }
    });
    turned
}

/// Change of the height per row: the smaller of those to both sides, so that it is that of the pixel's own surface beside a
/// step, and none where they differ in sign.
pub(super) fn tilts(height: &Plane) -> Plane {
    let mut tilts = Plane::filled(height.width(), height.height(), 0.0);
    let is_there = |a: f32, b: f32| a > NOTHING && b > NOTHING;
    tilts.each_row(|y, row| {
        let own = height.row(y);
        let beside = [y.saturating_sub(1), (y + 1).min(height.height() - 1)];
        let [above, below] = beside.map(|y| height.row(y));
        for (x, tilt) in row.iter_mut().enumerate() {
            let (to, from) = (own[x] - above[x], below[x] - own[x]);
            let has = [y > 0, y + 1 < height.height()];
            let has = [
                has[0] && is_there(own[x], above[x]),
                has[1] && is_there(own[x], below[x]),
            ];
            *tilt = match has {
                [true, true] if to * from <= 0.0 => 0.0,
                [true, true] if to.abs() < from.abs() => to,
                [true, false] => to,
                [_, true] => from,
                [false, false] => 0.0,
            };
        }
    });
    tilts
}

/// The way that light comes along.
pub(super) struct Azimuth {
    pub(super) way: Way,
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
            way: Way::new(is_transposed, along > 0.0),
            drift: -across / along.abs(),
            per_column: along.abs() as f32,
        }
    }

    /// Sweeps a turned plane of heights, with its [`tilts`]. `seen` turns slopes per column, of a unit of which it gets the slope, into what is
    /// added to `sum`; `lines` is overwritten.
    pub(super) fn sweep(
        &self,
        surface: [&Plane; 2],
        [lines, sum]: [&mut Plane; 2],
        seen: impl Fn(&mut [f32], f32) + Sync,
    ) {
        let (width, rows) = (surface[0].width(), surface[0].height());
        if width * rows == 0 {
            return;
        }
        let course = Course::new(self.drift, width, rows);
        let tasks = lines.samples_mut().par_chunks_mut(LINES * width);
        tasks.enumerate().for_each_init(
            || Sweep::new(width),
            |sweep, (task, lines)| {
                let first = task * LINES;
                if course.is_aslant() {
                    sweep.go(&course, surface, (first + rows - 1) % rows);
                }
                for (i, line) in lines.chunks_mut(width).enumerate() {
                    std::mem::swap(&mut sweep.below, &mut sweep.above);
                    sweep.go(&course, surface, first + i);
                    course.mix(line, sweep, first + i);
                    seen(line, self.per_column);
                }
            },
        );
        let swept = lines.samples();
        sum.each_row(|y, row| {
            for (x, (sum, down)) in row.iter_mut().zip(&course.down).enumerate() {
                let line = if y >= *down {
                    y - down
                } else {
                    y + rows - down
                };
                *sum += swept[line * width + x];
            }
        });
    }
}

/// The course that all lines take.
struct Course {
    /// By column: rows below that in which a line began, less than those of the picture.
    down: Vec<usize>,
    /// By column: the share of the lower pixel.
    share: Vec<f32>,
    /// The columns in which lines have got to another row, and where between it and the one before they did.
    turns: Vec<(usize, f32)>,
    rows: usize,
    drift: f64,
}

impl Course {
    fn new(drift: f64, width: usize, rows: usize) -> Self {
        let place = |x: usize| drift * x as f64;
        let whole = |x: usize| place(x).floor();
        let columns = || 0..width;
        Self {
            down: columns()
                .map(|x| (whole(x) as i64).rem_euclid(rows as i64) as usize)
                .collect(),
            share: columns().map(|x| (place(x) - whole(x)) as f32).collect(),
            turns: (1..width)
                .filter(|&x| whole(x) != whole(x - 1))
                .map(|x| {
                    let row = whole(x).max(whole(x - 1));
                    (x, ((row - place(x - 1)) / drift) as f32)
                })
                .collect(),
            rows,
            drift,
        }
    }

    /// The row of a line in a column.
    fn row(&self, line: usize, x: usize) -> usize {
        let row = line + self.down[x];
        if row >= self.rows {
            row - self.rows
        } else {
            row
        }
    }

    /// The columns in which a line is on the last row: nothing is below.
    fn on_last_row(&self, line: usize) -> impl Iterator<Item = usize> + '_ {
        let down = (2 * self.rows - 1 - line) % self.rows;
        let columns = self.down.iter().enumerate();
        columns.filter_map(move |(x, &own)| (own == down).then_some(x))
    }

    /// The columns between which a line leaves the picture.
    fn stretches(&self, line: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let leaves = move |x: &usize| {
            let [from, to] = [x - 1, *x].map(|x| self.row(line, x));
            if self.drift > 0.0 {
                to <= from
            } else {
                to >= from
            }
        };
        let ends = self.turns.iter().map(|(x, _)| *x).filter(leaves);
        let mut from = 0;
        ends.chain([self.share.len()])
            .map(move |to| std::mem::replace(&mut from, to)..to)
    }

    /// Whether lines pass between pixels.
    fn is_aslant(&self) -> bool {
        self.drift != 0.0
    }

    /// What the upper pixels of a line see, by the line itself and by the one above it.
    fn mix(&self, mixed: &mut [f32], sweep: &Sweep, line: usize) {
        if !self.is_aslant() {
            mixed.copy_from_slice(&sweep.upper);
            return;
        }
        let (upper, lower, share) = (&sweep.upper, &sweep.above, &self.share);
        for (x, mixed) in mixed.iter_mut().enumerate() {
            let row = self.row(line, x);
            *mixed = match row {
                // No line is above the first row, and none between the last and another.
                0 => upper[x],
                _ if row + 1 == self.rows => lower[x],
                _ => upper[x] + share[x] * (lower[x] - upper[x]),
            };
        }
    }
}

/// A line being swept.
struct Sweep {
    /// Heights and tilts of the pixels on the rows that the next line has for its upper ones, and which line that is.
    next: [Vec<f32>; 2],
    next_line: Option<usize>,
    /// Heights of the upper and lower pixels, between them, and where a line has just passed through a row.
    heights: [Vec<f32>; 4],
    /// Heights at which the line passes the planes of the upper and the lower pixels: those they look from.
    eyes: [Vec<f32>; 2],
    /// Slopes to the horizons of the upper pixels, and of the lower ones; and of the lower ones of the line above.
    upper: Vec<f32>,
    below: Vec<f32>,
    above: Vec<f32>,
    /// The upper hull of the points passed.
    hull: Vec<[f32; 2]>,
}

impl Sweep {
    fn new(width: usize) -> Self {
        let row = || vec![0.0; width];
        Self {
            next: [row(), row()],
            next_line: None,
            heights: [row(), row(), row(), vec![NOTHING; width]],
            eyes: [row(), row()],
            upper: row(),
            below: row(),
            above: row(),
            hull: vec![[0.0; 2]; 2 * width],
        }
    }

    /// Sweeps a line.
    fn go(&mut self, course: &Course, [height, tilts]: [&Plane; 2], line: usize) {
        let [upper, lower, between, crossed] = &mut self.heights;
        let [next, next_tilts] = &mut self.next;
        let [from_upper, from_lower] = &mut self.eyes;
        let gather = |to: &mut [f32], plane: &Plane, line: usize| {
            let (samples, width) = (plane.samples(), plane.width());
            for (x, to) in to.iter_mut().enumerate() {
                *to = samples[course.row(line, x) * width + x];
            }
        };
        if self.next_line != Some(line) {
            gather(next, height, line);
            gather(next_tilts, tilts, line);
        }
        upper.copy_from_slice(next);
        let share = &course.share[..];
        wide!(pass_planes(from_upper, [upper, next_tilts, share], 0.0));
        gather(next, height, line + 1);
        gather(next_tilts, tilts, line + 1);
        self.next_line = Some(line + 1);
        lower.copy_from_slice(next);
        wide!(pass_planes(from_lower, [lower, next_tilts, share], 1.0));
        for x in course.on_last_row(line) {
            (lower[x], from_lower[x]) = (NOTHING, NOTHING);
        }
        wide!(between_rows(
            between,
            [&*upper, &*lower],
            [&*from_upper, &*from_lower],
            &course.share
        ));
        for &(x, share) in &course.turns {
            let ends = match course.drift > 0.0 {
                true => [lower[x - 1], upper[x]],
                false => [upper[x - 1], lower[x]],
            };
            let is_surface = ends[0] > NOTHING && ends[1] > NOTHING;
            crossed[x] = match is_surface && share > APART && share < 1.0 - APART {
                true => ends[0] + share * (ends[1] - ends[0]),
                false => NOTHING,
            };
        }
        let pass = match course.is_aslant() {
            true => pass::<true>,
            false => pass::<false>,
        };
        // A line that has left the picture is another one.
        for columns in course.stretches(line) {
            let heights = [&from_upper[..], &from_lower[..], &between[..], &crossed[..]];
            let slopes = [&mut self.upper[..], &mut self.below[..]];
            pass(&mut self.hull, course, columns, heights, slopes);
        }
    }
}

/// Heights at which a line passes the planes of pixels, `rows` below it, from their heights, tilts and its share.
#[inline(always)]
fn pass_planes(eyes: &mut [f32], [heights, tilts, share]: [&[f32]; 3], rows: f32) {
    let n = eyes.len();
    let (heights, tilts, share) = (&heights[..n], &tilts[..n], &share[..n]);
    for x in 0..n {
        eyes[x] = heights[x] + (share[x] - rows) * tilts[x];
    }
}

/// Heights between two rows. Beside [`NOTHING`] a pixel's own plane reaches half way.
#[inline(always)]
fn between_rows(between: &mut [f32], pixels: [&[f32]; 2], planes: [&[f32]; 2], share: &[f32]) {
    let n = between.len();
    let ([upper, lower], share) = (pixels.map(|row| &row[..n]), &share[..n]);
    let [of_upper, of_lower] = planes.map(|row| &row[..n]);
    for x in 0..n {
        let (a, b, w) = (upper[x], lower[x], share[x]);
        let [nearest, plane] = if w < 0.5 {
            [a, of_upper[x]]
        } else {
            [b, of_lower[x]]
        };
        let alone = if nearest > NOTHING { plane } else { NOTHING };
        let is_surface = a > NOTHING && b > NOTHING;
        between[x] = if is_surface { a + w * (b - a) } else { alone };
    }
}

/// Sweeps through these columns: slopes to the horizons of the upper and the lower pixels, unless lines pass through the upper
/// ones.
fn pass<const IS_ASLANT: bool>(
    hull: &mut [[f32; 2]],
    course: &Course,
    columns: Range<usize>,
    [upper, lower, between, crossed]: [&[f32]; 4],
    [of_upper, of_lower]: [&mut [f32]; 2],
) {
    let first = columns.start;
    let (mut count, mut turn) = (0, course.turns.partition_point(|(x, _)| *x <= first));
    for x in columns {
        let at = x as f32;
        if IS_ASLANT
            && let Some((next, share)) = course.turns.get(turn)
            && *next == x
        {
            turn += 1;
            if crossed[x] > NOTHING {
                count = pushed(hull, count, [at - 1.0 + share, crossed[x]]);
            }
        }
        let passed = &hull[..count];
        of_upper[x] = slope(passed, at, upper[x]);
        if IS_ASLANT {
            of_lower[x] = slope(passed, at, lower[x]);
        }
        if between[x] > NOTHING {
            count = pushed(hull, count, [at, between[x]]);
        }
    }
}

/// The steepest slope up to a point of a hull, back from a place beyond it.
#[inline(always)]
fn slope(hull: &[[f32; 2]], at: f32, height: f32) -> f32 {
    let Some((&[x, h], rest)) = hull.split_last() else {
        return NO_HORIZON;
    };
    let (mut run, mut rise) = (at - x, h - height);
    for &[x, h] in rest.iter().rev() {
        let (farther, higher) = (at - x, h - height);
        // The hull is convex: slopes rise up to the horizon, and fall from there on.
        if higher * run <= rise * farther {
            break;
        }
        (run, rise) = (farther, higher);
    }
    rise / run
}

/// Adds a point beyond all others of a hull of `count` points; returns how many are left.
#[inline(always)]
fn pushed(hull: &mut [[f32; 2]], mut count: usize, point: [f32; 2]) -> usize {
    while let [.., a, b] = &hull[..count] {
        let [near, far] = [b, a].map(|[x, h]| [point[0] - x, h - point[1]]);
        // A point on or below the line between its neighbours is no horizon.
        if near[1] * far[0] > far[1] * near[0] {
            break;
        }
        count -= 1;
    }
    hull[count] = point;
    count + 1
}
