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

/// Mapped curvature as [`mapped_curvature`], of a Hessian [xx, xy, yy] and for light from a unit direction
/// whose part in the picture is `l_xy` ([RS] section 4.1): `tanh(-gain [tr + 2 a (l.Hl - (tr/2) |l|^2)])`.
///
/// An anisotropy `a` of 0 counts both curvatures, whatever the light; at 1, light along a principal
/// direction counts that curvature alone, twice; at -1 the other one. Light from the viewer (`l_xy` 0)
/// prefers none. No eigen-solver is needed.
#[inline(always)]
pub fn mapped_curvature_toward(
    hessian: [f32; 3],
    l_xy: [f32; 2],
    gain: f32,
    anisotropy: f32,
) -> f32 {
    let ([xx, xy, yy], [x, y]) = (hessian, l_xy);
    // l.Hl - (tr/2) |l|^2: how far the curvature along the light is from the mean.
    let along = 0.5 * (xx - yy) * (x * x - y * y) + 2.0 * xy * x * y;
    mapped_curvature(xx + yy + 2.0 * anisotropy * along, gain)
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
    fn light_along_a_principal_direction_counts_that_curvature_twice() {
        // Principal curvatures 0.02 and -0.07 along 30 and 120 degrees.
        let (c, s) = (30.0_f32.to_radians().cos(), 30.0_f32.to_radians().sin());
        let (u, v) = (0.02, -0.07);
        let h = [
            u * c * c + v * s * s,
            (u - v) * c * s,
            u * s * s + v * c * c,
        ];
        let toward = |l, anisotropy| mapped_curvature_toward(h, l, 10.0, anisotropy);
        let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-6, "{a} is not {b}");
        near(toward([c, s], 1.0), mapped_curvature(2.0 * u, 10.0));
        near(toward([-s, c], 1.0), mapped_curvature(2.0 * v, 10.0));
        near(toward([c, s], -1.0), mapped_curvature(2.0 * v, 10.0));
        near(toward([0.4, 0.1], 0.0), mapped_curvature(u + v, 10.0));
        near(toward([0.0, 0.0], 1.0), mapped_curvature(u + v, 10.0));
        // A direction half way between counts both; one at 60 degrees off the picture a quarter as much.
        let half_way = std::f32::consts::FRAC_1_SQRT_2;
        let between = [(c - s) * half_way, (c + s) * half_way];
        near(toward(between, 1.0), mapped_curvature(u + v, 10.0));
        let quarter = u + v + 0.25 * (u - v);
        near(
            toward([0.5 * c, 0.5 * s], 1.0),
            mapped_curvature(quarter, 10.0),
        );
    }

    #[test]
    fn a_bump_maps_to_plus_one() {
        // A ball of radius 10 facing the viewer: trace -2/10.
        assert!(mapped_curvature(-0.2, 100.0) > 0.99);
        assert_eq!(mapped_curvature(0.0, 100.0), 0.0);
        assert_eq!(mapped_curvature(f32::MAX, 1e30), -1.0);
    }
}
