//! The patches of a frame: its surfaces cell by cell, each linked to its continuations.

use crate::frame::{Frame, Plane};
use crate::kernel::simd::wide;
use crate::line::direction_field::setting::OPEN;
use crate::line::patches::{MAX_CELL_PX, NO_PATCH, joined, label_cell};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// The part of one surface in one cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// Mean normal in the middle of the patch, unit or 0.
    pub(crate) normal: DVec3,
    /// Position of that middle in the picture.
    pub(crate) at: DVec2,
    /// Depth there; 0 without depth.
    pub(crate) depth: f32,
    /// Number of pixels.
    pub(crate) pixels: u16,
}

/// Continuation of each patch along one axis of the picture; [`NONE`] without one.
#[derive(Debug)]
pub(crate) struct Links {
    /// To the left, or above.
    pub(crate) before: Vec<u32>,
    /// To the right, or below.
    pub(crate) after: Vec<u32>,
}

/// No patch.
pub(crate) const NONE: u32 = u32::MAX;

/// The cells of a frame. They are at multiples of their size in the picture's coordinates, so that a crop has the cells
/// of the whole.
#[derive(Debug)]
pub(crate) struct Grid {
    cell_px: usize,
    /// Part of the first cell outside the frame.
    cut: [usize; 2],
    size: [usize; 2],
    places: [f32; MAX_CELL_PX],
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Grid {
    fn new(frame: &Frame, cell_px: usize) -> Self {
        let window = frame.data_window;
        let cut = [window.x0, window.y0].map(|c| c.rem_euclid(cell_px as i32) as usize);
        let size = [frame.mask.width(), frame.mask.height()];
        Self {
            cell_px,
            cut,
            size,
            places: std::array::from_fn(|inside| (inside as f32 + 0.5) / cell_px as f32 - 0.5),
            columns: (size[0] + cut[0]).div_ceil(cell_px),
            rows: (size[1] + cut[1]).div_ceil(cell_px),
        }
    }

    fn pixels(&self, axis: usize, cell: usize) -> Range<usize> {
        let (start, end) = (cell * self.cell_px, (cell + 1) * self.cell_px);
        let inside = |p: usize| p.saturating_sub(self.cut[axis]).min(self.size[axis]);
        inside(start)..inside(end)
    }

    /// The columns of pixels in a column of cells.
    pub(crate) fn x_pixels(&self, column: usize) -> Range<usize> {
        self.pixels(0, column)
    }

    /// The rows of pixels in a row of cells.
    pub(crate) fn y_pixels(&self, row: usize) -> Range<usize> {
        self.pixels(1, row)
    }

    /// Offsets of the centres of pixels of one cell from that of the cell, in cells, -1/2..1/2.
    pub(crate) fn places(&self, axis: usize, pixels: &Range<usize>) -> &[f32] {
        let first = (pixels.start + self.cut[axis]) % self.cell_px;
        &self.places[first..first + pixels.len()]
    }

    /// The places of the pixels across a cell of the usual four, the first two left of its middle.
    pub(crate) fn four_across(&self) -> Option<[f32; 4]> {
        (self.cell_px == 4).then(|| std::array::from_fn(|i| self.places[i]))
    }

    /// Samples of a plane, one part per row of cells.
    pub(crate) fn bands<'a, T>(&self, mut samples: &'a mut [T]) -> Vec<&'a mut [T]> {
        let mut bands = Vec::with_capacity(self.rows);
        for row in 0..self.rows {
            let (band, rest) = samples.split_at_mut(self.y_pixels(row).len() * self.size[0]);
            bands.push(band);
            samples = rest;
        }
        bands
    }
}

/// All patches, numbered by cell, row after row.
#[derive(Debug)]
pub(crate) struct Patches {
    pub(crate) grid: Grid,
    pub(crate) all: Vec<Patch>,
    /// The first patch of each cell, and the total number of patches.
    first: Vec<u32>,
    /// Whether each cell is one patch, whole.
    whole: Vec<bool>,
    /// Which patch of its cell a pixel belongs to.
    pub(crate) labels: Vec<u8>,
    pub(crate) across: Links,
    pub(crate) down: Links,
}

