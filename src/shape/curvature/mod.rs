//! Curvatures and their directions from the Hessian, without an eigen-solver, and the only mapping of curvature to
//! -1..1.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod stage;

use crate::kernel::fast_math::{select, tanh};

/// Principal curvatures `k_u >= k_v` per pixel of a symmetric Hessian [xx, xy, yy]. Concave is
/// positive, convex negative: [LW]'s sign.
#[inline(always)]
pub fn principal_curvatures([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let mean = 0.5 * (xx + yy);
    let spread = spread(0.5 * (xx - yy), xy) as f32;
    [mean + spread, mean - spread]
}

/// Half the difference of the principal curvatures, from half that of the diagonal, and xy: in double precision no square
/// overflows or vanishes.
#[inline(always)]
fn spread(half_difference: f32, xy: f32) -> f64 {
    let [c, s] = [half_difference, xy].map(f64::from);
    (c * c + s * s).sqrt()
}

/// Unit direction (x right, y up, opposites being equal) of the larger principal curvature by magnitude; zero if both
/// are equal to 1e-6 of their magnitude and there is none.
#[inline(always)]
pub(crate) fn principal_direction([xx, xy, yy]: [f32; 3]) -> [f32; 2] {
    let (half_difference, mean) = (0.5 * (xx - yy), 0.5 * (xx + yy));
    let spread = spread(half_difference, xy);
    let has_none = (spread <= f64::from(UMBILIC * mean.abs())) | (spread == 0.0);
    // Half the angle of (half_difference, xy): cos^2 = (1 + cos 2a) / 2 gives the larger of sine and cosine, sin 2a the
    // other.
    let [cosine, sine] = [half_difference, xy].map(|v| f64::from(v) / spread);
    let larger = (0.5 * (1.0 + cosine.abs())).sqrt();
    let lesser = 0.5 * sine / larger;
    let [x, y] = match cosine >= 0.0 {
        true => [larger, lesser],
        false => [lesser.abs(), larger.copysign(sine)],
    }
    .map(|v| v as f32);
    let [x, y] = if mean >= 0.0 { [x, y] } else { [-y, x] };
    [x, y].map(|v| select(has_none, 0.0, v))
}

/// Relative difference of the principal curvatures below which a point is umbilic: a few roundings
/// of f32.
pub(crate) const UMBILIC: f32 = 1e-6;

/// Mapped curvature in -1..1, **+1 convex and -1 concave** ([RS] section 4), from the trace of the Hessian. This is
/// the only place where the sign flips.
#[inline(always)]
pub fn mapped_curvature(trace: f32, gain: f32) -> f32 {
    tanh(-gain * trace)
}

/// [`mapped_curvature`] for light from one side ([RS] section 4): from the symmetric `hessian` [xx, xy, yy], with x
/// and y of the unit direction to the light in `l_xy`.
///
/// At `anisotropy` (lambda) 1 and grazing light it maps twice the curvature along the light, at -1 twice the curvature
/// across it; at 0, and for light along z, their sum. In between `kappa = tanh(-gain [tr + 2 lambda (l^T H l - |l|^2
/// tr/2)])`: the printed form `tr + lambda (k_u - k_v)(l_u^2 - l_v^2)` in the principal directions u and v, without
/// computing them.
#[inline(always)]
pub fn mapped_curvature_toward(
    [xx, xy, yy]: [f32; 3],
    [x, y]: [f32; 2],
    gain: f32,
    anisotropy: f32,
) -> f32 {
    // The form l^T H l without the trace, which would cancel if both curvatures are equal.
    let along = (xx - yy) * ((x - y) * (x + y)) + 4.0 * xy * (x * y);
    mapped_curvature((xx + yy) + anisotropy * along, gain)
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

    /// Unit directions over the hemisphere toward the viewer.
    fn directions() -> impl Iterator<Item = [f64; 3]> {
        (0..200).map(|i| {
            let (z, azimuth) = (f64::from(i) / 199.0, 2.4 * f64::from(i));
            let across = (1.0 - z * z).sqrt();
            [across * azimuth.cos(), across * azimuth.sin(), z]
        })
    }

    #[test]
    fn curvature_toward_a_light_is_that_of_the_principal_directions() {
        for (k_u, k_v, turn) in [(0.3_f64, -0.2_f64, 0.4), (0.1, 0.02, 2.0), (0.0, -0.4, 1.1)] {
            let (s, c) = f64::sin_cos(turn);
            let hessian = [
                k_u * c * c + k_v * s * s,
                (k_u - k_v) * s * c,
                k_u * s * s + k_v * c * c,
            ];
            for [x, y, z] in directions() {
                let (l_u, l_v) = (c * x + s * y, c * y - s * x);
                for lambda in [-1.0, -0.3, 0.0, 0.5, 1.0] {
                    let (sum, difference) = (k_u + k_v, lambda * (k_u - k_v));
                    let printed = (sum + difference) * l_u * l_u
                        + (sum - difference) * l_v * l_v
                        + sum * z * z;
                    // Convex is positive here and negative there.
                    let exact = (-1.5 * printed).tanh();
                    let l = [x as f32, y as f32];
                    let found =
                        mapped_curvature_toward(hessian.map(|h| h as f32), l, 1.5, lambda as f32);
                    assert!((f64::from(found) - exact).abs() < 5e-7, "{found}, {exact}");
                }
            }
        }
    }

    #[test]
    fn without_anisotropy_the_light_changes_no_bit() {
        for [x, y, _] in directions() {
            for [xx, xy, yy] in [[-0.02, 0.3, 0.017], [1e30, -1e30, 1e30], [0.1, 0.0, 0.1]] {
                let l = [x as f32, y as f32];
                let isotropic = mapped_curvature(xx + yy, 3.0);
                assert_eq!(
                    mapped_curvature_toward([xx, xy, yy], l, 3.0, 0.0),
                    isotropic
                );
                // Neither does light from the viewer's side, nor light on an umbilic.
                assert_eq!(
                    mapped_curvature_toward([xx, xy, yy], [0.0; 2], 3.0, 1.0),
                    isotropic
                );
                assert_eq!(
                    mapped_curvature_toward([xx, 0.0, xx], l, 3.0, -1.0),
                    mapped_curvature(xx + xx, 3.0)
                );
            }
        }
    }

    #[test]
    fn grazing_light_along_a_principal_direction_shows_twice_its_curvature() {
        // A cylinder along y of curvature -0.2 (convex), by light across it and along it.
        let cylinder = [-0.2, 0.0, 0.0];
        let shown = |l, lambda| mapped_curvature_toward(cylinder, l, 1.0, lambda);
        let (across, along) = ([1.0, 0.0], [0.0, -1.0]);
        assert_eq!(shown(across, 1.0), 0.4_f32.tanh());
        assert_eq!([shown(along, 1.0), shown(across, -1.0)], [0.0, 0.0]);
        assert_eq!(shown(along, -1.0), 0.4_f32.tanh());
        for hessian in [
            [1e30, -1e30, 1e30],
            [f32::MAX / 8.0; 3],
            [-f32::MAX / 8.0, 0.0, 0.0],
        ] {
            for lambda in [-1.0, 1.0] {
                assert!(mapped_curvature_toward(hessian, [0.6, -0.8], 1e30, lambda).abs() <= 1.0);
            }
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
