//! Curvatures and their directions from the Hessian, with no eigen-solver, and the one map from
//! curvature to -1..1.

use crate::fast_math::tanh;

/// Principal curvatures `k_u >= k_v` per pixel of a symmetric Hessian [xx, xy, yy]. Concave is
/// positive, convex negative: [LW]'s sign.
#[inline(always)]
pub fn principal_curvatures([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let mean = 0.5 * (xx + yy);
    let spread = (0.5 * (xx - yy)).hypot(xy);
    [mean + spread, mean - spread]
}

/// Unit direction (x right, y up, equal to its opposite) of the principal curvature that is larger
/// in size; zero where both are equal to 1e-6 of their size and there is none.
#[inline(always)]
pub fn principal_direction([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let (half_difference, mean) = (0.5 * (xx - yy), 0.5 * (xx + yy));
    let spread = half_difference.hypot(xy);
    if spread <= UMBILIC * mean.abs() || spread == 0.0 {
        return [0.0, 0.0];
    }
    let angle_u = 0.5 * xy.atan2(half_difference);
    let angle = if mean >= 0.0 {
        angle_u
    } else {
        angle_u + std::f32::consts::FRAC_PI_2
    };
    [angle.cos(), angle.sin()]
}

/// Relative difference of the principal curvatures below which a point is umbilic: a few roundings
/// of f32.
const UMBILIC: f32 = 1e-6;

/// Mapped curvature in -1..1, **+1 convex and -1 concave** ([RS] section 4.1), from the trace of
/// the Hessian. This is the only place where the sign turns.
#[inline(always)]
pub fn mapped_curvature(trace: f32, gain: f32) -> f32 {
    tanh(-gain * trace)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_curvatures_and_directions_of_a_turned_ridge() {
        // A convex ridge (second derivative -2 across it) whose crest lies at 30 degrees.
        let across = (120.0_f32).to_radians();
        let (c, s) = (across.cos(), across.sin());
        let h = [-2.0 * c * c, -2.0 * c * s, -2.0 * s * s];
        let [u, v] = principal_curvatures(h);
        assert!(u.abs() < 1e-6 && (v + 2.0).abs() < 1e-6);
        let [dx, dy] = principal_direction(h);
        assert!(
            (dx * c + dy * s).abs() > 1.0 - 1e-6,
            "({dx}, {dy}) is not across the ridge"
        );
    }

    #[test]
    fn umbilics_and_planes_have_no_direction() {
        assert_eq!(principal_direction([-0.01, 0.0, -0.01]), [0.0, 0.0]);
        assert_eq!(principal_direction([0.0; 3]), [0.0, 0.0]);
    }

    #[test]
    fn extreme_hessians_stay_finite() {
        for h in [
            [1e30, 1e30, -1e30],
            [f32::MAX / 4.0, 0.0, 0.0],
            [1e-38, 1e-38, 0.0],
        ] {
            assert!(principal_curvatures(h).iter().all(|k| k.is_finite()));
            assert!(principal_direction(h).iter().all(|d| d.is_finite()));
        }
    }

    #[test]
    fn a_bump_maps_to_plus_one() {
        // A ball of radius 10 facing the viewer: trace -2/10.
        assert!(mapped_curvature(-0.2, 100.0) > 0.99);
        assert_eq!(mapped_curvature(0.0, 100.0), 0.0);
        assert_eq!(mapped_curvature(f32::MAX, 1e30), -1.0);
    }
}
