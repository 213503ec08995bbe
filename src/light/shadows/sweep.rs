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

    /// Heights, turned, and a row of [`NOTHING`] below them: what is beyond the last row, and before the first.
    pub(super) fn turned(self, height: &Plane) -> Plane {
        let turned = match self.is_transposed {
            true => transposed(height),
            false => height.clone(),
        };
        let (width, rows) = (turned.width(), turned.height());
        let mut samples = self.mirrored(turned).into_samples();
        samples.resize(width * (rows + 1), NOTHING);
        Plane::from_samples(width, rows + 1, samples)
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

/// Which pixels look at their horizon along a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Looks {
    /// Both of a column, each by the lines on its two sides: the edge of a shadow is exact.
    Both,
    /// The nearer one, by this line alone: half the looks, for sums over several azimuths.
    Nearer,
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

    /// Sweeps [turned](Way::turned) heights, and fills `lines`, of their size; `seen` turns slopes per column, of a unit of
    /// which it gets the slope, into what they hold. [`Course::spread`] takes that to the pixels.
    pub(super) fn sweep(
        &self,
        height: &Plane,
        looks: Looks,
        lines: &mut Plane,
        seen: impl Fn(&mut [f32], f32) + Sync,
    ) -> Course {
        let (width, rows) = (height.width(), height.height());
        let course = Course::new(self.drift, width, rows, looks);
        if width == 0 {
            return course;
        }
        let tasks = lines.samples_mut().par_chunks_mut(LINES * width);
        tasks.enumerate().for_each_init(
            || Sweep::new(width),
            |sweep, (task, lines)| {
                let first = task * LINES;
                if course.looks == Looks::Both {
                    sweep.go::<true>(&course, height, (first + rows - 1) % rows);
                }
                for (i, line) in lines.chunks_mut(width).enumerate() {
                    match course.looks {
                        Looks::Both => {
                            std::mem::swap(&mut sweep.below, &mut sweep.above);
                            sweep.go::<true>(&course, height, first + i);
                            course.mix(line, sweep, first + i);
                        }
                        Looks::Nearer => {
                            sweep.go::<false>(&course, height, first + i);
                            line.copy_from_slice(&sweep.upper);
                        }
                    }
                    seen(line, self.per_column);
                }
            },
        );
        course
    }
}

/// Whether the lower pixel is the nearer one to a line with this share.
#[inline(always)]
fn is_lower(share: f32) -> bool {
    share >= 0.5
}

/// The course that all lines take.
pub(super) struct Course {
    looks: Looks,
    /// By column: rows below that in which a line began, less than there are.
    down: Vec<usize>,
    /// By column: the same of the pixel that looks along the line.
    looking: Vec<usize>,
    /// By column: the share of the lower pixel.
    share: Vec<f32>,
    /// The columns in which lines have got to another row, and where between it and the one before they did.
    turns: Vec<(usize, f32)>,
    rows: usize,
    drift: f64,
}

