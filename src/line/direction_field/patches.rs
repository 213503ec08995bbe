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
pub(crate) struct PatchGrid {
    cell_px: usize,
    /// Part of the first cell outside the frame.
    cut: [usize; 2],
    size: [usize; 2],
    places: [f32; MAX_CELL_PX],
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl PatchGrid {
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

    /// The columns of pixels in a column of cells, axis 0, or the rows in a row of them.
    pub(crate) fn pixels(&self, axis: usize, cell: usize) -> Range<usize> {
        let (start, end) = (cell * self.cell_px, (cell + 1) * self.cell_px);
        let inside = |p: usize| p.saturating_sub(self.cut[axis]).min(self.size[axis]);
        inside(start)..inside(end)
    }

    /// Offsets of the centres of pixels of one cell from that of the cell, in cells, -1/2..1/2.
    pub(crate) fn places(&self, axis: usize, pixels: &Range<usize>) -> &[f32] {
        let first = (pixels.start + self.cut[axis]) % self.cell_px;
        &self.places[first..first + pixels.len()]
    }

    /// Samples of a plane, one part per row of cells.
    pub(crate) fn bands<'a, T>(&self, mut samples: &'a mut [T]) -> Vec<&'a mut [T]> {
        let mut bands = Vec::with_capacity(self.rows);
        for row in 0..self.rows {
            let (band, rest) = samples.split_at_mut(self.pixels(1, row).len() * self.size[0]);
            bands.push(band);
            samples = rest;
        }
        bands
    }
}

/// All patches, numbered by cell, row after row.
#[derive(Debug)]
pub(crate) struct Patches {
    pub(crate) grid: PatchGrid,
    pub(crate) all: Vec<Patch>,
    /// The first patch of each cell, and the total number of patches.
    first: Vec<u32>,
    /// Which patch of its cell a pixel belongs to.
    pub(crate) labels: Vec<u8>,
    pub(crate) across: Links,
    pub(crate) down: Links,
}

impl Patches {
    pub(crate) fn new(frame: &Frame, conductance: &Plane, cell_px: usize) -> Self {
        let grid = PatchGrid::new(frame, cell_px);
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
        let mut first = vec![0];
        let mut all = Vec::new();
        for (counts, patches) in found {
            for count in counts {
                first.push(first[first.len() - 1] + count);
            }
            all.extend(patches);
        }
        let mut patches = Self {
            across: Links::none(0),
            down: Links::none(0),
            grid,
            all,
            first,
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

    /// The links of patches across and down.
    fn links(&self) -> [Links; 2] {
        let Self { grid, labels, .. } = self;
        let [mut across, mut down] = [(); 2].map(|()| Links::none(self.all.len()));
        let [mut a, mut b] = [[NO_PATCH; MAX_CELL_PX]; 2];
        for (row, column) in (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |c| (row, c)))
        {
            let own = self.of_cell(column, row);
            if own.is_empty() {
                continue;
            }
            let (xs, ys) = (grid.pixels(0, column), grid.pixels(1, row));
            if column + 1 < grid.columns {
                let next = self.of_cell(column + 1, row);
                for (i, y) in ys.clone().enumerate() {
                    let side = y * grid.size[0] + xs.end;
                    (a[i], b[i]) = (labels[side - 1], labels[side]);
                }
                across.join(own.start, &a[..ys.len()], next.start, &b[..ys.len()]);
            }
            if row + 1 < grid.rows {
                let next = self.of_cell(column, row + 1);
                let along = |y: usize| &labels[y * grid.size[0]..][xs.clone()];
                down.join(own.start, along(ys.end - 1), next.start, along(ys.end));
            }
        }
        [across, down]
    }

    /// The patch that a pixel belongs to, if any.
    pub(crate) fn of_pixel(&self, x: usize, y: usize) -> Option<usize> {
        let PatchGrid {
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

    /// Links the patches of two cells, from these ones on, by their labels along the side between them.
    fn join(&mut self, first: usize, labels: &[u8], next: usize, next_labels: &[u8]) {
        joined(labels, next_labels, |a, b| {
            let (a, b) = (first + usize::from(a), next + usize::from(b));
            (self.after[a], self.before[b]) = (b as u32, a as u32);
        });
    }
}

struct RowOfCells<'a> {
    grid: &'a PatchGrid,
    frame: &'a Frame,
    conductance: &'a Plane,
    row: usize,
}

impl RowOfCells<'_> {
    /// Labels the pixels, all 0 so far; returns the number of patches of each cell, and the patches.
    fn find(&self, labels: &mut [u8]) -> (Vec<u32>, Vec<Patch>) {
        let width = self.grid.size[0];
        let ys = self.grid.pixels(1, self.row);
        let mut open = [false; MAX_CELL_PX * MAX_CELL_PX];
        let mut own = [NO_PATCH; MAX_CELL_PX * MAX_CELL_PX];
        let mut counts = Vec::with_capacity(self.grid.columns);
        let mut patches = Vec::with_capacity(self.grid.columns);
        for column in 0..self.grid.columns {
            let xs = self.grid.pixels(0, column);
            let size = xs.len() * ys.len();
            let (open, own) = (&mut open[..size], &mut own[..size]);
            let mut count_open = 0;
            for (row, y) in open.chunks_mut(xs.len()).zip(ys.clone()) {
                for (open, &c) in row.iter_mut().zip(&self.conductance.row(y)[xs.clone()]) {
                    *open = c > OPEN;
                    count_open += usize::from(*open);
                }
            }
            if count_open == self.grid.cell_px.pow(2) {
                counts.push(1);
                patches.push(self.whole(&xs, &ys));
                continue;
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
