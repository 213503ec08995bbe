//! Selection of lines: those that persist at a coarser scale, the strongest first, none twice, and no more than a
//! drawing bears.

use crate::frame::{Mask, Plane};
use crate::kernel::quantile::quantile;
use crate::line::contours::ContourKind;
use crate::line::contours::network::{End, Line};
use crate::line::interior::fade::{by_budget, by_size};
use crate::line::interior::sizes::Sizes;
use glam::Vec2;

/// A line inside a surface.
pub(super) struct Interior {
    pub(super) kind: ContourKind,
    pub(super) line: Line,
    /// Share of the full width to draw it with, 0..1.
    pub(super) fade: f32,
    /// Length of its other parts, beyond something that hides the line between them.
    pub(super) beyond: f32,
}

/// Smallest ratio of a line's curvature at a coarser scale to its own: it is 1 over the ratio of scales for a fold as
/// sharp as the scale shows it, and nearly 0 on a rough surface.
const PERSISTENT: f32 = 0.3;

/// The same ratio on the roughest surfaces, where medium-sized bumps would pass for folds.
const PERSISTENT_IF_ROUGH: f32 = 0.45;

/// Median of that ratio over the turning surface: from the first of these to the second it is increasingly treated as
/// rough, and from the third to the last decreasingly, since no finer grain passes for a fold.
const ROUGH: [f32; 4] = [0.5, 0.4, 0.37, 0.31];

/// Share of a surface that turns, from which and up to which roughness phases in: a few folds in a plane are not rough.
const TURNING: [f32; 2] = [0.5, 0.75];

/// Lines above this rank of a surface's curvature, times a factor, are sharper than its roughness.
const SHARP_RANK: f64 = 0.75;
const SHARPER: f32 = 2.5;

/// Spots of a piece of a line, and how much a line at the least strength may turn to and fro, in radians from piece to
/// piece, before it has to persist twice as much.
const PIECE: usize = 4;
const WAVERING: f32 = 0.2;

/// Pixels to either side searched for the curvature of the coarser scale.
const LOOKED_FOR: f32 = 2.0;

/// Turn of the normal over the picture, in radians, below which a surface is as good as flat.
const LEAST_TURN: f32 = 9.0;

/// The weight of ridges against other lines.
const RIDGE_WORTH: f32 = 0.45;

/// The criterion that separates lines of the form from those of a rough surface.
pub(super) struct Roughness<'a> {
    /// The curvature in radians per pixel.
    fine: &'a Plane,
    /// The same at a coarser scale, in a plane of half the size.
    coarse: &'a Plane,
    /// The part of a line's curvature that has to be left at the coarser scale.
    persistent: f32,
    /// Strength that a line has somewhere at the least.
    plain: f32,
    /// Strength from which persistence is not required.
    sharp: f32,
}

impl<'a> Roughness<'a> {
    /// Roughness of a surface with these curvatures, where the coarser one is known.
    pub(super) fn of(fine: &'a Plane, coarse: &'a Plane, known: &Mask, sizes: &Sizes) -> Self {
        let pixels = (0..known.height()).flat_map(|y| known.runs(y).flatten().map(move |x| (x, y)));
        let both = pixels.map(|(x, y)| (fine.at(2 * x, 2 * y), 0.5 * coarse.at(x, y)));
        let least = LEAST_TURN / sizes.picture;
        let (mut curvature, mut left): (Vec<f32>, Vec<f32>) = both
            .filter(|(fine, _)| *fine >= least)
            .map(|(fine, coarse)| (fine, coarse / fine))
            .unzip();
        let turning = left.len() as f32 / known.count().max(1) as f32;
        let left = quantile(&mut left, 0.5, f32::total_cmp).unwrap_or(1.0);
        let share = |of: f32, from: f32, to: f32| ((of - from) / (to - from)).clamp(0.0, 1.0);
        let rough = share(left, ROUGH[0], ROUGH[1])
            .min(share(left, ROUGH[3], ROUGH[2]))
            .min(share(turning, TURNING[0], TURNING[1]));
        let usual = quantile(&mut curvature, SHARP_RANK, f32::total_cmp).unwrap_or(0.0);
        Self {
            fine,
            coarse,
            persistent: PERSISTENT + rough * (PERSISTENT_IF_ROUGH - PERSISTENT),
            plain: sizes.thresholds[1],
            sharp: sizes.sharp.max(rough * SHARPER * usual * sizes.picture),
        }
    }

