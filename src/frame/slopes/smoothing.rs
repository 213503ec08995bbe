//! Smoothing along links by exponential passes.

use super::links::SurfaceLinks;
use crate::frame::Plane;
use crate::kernel::simd::wide;
use rayon::prelude::*;

/// Rows, or columns, that are smoothed together, one to a lane.
const LANES: usize = 16;

type LineLanes = [f32; LANES];

/// Two planes smoothed along links by this variance.
pub(super) fn smoothed(planes: &[Plane; 2], links: &SurfaceLinks, variance: f32) -> [Plane; 2] {
    let decay = decay(variance);
    let mut smooth = across(planes, &links.across, decay);
    down(&mut smooth, &links.down, decay);
    smooth
}

/// The factor by which weights a^|i| fall from one pixel to the next, if their variance 2 a / (1 - a)^2 is this.
fn decay(variance: f32) -> f32 {
    let b = 1.0 + 1.0 / variance;
    b - (b * b - 1.0).sqrt()
}

/// Two planes smoothed along their rows, a few of which are turned at a time so that lanes are next to each other.
fn across(planes: &[Plane; 2], links: &Plane<bool>, decay: f32) -> [Plane; 2] {
    let (width, rows) = (links.width(), LANES * links.width());
    let mut smooth = [(); 2].map(|()| Plane::filled(width, links.height(), 0.0));
    let [to_p, to_q] = smooth
        .each_mut()
        .map(|plane| plane.samples_mut().par_chunks_mut(rows));
    let [p, q] = planes
        .each_ref()
        .map(|plane| plane.samples().par_chunks(rows));
    let blocks = p.zip(q).zip(links.samples().par_chunks(rows));
    blocks.zip(to_p.zip(to_q)).for_each_init(
        || LineBlock::new(width),
        |block, (((p, q), links), (to_p, to_q))| {
            for (field, block) in [p, q].iter().zip(&mut block.fields) {
                turn(field, width, |x, lane, &v| block[x][lane] = v);
            }
            turn(links, width, |x, lane, &link| {
                block.weights[x][lane] = if link { decay } else { 0.0 }
            });
            wide!(block.smooth());
            for (field, block) in [to_p, to_q].into_iter().zip(&block.fields) {
                turn_back(block, field, width);
            }
        },
    );
    smooth
}

/// Calls `put(x, row, value)` for all values of a few rows, in tiles that stay in the fastest cache.
fn turn<T>(rows: &[T], width: usize, mut put: impl FnMut(usize, usize, &T)) {
    for from in (0..width).step_by(LANES) {
        for (lane, row) in rows.chunks_exact(width).enumerate() {
            let row = row[from..].iter().take(LANES);
            row.enumerate()
                .for_each(|(x, value)| put(from + x, lane, value));
        }
    }
}

/// Writes the lanes of a block back to a few rows.
fn turn_back(block: &[LineLanes], rows: &mut [f32], width: usize) {
    for (i, tile) in block.chunks(LANES).enumerate() {
        for (lane, row) in rows.chunks_exact_mut(width).enumerate() {
            tile.iter()
                .zip(&mut row[i * LANES..])
                .for_each(|(lanes, v)| *v = lanes[lane]);
        }
    }
}

/// Smooths two planes along their columns.
fn down(planes: &mut [Plane; 2], links: &Plane<bool>, decay: f32) {
    let height = links.height();
    let [p, q] = planes.each_mut().map(columns);
    let blocks = p.into_par_iter().zip(q).enumerate();
    blocks.for_each_init(
        || LineBlock::new(height),
        |block, (i, (mut p, mut q))| {
            for (field, block) in [&p, &q].into_iter().zip(&mut block.fields) {
                for (lanes, piece) in block.iter_mut().zip(field) {
                    copy(piece, lanes);
                }
            }
            let (from, count) = (i * LANES, p[0].len());
            for (y, lanes) in block.weights.iter_mut().enumerate() {
                let links = &links.row(y)[from..from + count];
                for (lane, &link) in lanes.iter_mut().zip(links) {
                    *lane = if link { decay } else { 0.0 };
                }
            }
            wide!(block.smooth());
            for (field, block) in [&mut p, &mut q].into_iter().zip(&block.fields) {
                for (lanes, piece) in block.iter().zip(field) {
                    copy(lanes, piece);
                }
            }
        },
    );
}

/// Copies as many values as both have, nearly always all lanes.
#[inline(always)]
fn copy(from: &[f32], to: &mut [f32]) {
    match (
        <&LineLanes>::try_from(from),
        <&mut LineLanes>::try_from(&mut *to),
    ) {
        (Ok(from), Ok(to)) => *to = *from,
        _ => to.iter_mut().zip(from).for_each(|(to, from)| *to = *from),
    }
}

/// The parts of all rows in each group of adjacent columns.
fn columns(plane: &mut Plane) -> Vec<Vec<&mut [f32]>> {
    let (width, height) = (plane.width(), plane.height());
    let mut columns: Vec<_> = (0..width.div_ceil(LANES))
        .map(|_| Vec::with_capacity(height))
        .collect();
    for row in plane.samples_mut().chunks_exact_mut(width) {
        let pieces = row.chunks_mut(LANES).zip(&mut columns);
        pieces.for_each(|(piece, column)| column.push(piece));
    }
    columns
}

/// Lines of samples side by side.
struct LineBlock {
    fields: [Vec<LineLanes>; 2],
    /// Weight of each sample in sums of the one before it, and the other way around.
    weights: Vec<LineLanes>,
    /// Sums of the fields, and of weights, over a sample and all before it.
    before: Vec<[LineLanes; 3]>,
}

impl LineBlock {
    fn new(length: usize) -> Self {
        Self {
            fields: [(); 2].map(|()| vec![[0.0; LANES]; length]),
            weights: vec![[0.0; LANES]; length],
            before: vec![[[0.0; LANES]; 3]; length],
        }
    }

    /// Weighted means along the lines, with weights that fall by a factor for each pixel, and to 0 at a broken link. The
    /// last weight has to be 0.
    #[inline(always)]
    fn smooth(&mut self) {
        let [p, q] = &mut self.fields;
        let mut sums = [[0.0; LANES]; 3];
        let mut weight = &[0.0; LANES];
        for (((p, q), next), before) in p.iter().zip(&*q).zip(&self.weights).zip(&mut self.before) {
            for i in 0..LANES {
                sums[0][i] = p[i] + weight[i] * sums[0][i];
                sums[1][i] = q[i] + weight[i] * sums[1][i];
                sums[2][i] = 1.0 + weight[i] * sums[2][i];
            }
            *before = sums;
            weight = next;
        }
        let mut sums = [[0.0; LANES]; 3];
        let lines = p.iter_mut().zip(q).zip(&self.weights).zip(&self.before);
        for (((p, q), weight), before) in lines.rev() {
            // Copies, which the compiler knows to be apart.
            let (values, weight, before) = ([*p, *q, [1.0; LANES]], *weight, *before);
            let mut both = before;
            for k in 0..3 {
                for i in 0..LANES {
                    let ahead = weight[i] * sums[k][i];
                    both[k][i] += ahead;
                    sums[k][i] = values[k][i] + ahead;
                }
            }
            let share = both[2].map(|weight| 1.0 / weight);
            for sums in &mut both[..2] {
                sums.iter_mut()
                    .zip(&share)
                    .for_each(|(sum, share)| *sum *= share);
            }
            (*p, *q) = (both[0], both[1]);
        }
    }
}