impl Patches {
    pub(crate) fn new(frame: &Frame, conductance: &Plane, cell_px: usize) -> Self {
        let grid = Grid::new(frame, cell_px);
        let mut labels = vec![0; frame.mask.plane().samples().len()];
        let found: Vec<(Vec<u32>, Vec<Patch>)> = grid
            .bands(&mut labels)
            .into_par_iter()
            .enumerate()
            .map(|(row, labels)| {
                RowOfCells {
                    grid: &grid,
                    frame,
                    conductance,
                    row,
                }
                .find(labels)
            })
            .collect();
        let mut first = Vec::with_capacity(grid.columns * grid.rows + 1);
        let mut count = 0;
        first.push(0);
        for (counts, _) in &found {
            first.extend(counts.iter().map(|c| {
                count += c;
                count
            }));
        }
        let mut all = Vec::with_capacity(count as usize);
        for (_, patches) in &found {
            all.extend_from_slice(patches);
        }
        let full = cell_px.pow(2);
        let is_whole = |cell: &[u32]| {
            cell[1] == cell[0] + 1 && usize::from(all[cell[0] as usize].pixels) == full
        };
        let whole = first.windows(2).map(is_whole).collect();
        let mut patches = Self {
            across: Links::none(0),
            down: Links::none(0),
            grid,
            all,
            first,
            whole,
            labels,
        };
        [patches.across, patches.down] = patches.links();
        patches
    }

    /// The patches of a cell.
    pub(crate) fn of_cell(&self, column: usize, row: usize) -> Range<usize> {
        let cell = row * self.grid.columns + column;
        self.first[cell] as usize..self.first[cell + 1] as usize
    }

    /// Whether each cell of a row is one patch, whole.
    pub(crate) fn whole(&self, row: usize) -> &[bool] {
        &self.whole[row * self.grid.columns..][..self.grid.columns]
    }

    /// The links of patches across and down.
    fn links(&self) -> [Links; 2] {
        let Grid { columns, rows, .. } = self.grid;
        let [mut across, mut down] = [(); 2].map(|()| Links::none(self.all.len()));
        let count = |row: usize| match row < rows {
            true => (self.first[(row + 1) * columns] - self.first[row * columns]) as usize,
            false => 0,
        };
        let mut rest = [
            &mut across.before[..],
            &mut across.after,
            &mut down.before,
            &mut down.after,
        ];
        let mut take = |which: usize, count: usize| {
            let (part, after) = std::mem::take(&mut rest[which]).split_at_mut(count);
            rest[which] = after;
            part
        };
        // Nothing is above the first row.
        take(2, count(0));
        let parts: Vec<RowLinks> = (0..rows)
            .map(|row| RowLinks {
                left: take(0, count(row)),
                right: take(1, count(row)),
                above_next: take(2, count(row + 1)),
                below: take(3, count(row)),
            })
            .collect();
        let parts = parts.into_par_iter().enumerate();
        parts.for_each(|(row, links)| self.link_row(row, links));
        [across, down]
    }

    /// Links the patches in the cells of a row to those in the cells to their right, and below.
    fn link_row(&self, row: usize, links: RowLinks) {
        let Self { grid, labels, .. } = self;
        let label = |x: usize, y: usize| labels[y * grid.size[0] + x];
        let [mut a, mut b] = [[NO_PATCH; MAX_CELL_PX]; 2];
        let ys = grid.y_pixels(row);
        let cells = |row: usize| &self.first[row * grid.columns..][..grid.columns + 1];
        let (first, whole) = (cells(row), self.whole(row));
        let below = (row + 1 < grid.rows).then(|| (cells(row + 1), self.whole(row + 1)));
        let of_row = first[0];
        for (column, (own, &is_whole)) in first.windows(2).zip(whole).enumerate() {
            if own[0] == own[1] {
                continue;
            }
            if column + 1 < grid.columns {
                let next = own[1];
                let mut join = |a: u32, b: u32| {
                    links.right[(own[0] + a - of_row) as usize] = next + b;
                    links.left[(next + b - of_row) as usize] = own[0] + a;
                };
                if is_whole && whole[column + 1] {
                    join(0, 0);
                } else {
                    let x = grid.x_pixels(column).end;
                    for (i, y) in ys.clone().enumerate() {
                        (a[i], b[i]) = (label(x - 1, y), label(x, y));
                    }
                    let (a, b) = (&a[..ys.len()], &b[..ys.len()]);
                    joined(a, b, |a, b| join(a.into(), b.into()));
                }
            }
            if let Some((next, is_next_whole)) = below {
                let mut join = |a: u32, b: u32| {
                    links.below[(own[0] + a - of_row) as usize] = next[column] + b;
                    links.above_next[(next[column] + b - next[0]) as usize] = own[0] + a;
                };
                if is_whole && is_next_whole[column] {
                    join(0, 0);
                } else {
                    let xs = grid.x_pixels(column);
                    let along = |y: usize| &labels[y * grid.size[0]..][xs.clone()];
                    let (a, b) = (along(ys.end - 1), along(ys.end));
                    joined(a, b, |a, b| join(a.into(), b.into()));
                }
            }
        }
    }

