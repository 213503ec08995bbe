//! Light turned to the form: local light alignment.
//!
//! Source: N. Mestres, R. Vergne, C. Nous, J. Thollot: Local Light Alignment for Multi-Scale Shape Depiction, Eurographics
//! 2021. From the coarsest scale to the finest the light is turned, in each pixel, toward what the detail shows of itself:
//! its normal n where it leans toward the light, else its slope, a quarter of a turn from n. The share of the way grows with
//! the angle between n and the normal b of the next coarser scale, and with how far the detail leans along the light; light
//! along a ridge, and all light on what has no detail, stays. Change: where light falls along b itself it has no azimuth
//! about it, so that it would turn to another side from pixel to pixel; there the share fades.

use super::batch::{BATCH, Lanes, Vectors};
use crate::kernel::fast_math::atan;
use std::f32::consts::FRAC_2_PI;

/// The scales of the coarser normals, sigmas in pixels; the detail of each is what the next finer one has beyond it.
pub(crate) const SIGMAS_PX: [f32; 3] = [2.0, 5.0, 12.0];

/// e^-gamma, for the gamma of 3 that bends the share of the way: with 6 forms break into patches.
const BEND: f32 = 0.049_787_07;

/// One over the sine of the angle between light and b up to which the share fades: 14 degrees.
const PER_FADE: f32 = 4.0;

/// The least length that is divided by.
const SHORTEST: f32 = 1e-9;

/// The detail at one scale: n in the plane of b and the direction that the detail leans to.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct Detail {
    /// b.
    base: Vectors,
    /// The unit direction across b that n leans to.
    lean: Vectors,
    /// Sine and cosine of the angle between n and b.
    angle: [Lanes; 2],
}

const ZERO: Lanes = [0.0; BATCH];

impl Detail {
    pub(crate) const NONE: Self = Self {
        base: [ZERO; 3],
        lean: [ZERO; 3],
        angle: [ZERO; 2],
    };

    /// The detail that `normal` has beyond `base`.
    #[inline(always)]
    pub(crate) fn find(&mut self, normal: &Vectors, base: &Vectors) {
        self.base = *base;
        let ([nx, ny, nz], [bx, by, bz]) = (normal, base);
        let [x, y, z] = &mut self.lean;
        let [sine, cosine] = &mut self.angle;
        for i in 0..BATCH {
            let along = nx[i] * bx[i] + ny[i] * by[i] + nz[i] * bz[i];
            let across = [
                nx[i] - along * bx[i],
                ny[i] - along * by[i],
                nz[i] - along * bz[i],
            ];
            let square = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
            let length = square.sqrt();
            let unit = 1.0 / length.max(SHORTEST);
            (x[i], y[i], z[i]) = (unit * across[0], unit * across[1], unit * across[2]);
            (sine[i], cosine[i]) = (length, along);
        }
    }