    /// Evidence that a line belongs to the form: at least 1 if its curvature persists at the coarser scale, or if it is
    /// sharper than roughness.
    pub(super) fn formed(&self, line: &Line) -> f32 {
        let shares = line.spots.iter().map(|spot| {
            let around =
                (0..9).map(|i| Vec2::new((i % 3 - 1) as f32, (i / 3 - 1) as f32) * LOOKED_FOR);
            let there = around.map(|offset| 0.5 * self.coarse.nearest(0.5 * (spot.at + offset)));
            there.fold(0.0, f32::max) / self.fine.nearest(spot.at).max(f32::MIN_POSITIVE)
        });
        let persistent = self.persistent * self.wavering(line);
        (line.strength() / self.sharp).max(median(shares.collect()) / persistent)
    }

    /// By how much more a line has to persist as it winds along bumps, which a faint one is more likely to do.
    fn wavering(&self, line: &Line) -> f32 {
        let turns = line.spots.windows(2 * PIECE + 1).map(|spots| {
            let [a, b, c] = [0, PIECE, 2 * PIECE].map(|i| spots[i].at);
            (b - a).angle_to(c - b)
        });
        let (sum, all) = turns.fold((0.0, 0.0), |(sum, all), turn| {
            (sum + turn, all + turn.abs())
        });
        // What a bend turns by does not count.
        let to_and_fro = (all - sum.abs()) / line.spots.len() as f32;
        1.0 + self.plain / line.strength() * (to_and_fro / WAVERING).powi(2)
    }
}

fn median(mut values: Vec<f32>) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Marks the pixels within reach of a place.
fn mark(near: &mut Plane<bool>, at: Vec2, reach: f32) {
    let ([left, top], [right, bottom]) = (near.pixel_at(at - reach), near.pixel_at(at + reach));
    for y in top..=bottom {
        for (x, near) in near
            .row_mut(y)
            .iter_mut()
            .enumerate()
            .take(right + 1)
            .skip(left)
        {
            let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            *near |= middle.distance_squared(at) <= reach * reach;
        }
    }
}

/// The lines to draw beside the lines already drawn through `drawn` points, on a level of this size: `longest` in all.
pub(super) fn chosen(
    lines: Vec<Interior>,
    drawn: impl Iterator<Item = Vec2>,
    size: [usize; 2],
    longest: f32,
    sizes: &Sizes,
) -> Vec<Interior> {
    // Area near lines already drawn, for each kind.
    let mut taken = sizes.apart.map(|_| Plane::filled(size[0], size[1], false));
    let take = |taken: &mut [Plane<bool>; 3], at: Vec2, apart: [f32; 3]| {
        let kinds = taken.iter_mut().zip(apart);
        kinds.for_each(|(taken, apart)| mark(taken, at, apart));
    };
    drawn.for_each(|at| take(&mut taken, at, sizes.apart));
    let mut lines: Vec<(f32, Interior)> =
        lines.into_iter().map(|line| (worth(&line), line)).collect();
    // Ridges come last: beside a valley they double it.
    let is_ridge = |line: &(f32, Interior)| line.1.kind == ContourKind::Ridge;
    lines.sort_by(|a, b| is_ridge(a).cmp(&is_ridge(b)).then(b.0.total_cmp(&a.0)));
    let (mut kept, mut length) = (Vec::new(), 0.0);
    for (_, line) in lines {
        let Interior {
            kind,
            line,
            fade,
            beyond,
        } = line;
        for part in free_parts(line, &taken[number(kind)]) {
            let own = part.length();
            let (shortest, worth) = (shortest(kind, sizes), part.strength() * (own + beyond));
            if own < shortest || worth < sizes.worth || length + own > longest {
                continue;
            }
            length += own;
            let fade = match sizes.fades {
                true => {
                    let by_sizes = by_size(own / shortest) * by_size(worth / sizes.worth);
                    fade * by_sizes * by_budget(length / longest)
                }
                false => 1.0,
            };
            for spot in &part.spots {
                take(&mut taken, spot.at, sizes.apart);
            }
            let line = part;
            kept.extend((fade > 0.0).then_some(Interior {
                kind,
                line,
                fade,
                beyond,
            }));
        }
    }
    kept
}

