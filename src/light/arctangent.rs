//! The angle of a vector, quickly enough for every look-up by direction.

use std::f32::consts::{FRAC_PI_2, PI};

/// arctan(sqrt(s)) / sqrt(s) for s from 0 to 1: the polynomial through the 8 Chebyshev nodes, lowest
/// power first. It errs by 7e-8, as much as f32 rounds.
const ARCTANGENT: [f32; 8] = [
    0.999_999_9,
    -0.333_318_1,
    0.199_669_61,
    -0.140_032_9,
    0.098_688_655,
    -0.058_829_755,
    0.023_780_52,
    -0.004_559_792,
];

/// The angle in radians, -pi to pi, of the vector (`x`, `y`) from the x axis, as `y.atan2(x)`, to 4e-7.
///
/// No call, no branch: rows of look-ups can be compiled for wide registers. A vector of no length has
/// the angle 0; whatever the components are, the angle is finite.
#[inline(always)]
pub(super) fn arctangent(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (small, large) = (select(steep, ax, ay), select(steep, ay, ax));
    let ratio = small / select(large > 0.0, large, 1.0);
    // NaN fails the comparison: infinite on both sides is half way between them.
    let ratio = select(ratio < 1.0, ratio, 1.0);
    let angle = ratio * polynomial(ratio * ratio);
    let angle = select(steep, FRAC_PI_2 - angle, angle);
    select(x < 0.0, PI - angle, angle).copysign(y)
}

/// In pairs, whose products do not wait for each other.
#[inline(always)]
fn polynomial(s: f32) -> f32 {
    let [a, b, c, d, e, f, g, h] = ARCTANGENT;
    let (s2, low) = (s * s, a + b * s);
    let (middle, high) = (e + f * s, g + h * s);
    (low + s2 * (c + d * s)) + (s2 * s2) * (middle + s2 * high)
}

/// `a` where `which`, else `b`: by bits, since a branch that depends on the direction is often foreseen
/// wrongly.
#[inline(always)]
fn select(which: bool, a: f32, b: f32) -> f32 {
    let mask = (which as u32).wrapping_neg();
    f32::from_bits(a.to_bits() & mask | b.to_bits() & !mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_angle_all_around() {
        for i in 0..1_000_000 {
            let angle = (f64::from(i) / 5e5 - 1.0) * std::f64::consts::PI;
            for length in [1.0, 1e-30, 1e30] {
                let (x, y) = ((length * angle.cos()) as f32, (length * angle.sin()) as f32);
                let truth = f64::from(y).atan2(f64::from(x));
                let error = (f64::from(arctangent(y, x)) - truth).abs();
                assert!(error < 4e-7, "{x}, {y}: {error}");
            }
        }
    }

    #[test]
    fn axes_and_ends() {
        assert_eq!(arctangent(0.0, 0.0), 0.0);
        assert_eq!(arctangent(1.0, 0.0), FRAC_PI_2);
        assert_eq!(arctangent(-f32::MAX, 0.0), -FRAC_PI_2);
        assert_eq!(arctangent(0.0, -1.0), PI);
        assert_eq!(arctangent(1.0, f32::INFINITY), 0.0);
        assert_eq!(arctangent(f32::INFINITY, 1.0), FRAC_PI_2);
        let values = [
            0.0,
            -1.0,
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::MAX,
            1e-45,
        ];
        for (y, x) in values.iter().flat_map(|y| values.map(|x| (*y, x))) {
            assert!(arctangent(y, x).abs() <= PI, "{y}, {x}");
        }
    }
}
