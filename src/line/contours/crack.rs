//! Silhouettes between two pixels: the crack where the surface ends, or where one part of it hides another.
//!
//! The weights of [`crate::shape::silhouette`] mark the pixels beside a silhouette, two to either side. A line needs
//! one position: the crack between the two pixels on either side.

/// Samples along a row or column, from two before the crack to three behind it, so three on either side: the crack is
/// between the third and the fourth. `None` where uncovered or beyond the picture.
pub(crate) type SixSamples = [Option<f32>; 6];

/// A spread jump counts if it is this many times the steepest slope beside it: a kink alone gives up to twice its
/// slope.
const KINK: f32 = 2.5;

/// The jump of a map at the crack, beyond the part explained by the slopes to either side.
///
/// A slope, however steep, and a kink between two slopes are not jumps: on one side at least the slope continues. A
/// filter may spread the jump over the pixels beside the crack; then the sum of the jumps at the three cracks around it
/// counts.
#[inline]
pub(crate) fn unexplained_jump(a: &SixSamples) -> f32 {
    let Some(jump) = difference(a[2], a[3]) else {
        return 0.0;
    };
    let beside = [difference(a[1], a[2]), difference(a[3], a[4])];
    let sharp = beyond_slopes(jump, 1.0, beside).unwrap_or(jump.abs());
    let slopes = [difference(a[0], a[1]), difference(a[4], a[5])];
    let steepest = steepness(slopes[0]).max(steepness(slopes[1]));
    let spread = difference(a[1], a[4])
        .and_then(|jump| beyond_slopes(jump, 3.0, slopes))
        .filter(|&spread| spread > KINK * steepest);
    sharp.max(spread.unwrap_or(0.0))
}

/// The difference between two samples.
#[inline]
fn difference(a: Option<f32>, b: Option<f32>) -> Option<f32> {
    Some(b? - a?)
}

/// The part of a jump beyond a multiple of the slope on either side, where one is known.
#[inline]
fn beyond_slopes(jump: f32, times: f32, slopes: [Option<f32>; 2]) -> Option<f32> {
    slopes
        .into_iter()
        .flatten()
        .map(|slope| (jump - times * slope).abs())
        .reduce(f32::min)
}

#[inline]
fn steepness(slope: Option<f32>) -> f32 {
    slope.map_or(0.0, f32::abs)
}

/// Position of the edge of coverage on the line from a covered pixel to an uncovered one, in pixels beyond the crack
/// between them; `coverage` is that of the pixels from the second before the crack to the second behind it. 0 if
/// coverage does not fall from whole to none around the crack.
#[inline]
pub(crate) fn border_offset(coverage: [f32; 4]) -> f32 {
    let [inmost, inside, outside, outmost] = coverage;
    let falls = inmost >= inside && inside > outside && outside >= outmost;
    if !(falls && inmost > 0.95 && outmost < 0.05) {
        return 0.0;
    }
    (outside + outmost) - (1.0 - inside) - (1.0 - inmost)
}

/// Position of the edge, in pixels behind the crack, between a pixel of the value `before` and one of the value
/// `behind`, both blended with the other side by a filter; unblended they would be `sharp`.
#[inline]
pub(crate) fn spread_offset([before, behind]: [f32; 2], sharp: [f32; 2]) -> f32 {
    let jump = sharp[1] - sharp[0];
    let share = |value: f32, own: f32| ((value - own) / jump).abs().min(0.5);
    let offset = share(behind, sharp[1]) - share(before, sharp[0]);
    if offset.is_finite() { offset } else { 0.0 }
}

/// The nearer of the least and the greatest value around a pixel: mixtures by a filter are assigned to the side they
/// mostly consist of.
#[inline]
pub(crate) fn sharpened(value: f32, around: impl Iterator<Item = f32>) -> f32 {
    let (least, greatest) = around.fold((value, value), |(least, greatest), v| {
        (least.min(v), greatest.max(v))
    });
    if value - least < greatest - value {
        least
    } else {
        greatest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(values: [f32; 6]) -> SixSamples {
        values.map(Some)
    }

    #[test]
    fn slopes_and_kinks_are_no_jumps() {
        assert!(unexplained_jump(&all([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])) < 1e-6);
        assert!(unexplained_jump(&all([0.0, 0.1, 0.2, 0.1, 0.0, -0.1])) < 1e-6);
        assert!(unexplained_jump(&all([0.0, 0.0, 0.0, 0.1, 0.2, 0.3])) < 1e-6);
    }

    #[test]
    fn jumps_count_beyond_slopes_sharp_or_spread() {
        // A jump of 1 between slopes of 0.1: it exceeds the slope by 0.9.
        let sharp = all([0.0, 0.1, 0.2, 1.2, 1.3, 1.4]);
        assert!((unexplained_jump(&sharp) - 0.9).abs() < 1e-6);
        // Half-way in the pixel behind the crack.
        let spread = all([0.0, 0.0, 0.0, 0.5, 1.0, 1.0]);
        assert!((unexplained_jump(&spread) - 1.0).abs() < 1e-6);
        // At the border no slopes are known.
        assert_eq!(
            unexplained_jump(&[None, None, Some(0.0), Some(1.0), None, None]),
            1.0
        );
        assert_eq!(
            unexplained_jump(&[Some(0.0); 6].map(|v| v.filter(|_| false))),
            0.0
        );
    }

    #[test]
    fn coverage_tells_the_place_within_a_pixel() {
        // 30 % of the pixel behind the crack is covered: the edge lies 0.3 behind it.
        assert!((border_offset([1.0, 1.0, 0.3, 0.0]) - 0.3).abs() < 1e-6);
        assert!((border_offset([1.0, 0.6, 0.0, 0.0]) + 0.4).abs() < 1e-6);
        // Coverage without evidence: opaque everywhere, or nowhere.
        assert_eq!(border_offset([1.0; 4]), 0.0);
        assert_eq!(border_offset([0.4, 0.3, 0.0, 0.0]), 0.0);
    }

    #[test]
    fn mixtures_go_to_the_side_they_are_more_of() {
        assert_eq!(sharpened(0.4, [0.0, 1.0].into_iter()), 0.0);
        assert_eq!(sharpened(0.7, [0.0, 1.0].into_iter()), 1.0);
        // A pixel behind the crack contains 30 % of the value before it.
        assert!((spread_offset([0.0, 0.7], [0.0, 1.0]) - 0.3).abs() < 1e-6);
        assert_eq!(spread_offset([0.0, 0.0], [0.0, 0.0]), 0.0);
    }
}
