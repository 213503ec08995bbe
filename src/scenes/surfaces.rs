//! Surfaces as zero sets of functions with explicit gradients and second derivatives.
//!
//! Shapes are on the view axis, [`Surface::DISTANCE`] from the eye, unless moved.

use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::PI;

/// Smallest step of a ray toward a surface, in pixels.
const LEAST_STEP: f64 = 0.01;

/// A surface, seen from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// `normal . (p - point) = 0`.
    Plane {
        /// A point of it.
        point: DVec3,
        /// Its unit normal.
        normal: DVec3,
    },
    /// `q . form q + 2 linear . q + constant = 0` with `q = p - center`; inside where negative.
    Quadric {
        /// The origin of q.
        center: DVec3,
        /// Symmetric.
        form: DMat3,
        /// Half the linear terms.
        linear: DVec3,
        /// F at the centre.
        constant: f64,
    },
    /// Points at distance `tube` from a circle of radius `ring` around `axis` (unit).
    Torus {
        /// The centre of the circle.
        center: DVec3,
        /// Perpendicular to its plane.
        axis: DVec3,
        /// Radius of the circle.
        ring: f64,
        /// Radius of the tube.
        tube: f64,
    },
    /// `z = base + amplitude sin(wave . (x, y))`; `wave` in radians per unit.
    SineRelief {
        /// z of the mean level.
        base: f64,
        /// Half the height of the waves.
        amplitude: f64,
        /// Wave vector, perpendicular to the crests.
        wave: DVec2,
    },
}

fn middle() -> DVec3 {
    DVec3::new(0.0, 0.0, -Surface::DISTANCE)
}

impl Surface {
    /// Distance of the shapes from the eye.
    pub const DISTANCE: f64 = 400.0;

    /// A plane through the centre, facing along `normal`.
    pub fn plane(normal: DVec3) -> Self {
        Self::Plane {
            point: middle(),
            normal: normal.normalize(),
        }
    }

    /// A ball: `|q|^2 - radius^2`.
    pub fn ball(radius: f64) -> Self {
        Self::ellipsoid(DVec3::splat(radius), DMat3::IDENTITY)
    }

    /// An ellipsoid with its half-axes along the columns of the rotation `turn`.
    ///
    /// In its own axes it is `sum (q_i / r_i)^2 - 1`, multiplied by the smallest squared half-axis, so that a ball's
    /// form is the identity.
    pub fn ellipsoid(half_axes: DVec3, turn: DMat3) -> Self {
        let unit = half_axes.min_element().powi(2);
        let own = DMat3::from_diagonal(unit / (half_axes * half_axes));
        Self::Quadric {
            center: middle(),
            form: turn * own * turn.transpose(),
            linear: DVec3::ZERO,
            constant: -unit,
        }
    }

    /// An infinite cylinder around `axis`: the squared distance to the axis is `q . (1 - a a^T) q`.
    pub fn cylinder(radius: f64, axis: DVec3) -> Self {
        let a = axis.normalize();
        Self::Quadric {
            center: middle(),
            form: DMat3::IDENTITY - outer(a, a),
            linear: DVec3::ZERO,
            constant: -radius * radius,
        }
    }

    /// The graph `z = (k_u u^2 + k_v v^2) / 2`, u at `angle` from x: a saddle if the signs differ.
    ///
    /// F = 2 z - (k_u u^2 + k_v v^2), whose gradient points to the viewer.
    pub fn saddle(k_u: f64, k_v: f64, angle: f64) -> Self {
        let u = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let v = DVec3::new(-u.y, u.x, 0.0);
        Self::Quadric {
            center: middle(),
            form: outer(u, u) * -k_u - outer(v, v) * k_v,
            linear: DVec3::Z,
            constant: 0.0,
        }
    }

    /// A torus around `axis`.
    pub fn torus(ring: f64, tube: f64, axis: DVec3) -> Self {
        Self::Torus {
            center: middle(),
            axis: axis.normalize(),
            ring,
            tube,
        }
    }

    /// Parallel waves of the given amplitude and wavelength, varying along the direction `angle`.
    pub fn sine_relief(amplitude: f64, wavelength: f64, angle: f64) -> Self {
        Self::SineRelief {
            base: -Surface::DISTANCE,
            amplitude,
            wave: DVec2::from_angle(angle) * (2.0 * PI / wavelength),
        }
    }

    /// The surface moved by `by`.
    pub fn moved(mut self, by: DVec3) -> Self {
        match &mut self {
            Self::Plane { point, .. } => *point += by,
            Self::Quadric { center, .. } | Self::Torus { center, .. } => *center += by,
            Self::SineRelief { base, .. } => {
                assert!(
                    by.truncate() == DVec2::ZERO,
                    "a relief moves along the view axis only"
                );
                *base += by.z;
            }
        }
        self
    }

    /// The surface with x negated.
    pub fn mirrored(mut self) -> Self {
        let turn = |v: &mut DVec3| v.x = -v.x;
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        match &mut self {
            Self::Plane { point, normal } => [point, normal].map(turn),
            Self::Quadric {
                center,
                form,
                linear,
                ..
            } => {
                *form = mirror * *form * mirror;
                [center, linear].map(turn)
            }
            Self::Torus { center, axis, .. } => [center, axis].map(turn),
            Self::SineRelief { wave, .. } => {
                wave.x = -wave.x;
                [(); 2]
            }
        };
        self
    }

