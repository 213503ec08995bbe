//! Light warping: incoming light bent by curvature.
//!
//! Theory: [LW] section 5 scales the stereographic coordinates `p = l_xy / (1 + l_z)` of a light's direction l along
//! the principal directions, by factors that follow the principal curvatures: a convexity gathers light from around the
//! viewer's direction z, a concavity light from around the horizon. z itself stays fixed.
//!
//! Changes: p is also `h_xy / h_z` of the half vector h between l and z. So warping is a **linear map of half
//! vectors**, `h -> (Lambda h_xy, h_z)`, with a symmetric 2x2 matrix Lambda; its inverse is linear too, and its
//! Jacobian is a determinant over the fourth power of a length. In this form the direction -z, where p is infinite, is
//! not special: the printed form is NaN in f32 within 0.014 degrees of it. And Lambda needs neither an eigen-solver nor
//! principal directions.
//!
//! Use: compute [`Warp::of`] the Hessian once per pixel. To look light up by direction ([LW] equation 1), look it up at
//! [`warped`]. For given lights (equation 2), use the [inverse](Warp::inverse): a light with half vector h then comes
//! from [`Warp::direction`] of h, with its intensity times [`Warp::jacobian`] at h. Half vectors of lights do not
//! depend on the pixel.

use crate::kernel::fast_math::circular::{COT_EIGHTH_PI, SIXTH, TAN_EIGHTH_PI, rest_of_tangent};
use crate::kernel::fast_math::{exp, ln, polynomial, select};

/// The factor lambda, from 1/sqrt(3) to sqrt(3), by which a principal curvature `k` (concave positive)
/// scales stereographic coordinates along its direction, at warping strength `alpha`.
///
/// `lambda = tan(atan(alpha k) / 6 + pi/4)`: 1 for no warping, reciprocal for the opposite curvature. Source: [LW]
/// section 5. The 6 lets the strongest warping move half of the solid angle of a hemisphere across its border. If
/// `alpha k` is NaN, as for 0 times infinity, lambda is 1.
#[inline(always)]
pub fn scale_factor(k: f32, alpha: f32) -> f32 {
    factor(alpha * k)
}

/// [`scale_factor`] where `alpha k` is `x`.
#[inline(always)]
pub(crate) fn factor(x: f32) -> f32 {
    let size = if x.is_nan() { 0.0 } else { x.abs() };
    let (steep, middle) = (size > COT_EIGHTH_PI, size > TAN_EIGHTH_PI);
    let y = rest_of_tangent(size);
    let whole = select(steep, LARGEST_FACTOR, select(middle, FACTOR_OF_1, 1.0));
    // The tangent of a sum of angles: that of the factor there, and a sixth of atan y.
    let t = y * polynomial(y * y, SIXTH);
    let (more, less) = (whole + t, 1.0 - whole * t);
    select(x < 0.0, less, more) / select(x < 0.0, more, less)
}

/// The factor of 1, tan(7 pi/24), and that of infinity, the square root of 3.
pub(crate) const FACTOR_OF_1: f32 = 1.303_225_4;
pub(crate) const LARGEST_FACTOR: f32 = 1.732_050_8;

/// Upper bound of a light's unwarped cosine, as a multiple of its cosine as given.
///
/// [LW] section 6.1 counts a light only if both its directions are above the surface. A hard edge there breaks up the
/// terminator of a raking light; with the smaller of the unwarped cosine and this multiple of the other one, the light
/// fades as it sets. Smaller values damp the warp itself.
pub(crate) const MOST_BRIGHTENED: f32 = 4.0;

/// The effective cosine of a warped light with the normal, 0 if it does not count: `unwarped` belongs to the direction
/// the surface assigns to the light, `warped` to the direction it actually comes from.
///
/// Both equations of [LW] section 6.1 need the same effective cosine, or they are different integrals: in equation 1
/// `warped` belongs to the direction looked up, in equation 2 to the light as given.
#[inline(always)]
pub fn counted_cosine(unwarped: f32, warped: f32) -> f32 {
    unwarped.min(MOST_BRIGHTENED * warped).max(0.0)
}

/// A warping of directions: the symmetric matrix Lambda that acts on x and y of half vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warp {
    /// From x to x.
    pub xx: f32,
    /// From x to y, and from y to x.
    pub xy: f32,
    /// From y to y.
    pub yy: f32,
}

