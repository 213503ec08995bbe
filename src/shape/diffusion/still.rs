//! Where sweeps change nothing.
//!
//! No flux passes between equal slopes, nor through a closed face. Pixels joined by open faces that all have the same slope
//! g keep it, in any rounding: an explicit step leaves g, and term k of the expansion is (-1)^k g. Blocks of such pixels
//! are left out of all sweeps, and the same bits are read out.

use crate::frame::{Plane, Vector2Planes};
use crate::kernel::lanes::multiply_add;
use crate::kernel::simd::wide;
use crate::shape::diffusion::medium::Medium;
use rayon::prelude::*;
use std::ops::Range;

/// Columns and rows of a block, the unit that is left out.
const BLOCK: [usize; 2] = [32, 16];
/// Pixels that are looked at together.
const AT_ONCE: usize = 64;
/// Minimum number of rows per task, to be worth scheduling.
const ROWS_PER_TASK: usize = 32;

/// Ascending ranges of columns with some between them.
type Spans = Vec<Range<usize>>;

/// The blocks of a frame that sweeps may change.
#[derive(Debug)]
pub(crate) struct Moving {
    width: usize,
    /// Their columns by row of blocks; after every row, those of this one and the next together.
    spans: Vec<Spans>,
    /// The number of blocks left out, and of all.
    pub(crate) left_out: [usize; 2],
}

/// Neighbouring pixels of a row that are joined by open faces.
struct Joined {
    columns: Range<usize>,
    /// The number of another run that it is joined with, or its own.
    with: usize,
    /// Whether slopes differ anywhere among those joined.
    moves: bool,
}

impl Moving {
    /// The blocks that touch joined pixels with different slopes; all of them where borders are joined or pixels have
    /// weights of their own.
    pub(crate) fn of(gradient: &Vector2Planes, medium: Medium) -> Self {
        let (width, height) = (medium.mask.width(), medium.mask.height());
        let [across, down] = [width.div_ceil(BLOCK[0]), height.div_ceil(BLOCK[1])];
        let are_all = medium.wraps != [false; 2] || medium.importance.is_some();
        let mut moves = Plane::filled(across, down, are_all);
        if !are_all {
            for (y, columns) in moving_runs(gradient, medium) {
                let blocks = columns.start / BLOCK[0]..columns.end.div_ceil(BLOCK[0]);
                moves.row_mut(y / BLOCK[1])[blocks].fill(true);
            }
        }
        let spans = (0..(2 * down).saturating_sub(1)).map(|i| {
            let pair = [i / 2, i.div_ceil(2)].map(|row| moves.row(row));
            let mut spans = Spans::new();
            for x in (0..across).filter(|&x| pair.iter().any(|row| row[x])) {
                let columns = x * BLOCK[0]..((x + 1) * BLOCK[0]).min(width);
                match spans.last_mut() {
                    Some(last) if last.end == columns.start => last.end = columns.end,
                    _ => spans.push(columns),
                }
            }
            spans
        });
        let still = moves.samples().iter().filter(|&&moves| !moves).count();
        Self {
            width,
            spans: spans.collect(),
            left_out: [still, moves.samples().len()],
        }
    }

    /// The columns of all blocks that these rows touch, no more rows than a block has.
    pub(crate) fn spans(&self, rows: Range<usize>) -> &[Range<usize>] {
        match rows.is_empty() {
            true => &[],
            false => &self.spans[rows.start / BLOCK[1] + (rows.end - 1) / BLOCK[1]],
        }
    }

    /// Reads out what is left out: the slopes `from` times the sum of `weights`, which have the signs of the terms.
    pub(crate) fn read_out_still(&self, from: &Plane, to: &mut Plane, weights: &[f32]) {
        to.each_row(|y, row| {
            let mut start = 0;
            let end = self.width..self.width;
            for moving in self.spans(y..y + 1).iter().chain([&end]) {
                let still = std::mem::replace(&mut start, moving.end)..moving.start;
                let (sums, slopes) = (&mut row[still.clone()], &from.row(y)[still]);
                wide!(|fma| still_row(fma, sums, slopes, weights));
            }
        });
    }
}