    /// F at a point.
    pub fn value(&self, p: DVec3) -> f64 {
        match *self {
            Self::Plane { point, normal } => normal.dot(p - point),
            Self::Quadric {
                center,
                form,
                linear,
                constant,
            } => {
                let q = p - center;
                q.dot(form * q) + 2.0 * linear.dot(q) + constant
            }
            // A point at height a above the ring's plane and distance rho from the axis is on the tube if (rho - R)^2 +
            // a^2 = r^2, that is |q|^2 + R^2 - r^2 = 2 R rho; squared to remove the root: (|q|^2 + R^2 - r^2)^2 - 4 R^2
            // (|q|^2 - a^2).
            Self::Torus {
                center,
                axis,
                ring,
                tube,
            } => {
                let q = p - center;
                let s = q.length_squared() + ring * ring - tube * tube;
                s * s - 4.0 * ring * ring * (q.length_squared() - q.dot(axis).powi(2))
            }
            Self::SineRelief {
                base,
                amplitude,
                wave,
            } => p.z - base - amplitude * wave.dot(p.truncate()).sin(),
        }
    }

    /// The gradient of F and its matrix of second derivatives.
    pub fn derivatives(&self, p: DVec3) -> (DVec3, DMat3) {
        match *self {
            Self::Plane { normal, .. } => (normal, DMat3::ZERO),
            Self::Quadric {
                center,
                form,
                linear,
                ..
            } => (2.0 * (form * (p - center) + linear), form * 2.0),
            // d(s^2) = 2 s ds with ds = 2 q, so the gradient is 4 s q - 8 R^2 (q - (q . a) a), and the second
            // derivatives are 4 s + 8 q q^T - 8 R^2 (1 - a a^T).
            Self::Torus {
                center,
                axis,
                ring,
                tube,
            } => {
                let q = p - center;
                let s = q.length_squared() + ring * ring - tube * tube;
                let r2 = 8.0 * ring * ring;
                (
                    4.0 * s * q - r2 * (q - q.dot(axis) * axis),
                    DMat3::IDENTITY * (4.0 * s) + outer(q, q) * 8.0
                        - (DMat3::IDENTITY - outer(axis, axis)) * r2,
                )
            }
            Self::SineRelief {
                amplitude, wave, ..
            } => {
                let (sin, cos) = wave.dot(p.truncate()).sin_cos();
                let w = wave.extend(0.0);
                (
                    DVec3::Z - amplitude * cos * w,
                    outer(w, w) * (amplitude * sin),
                )
            }
        }
    }

    /// The first `t > 0` at which `origin + t direction` hits the surface.
    pub(super) fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        match *self {
            Self::Plane { point, normal } => {
                let t = normal.dot(point - origin) / normal.dot(direction);
                (t.is_finite() && t > 0.0).then_some(t)
            }
            // F along the ray is a t^2 + 2 b t + c. Both roots come from w = -(b + sign(b) sqrt(b^2 - ac)), which never
            // cancels, as w/a and c/w; if a is 0 the first is infinite and drops out.
            Self::Quadric {
                center,
                form,
                linear,
                constant,
            } => {
                let o = origin - center;
                let a = direction.dot(form * direction);
                let b = direction.dot(form * o) + linear.dot(direction);
                let c = o.dot(form * o) + 2.0 * linear.dot(o) + constant;
                let inside = b * b - a * c;
                let w = -(b + inside.max(0.0).sqrt().copysign(b));
                (inside > 0.0)
                    .then(|| [w / a, c / w])?
                    .into_iter()
                    .filter(|t| t.is_finite() && *t > 0.0)
                    .min_by(f64::total_cmp)
            }
            // Only the part of the ray inside the ball around the torus can hit it.
            Self::Torus {
                center,
                axis,
                ring,
                tube,
            } => {
                let o = origin - center;
                let (a, b) = (direction.length_squared(), direction.dot(o));
                let c = o.length_squared() - (ring + tube).powi(2);
                let half = (b * b - a * c).max(0.0).sqrt() / a;
                let clearance = |p: DVec3| {
                    let height = axis.dot(p - center);
                    let across = (p - center - height * axis).length();
                    (across - ring).hypot(height) - tube
                };
                self.first_crossing(origin, direction, [-b / a - half, -b / a + half], clearance)
            }
            // The slope is at most amplitude times wave number: the distance is bounded by a share of the height
            // difference.
            Self::SineRelief {
                base,
                amplitude,
                wave,
            } => {
                let reach = amplitude.abs() * (1.0 + 1e-9);
                let ends = [reach, -reach].map(|z| (base + z - origin.z) / direction.z);
                let share = (amplitude * wave.length()).hypot(1.0).recip();
                self.first_crossing(origin, direction, ends, |p| share * self.value(p))
            }
        }
    }

    /// The first `t` between the ends at which F turns from positive to negative, approached in steps of the
    /// `clearance`, a lower bound of the distance to the surface, and then bisected to the last bit. Two crossings
    /// within [`LEAST_STEP`] are missed: grazing rays, within about a millionth of a pixel of an outline.
    fn first_crossing(
        &self,
        origin: DVec3,
        direction: DVec3,
        [near, far]: [f64; 2],
        clearance: impl Fn(DVec3) -> f64,
    ) -> Option<f64> {
        let at = |t: f64| origin + t * direction;
        let (mut outside, length) = (near, direction.length());
        let mut inside = loop {
            let ahead = outside + clearance(at(outside)).max(LEAST_STEP) / length;
            if self.value(at(ahead)) < 0.0 {
                break ahead;
            }
            outside = ahead;
            if outside > far {
                return None;
            }
        };
        loop {
            let t = 0.5 * (outside + inside);
            if t <= outside || t >= inside {
                return (t > 0.0).then_some(t);
            }
            if self.value(at(t)) < 0.0 {
                inside = t;
            } else {
                outside = t;
            }
        }
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
