//! The search along a path for its first crossing behind a surface: even steps, then the secant rule.

use crate::params::SearchParams;
use std::ops::Range;

/// Gap between both sides of a crossing, as a share of the distance, above which the path passes behind an edge rather
/// than hitting the surface.
const JUMP: f64 = 0.05;

/// A gap that counts as zero.
const TOUCHING: f64 = 1e-10;

/// Minimum number of steps of a search, for short paths.
const FEWEST_STEPS: u32 = 4;

/// Steps for a path that is this `share` of the longest.
#[inline]
pub(super) fn steps_for(search: &SearchParams, share: f64) -> u32 {
    let steps = (f64::from(search.steps) * share).ceil() as u32;
    steps.clamp(FEWEST_STEPS.min(search.steps), search.steps)
}

/// Outcome of a search; positions are shares of the path, 0..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Crossing {
    /// Passes through the surface here.
    Hit(f64),
    /// Leaves, or continues behind an edge for good, so that its hit is unseen. Here it was last seen in front of a
    /// surface.
    Unseen(f64),
    /// Never in front of a surface.
    Nothing,
}

/// What bounds tell of a position before its gap is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Bounded {
    /// In front of the surface, if there is one.
    InFront,
    /// Behind the surface, if there is one.
    Behind,
    /// Either.
    Open,
}

/// The first position on a path, searched in `steps` even steps and `refinements`, where it passes through a surface
/// from the front.
///
/// `gap` is the distance of a position in front of the surface, as a share of the distance: positive in front, negative
/// behind, `None` without a surface. If the gap jumps below 0 the path passes behind an edge; it is followed, unseen,
/// until it emerges in front of a surface again. `bounded` is asked at every step in turn; gaps are computed only where
/// it leaves the outcome open. `aimed` is where the path passes through the surface if that goes on as the plane it is at
/// a position, any number if nowhere. Source: [LA] section 5.2, after the linear and secant search in distance maps; the
/// secant rule is the Illinois variant, which keeps the surface bracketed.
#[inline]
pub(super) fn first_crossing(
    steps: u32,
    refinements: u32,
    mut bounded: impl FnMut(f64) -> Bounded,
    gap: impl Fn(f64) -> Option<f64>,
    aimed: impl Fn(f64) -> f64,
) -> Crossing {
    let share = |k: u32| f64::from(k) / f64::from(steps);
    let end = |k: u32| {
        let s = share(k);
        gap(s).map(|gap| PathEnd { s, gap })
    };
    let is_front = |end: &PathEnd| end.gap > 0.0;
    let mut before: Option<PathEnd> = None;
    // Steps after that one, in front of any surface they have.
    let mut passed = 0..0;
    let last_in_front = |before: Option<PathEnd>, passed: Range<u32>| {
        passed.rev().find_map(end).or(before.filter(is_front))
    };
    let mut in_front = None;
    for k in 0..=steps {
        let is_behind = match bounded(share(k)) {
            Bounded::InFront => {
                passed = if passed.is_empty() { k } else { passed.start }..k + 1;
                continue;
            }
            Bounded::Behind => true,
            Bounded::Open => false,
        };
        if is_behind && passed.is_empty() && !before.as_ref().is_some_and(is_front) {
            before = None;
            continue;
        }
        // Without a surface the path counts as in front of the next one.
        let Some(here) = end(k) else {
            passed.end += u32::from(!passed.is_empty());
            before = before.filter(is_front);
            continue;
        };
        let passed = std::mem::take(&mut passed);
        if !is_front(&here)
            && let Some(front) = last_in_front(before, passed)
        {
            in_front = Some(front.s);
            if here.gap <= 0.0
                && let Some(found) = narrowed(refinements, front, here, &gap, &aimed)
            {
                return Crossing::Hit(found);
            }
        }
        before = Some(here);
    }
    let last = last_in_front(before, passed);
    last.map(|front| front.s)
        .or(in_front)
        .map_or(Crossing::Nothing, Crossing::Unseen)
}

/// A position on the path and its gap.
#[derive(Debug, Clone, Copy)]
struct PathEnd {
    s: f64,
    gap: f64,
}