/// Rows and columns of the pixels joined with any of another slope.
fn moving_runs(
    gradient: &Vector2Planes,
    medium: Medium,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let slopes = |y: usize, columns: Range<usize>| {
        [&gradient.x, &gradient.y].map(|plane| &plane.row(y)[columns.clone()])
    };
    let of_row = |y: usize| -> Vec<Joined> {
        let (open, mut at) = (medium.conductance.row(y), 0);
        let runs = std::iter::from_fn(|| {
            let start = at + length_of(&open[at..], false);
            at = start + length_of(&open[start..], true);
            (at > start).then_some(start..at)
        });
        let joined = runs.map(|columns| {
            let [before, after] = [
                columns.start..columns.end - 1,
                columns.start + 1..columns.end,
            ];
            Joined {
                moves: differ(slopes(y, before), slopes(y, after)),
                columns,
                with: 0,
            }
        });
        joined.collect()
    };
    let rows = (0..medium.mask.height()).into_par_iter();
    let rows: Vec<_> = rows.with_min_len(ROWS_PER_TASK).map(of_row).collect();
    let row_of = |y: usize, row: &Vec<Joined>| vec![y; row.len()];
    let ys: Vec<usize> = rows
        .iter()
        .enumerate()
        .flat_map(|(y, row)| row_of(y, row))
        .collect();
    let mut runs: Vec<Joined> = rows.into_iter().flatten().collect();
    (0..runs.len()).for_each(|i| runs[i].with = i);
    let mut above = 0;
    for i in 0..runs.len() {
        // Those of the row above that end left of this one join no later one of its row.
        while ys[above] + 1 < ys[i]
            || (ys[above] + 1 == ys[i] && runs[above].columns.end <= runs[i].columns.start)
        {
            above += 1;
        }
        let mut j = above;
        while ys[j] + 1 == ys[i] && runs[j].columns.start < runs[i].columns.end {
            let [a, b] = [&runs[j].columns, &runs[i].columns];
            let both = a.start.max(b.start)..a.end.min(b.end);
            let [a, b] = [j, i].map(|run| last_joined(&mut runs, run));
            let moves = runs[a].moves
                || runs[b].moves
                || differ(slopes(ys[j], both.clone()), slopes(ys[i], both));
            runs[b].with = a;
            runs[a].moves = moves;
            j += 1;
        }
    }
    (0..runs.len()).filter_map(move |i| {
        let last = last_joined(&mut runs, i);
        runs[last].moves.then(|| (ys[i], runs[i].columns.clone()))
    })
}

/// The run at the end of those that a run is joined with, one with another.
fn last_joined(runs: &mut [Joined], mut run: usize) -> usize {
    while runs[run].with != run {
        runs[run].with = runs[runs[run].with].with;
        run = runs[run].with;
    }
    run
}

/// Number of leading pixels that are open, or closed.
fn length_of(row: &[f32], is_open: bool) -> usize {
    let is_other = |&c: &f32| (c > 0.0) != is_open;
    let any_other = |part: &[f32]| part.iter().fold(false, |any, c| any | is_other(c));
    let whole = row.chunks(AT_ONCE).position(any_other);
    let Some(skipped) = whole.map(|chunk| chunk * AT_ONCE) else {
        return row.len();
    };
    let rest = row[skipped..].iter().position(is_other);
    skipped + rest.expect("there is one in the chunk")
}

/// Whether slopes of two rows differ anywhere.
fn differ([ax, ay]: [&[f32]; 2], [bx, by]: [&[f32]; 2]) -> bool {
    let pair = |a: &[f32], b: &[f32]| {
        let pairs = a.iter().zip(b);
        pairs.fold(false, |any, (a, b)| any | (a != b))
    };
    let parts = |row: &[f32], other: &[f32]| {
        let mut parts = row.chunks(AT_ONCE).zip(other.chunks(AT_ONCE));
        parts.any(|(a, b)| pair(a, b))
    };
    parts(ax, bx) || parts(ay, by)
}

