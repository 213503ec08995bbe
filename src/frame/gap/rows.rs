//! Gaps by rows: plain loops over pixels, compiled for the vectors of the machine.

use crate::frame::facing;
use crate::frame::gap::pair::{Gap, Side};
use crate::frame::gap::scale::GapScale;
use glam::{Vec2, Vec3};
use std::ops::Range;

/// A row of pixels as gaps are measured between them, with [`PAD`] unknown ones at either end.
#[derive(Debug, Clone, Default)]
pub(crate) struct GapRow {
    depth: Vec<f32>,
    linear: Vec<f32>,
    facing: Vec<f32>,
    /// The columns that may be known.
    known: Range<usize>,
}

/// Unknown pixels at either end of a row.
const PAD: usize = 2;

impl GapRow {
    /// A row of `width` unknown pixels.
    pub(crate) fn new(width: usize) -> Self {
        let row = || vec![f32::NAN; width + 2 * PAD];
        Self {
            depth: row(),
            linear: row(),
            facing: row(),
            known: 0..0,
        }
    }

    /// Makes all pixels unknown.
    pub(crate) fn clear(&mut self) {
        let known = PAD + self.known.start..PAD + self.known.end;
        for row in [&mut self.depth, &mut self.linear, &mut self.facing] {
            row[known.clone()].fill(f32::NAN);
        }
        self.known = 0..0;
    }
}

/// The samples of a row of a frame from column `first` on, and the direction to the eye by column and of the row.
#[derive(Clone, Copy)]
pub(crate) struct GapSamples<'a> {
    pub(crate) first: usize,
    pub(crate) depth: &'a [f32],
    pub(crate) covered: &'a [bool],
    pub(crate) normal: [&'a [f32]; 3],
    pub(crate) to_eye: (&'a [f32], f32),
}

/// Prepares a row; all but the samples is unknown.
#[inline(always)]
pub(crate) fn fill_gap_row(row: &mut GapRow, samples: &GapSamples, scale: &GapScale) {
    let n = samples.depth.len();
    let [nx, ny, nz] = samples.normal.map(|row| &row[..n]);
    let (covered, to_eye) = (&samples.covered[..n], &samples.to_eye.0[..n]);
    row.clear();
    row.known = samples.first..samples.first + n;
    let inside = PAD + samples.first..PAD + samples.first + n;
    let depths = &mut row.depth[inside.clone()];
    let (linear, facing) = (&mut row.linear[inside.clone()], &mut row.facing[inside]);
    for x in 0..n {
        let eye = [to_eye[x], samples.to_eye.1];
        let depth = scale.planar(samples.depth[x], eye);
        let depth = if covered[x] { depth } else { f32::NAN };
        depths[x] = depth;
        linear[x] = scale.linear(depth);
        facing[x] = -self::facing(Vec3::new(nx[x], ny[x], nz[x]), Vec2::from(eye));
    }
}

/// Pixels and the next ones along an axis: 0 to the right, 1 downward.
#[derive(Clone, Copy)]
pub(crate) struct Along<'a> {
    pub(crate) axis: usize,
    /// Their first column.
    pub(crate) first: usize,
    /// Normals along the axis, of both.
    pub(crate) normals: [&'a [f32]; 2],
}

/// A pixel of rows of depth, of what is linear here and beyond, of sight lines times normals, and of normals along the step.
#[inline(always)]
fn side([depth, linear, beyond, facing, along]: [&[f32]; 5], x: usize, step: f32) -> Side {
    Side {
        depth: depth[x],
        linear: linear[x],
        beyond: beyond[x],
        facing: facing[x],
        along: along[x] * step,
    }
}

/// What pixels of some rows and the next ones along an axis have to be compared: those of one row, given four times, or of
/// the second row and the third.
#[inline(always)]
fn sides<'a>(rows: [&'a GapRow; 4], along: &Along<'a>, n: usize) -> [[&'a [f32]; 5]; 2] {
    let shifts = match along.axis {
        0 => [PAD - 1, PAD, PAD + 1, PAD + 2],
        _ => [PAD; 4],
    };
    let from = shifts.map(|shift| shift + along.first);
    let [before, a, b, behind] = [0, 1, 2, 3].map(|i| &rows[i].linear[from[i]..][..n]);
    let [depth_a, depth_b] = [1, 2].map(|i| &rows[i].depth[from[i]..][..n]);
    let [facing_a, facing_b] = [1, 2].map(|i| &rows[i].facing[from[i]..][..n]);
    let [along_a, along_b] = along.normals.map(|row| &row[..n]);
    [
        [depth_a, a, before, facing_a, along_a],
        [depth_b, b, behind, facing_b, along_b],
    ]
}

/// Gaps examined together: most groups contain none that is large enough.
pub(crate) const GROUP: usize = 16;

/// Strengths of the silhouettes between pixels, where depth has no noise. Positive where the first is the nearer, else
/// negative. Adds the first columns of the groups of `out` that may contain one to `found`.
#[inline(always)]
pub(crate) fn gap_strength_row(
    out: &mut [f32],
    found: &mut Vec<usize>,
    rows: [&GapRow; 4],
    along: &Along,
    scale: &GapScale,
) {
    let [first, second] = sides(rows, along, out.len());
    let (step, unit) = (scale.step[along.axis], scale.unit(along.axis));
    for (x, out) in out.iter_mut().enumerate() {
        let (a, b) = (side(first, x, step), side(second, x, step));
        *out = Gap::px_between(&a, &b, unit);
    }
    for (i, group) in out.chunks_mut(GROUP).enumerate() {
        let mut is_any = false;
        for px in &*group {
            is_any |= *px > scale.threshold.lo;
        }
        if !is_any {
            group.fill(0.0);
            continue;
        }
        found.push(GROUP * i);
        let (first, second) = (
            part(&first, GROUP * i, group),
            part(&second, GROUP * i, group),
        );
        for (x, out) in group.iter_mut().enumerate() {
            let (a, b) = (side(first, x, step), side(second, x, step));
            let strength = Gap::between(a, b, unit).strength(0.0, scale.threshold);
            // Not a number where one is not covered.
            let strength = if strength > 0.0 { strength } else { 0.0 };
            *out = if a.depth <= b.depth {
                strength
            } else {
                -strength
            };
        }
    }
}

/// The part of rows from `start` on that is as long as `group`, so that loops over it vectorise.
#[inline(always)]
fn part<'a>(rows: &[&'a [f32]; 5], start: usize, group: &[f32]) -> [&'a [f32]; 5] {
    let n = group.len();
    // Written out: `map` over an array is not always inlined.
    [
        &rows[0][start..][..n],
        &rows[1][start..][..n],
        &rows[2][start..][..n],
        &rows[3][start..][..n],
        &rows[4][start..][..n],
    ]
}
