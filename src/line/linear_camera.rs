//! General linear cameras: the rays neighbouring one bent by a mirror or lens, and the image position of a point along
//! them.
//!
//! Theory: [LA] section 5. The rays of neighbouring pixels meet a plane at (u, v) with slopes (sigma, tau); three of
//! them, at (0, 0), (1, 0) and (0, 1), span all their affine combinations, and one of those passes through any given
//! point. Changes: the paper leaves A', B' and C' of equation 6 undefined; with slopes *relative* to the plane,
//! `x = u + z sigma` and `y = v + z tau`, they are `A' = a d - b c`, `B' = a + d`, `C' = 1` for the differences of slopes
//! `a = sigma2 - sigma1`, `b = sigma3 - sigma1`, `c = tau2 - tau1`, `d = tau3 - tau1`. And the paper projects a point a
//! little along a stroke, which in f32 costs degrees; `foot_direction` is its limit in closed form. Practice: with the
//! steps between the feet of neighbouring rays as the plane's axes, (u, v) is an offset in pixels.

use crate::frame::Ray;
use glam::{DMat3, DVec2, DVec3};
use num_traits::Float;

/// A general linear camera: its first ray through the origin, and how slopes grow along u and v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearCamera<F> {
    /// (sigma, tau) of the first ray.
    slope: [F; 2],
    /// (a, c): change of the slopes from one foot to the next along u.
    along_u: [F; 2],
    /// (b, d): likewise along v.
    along_v: [F; 2],
}

impl<F: Float> LinearCamera<F> {
    /// The camera of three rays with their feet at (0, 0), (1, 0) and (0, 1) and these slopes.
    pub(crate) fn new([first, beside_u, beside_v]: [[F; 2]; 3]) -> Self {
        let gain = |there: [F; 2]| [there[0] - first[0], there[1] - first[1]];
        Self {
            slope: first,
            along_u: gain(beside_u),
            along_v: gain(beside_v),
        }
    }

    /// Direction in which the foot moves, (du, dv) of any length and either sense, when the point hit by the first ray
    /// at height `z` moves along a `direction`: equation 6 in the limit of no motion.
    ///
    /// On the focal locus the foot moves infinitely fast, but its direction still has a limit. It is 0 only there, for
    /// directions along which the rays do not spread.
    #[inline]
    pub(crate) fn foot_direction(&self, z: F, direction: [F; 3]) -> [F; 2] {
        let [s, t] = self.slope;
        let [x, y, rise] = direction;
        self.spread_back(z, [x - rise * s, y - rise * t])
    }

    /// The adjugate of `I + z M`, the map from feet to points at height `z`, applied to `p`.
    #[inline]
    fn spread_back(&self, z: F, [x, y]: [F; 2]) -> [F; 2] {
        let ([a, c], [b, d]) = (self.along_u, self.along_v);
        let one = F::one();
        [(one + z * d) * x - z * b * y, (one + z * a) * y - z * c * x]
    }
}

/// A linear camera in space, its (u, v) offsets in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalCamera {
    camera: LinearCamera<f64>,
    foot: DVec3,
    local_from_view: DMat3,
}

/// Least sine between the steps: below it the surface is seen edge-on.
const MIN_SINE: f64 = 1e-6;

impl LocalCamera {
    /// The camera of a pixel's ray and the adjacent ones, given per pixel: `steps`, the changes of feet and directions
    /// from pixel to pixel along u and v, by one-sided or, better, central differences. `None` if the feet are
    /// collinear or a ray is in their plane.
    #[inline]
    pub fn new(ray: Ray, steps: [Ray; 2]) -> Option<Self> {
        let [u, v] = steps.map(|step| step.start);
        let across = u.cross(v);
        let (area, size) = (
            across.length(),
            0.5 * (u.length_squared() + v.length_squared()),
        );
        let is_flat = area > MIN_SINE * size;
        if !is_flat {
            return None;
        }
        // The normal gets about the length of the steps.
        let local_from_view = DMat3::from_cols(u, v, across / area.sqrt()).inverse();
        let direction = local_from_view * ray.direction;
        let slope = direction.truncate() / direction.z;
        // The derivative of the slope: the slope of a ray a step away is of first order in the step.
        let beside = |step: &Ray| {
            let turn = local_from_view * step.direction;
            slope + (turn.truncate() - turn.z * slope) / direction.z
        };
        let slopes = [slope, beside(&steps[0]), beside(&steps[1])];
        if !slopes.iter().all(|slope| slope.is_finite()) {
            return None;
        }
        Some(Self {
            camera: LinearCamera::new(slopes.map(|slope| slope.to_array())),
            foot: ray.start,
            local_from_view,
        })
    }