impl Course {
    fn new(drift: f64, width: usize, rows: usize, looks: Looks) -> Self {
        let place = |x: usize| drift * x as f64;
        let whole = |x: usize| place(x).floor();
        let columns = || 0..width;
        let down = |row: f64| (row as i64).rem_euclid(rows as i64) as usize;
        // Lines through pixels have the upper ones alone.
        let looks = if drift == 0.0 { Looks::Nearer } else { looks };
        let share = |x: usize| (place(x) - whole(x)) as f32;
        let looking = |x: usize| match looks {
            Looks::Nearer if is_lower(share(x)) => whole(x) + 1.0,
            _ => whole(x),
        };
        Self {
            looks,
            down: columns().map(|x| down(whole(x))).collect(),
            looking: columns().map(|x| down(looking(x))).collect(),
            share: columns().map(share).collect(),
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

    /// The columns between which a line leaves the picture.
    fn stretches(&self, line: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let leaves = move |x: &usize| {
            // Between the last row and the one beyond it.
            let [from, to] = [x - 1, *x].map(|x| (self.row(line, x) + 1) % self.rows);
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

    /// Takes what lines hold to the pixels that look along them.
    pub(super) fn spread<T: Copy + Send>(
        &self,
        lines: &Plane,
        pixels: &mut Plane<T>,
        add: impl Fn(&mut T, f32) + Sync,
    ) {
        let (held, width) = (lines.samples(), lines.width());
        pixels.each_row(|y, row| {
            for (x, (pixel, &down)) in row.iter_mut().zip(&self.looking).enumerate() {
                let line = if y >= down {
                    y - down
                } else {
                    y + self.rows - down
                };
                add(pixel, held[line * width + x]);
            }
        });
    }

    /// What the upper pixels of a line see, by the line itself and by the one above it.
    fn mix(&self, mixed: &mut [f32], sweep: &Sweep, line: usize) {
        let (upper, lower, share) = (&sweep.upper, &sweep.above, &self.share);
        for (x, mixed) in mixed.iter_mut().enumerate() {
            let row = self.row(line, x);
            *mixed = match row {
                // No surface is above the first row, and none below the last.
                0 => upper[x],
                _ if row + 2 == self.rows => lower[x],
                _ => upper[x] + share[x] * (lower[x] - upper[x]),
            };
        }
    }
}

/// A line being swept.
struct Sweep {
    /// Heights of the pixels above the upper ones, of these, of the lower ones, and of those below; and of which line.
    rows: [Vec<f32>; 4],
    line: Option<usize>,
    /// Heights between the upper and the lower pixels, and where a line has just passed through a row.
    between: Vec<f32>,
    crossed: Vec<f32>,
    /// Heights at which the line passes the planes of the pixels that look along it: the upper or nearer ones, and the lower
    /// ones.
    eyes: [Vec<f32>; 2],
    /// Slopes to the horizons of the upper or nearer pixels, and of the lower ones; and of the lower ones of the line above.
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
            rows: [row(), row(), row(), row()],
            line: None,
            between: row(),
            crossed: vec![NOTHING; width],
            eyes: [row(), row()],
            upper: row(),
            below: row(),
            above: row(),
            hull: vec![[0.0; 2]; 2 * width],
        }
    }

    /// Takes up the heights around a line.
    fn take_up(&mut self, course: &Course, height: &Plane, line: usize) {
        let (samples, width, rows) = (height.samples(), height.width(), course.rows);
        let gather = |to: &mut [f32], line: usize| {
            for (x, to) in to.iter_mut().enumerate() {
                *to = samples[course.row(line % rows, x) * width + x];
            }
        };
        if line == 0 || self.line != Some(line - 1) {
            for (i, row) in self.rows.iter_mut().skip(1).enumerate() {
                gather(row, line + rows - 1 + i);
            }
        }
        self.rows.rotate_left(1);
        gather(&mut self.rows[3], line + 2);
        self.line = Some(line);
    }

    /// Sweeps a line, looking from both pixels of a column or from the nearer one.
    fn go<const BOTH: bool>(&mut self, course: &Course, height: &Plane, line: usize) {
        self.take_up(course, height, line);
        let rows = self.rows.each_ref().map(|row| &row[..]);
        let (between, crossed) = (&mut self.between, &mut self.crossed);
        let [eyes, lower_eyes] = &mut self.eyes;
        let share = &course.share[..];
        if BOTH {
            wide!(pass_planes(eyes, rows, share, |_| false));
            wide!(pass_planes(lower_eyes, rows, share, |_| true));
            wide!(between_rows(between, rows, [eyes, lower_eyes], share));
        } else {
            wide!(pass_planes(eyes, rows, share, is_lower));
            wide!(between_rows(between, rows, [eyes, eyes], share));
        }
        let [_, upper, lower, _] = rows;
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
        // A line that has left the picture is another one.
        for columns in course.stretches(line) {
            let heights = [&eyes[..], &lower_eyes[..], &between[..], &crossed[..]];
            let slopes = [&mut self.upper[..], &mut self.below[..]];
            pass::<BOTH>(&mut self.hull, course, columns, heights, slopes);
        }
    }
}

/// Heights at which a line passes the planes of the upper pixels, or of the lower ones where its share says so.
#[inline(always)]
fn pass_planes(eyes: &mut [f32], rows: [&[f32]; 4], share: &[f32], is_lower: impl Fn(f32) -> bool) {
    let n = eyes.len();
    let ([a, b, c, d], share) = (rows.map(|row| &row[..n]), &share[..n]);
    for x in 0..n {
        let w = share[x];
        eyes[x] = match is_lower(w) {
            true => c[x] + (w - 1.0) * tilt(b[x], c[x], d[x]),
            false => b[x] + w * tilt(a[x], b[x], c[x]),
        };
    }
}

/// Heights between two rows. Beside [`NOTHING`] a pixel's own plane reaches half way.
#[inline(always)]
fn between_rows(between: &mut [f32], rows: [&[f32]; 4], eyes: [&[f32]; 2], share: &[f32]) {
    let n = between.len();
    let ([_, upper, lower, _], share) = (rows.map(|row| &row[..n]), &share[..n]);
    let [of_upper, of_lower] = eyes.map(|row| &row[..n]);
    for x in 0..n {
        let (a, b, w) = (upper[x], lower[x], share[x]);
        let [nearest, plane] = match is_lower(w) {
            true => [b, of_lower[x]],
            false => [a, of_upper[x]],
        };
        let alone = if nearest > NOTHING { plane } else { NOTHING };
        let is_surface = a > NOTHING && b > NOTHING;
        between[x] = if is_surface { a + w * (b - a) } else { alone };
    }
}

/// Sweeps through these columns: slopes to the horizons of the upper pixels, or the nearer ones, and of the lower pixels.
fn pass<const BOTH: bool>(
    hull: &mut [[f32; 2]],
    course: &Course,
    columns: Range<usize>,
    [upper, lower, between, crossed]: [&[f32]; 4],
    [of_upper, of_lower]: [&mut [f32]; 2],
) {
    let mut passed = Passed { hull, count: 0 };
    let first = columns.start;
    let mut turn = course.turns.partition_point(|(x, _)| *x <= first);
    for x in columns {
        let at = x as f32;
        if let Some((next, share)) = course.turns.get(turn)
            && *next == x
        {
            turn += 1;
            if crossed[x] > NOTHING {
                passed.add([at - 1.0 + share, crossed[x]]);
            }
        }
        of_upper[x] = passed.slope([at, upper[x]]);
        if BOTH {
            of_lower[x] = passed.slope([at, lower[x]]);
        }
        if between[x] > NOTHING {
            passed.add([at, between[x]]);
        }
    }
}

/// The points that a line has passed.
struct Passed<'a> {
    /// The first `count` are their upper hull.
    hull: &'a mut [[f32; 2]],
    count: usize,
}

impl Passed<'_> {
    /// The steepest slope up to one of the points, from a place beyond them.
    #[inline(always)]
    fn slope(&self, [at, height]: [f32; 2]) -> f32 {
        let Some((&[x, h], rest)) = self.hull[..self.count].split_last() else {
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

    /// Adds a point beyond all others.
    #[inline(always)]
    fn add(&mut self, point: [f32; 2]) {
        while let [.., a, b] = &self.hull[..self.count] {
            let [near, far] = [b, a].map(|[x, h]| [point[0] - x, h - point[1]]);
            // A point on or below the line between its neighbours is no horizon.
            if near[1] * far[0] > far[1] * near[0] {
                break;
            }
            self.count -= 1;
        }
        self.hull[self.count] = point;
        self.count += 1;
    }
}
