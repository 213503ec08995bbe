//! Silhouettes, creases, conductance and the depth gradient in one sweep over rows.

use crate::frame::gap::of_frame::Gaps;
use crate::frame::gap::rows;
use crate::frame::gap::rows::{Along, GROUP, GapRow};
use crate::frame::memory::Memory;
use crate::frame::{Frame, Plane, ToEye, Vector2Planes};
use crate::kernel::simd::wide;
use crate::params::{ShapeParams, SoftThreshold};
use crate::plan::Plan;
use crate::product::Product;
use crate::shape::Rows;
use crate::shape::conductance;
use crate::shape::crease;
use crate::shape::crease::{CreaseDetector, NormalRows};
use crate::shape::edges::SilhouetteSource;
use crate::shape::gradient;
use crate::shape::silhouette;
use rayon::prelude::*;
use std::ops::Range;

/// Rows per task: enough to make the cost of the rows around them, which it prepares too, negligible.
const ROWS: usize = 32;

/// Rows that the gap between two rows is found in, and rows of gaps that silhouettes are found in.
const GAP_ROWS: usize = 4;

/// Columns checked together for creases: most contain none.
const BLOCK: usize = 16;

/// Edge weights and conductance.
pub(crate) struct Weights {
    /// Only if requested; the same for creases.
    pub(crate) silhouette: Option<Plane>,
    pub(crate) crease: Option<Plane>,
    pub(crate) conductance: Plane,
}

/// Edges, with their weights if requested, and the gradient.
pub(crate) fn edges_and_gradient(
    plan: &Plan,
    frame: &Frame,
    memory: &Memory,
) -> (Weights, Vector2Planes) {
    let with_weights = plan.wants(Product::Silhouette);
    edges_with_weights(plan, frame, None, with_weights, memory)
}

/// The same, with or without the two weights. Conductance takes the memory of the lengths of normals: those given, else a
/// copy of the frame's.
pub(crate) fn edges_with_weights(
    plan: &Plan,
    frame: &Frame,
    lengths: Option<Plane>,
    with_weights: bool,
    memory: &Memory,
) -> (Weights, Vector2Planes) {
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let blank = || memory.plane(&frame.mask);
    let lengths = lengths.or_else(|| {
        let copied = frame.normal_length.as_ref()?;
        let mut lengths = memory.unwritten(&frame.mask);
        lengths.samples_mut().copy_from_slice(copied.samples());
        Some(lengths)
    });
    let has_lengths = lengths.is_some();
    let mut edges = Weights {
        silhouette: with_weights.then(blank),
        crease: with_weights.then(blank),
        conductance: lengths.unwrap_or_else(blank),
    };
    let mut gradient = memory.vectors(&frame.mask);
    let sources = Sources::new(plan, frame);
    let bands = bands(&mut edges.silhouette, height)
        .into_par_iter()
        .zip(bands(&mut edges.crease, height))
        .zip(edges.conductance.samples_mut().par_chunks_mut(ROWS * width))
        .zip(gradient.x.samples_mut().par_chunks_mut(ROWS * width))
        .zip(gradient.y.samples_mut().par_chunks_mut(ROWS * width));
    bands.with_max_len(1).enumerate().for_each_init(
        || EdgeRows::new(width),
        |scratch, (i, ((((silhouette, crease), conductance), x), y))| {
            let mut band = RowsToFill {
                top: ROWS * i,
                silhouette,
                crease,
                conductance,
                has_lengths,
                gradient: [x, y],
            };
            sources.fill(&mut band, scratch);
        },
    );
    (edges, gradient)
}

/// Bands of an optional plane: `None` for each band if there is no plane.
fn bands(plane: &mut Option<Plane>, height: usize) -> Vec<Option<&mut [f32]>> {
    match plane {
        Some(plane) => {
            let samples = ROWS * plane.width();
            plane.samples_mut().chunks_mut(samples).map(Some).collect()
        }
        None => (0..height.div_ceil(ROWS)).map(|_| None).collect(),
    }
}