    /// The patch that a pixel belongs to, if any.
    pub(crate) fn of_pixel(&self, x: usize, y: usize) -> Option<usize> {
        let Grid {
            cell_px, cut, size, ..
        } = &self.grid;
        let [column, row] = [(x + cut[0]) / cell_px, (y + cut[1]) / cell_px];
        let label = self.labels[y * size[0] + x];
        let cell = self.of_cell(column, row);
        (label != NO_PATCH && cell.len() > usize::from(label))
            .then(|| cell.start + usize::from(label))
    }

    /// Whether a patch is a speck: a few pixels enclosed by edges, a sign of noise.
    pub(crate) fn is_speck(&self, i: usize) -> bool {
        let links = [&self.across, &self.down];
        2 * usize::from(self.all[i].pixels) < self.grid.cell_px.pow(2)
            && links.map(|l| [l.before[i], l.after[i]]) == [[NONE; 2]; 2]
    }
}

impl Links {
    fn none(count: usize) -> Self {
        Self {
            before: vec![NONE; count],
            after: vec![NONE; count],
        }
    }
}

/// The links of the patches in a row of cells, and those upward of the patches in the next.
struct RowLinks<'a> {
    left: &'a mut [u32],
    right: &'a mut [u32],
    above_next: &'a mut [u32],
    below: &'a mut [u32],
}

struct RowOfCells<'a> {
    grid: &'a Grid,
    frame: &'a Frame,
    conductance: &'a Plane,
    row: usize,
}

