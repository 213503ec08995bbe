//! `atan` and `atan2`, for look-ups.

use super::{polynomial, select};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// The arc tangent of `x`, in radians; 1.93 ulp. Exactly pi/2 in magnitude at the infinities; keeps the sign of 0; NaN
/// gives NaN.
#[inline(always)]
pub(crate) fn atan(x: f32) -> f32 {
    let size = x.abs();
    let (steep, middle) = (size > COT_EIGHTH_PI, size > TAN_EIGHTH_PI);
    let t = rest_of_tangent(size);
    let whole = select(steep, FRAC_PI_2, select(middle, FRAC_PI_4, 0.0));
    let lost = select(steep, PI_2_LOW, select(middle, 0.5 * PI_2_LOW, 0.0));
    let square = t * t;
    let small = square * t * polynomial(square, ATAN) + lost;
    (whole + (small + t)).copysign(x)
}

/// The t whose arc tangent is left of that of `size`, 0 or more, without that of infinity, 1 or 0, whichever makes t
/// smallest: at most tan(pi/8) in magnitude.
#[inline(always)]
pub(crate) fn rest_of_tangent(size: f32) -> f32 {
    let (steep, middle) = (size > COT_EIGHTH_PI, size > TAN_EIGHTH_PI);
    let above = select(steep, -1.0, select(middle, size - 1.0, size));
    let below = select(steep, size, select(middle, size + 1.0, 1.0));
    above / below
}

/// The angle in radians, -pi to pi, of the vector (`x`, `y`) from the x axis; 4e-7 absolute.
///
/// A zero vector has the angle 0; the angle is finite for any components.
#[inline(always)]
pub(crate) fn atan2(y: f32, x: f32) -> f32 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (small, large) = (select(steep, ax, ay), select(steep, ay, ax));
    let ratio = small / select(large > 0.0, large, 1.0);
    // NaN, for two infinite components, fails the comparison and gives the half-way angle.
    let angle = atan(select(ratio < 1.0, ratio, 1.0));
    let angle = select(steep, FRAC_PI_2 - angle, angle);
    select(x < 0.0, PI - angle, angle).copysign(y)
}

/// Boundaries between the forms of `atan`: tan(pi/8) and its reciprocal.
pub(crate) const TAN_EIGHTH_PI: f32 = 0.414_213_57;
pub(crate) const COT_EIGHTH_PI: f32 = 2.414_213_7;

/// pi/2 minus the nearest f32.
pub(crate) const PI_2_LOW: f32 = -4.371_139e-8;

/// Coefficients of tan(atan(y) / 6) / y in powers of y^2, for |y| up to tan(pi/8); 2^-25.8 relative to it.
pub(crate) const SIXTH: [f32; 5] = [
    0.166_666_66,
    -0.054_011_524,
    0.031_767_994,
    -0.021_730_65,
    0.012_416_046,
];

/// Coefficients of (atan(t) - t) / t^3 in powers of t^2, for |t| up to tan(pi/8); 2^-30 relative to atan(t).
pub(crate) const ATAN: [f32; 5] = [
    -0.333_333_16,
    0.199_985_28,
    -0.142_443_91,
    0.105_991_736,
    -0.060_900_714,
];

#[cfg(test)]
mod tests {
    use super::super::accuracy::{assert_within, sweep};
    use super::*;

    #[test]
    fn atan_is_within_its_error_everywhere() {
        assert_within(1.93, sweep(0.0, f32::MAX), atan, f64::atan);
        assert_within(1.93, sweep(-0.0, -f32::MAX), atan, f64::atan);
        // Boundaries between the forms.
        for seam in [TAN_EIGHTH_PI, COT_EIGHTH_PI] {
            let around = (0..100_000).map(|i| f32::from_bits(seam.to_bits() - 50_000 + i));
            assert_within(1.93, around, atan, f64::atan);
        }
    }

    #[test]
    fn atan_is_odd_and_ends_at_half_of_pi() {
        for x in [1e-45, 1e-20, 0.1, 0.414_213_57, 1.0, 2.5, 1e9, f32::MAX] {
            assert_eq!(atan(-x), -atan(x), "{x}");
        }
        assert_eq!(atan(f32::INFINITY), FRAC_PI_2);
        assert_eq!(atan(f32::NEG_INFINITY), -FRAC_PI_2);
        assert_eq!(atan(1.0), FRAC_PI_4);
        assert_eq!(atan(0.0).to_bits(), 0.0_f32.to_bits());
        assert_eq!(atan(-0.0).to_bits(), (-0.0_f32).to_bits());
        // Arguments so small that the angle equals its tangent.
        for x in [f32::from_bits(1), 1e-40, f32::MIN_POSITIVE, 1e-10] {
            assert_eq!(atan(x), x);
        }
        assert!(atan(f32::NAN).is_nan());
    }

    #[test]
    fn atan2_is_the_angle_all_around() {
        for i in 0..1_000_000 {
            let angle = (f64::from(i) / 5e5 - 1.0) * std::f64::consts::PI;
            for length in [1.0, 1e-30, 1e30] {
                let (x, y) = ((length * angle.cos()) as f32, (length * angle.sin()) as f32);
                let truth = f64::from(y).atan2(f64::from(x));
                let error = (f64::from(atan2(y, x)) - truth).abs();
                assert!(error < 4e-7, "{x}, {y}: {error}");
            }
        }
    }

    #[test]
    fn atan2_on_the_axes_and_at_the_ends() {
        assert_eq!(atan2(0.0, 0.0), 0.0);
        assert_eq!(atan2(1.0, 0.0), FRAC_PI_2);
        assert_eq!(atan2(-f32::MAX, 0.0), -FRAC_PI_2);
        assert_eq!(atan2(0.0, -1.0), PI);
        assert_eq!(atan2(1.0, f32::INFINITY), 0.0);
        assert_eq!(atan2(f32::INFINITY, 1.0), FRAC_PI_2);
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
            assert!(atan2(y, x).abs() <= PI, "{y}, {x}");
        }
    }
}