/// The crossing between two positions; `None` if the gap jumps. Once no jump is left between them, the plane of the
/// surface at the nearer one gives a position, on walls the crossing.
#[inline]
fn narrowed(
    refinements: u32,
    mut front: PathEnd,
    mut behind: PathEnd,
    gap: &impl Fn(f64) -> Option<f64>,
    aimed: &impl Fn(f64) -> f64,
) -> Option<f64> {
    let mut has_aimed = false;
    // An end that stays twice in a row counts half, so that both ends converge.
    let mut weights = [1.0, 1.0];
    for _ in 0..refinements {
        if front.gap < TOUCHING {
            return Some(front.s);
        }
        if behind.gap > -TOUCHING {
            return Some(behind.s);
        }
        let (near, far) = (weights[0] * front.gap, weights[1] * behind.gap);
        let mut s = front.s + (behind.s - front.s) * near / (near - far);
        if !has_aimed && front.gap - behind.gap <= JUMP {
            has_aimed = true;
            let is_front = front.gap < -behind.gap;
            let aim = aimed(if is_front { front.s } else { behind.s });
            if aim > front.s && aim < behind.s {
                s = aim;
            }
        }
        match gap(s) {
            Some(gap) if gap <= 0.0 => {
                behind = PathEnd { s, gap };
                weights = [0.5 * weights[0], 1.0];
            }
            Some(gap) => {
                front = PathEnd { s, gap };
                weights = [1.0, 0.5 * weights[1]];
            }
            None => front.s = s,
        }
    }
    if front.gap - behind.gap > JUMP {
        return None;
    }
    let share = front.gap / (front.gap - behind.gap).max(TOUCHING);
    Some(front.s + (behind.s - front.s) * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crossing(gap: impl Fn(f64) -> Option<f64>) -> Crossing {
        first_crossing(16, 12, |_| Bounded::Open, gap, |_| f64::NAN)
    }

    fn met(gap: impl Fn(f64) -> Option<f64>) -> f64 {
        match crossing(gap) {
            Crossing::Hit(s) => s,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_smooth_surface_is_met_where_it_lies() {
        // exp(-2 s) equals 0.3 at ln(1/0.3)/2.
        let found = met(|s| Some((-2.0 * s).exp() - 0.3));
        let exact = (1.0_f64 / 0.3).ln() / 2.0;
        assert!((found - exact).abs() < 1e-9);
        // Aimed well or badly.
        for aim in [exact, exact + 0.01, 7.0, f64::NAN] {
            let gap = |s: f64| Some((-2.0 * s).exp() - 0.3);
            let found = first_crossing(16, 12, |_| Bounded::Open, gap, |_| aim);
            assert!(
                matches!(found, Crossing::Hit(s) if (s - exact).abs() < 1e-9),
                "{aim}"
            );
        }
        assert_eq!(crossing(|s| Some(1.0 + s)), Crossing::Unseen(1.0));
        assert_eq!(crossing(|_| None), Crossing::Nothing);
        assert_eq!(crossing(|_| Some(f64::NAN)), Crossing::Nothing);
    }

    #[test]
    fn what_is_passed_behind_is_not_met() {
        // A post from 0.3 to 0.4 in front of a wall at 0.8.
        let post = 0.3..0.4;
        let gap = |s: f64| Some(if post.contains(&s) { -0.5 } else { 0.8 - s });
        assert!((met(gap) - 0.8).abs() < 1e-9);
        // The path starts behind the surface: it must emerge first.
        let gap = |s: f64| Some(if s < 0.2 { -0.1 } else { 0.6 - s });
        assert!((met(gap) - 0.6).abs() < 1e-9);
        // A hole, with the surface beyond it.
        let gap = |s: f64| (!(0.5..=0.7).contains(&s)).then_some(0.75 - s);
        assert!((met(gap) - 0.75).abs() < 1e-9);
        // Behind the post for good: last seen one step before it.
        let gap = |s: f64| Some(if s > 0.3 { -0.5 } else { 0.8 - s });
        assert_eq!(crossing(gap), Crossing::Unseen(0.25));
    }

    #[test]
    fn bounds_change_nothing() {
        // Gaps at random from step to step, small enough for some to be crossed; bounds that tell some of them.
        let mut state = 1_u32;
        let mut random = |count: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) % count
        };
        let (mut told, mut hits) = (0, 0);
        for _ in 0..5_000 {
            let most = 1 + random(8);
            let gaps: [Option<f64>; 42] = std::array::from_fn(|_| match random(7) {
                0 => None,
                1 if most == 8 => Some(f64::NAN),
                sign => Some((f64::from(sign) - 4.0 + 0.1) * 0.01 * f64::from(most)),
            });
            let of = |s: f64| gaps[(41.0 * s).round() as usize];
            let bounds: [Bounded; 42] = std::array::from_fn(|k| match (gaps[k], random(3)) {
                (Some(gap), 1..) if gap > 0.0 => Bounded::InFront,
                (Some(gap), 1..) if gap <= 0.0 => Bounded::Behind,
                (None, 1) => Bounded::InFront,
                (None, 2) => Bounded::Behind,
                _ => Bounded::Open,
            });
            told += bounds.iter().filter(|b| **b != Bounded::Open).count();
            let expected = first_crossing(41, 12, |_| Bounded::Open, of, |_| f64::NAN);
            let found = first_crossing(
                41,
                12,
                |s| bounds[(41.0 * s).round() as usize],
                of,
                |_| f64::NAN,
            );
            assert_eq!(found, expected, "{gaps:?} {bounds:?}");
            hits += usize::from(matches!(found, Crossing::Hit(_)));
        }
        assert!(
            told > 100_000 && (1_000..4_900).contains(&hits),
            "{told} {hits}"
        );
    }
}