impl Warp {
    /// The warp that leaves every direction unchanged.
    pub const IDENTITY: Self = Self {
        xx: 1.0,
        xy: 0.0,
        yy: 1.0,
    };

    /// The warping of strength `alpha` (pixels; 0 is the identity) where the `hessian` [xx, xy, yy] is
    /// given, convex negative.
    ///
    /// Lambda has the Hessian's directions, and the [`scale_factor`] of each curvature: with the mean m of the
    /// curvatures `m +- q`, it is `(lambda_u + lambda_v)/2 I + (lambda_u - lambda_v)/2 (H - m I)/q`. Umbilics need no
    /// threshold: the last matrix has norm 1 however small q is, and its factor vanishes with q. Infinite curvatures
    /// count as very large ones, NaN as 0.
    #[inline(always)]
    pub fn of(hessian: [f32; 3], alpha: f32) -> Self {
        let WarpParts { principal, turn } = WarpParts::of(hessian, alpha);
        WarpParts {
            principal: principal.map(factor),
            turn,
        }
        .warp()
    }

    /// The inverse warp: reciprocal factors along the same directions, equal to [`Warp::of`] for `-alpha`.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let unit = 1.0 / self.determinant();
        Self {
            xx: self.yy * unit,
            xy: -self.xy * unit,
            yy: self.xx * unit,
        }
    }

    /// Determinant: the product of both factors, 1/3 to 3.
    #[inline(always)]
    pub fn determinant(self) -> f32 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// The image of the direction with half vector `half`, as a unit vector. `half` may have any length.
    #[inline(always)]
    pub fn direction(self, half: [f32; 3]) -> [f32; 3] {
        let ([x, y], z) = (self.apply(half), half[2]);
        let (across, along) = (x * x + y * y, z * z);
        let unit = 1.0 / (across + along);
        let twice = 2.0 * z * unit;
        [twice * x, twice * y, (along - across) * unit]
    }

    /// Ratio of solid angles after and before this warp, at the direction with the **unit** half vector `half`: 1/3 to
    /// 3 if both factors are equal, else 1/9 to 9.
    ///
    /// [LW] equation 2 needs that of the [inverse](Warp::inverse) warp.
    #[inline(always)]
    pub fn jacobian(self, half: [f32; 3]) -> f32 {
        let ([x, y], z) = (self.apply(half), half[2]);
        let squared = x * x + y * y + z * z;
        self.determinant() / (squared * squared)
    }

    /// x and y of a warped half vector; its z stays the same, and its length is no longer 1.
    #[inline(always)]
    pub(crate) fn apply(self, [x, y, _]: [f32; 3]) -> [f32; 2] {
        [self.xx * x + self.xy * y, self.xy * x + self.yy * y]
    }
}

/// What a [`Warp`] consists of: [`Warp::of`] in steps, for loops that vectorise in each of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WarpParts {
    /// The principal curvatures, times the strength of the warp: arguments of [`factor`].
    pub(crate) principal: [f32; 2],
    /// Half the difference of the entries xx and yy, the entry xy, and the length of both, in the unit of the largest
    /// entry: cosine and sine of twice the angle of the first direction, times that length.
    pub(crate) turn: [f32; 3],
}

impl WarpParts {
    /// The first step.
    #[inline(always)]
    pub(crate) fn of(hessian: [f32; 3], alpha: f32) -> Self {
        let [xx, xy, yy] = hessian.map(bounded_entry);
        // In units of the largest entry, so that squares neither overflow nor vanish.
        let size = xx.abs().max(xy.abs()).max(yy.abs());
        let unit = 1.0 / size.max(f32::MIN_POSITIVE);
        let (mean, difference) = (0.5 * (xx + yy) * unit, 0.5 * (xx - yy) * unit);
        let cross = xy * unit;
        let spread = (difference * difference + cross * cross).sqrt();
        let strength = alpha * size;
        Self {
            principal: [mean + spread, mean - spread].map(|k| strength * k),
            turn: [difference, cross, spread],
        }
    }

    /// The last step: the warp, once the principal curvatures are replaced by their factors.
    #[inline(always)]
    pub(crate) fn warp(self) -> Warp {
        let ([u, v], [difference, cross, spread]) = (self.principal, self.turn);
        let turn = 0.5 * (u - v) / spread.max(f32::MIN_POSITIVE);
        let middle = 0.5 * (u + v);
        Warp {
            xx: middle + turn * difference,
            xy: turn * cross,
            yy: middle - turn * difference,
        }
    }
}