/// Slopes times the sum of weights, added up in the order of terms.
#[inline(always)]
pub(crate) fn still_row(fma: bool, sums: &mut [f32], slopes: &[f32], weights: &[f32]) {
    let mut last = [[0.0; AT_ONCE]; 2];
    for (sums, slopes) in sums.chunks_mut(AT_ONCE).zip(slopes.chunks(AT_ONCE)) {
        let mut g = [0.0_f32; AT_ONCE];
        g[..slopes.len()].copy_from_slice(slopes);
        let differs = |any, (a, b): (&f32, &f32)| any | (a != b);
        if g.iter().zip(&last[0]).fold(false, differs) {
            let mut sum = [0.0; AT_ONCE];
            for &weight in weights {
                for j in 0..AT_ONCE {
                    sum[j] = multiply_add(fma, weight, g[j], sum[j]);
                }
            }
            last = [g, sum.map(|sum| sum + 0.0)];
        }
        sums.copy_from_slice(&last[1][..sums.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Mask;
    use crate::frame::memory::Memory;
    use crate::params::{RunOptions, Scale, ShapeParams, Solver, TileSize};
    use crate::shape::diffusion::LEVELS;
    use crate::shape::diffusion::cpu::diffusion;
    use crate::shape::diffusion::importance::ImportanceLevels;
    use crate::shape::diffusion::sweeps::DiffusionSchedule;
    use std::num::NonZeroUsize;

    const SIZE: [usize; 2] = [704, 208];
    /// An island of two pixels in every block: its place within, with nothing through the faces around it.
    const ISLAND: [usize; 2] = [5, 4];

    /// Three walls apart at columns 300 and 420, the last with a bump; and conductances with a closed, uncovered rim.
    fn scene(islands_differ: bool) -> (Vector2Planes, Plane, Mask) {
        let [width, height] = SIZE;
        let within = |x: usize, y: usize| [x % BLOCK[0], y % BLOCK[1]];
        let slope = |x: usize, y: usize, walls: [f32; 2]| match within(x, y) {
            [x, y] if y == ISLAND[1] && x == ISLAND[0] => 0.25,
            [x, y] if y == ISLAND[1] && x == ISLAND[0] + 1 && islands_differ => 0.5,
            [x, y] if y == ISLAND[1] && x == ISLAND[0] + 1 => 0.25,
            _ if x.abs_diff(500) < 4 && y.abs_diff(100) < 4 => 0.1 * (x % 7) as f32,
            _ => walls[usize::from(x >= 300)],
        };
        let mask = Mask::new(Plane::from_fn(width, height, |x, y| {
            (3..width - 9).contains(&x) && y < height - 5
        }));
        let component = |walls: [f32; 2]| {
            Plane::from_fn(width, height, |x, y| match mask.at(x, y) {
                true => slope(x, y, walls),
                false => 0.0,
            })
        };
        let gradient = Vector2Planes {
            x: component([0.3, 0.7]),
            y: component([-0.2, 1e-3]),
        };
        let open = Plane::from_fn(width, height, |x, y| {
            let [left, above] = [0, 1].map(|axis| within(x, y)[axis].abs_diff(ISLAND[axis]));
            let right = within(x, y)[0].abs_diff(ISLAND[0] + 1);
            let is_island = left.min(right) == 0 && above == 0;
            let is_beside = left.min(right) <= 1 && above <= 1;
            let is_apart = x == 300 || x == 420;
            match mask.at(x, y) && !is_apart && (is_island || !is_beside) {
                true => 0.5 + 0.5 * ((x * 5 + y * 3) % 11) as f32 / 11.0,
                false => 0.0,
            }
        });
        (gradient, open, mask)
    }

    /// Slopes that differ within islands, out of which nothing flows, let no block be left out. All other pixels have the
    /// same bits whether blocks are left out or not: at one scale and two, by importance, by steps, in one pass and several.
    #[test]
    fn what_is_left_out_has_the_bits_of_what_is_swept() {
        let of_scale = |scale, solver, by_importance| {
            let shape = ShapeParams {
                scale,
                solver,
                ..ShapeParams::default()
            };
            DiffusionSchedule::new(&shape, 1.0, &[], by_importance)
        };
        let by_importance = of_scale(Scale::Sigma(4.0), Solver::Chebyshev, true);
        let mut weights = vec![[0.0; LEVELS]; by_importance.count() + 1];
        let of_levels = by_importance.weights_by_importance(&[0.3, 0.6, 1.0]);
        for (level, of_level) in of_levels.iter().enumerate() {
            let of_terms = weights.iter_mut().zip(of_level);
            of_terms.for_each(|(of_term, weight)| of_term[level] = *weight);
        }
        // Few levels and, as far as is known, many.
        let levels = [3, LEVELS].map(|count| ImportanceLevels {
            plane: Plane::from_fn(SIZE[0], SIZE[1], |x, y| ((x + y / 40) / 90 % 3) as u16),
            count,
            weights: weights.clone(),
        });
        let cases = [
            (DiffusionSchedule::to_sigmas(&[4.0], 1e-4), None),
            (DiffusionSchedule::to_sigmas(&[1.0, 5.0], 1e-4), None),
            (
                of_scale(Scale::Iterations(20), Solver::Explicit, false),
                None,
            ),
            (by_importance.clone(), Some(&levels[0])),
            (by_importance, Some(&levels[1])),
        ];
        let size = |n: usize| NonZeroUsize::new(n).expect("above 0");
        for (sweeps, importance) in &cases {
            for (sweeps_per_pass, tile) in [(64, [2048, 640]), (7, [230, 90])] {
                let options = RunOptions {
                    sweeps_per_pass: size(sweeps_per_pass),
                    tile: TileSize {
                        width: size(tile[0]),
                        height: size(tile[1]),
                    },
                };
                let [left_out, swept] = [false, true].map(|islands_differ| {
                    let (gradient, open, mask) = scene(islands_differ);
                    let medium = Medium {
                        importance: *importance,
                        ..Medium::of_whole(&open, &mask)
                    };
                    let [left_out, all] = Moving::of(&gradient, medium).left_out;
                    let are_swept = islands_differ || importance.is_some();
                    match are_swept {
                        true => assert_eq!(left_out, 0),
                        false => assert!(left_out > all / 2, "{left_out} of {all}"),
                    }
                    diffusion(gradient, medium, sweeps, &options, &Memory::default()).scales
                });
                for (a, b) in left_out.iter().zip(&swept) {
                    for (a, b) in [(&a.x, &b.x), (&a.y, &b.y)] {
                        for y in 0..SIZE[1] {
                            for x in 0..SIZE[0] {
                                let at = [x % BLOCK[0], y % BLOCK[1]];
                                let is_island =
                                    at[1] == ISLAND[1] && at[0].wrapping_sub(ISLAND[0]) < 2;
                                let (a, b) = (a.at(x, y), b.at(x, y));
                                assert!(is_island || a.to_bits() == b.to_bits(), "({x}, {y})");
                            }
                        }
                    }
                }
            }
        }
    }
}