/// Rows to fill, from row `top` on.
struct RowsToFill<'a> {
    top: usize,
    silhouette: Option<&'a mut [f32]>,
    crease: Option<&'a mut [f32]>,
    /// The lengths of normals, if there are any.
    conductance: &'a mut [f32],
    has_lengths: bool,
    gradient: [&'a mut [f32]; 2],
}

/// Scratch rows of a thread.
struct EdgeRows {
    /// Rows prepared for gaps, row y at index y modulo 4.
    gaps: [GapRow; GAP_ROWS],
    /// Signed strengths of the gaps to each pixel from the one before it, with one more at either end, 0.
    across: Vec<f32>,
    /// The same to the row below, of row y at index y modulo 4.
    down: [Vec<f32>; GAP_ROWS],
    /// The weight drawn: of pixels in front of a gap.
    silhouette: Vec<f32>,
    /// The weight that closes: of pixels on both sides of one.
    barrier: Vec<f32>,
    crease: Vec<f32>,
    least_cosine: Vec<f32>,
}

impl EdgeRows {
    fn new(width: usize) -> Self {
        let row = || vec![0.0; width];
        Self {
            gaps: std::array::from_fn(|_| GapRow::new(width)),
            across: vec![0.0; width + 3],
            down: std::array::from_fn(|_| row()),
            silhouette: row(),
            barrier: row(),
            crease: row(),
            least_cosine: row(),
        }
    }
}

/// What silhouettes are found in.
enum SilhouettesIn<'a> {
    Depth(Box<Gaps<'a>>),
    Occlusion(&'a Plane, SoftThreshold),
    Border,
}

struct Sources<'a> {
    frame: &'a Frame,
    params: &'a ShapeParams,
    silhouettes: SilhouettesIn<'a>,
    creases: CreaseDetector,
    to_eye: ToEye,
}

impl<'a> Sources<'a> {
    fn new(plan: &'a Plan, frame: &'a Frame) -> Self {
        let map =
            |plane: &'a Option<Plane>| plane.as_ref().expect("the plan found it in the frame");
        let silhouettes = match SilhouetteSource::of(plan) {
            SilhouetteSource::Depth => {
                let gaps = Gaps::new(frame, map(&frame.depth), plan.shape.silhouette);
                SilhouettesIn::Depth(Box::new(gaps))
            }
            SilhouetteSource::Occlusion => {
                SilhouettesIn::Occlusion(map(&frame.occlusion), plan.shape.occlusion_silhouette)
            }
            SilhouetteSource::Border => SilhouettesIn::Border,
        };
        Self {
            frame,
            params: &plan.shape,
            silhouettes,
            creases: CreaseDetector::new(plan.shape.crease),
            to_eye: ToEye::of(
                frame.data_window,
                frame.camera.map(|camera| camera.projection),
            ),
        }
    }

    fn fill(&self, band: &mut RowsToFill, scratch: &mut EdgeRows) {
        let width = self.frame.mask.width();
        let rows = band.conductance.len() / width;
        let [gradient_x, gradient_y] = &mut band.gradient;
        let mut own_lengths = vec![0.0; width];
        for row in 0..rows {
            let y = band.top + row;
            let of_row = row * width..(row + 1) * width;
            let conductance = &mut band.conductance[of_row.clone()];
            let span = self.frame.mask.span(y);
            let lengths = band.has_lengths.then(|| {
                own_lengths.copy_from_slice(conductance);
                conductance[..span.start].fill(0.0);
                conductance[span.end..].fill(0.0);
                &own_lengths[..]
            });
            let slopes = [
                &mut gradient_x[of_row.clone()],
                &mut gradient_y[of_row.clone()],
            ];
            self.fill_row(y, row == 0, lengths, conductance, slopes, scratch);
            for (plane, weights) in [
                (&mut band.silhouette, &scratch.silhouette),
                (&mut band.crease, &scratch.crease),
            ] {
                if let Some(plane) = plane {
                    self.keep_covered(&mut plane[of_row.clone()], weights, y);
                }
            }
        }
    }