    /// The image direction in pixels, (du, dv) of any length, of a tangent at a `point` on the ray.
    #[inline]
    pub fn seen(&self, point: DVec3, tangent: DVec3) -> DVec2 {
        let height = (self.local_from_view * (point - self.foot)).z;
        let tangent = self.local_from_view * tangent;
        self.camera
            .foot_direction(height, tangent.to_array())
            .into()
    }
}

/// The image direction in pixels, of any length, of a tangent where the hit points of rays change by `steps` from pixel
/// to pixel: the pseudo-inverse `[dP/di dP/dj]^+ V`. `None` if no step has a component along it.
#[inline]
pub(crate) fn seen_by_steps(steps: [DVec3; 2], tangent: DVec3) -> Option<DVec2> {
    let [a, b] = steps;
    let along = DVec2::new(a.dot(tangent), b.dot(tangent));
    let (aa, ab, bb) = (a.length_squared(), a.dot(b), b.length_squared());
    let (determinant, size) = (aa * bb - ab * ab, 0.5 * (aa + bb));
    let spreads = determinant > MIN_SINE * MIN_SINE * size * size;
    let seen = match spreads {
        true => DVec2::new(bb * along.x - ab * along.y, aa * along.y - ab * along.x),
        // For rank 1 the pseudo-inverse is the transpose, up to scale.
        false => along,
    };
    seen.try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::Rng;
    use rand_pcg::Pcg64;

    impl<F: Float> LinearCamera<F> {
        /// The foot of the ray through a point (x, y, z): [LA] equation 6. `None` on the focal locus, where neighbouring
        /// rays meet.
        fn foot_of(&self, [x, y, z]: [F; 3]) -> Option<[F; 2]> {
            let [s, t] = self.slope;
            let [u, v] = self.spread_back(z, [x - z * s, y - z * t]);
            let (area, size) = self.area(z);
            let is_focal = area.abs() <= F::epsilon().sqrt() * size;
            (!is_focal).then(|| [u / area, v / area])
        }

        /// The determinant of `I + z M`, `A' z^2 + B' z + C'`, and the sum of the sizes of its terms.
        fn area(&self, z: F) -> (F, F) {
            let ([a, c], [b, d]) = (self.along_u, self.along_v);
            let (quadratic, linear) = ((a * d - b * c) * z * z, (a + d) * z);
            let one = F::one();
            (
                quadratic + linear + one,
                quadratic.abs() + linear.abs() + one,
            )
        }
    }

    /// Even numbers from -1 to 1.
    struct Numbers(Pcg64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0.next_u64() as f64 / u64::MAX as f64 * 2.0 - 1.0
        }
    }

    /// A camera, the foot (u, v) of one of its rays, and the point of that ray at a height z.
    fn example(numbers: &mut Numbers) -> ([[f64; 2]; 3], [f64; 2], [f64; 3]) {
        let slopes: [[f64; 2]; 3] = std::array::from_fn(|_| [numbers.next(), numbers.next()]);
        let [u, v] = [numbers.next(), numbers.next()].map(|n| 4.0 * n);
        let z = 4.0 * numbers.next();
        let slope = |k: usize| {
            let [s1, s2, s3] = slopes.map(|s| s[k]);
            (1.0 - u - v) * s1 + u * s2 + v * s3
        };
        (slopes, [u, v], [u + z * slope(0), v + z * slope(1), z])
    }

    #[test]
    fn the_ray_through_a_point_is_found_again() {
        // x = u + z sigma(u, v), y = v + z tau(u, v) by equation 5; this must recover the foot. The effect of rounding
        // grows as D shrinks: away from the focal locus, |D| above 0.1 of its terms.
        let mut numbers = Numbers(Pcg64::new(6, 1));
        let (mut found, mut worst, mut worst_f32) = (0, 0.0_f64, 0.0_f64);
        for _ in 0..200_000 {
            let (slopes, foot, point) = example(&mut numbers);
            let camera = LinearCamera::new(slopes);
            let (area, size) = camera.area(point[2]);
            if area.abs() < 0.1 * size {
                continue;
            }
            found += 1;
            let back = camera.foot_of(point).expect("not focal");
            let narrow = LinearCamera::new(slopes.map(|s| s.map(|v| v as f32)));
            let narrow_back = narrow.foot_of(point.map(|v| v as f32)).expect("not focal");
            for k in 0..2 {
                worst = worst.max((back[k] - foot[k]).abs());
                worst_f32 = worst_f32.max((f64::from(narrow_back[k]) - foot[k]).abs());
            }
        }
        println!("{found} cameras: f64 {worst:.1e}, f32 {worst_f32:.1e}");
        assert!(found > 150_000 && worst < 1e-9 && worst_f32 < 1e-4);
    }

    #[test]
    fn the_limit_is_where_a_moved_point_is_seen_to_go() {
        let mut numbers = Numbers(Pcg64::new(7, 1));
        for _ in 0..10_000 {
            let (slopes, _, [.., z]) = example(&mut numbers);
            let camera = LinearCamera::new(slopes);
            let (area, size) = camera.area(z);
            if area.abs() < 0.1 * size {
                continue;
            }
            let direction: [f64; 3] = std::array::from_fn(|_| numbers.next());
            let [s, t] = slopes[0];
            // The first ray meets z at (z s, z t); both sides of it differ by twice the derivative.
            let moved = |by: f64| {
                let at = [z * s, z * t, z];
                camera
                    .foot_of(std::array::from_fn(|k| at[k] + by * direction[k]))
                    .expect("not focal")
            };
            let (ahead, behind) = (moved(1e-5), moved(-1e-5));
            let limit = camera.foot_direction(z, direction);
            for k in 0..2 {
                let expected = (ahead[k] - behind[k]) / 2e-5;
                assert!((limit[k] / area - expected).abs() < 1e-6, "{limit:?}");
            }
        }
    }

    #[test]
    fn on_the_focal_locus_there_is_no_foot_but_still_a_direction() {
        // Slopes that decrease by 1/2 along u meet at height 2: everything there is seen along u.
        let camera = LinearCamera::new([[0.3, 0.1], [-0.2, 0.1], [0.3, 0.1]]);
        assert_eq!(camera.foot_of([0.6, 0.2, 2.0]), None);
        let direction = camera.foot_direction(2.0, [0.4, 0.3, 0.0]);
        assert_eq!(direction, [0.4, 0.0]);
        for height in [2.0 - 1e-9, 2.0 + 1e-9] {
            let [u, v] = camera.foot_direction(height, [0.4, 0.3, 0.0]);
            assert!((v / u).abs() < 1e-8);
        }
        // Along v alone rays do not spread, so the steps of hit points decide.
        let [u, v] = camera.foot_direction(2.0, [0.0, 0.3, 0.0]);
        assert_eq!([u, v], [0.0, 0.0]);
        assert_eq!(
            seen_by_steps([DVec3::ZERO, DVec3::Y], 0.3 * DVec3::Y),
            Some(DVec2::Y)
        );
    }

    #[test]
    fn a_pinhole_sees_as_a_perspective_does() {
        // Rays from an eye at height 2 above the plane, through its points (u, v): the camera of a picture. A point at
        // height z is seen from (0, 0, 2) at (x, y) 2 / (2 - z).
        let pinhole = LinearCamera::new([[0.0, 0.0], [-0.5, 0.0], [0.0, -0.5]]);
        let [u, v] = pinhole.foot_of([0.3, -0.7, -4.0]).unwrap();
        assert!((u - 0.1).abs() < 1e-12 && (v + 0.7 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_is_refused_or_stays_a_number_to_be_refused() {
        let ray = |start, direction| Ray { start, direction };
        let (flat, along) = (DVec3::X, DVec3::NEG_Z);
        let steps = [ray(DVec3::X, DVec3::ZERO), ray(DVec3::Y, DVec3::ZERO)];
        assert!(LocalCamera::new(ray(DVec3::ZERO, along), steps).is_some());
        assert_eq!(LocalCamera::new(ray(DVec3::ZERO, flat), steps), None);
        assert_eq!(
            LocalCamera::new(ray(DVec3::ZERO, along), [steps[0]; 2]),
            None
        );
        let broken = [ray(DVec3::NAN, DVec3::ZERO), steps[1]];
        assert_eq!(LocalCamera::new(ray(DVec3::ZERO, along), broken), None);
        assert_eq!(seen_by_steps([DVec3::NAN; 2], DVec3::X), None);
        assert_eq!(seen_by_steps([DVec3::ZERO; 2], DVec3::X), None);
    }
}