impl RowOfCells<'_> {
    /// Labels the pixels, all 0 so far; returns the number of patches of each cell, and the patches.
    fn find(&self, labels: &mut [u8]) -> (Vec<u32>, Vec<Patch>) {
        let width = self.grid.size[0];
        let ys = self.grid.y_pixels(self.row);
        let mut open = [false; MAX_CELL_PX * MAX_CELL_PX];
        let mut own = [NO_PATCH; MAX_CELL_PX * MAX_CELL_PX];
        let mut counts = Vec::with_capacity(self.grid.columns);
        let mut patches = Vec::with_capacity(self.grid.columns);
        let counts_open = self.open_across(&ys);
        let open_in = |column: usize| {
            let columns = &counts_open[self.grid.x_pixels(column)];
            columns
                .iter()
                .map(|&count| usize::from(count))
                .sum::<usize>()
        };
        let is_open = |&count: &u8| count > 0;
        let first_open = counts_open.iter().position(is_open);
        let middles = first_open.and_then(|first| {
            let last = counts_open.iter().rposition(is_open).unwrap_or(first);
            self.middles(first..last + 1, &ys)
        });
        let mut columns = 0..self.grid.columns;
        while let Some(column) = columns.next() {
            let xs = self.grid.x_pixels(column);
            let count_open = open_in(column);
            if count_open == 0 {
                let end = columns.find(|&c| open_in(c) > 0).unwrap_or(columns.end);
                counts.resize(end, 0);
                let closed = xs.start..self.grid.x_pixels(end - 1).end;
                for row in labels.chunks_mut(width) {
                    row[closed.clone()].fill(NO_PATCH);
                }
                columns.start = end;
                continue;
            }
            let size = xs.len() * ys.len();
            if count_open == self.grid.cell_px.pow(2) {
                counts.push(1);
                patches.push(match &middles {
                    Some(middles) => middles.patch(self, &xs, &ys),
                    None => self.whole(&xs, &ys),
                });
                continue;
            }
            let (open, own) = (&mut open[..size], &mut own[..size]);
            for (row, y) in open.chunks_mut(xs.len()).zip(ys.clone()) {
                for (open, &c) in row.iter_mut().zip(&self.conductance.row(y)[xs.clone()]) {
                    *open = c > OPEN;
                }
            }
            let count = label_cell(open, own, xs.len());
            counts.push(count as u32);
            for (i, row) in own.chunks(xs.len()).enumerate() {
                labels[i * width + xs.start..][..xs.len()].copy_from_slice(row);
            }
            for label in 0..count as u8 {
                patches.push(self.patch(own, label, &xs, &ys));
            }
        }
        (counts, patches)
    }

    /// The number of open pixels of each column of pixels within the row of cells.
    fn open_across(&self, ys: &Range<usize>) -> Vec<u8> {
        let mut counts = vec![0; self.grid.size[0]];
        for y in ys.clone() {
            wide!(count_open_row(&mut counts, self.conductance.row(y)));
        }
        counts
    }

    /// The middles of all cells of four pixels that are inside a range of columns, open or not; `None` of others.
    fn middles(&self, xs: Range<usize>, ys: &Range<usize>) -> Option<Middles> {
        self.grid.four_across().filter(|_| ys.len() == 4)?;
        let from = (xs.start + self.grid.cut[0]).next_multiple_of(4) - self.grid.cut[0];
        let count = xs.end.checked_sub(from)? / 4;
        let rows = |plane| middle_rows(plane, ys, from..from + 4 * count);
        let blank = || vec![0.0; count];
        let mut found = Middles {
            from,
            normals: [blank(), blank(), blank()],
            depths: Vec::new(),
        };
        let n = &self.frame.normal;
        let normals = [&n.x, &n.y, &n.z].map(rows);
        let [x, y, z] = &mut found.normals;
        wide!(middle_normals([x, y, z], normals));
        if let Some(depth) = &self.frame.depth {
            found.depths = blank();
            wide!(middle_sums(&mut found.depths, rows(depth)));
        }
        Some(found)
    }

    /// The patch of a whole cell, from the pixels around its middle: a mean over all of it would be below the surface.
    fn whole(&self, xs: &Range<usize>, ys: &Range<usize>) -> Patch {
        let margin = self.grid.cell_px / 4;
        let [columns, rows] = [xs, ys].map(|r| r.start + margin..r.end - margin);
        let mut middle = Middle::default();
        for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
            middle.add(self.frame, x, y);
        }
        middle.patch(self.frame, self.grid.cell_px.pow(2))
    }

    /// The patch of a part of a cell, likewise.
    fn patch(&self, labels: &[u8], label: u8, xs: &Range<usize>, ys: &Range<usize>) -> Patch {
        let mut places = [(0, 0); MAX_CELL_PX * MAX_CELL_PX];
        let (mut pixels, mut sum) = (0, [0, 0]);
        for (y, row) in ys.clone().zip(labels.chunks(xs.len())) {
            for (x, _) in xs.clone().zip(row).filter(|(_, l)| **l == label) {
                places[pixels] = (x, y);
                pixels += 1;
                sum = [sum[0] + x, sum[1] + y];
            }
        }
        let places = &places[..pixels];
        let off = |&(x, y): &(usize, usize)| {
            let square = |sum: usize, p: usize| sum.abs_diff(p * pixels).pow(2);
            square(sum[0], x) + square(sum[1], y)
        };
        let least = places.iter().map(off).min().unwrap_or(0);
        // All equally near ones: one of two would prefer a side.
        let mut middle = Middle::default();
        for &(x, y) in places.iter().filter(|p| off(p) == least) {
            middle.add(self.frame, x, y);
        }
        middle.patch(self.frame, pixels)
    }
}

/// The middle rows of a row of cells of four pixels, cell by cell.
fn middle_rows<'a>(plane: &'a Plane, ys: &Range<usize>, xs: Range<usize>) -> [&'a [[f32; 4]]; 2] {
    [ys.start + 1, ys.start + 2].map(|y| plane.row(y)[xs.clone()].as_chunks().0)
}