    /// Fills the span of row `y` of the outputs, and of the scratch rows of both edge weights.
    fn fill_row(
        &self,
        y: usize,
        is_first: bool,
        lengths: Option<&[f32]>,
        conductance: &mut [f32],
        slopes: [&mut [f32]; 2],
        scratch: &mut EdgeRows,
    ) {
        if let SilhouettesIn::Depth(gaps) = &self.silhouettes {
            self.find_gaps(gaps, y, is_first, scratch);
        }
        let columns = self.frame.mask.span(y);
        if columns.is_empty() {
            return;
        }
        self.silhouette_row(y, &columns, scratch);
        let normals = NormalRows::around(&self.frame.normal, y);
        self.crease_row(y, &columns, &normals, lengths, scratch);
        wide!(conductance::conductance_row(
            &mut conductance[columns.clone()],
            &scratch.barrier[columns.clone()],
            &scratch.crease[columns.clone()],
            &self.frame.mask.row(y)[columns.clone()],
        ));
        self.gradient_row(y, columns, &normals, slopes);
    }

    /// Finds the gaps within row `y`, and between the two rows above and the two below; the former are known unless it
    /// `is_first`.
    fn find_gaps(&self, gaps: &Gaps, y: usize, is_first: bool, scratch: &mut EdgeRows) {
        let reach = GAP_ROWS - 1;
        if is_first {
            scratch.gaps.iter_mut().for_each(GapRow::clear);
            scratch.down.iter_mut().for_each(|row| row.fill(0.0));
            for near in y.saturating_sub(reach)..y + reach {
                self.prepare(gaps, near, scratch);
                if near >= y.max(2) {
                    self.find_gaps_below(gaps, near - 2, scratch);
                }
            }
        }
        self.prepare(gaps, y + reach, scratch);
        self.find_gaps_below(gaps, y + 1, scratch);
        let (row, normals) = (&scratch.gaps[y % GAP_ROWS], self.frame.normal.x.row(y));
        let span = self.frame.mask.span(y);
        let columns = span.start.saturating_sub(1)..span.end.min(normals.len() - 1);
        let out = &mut scratch.across[columns.start + 2..columns.end.max(columns.start) + 2];
        self.weigh_gaps(gaps, [row; 4], out, [columns.start, y], 0);
    }

