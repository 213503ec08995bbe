//! The patches of a frame: its surfaces cell by cell, each linked to its continuations.

use crate::frame::{Frame, Plane};
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
            across: Links::new(all.len(), []),
            down: Links::new(all.len(), []),
            grid,
            all,
            first,
            whole,
            labels,
        };
        let pairs: Vec<[Vec<(u32, u32)>; 2]> = (0..patches.grid.rows)
            .into_par_iter()
            .map(|row| patches.pairs(row))
            .collect();
        [patches.across, patches.down] = [0, 1].map(|axis| {
            let pairs = pairs.iter().flat_map(|p| &p[axis]);
            Links::new(patches.all.len(), pairs.copied())
        });
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

    /// Linked pairs of patches between the cells of a row and those to their right, and below.
    fn pairs(&self, row: usize) -> [Vec<(u32, u32)>; 2] {
        let Self { grid, labels, .. } = self;
        let label = |x: usize, y: usize| labels[y * grid.size[0] + x];
        let mut pairs = [(); 2].map(|()| Vec::with_capacity(grid.columns));
        let [mut a, mut b] = [[NO_PATCH; MAX_CELL_PX]; 2];
        let ys = grid.y_pixels(row);
        for column in 0..grid.columns {
            let own = self.of_cell(column, row);
            if own.is_empty() {
                continue;
            }
            let is_whole = self.whole(row)[column];
            let sides = [(column + 1, row), (column, row + 1)];
            for (axis, (to_column, to_row)) in sides.into_iter().enumerate() {
                if to_column >= grid.columns || to_row >= grid.rows {
                    continue;
                }
                let next = self.of_cell(to_column, to_row).start as u32;
                let mut pair = |a, b| {
                    pairs[axis].push((own.start as u32 + u32::from(a), next + u32::from(b)));
                };
                if is_whole && self.whole(to_row)[to_column] {
                    pair(0, 0);
                    continue;
                }
                let xs = grid.x_pixels(column);
                let length = if axis == 0 {
                    for (i, y) in ys.clone().enumerate() {
                        (a[i], b[i]) = (label(xs.end - 1, y), label(xs.end, y));
                    }
                    ys.len()
                } else {
                    for (i, x) in xs.clone().enumerate() {
                        (a[i], b[i]) = (label(x, ys.end - 1), label(x, ys.end));
                    }
                    xs.len()
                };
                joined(&a[..length], &b[..length], pair);
            }
        }
        pairs
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
    fn new(count: usize, pairs: impl IntoIterator<Item = (u32, u32)>) -> Self {
        let mut links = Self {
            before: vec![NONE; count],
            after: vec![NONE; count],
        };
        for (a, b) in pairs {
            links.after[a as usize] = b;
            links.before[b as usize] = a;
        }
        links
    }
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
                patches.push(self.whole(&xs, &ys));
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
            for (count, &c) in counts.iter_mut().zip(self.conductance.row(y)) {
                *count += u8::from(c > OPEN);
            }
        }
        counts
    }

    /// The patch of a whole cell, from the pixels around its middle: a mean over all of it would be below the surface.
    fn whole(&self, xs: &Range<usize>, ys: &Range<usize>) -> Patch {
        let margin = self.grid.cell_px / 4;
        let [columns, rows] = [xs, ys].map(|r| r.start + margin..r.end - margin);
        let width = self.grid.size[0];
        let sum = |plane: &Plane| {
            let mut sum = 0.0;
            for y in rows.clone() {
                for &sample in &plane.samples()[y * width..][columns.clone()] {
                    sum += f64::from(sample);
                }
            }
            sum
        };
        let n = &self.frame.normal;
        let count = (columns.len() * rows.len()) as f64;
        let at = [xs, ys].map(|pixels| 0.5 * (pixels.start + pixels.end) as f64);
        let middle = Middle {
            normal: DVec3::new(sum(&n.x), sum(&n.y), sum(&n.z)),
            at: count * DVec2::from(at),
            depth: self.frame.depth.as_ref().map_or(0.0, sum),
            count,
        };
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
        let window = frame.data_window;
        let corner = DVec2::new(f64::from(window.x0), f64::from(window.y0));
        Patch {
            normal: self.normal.normalize_or_zero(),
            at: corner + self.at / self.count,
            depth: (self.depth / self.count) as f32,
            pixels: pixels as u16,
        }
    }
}