/// Entries of a Hessian are clamped to this magnitude: its reciprocal is still a normal number.
pub(crate) const LARGEST: f32 = 1e37;

/// An entry of a Hessian clamped to that magnitude; 0 for NaN.
#[inline(always)]
pub(crate) fn bounded_entry(h: f32) -> f32 {
    if h.is_nan() {
        0.0
    } else {
        h.clamp(-LARGEST, LARGEST)
    }
}

/// Unit half vector between the unit `direction` and z; for -z itself, x. Non-finite directions count as z.
#[inline(always)]
pub fn half_vector([x, y, z]: [f32; 3]) -> [f32; 3] {
    let squared = x * x + y * y;
    let (across, along) = (squared.sqrt(), 1.0 + z.abs());
    // The half vector is (l_xy, 1 + l_z), and below the horizon, where 1 + l_z loses digits, the same
    // times |l_xy| / (1 + l_z) = (1 - l_z) / |l_xy|.
    let lean = along / across.max(f32::MIN_POSITIVE);
    let (below, at_pole) = (z < 0.0, squared < f32::MIN_POSITIVE);
    let [mut half_x, mut half_y, half_z] = if below {
        [x * lean, y * lean, across]
    } else {
        [x, y, along]
    };
    if below & at_pole {
        [half_x, half_y] = [along, 0.0];
    }
    let length_squared = along * along + squared;
    let unit = 1.0 / length_squared.sqrt();
    if length_squared < f32::INFINITY {
        [half_x * unit, half_y * unit, half_z * unit]
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// The image of a unit direction.
#[inline(always)]
pub fn warped(direction: [f32; 3], warp: Warp) -> [f32; 3] {
    warp.direction(half_vector(direction))
}

/// The exponent of the contrast is clamped to this magnitude: e^60 is far above any picture, and its square still
/// finite.
pub(crate) const MAX_EXPONENT: f32 = 60.0;

/// Factor of the reflected light for the warp `warp`: `(lambda_u lambda_v)^gamma`, 3^-|gamma| to 3^|gamma|.
///
/// Positive `gamma` brightens **concavities** and darkens convexities; 0 gives exactly 1. Source: [LW]
/// equation 3, gamma from -1 to 1.
#[inline(always)]
pub fn contrast(warp: Warp, gamma: f32) -> f32 {
    exp((gamma * ln(warp.determinant())).clamp(-MAX_EXPONENT, MAX_EXPONENT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_4, PI, TAU};

    /// The scale factor in its printed form.
    fn exact_factor(x: f64) -> f64 {
        (x.atan() / 6.0 + FRAC_PI_4).tan()
    }

    /// Lambda by principal curvatures and directions.
    fn exact_warp([xx, xy, yy]: [f64; 3], alpha: f64) -> [f64; 3] {
        let (mean, spread) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let (s, c) = (0.5 * xy.atan2(0.5 * (xx - yy))).sin_cos();
        let u = exact_factor(alpha * (mean + spread));
        let v = exact_factor(alpha * (mean - spread));
        [
            u * c * c + v * s * s,
            (u - v) * s * c,
            u * s * s + v * c * c,
        ]
    }

    /// Scaled stereographic coordinates in their printed form.
    fn exact_direction([xx, xy, yy]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [px, py] = [x / (1.0 + z), y / (1.0 + z)];
        let [qx, qy] = [xx * px + xy * py, xy * px + yy * py];
        let square = qx * qx + qy * qy;
        [2.0 * qx, 2.0 * qy, 1.0 - square].map(|c| c / (1.0 + square))
    }

    fn widened(v: [f32; 3]) -> [f64; 3] {
        v.map(f64::from)
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    /// Direction `angle` radians from z, at azimuth `azimuth`.
    fn at(angle: f64, azimuth: f64) -> [f32; 3] {
        let (s, c) = angle.sin_cos();
        [s * azimuth.cos(), s * azimuth.sin(), c].map(|v| v as f32)
    }

    /// Hessians of every kind: umbilic, nearly umbilic, a cylinder, a saddle, rotated and not.
    const HESSIANS: [[f32; 3]; 9] = [
        [-0.01, 0.0, -0.01],
        [0.01, 0.0, 0.01],
        [0.01, 1e-9, 0.010_000_001],
        [-0.02, 0.0, 0.0],
        [0.0, 0.0, 0.03],
        [0.02, 0.005, -0.015],
        [0.01, 0.01, 0.01],
        [0.0, -0.02, 0.0],
        [1.0, 0.3, -0.2],
    ];

    #[test]
    fn a_light_counts_where_both_its_directions_are_above() {
        assert_eq!(counted_cosine(0.5, 0.5), 0.5);
        assert_eq!(counted_cosine(0.5, 1.0), 0.5);
        assert_eq!(counted_cosine(0.5, 0.1), 0.4);
        for below in [0.0, -0.0, -0.3, -1.0] {
            assert_eq!(counted_cosine(0.5, below), 0.0);
            assert_eq!(counted_cosine(below, 0.5), 0.0);
        }
    }

    #[test]
    fn the_factor_is_as_printed() {
        for i in 0..=400 {
            let x = 10.0_f64.powf(f64::from(i) / 20.0 - 10.0);
            let exact = exact_factor(f64::from(x as f32));
            let [found, opposite] = [scale_factor(x as f32, 1.0), scale_factor(-x as f32, 1.0)];
            assert!((f64::from(found) / exact - 1.0).abs() < 2e-7, "{x}");
            assert!((found * opposite - 1.0).abs() < 2e-7, "{x}");
        }
    }

    #[test]
    fn the_factor_is_one_without_warping_and_saturates() {
        for k in [0.0, 1.0, -1e30, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(scale_factor(k, 0.0), 1.0);
        }
        assert_eq!(scale_factor(0.0, f32::INFINITY), 1.0);
        let most = 3.0_f32.sqrt();
        for k in [1e30, f32::MAX, f32::INFINITY] {
            assert!((scale_factor(k, 1e3) - most).abs() < 3e-7);
            assert!((scale_factor(-k, 1e3) - 1.0 / most).abs() < 2e-7);
        }
    }

    #[test]
    fn lambda_is_that_of_the_eigenvectors() {
        for hessian in HESSIANS {
            for alpha in [0.01, 1.0, 30.0, -30.0, 1e3, 1e5] {
                let exact = exact_warp(widened(hessian), f64::from(alpha));
                let Warp { xx, xy, yy } = Warp::of(hessian, alpha);
                let error = distance(widened([xx, xy, yy]), exact);
                assert!(error < 1e-6, "{error:e} at {hessian:?}, alpha {alpha}");
            }
        }
    }

    #[test]
    fn lambda_is_the_same_in_every_unit_of_length() {
        // Powers of two preserve the digits of the curvatures, and alpha compensates for them.
        for hessian in HESSIANS {
            let plain = Warp::of(hessian, 50.0);
            for power in [-60, 60] {
                let unit = 2.0_f32.powi(power);
                assert_eq!(Warp::of(hessian.map(|h| h * unit), 50.0 / unit), plain);
            }
        }
    }

    #[test]
    fn no_warping_is_the_identity_to_the_bit() {
        for hessian in HESSIANS {
            assert_eq!(Warp::of(hessian, 0.0), Warp::IDENTITY);
        }
        assert_eq!(Warp::of([0.0; 3], 1e30), Warp::IDENTITY);
        assert_eq!(Warp::of([0.0; 3], f32::INFINITY), Warp::IDENTITY);
        assert_eq!(contrast(Warp::IDENTITY, 1.0), 1.0);
        assert_eq!(Warp::IDENTITY.jacobian([0.6, 0.0, 0.8]), 1.0);
    }

    /// A million directions: on cones of all angles, close to both poles and to the horizon.
    fn directions() -> Vec<[f32; 3]> {
        let mut angles: Vec<f64> = (0..700)
            .map(|i| PI * (f64::from(i) + 0.5) / 700.0)
            .collect();
        for i in 0..100 {
            // 1e-9 to 0.9 times 0.01 degree and more.
            let tiny = 10.0_f64.powf(f64::from(i) / 12.0 - 9.0);
            angles.extend([tiny, PI - tiny, PI / 2.0 - tiny]);
        }
        let mut all = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [-0.0, -0.0, -1.0]];
        all.extend([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [1e-30, 0.0, -1.0]]);
        for angle in angles {
            all.extend((0..1000).map(|i| at(angle, TAU * f64::from(i) / 1000.0)));
        }
        all
    }

    #[test]
    fn warping_and_back_is_the_same_direction_everywhere() {
        // Saturated warps: convex, concave, a ridge, a saddle.
        let hessians = [
            [-1e3, 0.0, -1e3],
            [1e3, 0.0, 1e3],
            [-1e3, 0.0, 0.0],
            [300.0, 900.0, -200.0],
        ];
        let directions = directions();
        assert!(directions.len() > 1_000_000);
        for warp in hessians.map(|h| Warp::of(h, 1e3)) {
            let (back, exact) = (warp.inverse(), widened([warp.xx, warp.xy, warp.yy]));
            for &l in &directions {
                let there = warped(l, warp);
                let error = distance(widened(warped(there, back)), widened(l));
                assert!(error < 1e-6, "{error:e} at {l:?} by {warp:?}");
                // The printed form loses its digits even in f64 at the last few directions.
                if l[2] > -1.0 + 1e-6 {
                    let error = distance(widened(there), exact_direction(exact, exactly_unit(l)));
                    assert!(error < 1e-6, "{error:e} from the printed form at {l:?}");
                }
            }
        }
    }

    /// The direction in f64, normalised to its precision.
    fn exactly_unit(l: [f32; 3]) -> [f64; 3] {
        let l = widened(l);
        let length = distance(l, [0.0; 3]);
        l.map(|c| c / length)
    }

    #[test]
    fn the_poles_stay() {
        for hessian in HESSIANS {
            let warp = Warp::of(hessian, 200.0);
            assert_eq!(warped([0.0, 0.0, 1.0], warp), [0.0, 0.0, 1.0]);
            let [x, y, z] = warped([0.0, 0.0, -1.0], warp);
            assert!(x == 0.0 && y == 0.0 && (z + 1.0).abs() < 2e-7, "{z}");
        }
    }

    #[test]
    fn convexities_look_toward_the_viewer_and_concavities_away() {
        // A light 45 degrees off, on a ball and in a bowl of radius 20.
        let l = at(FRAC_PI_4, 0.3);
        let [ball, bowl] = [-0.05, 0.05].map(|k| warped(l, Warp::of([k, 0.0, k], 20.0)));
        assert!(ball[2] > l[2] + 0.1 && bowl[2] < l[2] - 0.1);
        // The azimuth is preserved: the three lie in one plane with z.
        for warped in [ball, bowl] {
            assert!((warped[0] * l[1] - warped[1] * l[0]).abs() < 1e-7);
        }
        // Both in closed form: alpha k is -1 and 1, so lambda is tan(pi/4 -+ pi/24), and the angle is twice that of the
        // half vector.
        for (direction, factor) in [(ball, 5.0 * PI / 24.0), (bowl, 7.0 * PI / 24.0)] {
            let angle = 2.0 * (factor.tan() * (PI / 8.0).tan()).atan();
            assert!((f64::from(direction[2]) - angle.cos()).abs() < 3e-7);
        }
    }

    #[test]
    fn the_strongest_warping_moves_half_of_the_hemisphere_across_its_border() {
        // Solid angle is uniform in z. Of 2000 equal parts of the hemisphere the lower half moves below the horizon.
        let warp = Warp::of([1.0, 0.0, 1.0], 1e9);
        let below = (0..2000)
            .map(|i| (f64::from(i) + 0.5) / 2000.0)
            .filter(|z| warped(at(z.acos(), 2.0), warp)[2] < 0.0)
            .count();
        assert_eq!(below, 1000);
    }

    #[test]
    fn the_jacobian_is_that_of_stereographic_coordinates() {
        for hessian in HESSIANS {
            let warp = Warp::of(hessian, 300.0);
            let lambda = widened([warp.xx, warp.xy, warp.yy]);
            let determinant = lambda[0] * lambda[2] - lambda[1] * lambda[1];
            let inverse = [lambda[2], -lambda[1], lambda[0]].map(|c| c / determinant);
            for i in 0..300 {
                let l = at(f64::from(i) * 0.01, f64::from(i));
                // ((1 + |p|^2) / (1 + |q|^2))^2 / det, p of l and q = Lambda^-1 p.
                let [x, y, z] = exactly_unit(l);
                let [px, py] = [x / (1.0 + z), y / (1.0 + z)];
                let qx = inverse[0] * px + inverse[1] * py;
                let qy = inverse[1] * px + inverse[2] * py;
                let ratio = (1.0 + px * px + py * py) / (1.0 + qx * qx + qy * qy);
                let printed = ratio * ratio / determinant;
                // Ours: det^-1 over the fourth power of the half vector's length.
                let hz = (0.5 * (1.0 + z)).sqrt();
                let (gx, gy) = (qx * hz, qy * hz);
                let ours = 1.0 / (determinant * (gx * gx + gy * gy + hz * hz).powi(2));
                assert!((ours / printed - 1.0).abs() < 1e-12);
                let found = f64::from(warp.inverse().jacobian(half_vector(l)));
                assert!((found / printed - 1.0).abs() < 2e-6, "{found} at {l:?}");
            }
        }
    }

    #[test]
    fn the_jacobian_keeps_the_sphere_whole() {
        for hessian in HESSIANS {
            let inverse = Warp::of(hessian, 100.0).inverse();
            let (mut sum, mut least, mut most) = (0.0, f64::MAX, 0.0_f64);
            for i in 0..500 {
                let angle = (1.0 - (f64::from(i) + 0.5) / 250.0).acos();
                for j in 0..500 {
                    let l = at(angle, TAU * f64::from(j) / 500.0);
                    let jacobian = f64::from(inverse.jacobian(half_vector(l)));
                    sum += jacobian;
                    (least, most) = (least.min(jacobian), most.max(jacobian));
                }
            }
            let area = 4.0 * PI * sum / 250_000.0;
            assert!((area - 4.0 * PI).abs() < 1e-4, "{area} at {hessian:?}");
            let isotropic = hessian[0] == hessian[2] && hessian[1] == 0.0;
            let range = if isotropic { 3.0 } else { 9.0 };
            assert!(least * range > 1.0 - 1e-5 && most < range * (1.0 + 1e-5));
        }
    }

    #[test]
    fn contrast_is_a_power_of_the_two_factors() {
        for hessian in HESSIANS {
            let warp = Warp::of(hessian, 300.0);
            assert_eq!(contrast(warp, 0.0), 1.0);
            let determinant = f64::from(warp.determinant());
            for gamma in [-1.0, -0.3, 0.5, 1.0] {
                let exact = determinant.powf(f64::from(gamma));
                assert!((f64::from(contrast(warp, gamma)) / exact - 1.0).abs() < 3e-7);
            }
        }
        // Saturated: 3 in a bowl, a third on a ball.
        let [bowl, ball] = [1.0, -1.0].map(|k| contrast(Warp::of([k, 0.0, k], 1e9), 1.0));
        assert!((bowl - 3.0).abs() < 2e-6 && (ball * 3.0 - 1.0).abs() < 1e-6);
        for gamma in [1e3, -1e3, f32::MAX] {
            assert!(contrast(Warp::of([1.0, 0.0, 1.0], 1e9), gamma).is_finite());
        }
    }

    #[test]
    fn hostile_values_give_factors_in_range_and_unit_directions() {
        let (inf, nan, max) = (f32::INFINITY, f32::NAN, f32::MAX);
        let values = [
            0.0, -0.0, 1e-45, 1e-38, 1e-3, -1.0, 1e30, -max, inf, -inf, nan,
        ];
        let (least, most) = (1.0 / 3.0_f32.sqrt(), 3.0_f32.sqrt());
        for (i, &xx) in values.iter().enumerate() {
            for &xy in &values {
                for &yy in &values[i..] {
                    for alpha in [0.0, 1e-30, 1.0, -1e30, max, inf, nan] {
                        let warp = Warp::of([xx, xy, yy], alpha);
                        let [v, u] = factors(warp);
                        assert!(
                            least - 1e-6 < v && u < most + 1e-6,
                            "{u}, {v} at {xx}, {xy}, {yy}, alpha {alpha}"
                        );
                    }
                }
            }
        }
        let warp = Warp::of([inf, 0.0, -1e30], 1e30);
        assert!((warp.xx - most).abs() < 1e-6 && (warp.yy - least).abs() < 1e-6);
        for &x in &values {
            for &z in &values {
                let to = warped([x, 1e-20, z], warp);
                assert!(
                    (distance(widened(to), [0.0; 3]) - 1.0).abs() < 1e-6,
                    "{x}, {z}"
                );
            }
        }
    }

    /// Eigenvalues, the smaller first; NaN if an entry is NaN.
    fn factors(Warp { xx, xy, yy }: Warp) -> [f32; 2] {
        let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        [middle - half, middle + half]
    }
}