    /// Finds the gaps between row `y` and the one below.
    fn find_gaps_below(&self, gaps: &Gaps, y: usize, scratch: &mut EdgeRows) {
        let below = &mut scratch.down[y % GAP_ROWS];
        if y + 1 >= self.frame.mask.height() {
            below.fill(0.0);
            return;
        }
        let spans = [y, y + 1].map(|y| self.frame.mask.span(y));
        let filled = spans.into_iter().filter(|span| !span.is_empty());
        let Some(columns) = filled.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)) else {
            return;
        };
        // Above the first row slots are as unknown as below the last.
        let rows = [3, 0, 1, 2].map(|i| &scratch.gaps[(y + i) % GAP_ROWS]);
        let first = [columns.start, y];
        self.weigh_gaps(gaps, rows, &mut below[columns], first, 1);
    }

    /// The signed strengths of the gaps between `first`, the pixels to its right, and the next ones along an axis, from
    /// [`GapRow`]s around them.
    fn weigh_gaps(
        &self,
        gaps: &Gaps,
        rows: [&GapRow; 4],
        out: &mut [f32],
        [x, y]: [usize; 2],
        axis: usize,
    ) {
        let normals = [&self.frame.normal.x, &self.frame.normal.y][axis];
        let next = [x + 1 - axis, y + axis];
        let along = Along {
            axis,
            first: x,
            normals: [[x, y], next].map(|[x, y]| &normals.row(y)[x..]),
        };
        let mut found = Vec::new();
        wide!(rows::gap_strength_row(
            out,
            &mut found,
            rows,
            &along,
            &gaps.scale
        ));
        for start in found {
            let group = (x + start..).zip(out[start..].iter_mut().take(GROUP));
            for (x, strength) in group.filter(|(_, strength)| **strength != 0.0) {
                let with_noise = gaps.strength_after([x, y], axis, strength.abs());
                *strength = with_noise.copysign(*strength);
            }
        }
    }

    /// Prepares row `y` for gaps; all of a row below the picture is unknown.
    fn prepare(&self, gaps: &Gaps, y: usize, scratch: &mut EdgeRows) {
        let row = &mut scratch.gaps[y % GAP_ROWS];
        match y < self.frame.mask.height() {
            true => wide!(rows::fill_gap_row(row, &gaps.samples(y), &gaps.scale)),
            false => row.clear(),
        }
    }

    fn silhouette_row(&self, y: usize, columns: &Range<usize>, scratch: &mut EdgeRows) {
        let (line, barrier) = (&mut scratch.silhouette, &mut scratch.barrier);
        match &self.silhouettes {
            SilhouettesIn::Depth(_) => {
                // Of gaps two rows above to one row below; above the first row they are unknown, 0.
                let down = [2, 3, 0, 1].map(|i| &scratch.down[(y + i) % GAP_ROWS][columns.clone()]);
                let across = &scratch.across[columns.start..columns.end + 3];
                let out = [line, barrier].map(|row| &mut row[columns.clone()]);
                wide!(silhouette::silhouettes_of_gaps_row(out, across, down));
            }
            SilhouettesIn::Occlusion(map, threshold) => {
                let map = Rows::around(map, y);
                wide!(silhouette::jumps_row(
                    line,
                    &map,
                    columns.clone(),
                    *threshold
                ));
                barrier[columns.clone()].copy_from_slice(&line[columns.clone()]);
            }
            SilhouettesIn::Border => {
                for row in [line, barrier] {
                    row[columns.clone()].fill(0.0);
                }
            }
        }
        let covered = Rows::around(self.frame.mask.plane(), y);
        let both = [&mut scratch.silhouette[..], &mut scratch.barrier];
        wide!(silhouette::close_border_row(
            both,
            &covered,
            columns.clone()
        ));
    }

    fn crease_row(
        &self,
        y: usize,
        columns: &Range<usize>,
        normals: &NormalRows,
        lengths: Option<&[f32]>,
        scratch: &mut EdgeRows,
    ) {
        let covered = Rows::around(self.frame.mask.plane(), y);
        let least = &mut scratch.least_cosine;
        wide!(crease::least_cosine_row(
            least,
            normals,
            &covered,
            columns.clone()
        ));
        scratch.crease[columns.clone()].fill(0.0);
        for start in columns.clone().step_by(BLOCK) {
            let block = start..(start + BLOCK).min(columns.end);
            let lengths = lengths.map(|row| &row[block.clone()]);
            let cosines = &scratch.least_cosine[block.clone()];
            if wide!(self.creases.all_flat(cosines, lengths)) {
                continue;
            }
            for x in block.filter(|&x| covered.at[x]) {
                let length = lengths.map_or(1.0, |row| row[x - start]);
                if !self
                    .creases
                    .all_flat(&scratch.least_cosine[x..=x], Some(&[length]))
                {
                    let beside = normals.beside(x, &covered);
                    scratch.crease[x] = self.creases.weight(normals.at(x), length, beside);
                }
            }
        }
    }

    fn gradient_row(
        &self,
        y: usize,
        columns: Range<usize>,
        normals: &NormalRows,
        out: [&mut [f32]; 2],
    ) {
        let NormalRows { x, y: up, z } = normals;
        let normal = [x, up, z].map(|rows| &rows.at[columns.clone()]);
        let out = out.map(|row| &mut row[columns.clone()]);
        let covered = &self.frame.mask.row(y)[columns.clone()];
        let to_eye = (&self.to_eye.x[columns], self.to_eye.y[y]);
        wide!(gradient::depth_gradient_row(
            out,
            normal,
            covered,
            to_eye,
            self.params
        ));
    }

    fn keep_covered(&self, out: &mut [f32], weights: &[f32], y: usize) {
        let span = self.frame.mask.span(y);
        let covered = &self.frame.mask.row(y)[span.clone()];
        wide!(keep_row(&mut out[span.clone()], &weights[span], covered));
    }
}

/// Copies a row; 0 where uncovered.
#[inline(always)]
fn keep_row(out: &mut [f32], weights: &[f32], covered: &[bool]) {
    for ((out, &weight), &covered) in out.iter_mut().zip(weights).zip(covered) {
        *out = if covered { weight } else { 0.0 };
    }
}
