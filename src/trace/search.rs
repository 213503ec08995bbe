//! The search along a path for its first crossing behind a surface: even steps, then the secant rule.

use crate::params::SearchParams;

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

/// The first position on a path, searched in `steps` even steps and `refinements`, where it passes through a surface
/// from the front.
///
/// `gap` is the distance of a position in front of the surface, as a share of the distance: positive in front, negative
/// behind, `None` without a surface. If the gap jumps below 0 the path passes behind an edge; it is followed, unseen,
/// until it emerges in front of a surface again. Source: [LA] section 5.2, after the linear and secant search in
/// distance maps; the secant rule is the Illinois variant, which keeps the surface bracketed.
#[inline]
pub(crate) fn first_crossing(
    steps: u32,
    refinements: u32,
    gap: impl Fn(f64) -> Option<f64>,
) -> Crossing {
    let mut before: Option<End> = None;
    let mut in_front = None;
    for k in 0..=steps {
        let s = f64::from(k) / f64::from(steps);
        let here = gap(s).map(|gap| End { s, gap });
        if let (Some(front), Some(behind)) = (before, here)
            && front.gap > 0.0
            && behind.gap <= 0.0
            && let Some(found) = narrowed(refinements, front, behind, &gap)
        {
            return Crossing::Hit(found);
        }
        if here.is_some_and(|end| end.gap > 0.0) {
            in_front = Some(s);
        }
        // Without a surface the path counts as in front of the next one.
        before = here.or(before.filter(|end| end.gap > 0.0));
    }
    in_front.map_or(Crossing::Nothing, Crossing::Unseen)
}

/// A position on the path and its gap.
#[derive(Debug, Clone, Copy)]
struct End {
    s: f64,
    gap: f64,
}

/// The crossing between two positions; `None` if the gap jumps.
#[inline]
fn narrowed(
    refinements: u32,
    mut front: End,
    mut behind: End,
    gap: &impl Fn(f64) -> Option<f64>,
) -> Option<f64> {
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
        let s = front.s + (behind.s - front.s) * near / (near - far);
        match gap(s) {
            Some(gap) if gap <= 0.0 => {
                behind = End { s, gap };
                weights = [0.5 * weights[0], 1.0];
            }
            Some(gap) => {
                front = End { s, gap };
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
        first_crossing(16, 12, gap)
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
        assert!((found - (1.0_f64 / 0.3).ln() / 2.0).abs() < 1e-9);
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
}