    /// Turns light, by lane, `strength` of the way at most.
    #[inline(always)]
    pub(crate) fn turn(&self, light: &mut Vectors, strength: f32) {
        let Self {
            base: [bx, by, bz],
            lean: [ax, ay, az],
            angle: [sine, cosine],
        } = self;
        let [x, y, z] = light;
        for i in 0..BATCH {
            let (l, a, b) = (
                [x[i], y[i], z[i]],
                [ax[i], ay[i], az[i]],
                [bx[i], by[i], bz[i]],
            );
            let (lean, up) = (dot(l, a), dot(l, b));
            let around = (1.0 - up * up).max(0.0);
            let aside = (around - lean * lean).max(0.0).sqrt();
            // 1 for light along the lean, 0 across it.
            let along = FRAC_2_PI * atan(lean.abs() / aside.max(SHORTEST));
            let fade = (PER_FADE * around.sqrt()).min(1.0);
            let share = along * sine[i] * fade;
            let share = strength * share / (BEND * (1.0 - share) + share);
            // n, or the slope that it stands on, in the plane of lean and b.
            let faces = lean >= 0.0;
            let goal_lean = if faces { sine[i] } else { -cosine[i] };
            let goal_up = if faces { cosine[i] } else { sine[i] };
            let near = (lean * goal_lean + up * goal_up).clamp(-1.0, 1.0);
            let far = (1.0 - near * near).sqrt();
            let whole = 2.0 * atan(far / (1.0 + near).max(SHORTEST));
            let [sin, cos] = sine_cosine(share * whole);
            let of_goal = sin / far.max(SHORTEST);
            let of_light = cos - near * of_goal;
            let (lean, up) = (of_goal * goal_lean, of_goal * goal_up);
            x[i] = of_light * l[0] + lean * a[0] + up * b[0];
            y[i] = of_light * l[1] + lean * a[1] + up * b[1];
            z[i] = of_light * l[2] + lean * a[2] + up * b[2];
        }
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Sine and cosine of an angle from 0 to pi, 4e-6 absolute, by the series of the sine of its half.
#[inline(always)]
fn sine_cosine(angle: f32) -> [f32; 2] {
    let half = 0.5 * angle;
    let square = half * half;
    let series = 1.0 / 120.0 + square * (-1.0 / 5040.0 + square * (1.0 / 362_880.0));
    let sine = half * (1.0 + square * (-1.0 / 6.0 + square * series));
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    [2.0 * sine * cosine, 1.0 - 2.0 * sine * sine]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Light turned by one scale of detail.
    fn turned(normal: Vec3, base: Vec3, light: Vec3, strength: f32) -> Vec3 {
        let lanes = |v: Vec3| v.to_array().map(|c| [c; BATCH]);
        let (mut detail, mut light) = (Detail::NONE, lanes(light));
        detail.find(&lanes(normal), &lanes(base));
        detail.turn(&mut light, strength);
        Vec3::new(light[0][7], light[1][7], light[2][7])
    }

    /// A direction this many degrees from z, at this azimuth.
    fn at(degrees: f32, azimuth: f32) -> Vec3 {
        let ((sin, cos), turn) = (degrees.to_radians().sin_cos(), azimuth.to_radians());
        Vec3::new(sin * turn.cos(), sin * turn.sin(), cos)
    }

    #[test]
    fn light_turns_to_what_leans_to_it_and_to_the_slope_of_what_leans_away() {
        // Detail of 30 degrees, along the light: the share is 0.5 / (e^-3 0.5 + 0.5) = 0.95257, of which a fifth. The light
        // is 15 degrees from n, or from the slope at 60 degrees on the other side: it moves by 2.8577 degrees.
        let n = at(30.0, 0.0);
        let toward = turned(n, Vec3::Z, at(45.0, 0.0), 0.2);
        assert!(
            (toward - at(45.0 - 2.8577, 0.0)).length() < 1e-5,
            "{toward}"
        );
        let away = turned(n, Vec3::Z, at(45.0, 180.0), 0.2);
        assert!((away - at(45.0 + 2.8577, 180.0)).length() < 1e-5, "{away}");
    }

    #[test]
    fn light_along_a_ridge_and_on_what_has_no_detail_stays() {
        for elevation in [5.0, 30.0, 60.0, 89.0] {
            for azimuth in [90.0, -90.0] {
                let light = at(elevation, azimuth);
                let along = turned(at(30.0, 0.0), Vec3::Z, light, 0.2);
                assert!((along - light).length() < 1e-6, "{along}");
            }
            let (n, light) = (at(20.0, 70.0), at(elevation, 10.0));
            // Rounding makes a detail of 1e-7, and e^3 of that a share.
            let smooth = turned(n, n, light, 0.2);
            assert!((smooth - light).length() < 1e-5, "{smooth}");
            assert_eq!(turned(at(40.0, 3.0), n, light, 0.0), light);
        }
    }

    /// Light that moves by a fifth of a degree about detail that does not, and detail that turns by as much under light,
    /// makes no jump: bends of the share are steep, e^3 = 20 at 0, and reach a quarter of the way of 0.2 90 degrees here.
    #[test]
    fn light_turns_without_jumps() {
        let (mut largest, steps) = (0.0_f32, 1800);
        for base in [Vec3::Z, at(35.0, 200.0)] {
            for lean in [2.0, 10.0, 30.0, 60.0] {
                let n = |i: i32| {
                    let (x, y) = base.any_orthonormal_pair();
                    let (sin, cos) = (0.2 * i as f32).to_radians().sin_cos();
                    let to = lean * std::f32::consts::PI / 180.0;
                    to.cos() * base + to.sin() * (cos * x + sin * y)
                };
                for elevation in [0.0, 1.0, 20.0, 60.0, 120.0] {
                    let light = |i: i32| at(elevation, 0.2 * i as f32);
                    for i in 0..steps {
                        let moved = turned(n(0), base, light(i), 0.2).angle_between(turned(
                            n(0),
                            base,
                            light(i + 1),
                            0.2,
                        ));
                        let leans = turned(n(i), base, light(0), 0.2).angle_between(turned(
                            n(i + 1),
                            base,
                            light(0),
                            0.2,
                        ));
                        largest = largest.max(moved).max(leans);
                    }
                }
            }
        }
        assert!(largest.to_degrees() < 1.5, "{}", largest.to_degrees());
    }

    #[test]
    fn light_keeps_its_length_whatever_the_directions() {
        for (normal, base, light) in [
            (Vec3::Z, Vec3::Z, Vec3::Z),
            (at(40.0, 0.0), Vec3::Z, Vec3::Z),
            (at(40.0, 0.0), Vec3::Z, Vec3::NEG_Z),
            (Vec3::X, Vec3::NEG_X, at(50.0, 10.0)),
            (at(90.0, 0.0), Vec3::Z, -at(90.0, 0.0)),
        ] {
            for strength in [0.2, 1.0] {
                let length = turned(normal, base, light, strength).length();
                assert!(
                    (length - 1.0).abs() < 1e-5,
                    "{normal} {base} {light}: {length}"
                );
            }
        }
    }
}