/// Adds 1 to the count of every open pixel.
#[inline(always)]
pub(crate) fn count_open_row(counts: &mut [u8], conductance: &[f32]) {
    for (count, &c) in counts.iter_mut().zip(conductance) {
        *count += u8::from(c > OPEN);
    }
}

/// Sums over the four pixels in the middle of each cell of a row, given its middle rows.
#[inline(always)]
pub(crate) fn middle_sums(sums: &mut [f64], [upper, lower]: [&[[f32; 4]]; 2]) {
    for ((sum, upper), lower) in sums.iter_mut().zip(upper).zip(lower) {
        *sum = middle_sum(upper, lower);
    }
}

#[inline(always)]
fn middle_sum(upper: &[f32; 4], lower: &[f32; 4]) -> f64 {
    let samples = [upper[1], upper[2], lower[1], lower[2]].map(f64::from);
    0.0 + samples[0] + samples[1] + samples[2] + samples[3]
}

/// The unit normals in the middle of each cell of a row, or 0.
#[inline(always)]
pub(crate) fn middle_normals([x, y, z]: [&mut [f64]; 3], rows: [[&[[f32; 4]]; 2]; 3]) {
    let cells = x.len().min(y.len()).min(z.len());
    let [x, y, z] = [&mut x[..cells], &mut y[..cells], &mut z[..cells]];
    let rows = rows.map(|rows| rows.map(|row| &row[..cells]));
    for cell in 0..cells {
        let [nx, ny, nz] = rows.map(|[upper, lower]| middle_sum(&upper[cell], &lower[cell]));
        let normal = DVec3::new(nx, ny, nz);
        let over_length = normal.length_recip();
        let has_length = (over_length > 0.0) & (over_length < f64::INFINITY);
        let unit = normal * over_length;
        x[cell] = if has_length { unit.x } else { 0.0 };
        y[cell] = if has_length { unit.y } else { 0.0 };
        z[cell] = if has_length { unit.z } else { 0.0 };
    }
}

/// The middles of cells of four pixels in a row.
struct Middles {
    /// The first column of pixels of the first.
    from: usize,
    /// Unit normals, or 0.
    normals: [Vec<f64>; 3],
    /// Sums of depths over the four pixels in the middle; none without depth.
    depths: Vec<f64>,
}

impl Middles {
    /// The patch of a whole cell, as [`RowOfCells::whole`] finds it.
    fn patch(&self, of: &RowOfCells, xs: &Range<usize>, ys: &Range<usize>) -> Patch {
        let cell = (xs.start - self.from) / 4;
        let [x, y, z] = &self.normals;
        let at = [xs, ys].map(|pixels| 0.5 * (pixels.start + pixels.end) as f64);
        let depth = self.depths.get(cell).copied().unwrap_or(0.0);
        Patch {
            normal: DVec3::new(x[cell], y[cell], z[cell]),
            at: corner(of.frame) + DVec2::from(at),
            depth: (depth / 4.0) as f32,
            pixels: 16,
        }
    }
}

/// The upper left corner of a frame in the picture.
fn corner(frame: &Frame) -> DVec2 {
    let window = frame.data_window;
    DVec2::new(f64::from(window.x0), f64::from(window.y0))
}

/// Sums over the pixels in the middle of a patch.
#[derive(Default)]
struct Middle {
    normal: DVec3,
    at: DVec2,
    depth: f64,
    count: f64,
}

impl Middle {
    fn add(&mut self, frame: &Frame, x: usize, y: usize) {
        let i = y * frame.mask.width() + x;
        let sample = |plane: &Plane| f64::from(plane.samples()[i]);
        let n = &frame.normal;
        self.normal += DVec3::new(sample(&n.x), sample(&n.y), sample(&n.z));
        self.at += DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        self.depth += frame.depth.as_ref().map_or(0.0, sample);
        self.count += 1.0;
    }

    /// The means over them, for a patch of this many pixels.
    fn patch(self, frame: &Frame, pixels: usize) -> Patch {
        Patch {
            normal: self.normal.normalize_or_zero(),
            at: corner(frame) + self.at / self.count,
            depth: (self.depth / self.count) as f32,
            pixels: pixels as u16,
        }
    }
}