/// The place of a kind among sizes.
fn number(kind: ContourKind) -> usize {
    match kind {
        ContourKind::Ridge => 1,
        ContourKind::Suggestive => 2,
        _ => 0,
    }
}

/// The length that a line of a kind has at the least.
pub(super) fn shortest(kind: ContourKind, sizes: &Sizes) -> f32 {
    sizes.shortest[usize::from(kind != ContourKind::Valley)]
}

/// The integral of strength along a line and its parts beyond, ridges' in part.
fn worth(line: &Interior) -> f32 {
    let share = if line.kind == ContourKind::Ridge {
        RIDGE_WORTH
    } else {
        1.0
    };
    share * line.line.strength() * (line.line.length() + line.beyond)
}

/// The parts of a line not near a drawn one; all of it if next to nothing is near.
fn free_parts(line: Line, taken: &Plane<bool>) -> Vec<Line> {
    let is_taken: Vec<bool> = line
        .spots
        .iter()
        .map(|spot| taken.nearest(spot.at))
        .collect();
    if !is_taken.contains(&true) {
        return vec![line];
    }
    let mut parts = Vec::new();
    let mut from = 0;
    for run in is_taken.chunk_by(|a, b| a == b) {
        let to = from + run.len();
        if !run[0] {
            let end = |at_end: bool, i: usize| {
                if at_end && !line.closed {
                    line.ends[i]
                } else {
                    End::Free
                }
            };
            parts.push(Line {
                spots: line.spots[from..to].to_vec(),
                closed: false,
                ends: [end(from == 0, 0), end(to == line.spots.len(), 1)],
                part: line.part,
            });
        }
        from = to;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::contours::network::Spot;

    #[test]
    fn faint_lines_do_not_waver() {
        // Of the curvature 0.5 * 0.8 = 0.4 is left at the coarser scale: 4/3 of what is required.
        let (fine, coarse) = (Plane::filled(99, 99, 1.0), Plane::filled(50, 50, 0.8));
        let roughness = Roughness {
            fine: &fine,
            coarse: &coarse,
            persistent: 0.3,
            plain: 22.0,
            sharp: 220.0,
        };
        let formed = |strength: f32, at: fn(f32) -> Vec2| {
            let spot = |i: u8| Spot {
                at: at(f32::from(i)),
                strength,
                log_depth: 0.0,
                is_beside: false,
            };
            roughness.formed(&Line {
                spots: (0..81).map(spot).collect(),
                closed: false,
                ends: [End::Free; 2],
                part: 0,
            })
        };
        let arc = |i: f32| Vec2::new(50.0, 50.0) + 30.0 * Vec2::from_angle(i / 30.0);
        assert!((formed(22.0, arc) - 4.0 / 3.0).abs() < 1e-2);
        // Up and down by a half for four spots each: pieces of four turn by 2 atan(1/2), 2 atan(1/4), 0 and 2 atan(1/4) in
        // turn, 0.477 on average, at 73 of 81 spots: the line has to persist 1 + (0.43/0.2)^2 = 5.6 times as much.
        let wave = |i: f32| Vec2::new(i + 5.0, 50.0 + 0.5 * (i % 8.0 - 4.0).abs());
        assert!((formed(22.0, wave) - 0.238).abs() < 0.02);
        // Sharp as a cut it may.
        assert!(formed(330.0, wave) >= 1.5);
    }
}
