//! Principal curvatures of the surface itself, and their directions, from the rays along its normals.
//!
//! Theory: [LA] sections 4.1 and 4.2. In the frame of a point P (z its normal) a neighbour's normal ray meets z = 0 at
//! (u, v) with the slope (sigma, tau). To first order the slopes are a linear map M of the feet, whose eigenvectors are
//! the principal directions and whose eigenvalues are the negated principal curvatures. Changes: M is computed from
//! central differences of feet and slopes, which is second order (and exact on a ball, whose rays all meet in its
//! centre), made symmetric, and its eigenvectors taken in closed form; the paper's equation 3 fails where a neighbour
//! lies along a principal direction, as all of them do on an upright cylinder. Degenerate points are detected by tests
//! that do not depend on the unit of length, and by the noise of the samples. Practice: use only neighbours on the same
//! surface, a few pixels away where normals are coarse.

pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod setting;
pub(crate) mod stage;

use glam::{DVec2, DVec3};

/// A normal ray beside the point looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalRay {
    /// Vector to a point on the ray, in view space, in any unit of length.
    pub offset: DVec3,
    /// Direction of the ray: the normal there, of any length.
    pub normal: DVec3,
}

/// The rays on either side of a point along one axis of the picture, where they exist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sides {
    /// On the side of lesser x or y (y up).
    pub before: Option<NormalRay>,
    /// On the side of greater x or y.
    pub after: Option<NormalRay>,
    /// Distance in pixels.
    pub step_px: f64,
}

/// Errors of rounding are spread evenly up to the largest: their standard deviation is this share of it.
pub(crate) const ROUNDING_DEVIATION: f64 = 0.577_350_269;

/// Noise of the samples: standard deviations of their errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Error of a component of a unit normal.
    pub normal: f64,
    /// Error of a component of an offset, in its unit of length.
    pub offset: f64,
}

/// The kind of a surface point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LocalShape {
    /// The normal does not turn measurably: no direction.
    Planar,
    /// Equal curvature in all directions: no principal direction.
    Umbilic,
    /// Curvature in one direction only, as on a cylinder.
    Parabolic,
    /// Two curvatures.
    General,
}

/// Principal curvatures of a surface, the larger in size first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PrincipalCurvatures {
    /// The kind of the point; without a direction, the given ones are arbitrary.
    pub form: LocalShape,
    /// Curvatures per unit of length; convex is negative.
    pub curvatures: [f64; 2],
    /// Unit directions in view space, tangent to the surface, each equal to its opposite.
    pub directions: [DVec3; 2],
}

impl PrincipalCurvatures {
    /// The direction of the curvature larger in size, if the point has one.
    pub(crate) fn direction(&self) -> Option<DVec3> {
        match self.form {
            LocalShape::Planar | LocalShape::Umbilic => None,
            LocalShape::Parabolic | LocalShape::General => Some(self.directions[0]),
        }
    }
}

/// Turn of the normal, in radians per pixel, below which a surface is planar: 6 degrees over a thousand pixels,
/// visually flat. Higher values flatten large gentle shapes; lower ones follow the rounding of normals that were stored
/// exactly but computed in f32.
pub(crate) const PLANAR_TURN: f64 = 1e-4;

/// Difference of the curvatures over their sum below which a point is umbilic; its square is the
/// discriminant of [LA] equation 1 over B^2.
pub(crate) const UMBILIC: f64 = 1e-2;

/// The lesser curvature over the greater below which it is 0.
pub(crate) const PARABOLIC: f64 = 1e-3;

/// Standard deviations by which the curvatures must differ. At 3 the rounding of a ball's normals to 8 bits passes for
/// a direction here and there; from 6 to 10, where steps may widen, the 95th percentile of the error on an ellipsoid of
/// 256 px still falls from 8 to 6 degrees.
pub(crate) const CERTAINTY: f64 = 10.0;

/// Cosine of the angle between two normals below which their rays are not compared: slopes run away.
pub(crate) const MIN_COSINE: f64 = 0.1;

/// Least sine between the two differences of feet: below it the surface is seen edge-on.
pub(crate) const MIN_SINE: f64 = 1e-6;

/// Smallest z, out of the picture's plane, of the sum of a unit normal and the unit direction to the viewer.
pub(crate) const MIN_UPRIGHT: f64 = 1e-6;

/// Principal curvatures at a point with the normal `normal`, from the rays beside it along x and y.
///
/// `None` if an axis has no usable ray, or the surface is seen edge-on. With rays on both sides of each axis the error
/// is of second order in the step; a missing one is replaced by the point's own, at first order.
#[inline]
pub(crate) fn principal_curvatures(
    normal: DVec3,
    [along_x, along_y]: [Sides; 2],
    noise: Noise,
) -> Option<PrincipalCurvatures> {
    let local = Local::at(normal)?;
    let (x, y) = (local.difference(&along_x)?, local.difference(&along_y)?);
    let Slopes {
        mean,
        half_difference,
        off,
        area,
        spread,
    } = Slopes::of(&x, &y)?;
    let half_spread = DVec2::new(half_difference, off).length();
    let found = [mean + half_spread, mean - half_spread];
    let first = local.eigenvector(half_difference, off, half_spread);
    let second = local.normal.cross(first);
    let (curvatures, directions) = if mean >= 0.0 {
        (found, [first, second])
    } else {
        ([found[1], found[0]], [second, first])
    };
    let turn = (x.slope.length() / x.samples).max(y.slope.length() / y.samples);
    let sample_error = noise.normal + curvatures[0].abs() * noise.offset;
    // Each slope errs by sqrt(2) of a sample, and the half difference of two entries of S U^-1 by that
    // over sqrt(2), times the size of U^-1, which is sqrt(2) where U is the identity.
    let error = CERTAINTY * sample_error * (0.5 * spread).sqrt() / area.abs();
    let [larger, lesser] = curvatures;
    let form = if turn < PLANAR_TURN || larger.abs() <= error {
        LocalShape::Planar
    } else if half_spread <= (UMBILIC * mean.abs()).max(error) {
        LocalShape::Umbilic
    } else if lesser.abs() < PARABOLIC * larger.abs() {
        LocalShape::Parabolic
    } else {
        LocalShape::General
    };
    let lesser = if form == LocalShape::Parabolic {
        0.0
    } else {
        lesser
    };
    Some(PrincipalCurvatures {
        form,
        curvatures: [larger, lesser],
        directions,
    })
}

/// Curvatures of a surface as one tensor, in the frame that coincides with the picture's when the normal is rotated to
/// the viewer by the shortest way: frames of neighbours are nearly equal, so tensors can be averaged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CurvatureTensor {
    /// Mean of the principal curvatures, per unit of length; convex is negative.
    pub mean: f64,
    /// Half their difference, toward twice the angle of the larger one's direction.
    pub deviator: DVec2,
}

/// The tensor of curvature at a point with the unit normal `normal`, from the rays beside it along x and y.
///
/// `None` as for [`principal_curvatures`], and where the normal points straight away from the viewer.
#[inline]
pub(crate) fn curvature_tensor(
    normal: DVec3,
    [along_x, along_y]: [Sides; 2],
) -> Option<CurvatureTensor> {
    let local = Local {
        tangents: upright_tangents(normal)?,
        normal,
    };
    let slopes = Slopes::of(&local.difference(&along_x)?, &local.difference(&along_y)?)?;
    Some(CurvatureTensor {
        mean: slopes.mean,
        deviator: DVec2::new(slopes.half_difference, slopes.off),
    })
}

/// The tangents that become the picture's x and y when the unit normal is rotated to the viewer by the shortest way;
/// `None` if it points straight away.
#[inline]
pub(crate) fn upright_tangents(normal: DVec3) -> Option<[DVec3; 2]> {
    let both = normal + DVec3::Z;
    let faces = both.z > MIN_UPRIGHT;
    faces.then(|| [DVec3::X, DVec3::Y].map(|axis| axis - axis.dot(normal) / both.z * both))
}

/// M, made symmetric, and negated: its eigenvalues are the curvatures.
pub(crate) struct Slopes {
    pub(crate) mean: f64,
    pub(crate) half_difference: f64,
    pub(crate) off: f64,
    /// The area between the feet, and the sum of their squares.
    pub(crate) area: f64,
    pub(crate) spread: f64,
}

impl Slopes {
    #[inline]
    pub(crate) fn of(x: &Difference, y: &Difference) -> Option<Self> {
        let (u, v) = (x.foot, y.foot);
        let area = u.perp_dot(v);
        let spread = u.length_squared() + v.length_squared();
        let is_square_on = area.abs() > MIN_SINE * spread;
        if !is_square_on {
            return None;
        }
        // M U = S: the columns of U are feet, those of S slopes. Height above the tangent plane decreases where a ray
        // leans outward, so its second derivatives are -M.
        let column_x = (y.slope * u.y - x.slope * v.y) / area;
        let column_y = (x.slope * v.x - y.slope * u.x) / area;
        Some(Self {
            mean: 0.5 * (column_x.x + column_y.y),
            half_difference: 0.5 * (column_x.x - column_y.y),
            off: 0.5 * (column_x.y + column_y.x),
            area,
            spread,
        })
    }
}

/// The frame of a point: two tangents and the normal.
pub(crate) struct Local {
    pub(crate) tangents: [DVec3; 2],
    pub(crate) normal: DVec3,
}

/// Feet and slopes of two rays, one less the other, or of one ray in the point's own frame.
pub(crate) struct Difference {
    pub(crate) foot: DVec2,
    pub(crate) slope: DVec2,
    pub(crate) samples: f64,
}

impl Local {
    #[inline(always)]
    fn at(normal: DVec3) -> Option<Self> {
        let normal = normal.try_normalize()?;
        let (a, b) = normal.any_orthonormal_pair();
        Some(Self {
            tangents: [a, b],
            normal,
        })
    }

    /// Foot and slope of a ray; `None` if it leans too far.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &NormalRay) -> Option<(DVec2, DVec2)> {
        let along = |v: DVec3| DVec2::new(self.tangents[0].dot(v), self.tangents[1].dot(v));
        let (rise, up) = (self.normal.dot(ray.offset), self.normal.dot(ray.normal));
        let lean = along(ray.normal);
        let leans_little = up > MIN_COSINE * (lean.length_squared() + up * up).sqrt();
        let slope = lean / up;
        let foot = along(ray.offset) - rise * slope;
        (leans_little && foot.is_finite() && slope.is_finite()).then_some((foot, slope))
    }

    /// Difference of the rays after and before; the point's own ray, all zero, replaces a missing one.
    #[inline(always)]
    fn difference(&self, sides: &Sides) -> Option<Difference> {
        let ray = |side: &Option<NormalRay>| side.as_ref().and_then(|ray| self.ray(ray));
        let (before, after) = (ray(&sides.before), ray(&sides.after));
        let samples =
            sides.step_px * f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
        if samples == 0.0 {
            return None;
        }
        let own = (DVec2::ZERO, DVec2::ZERO);
        let (before, after) = (before.unwrap_or(own), after.unwrap_or(own));
        Some(Difference {
            foot: after.0 - before.0,
            slope: after.1 - before.1,
            samples,
        })
    }

    /// The tangent that belongs to the larger eigenvalue of [m + d, o; o, m - d], q = |(d, o)|: along
    /// (d + q, o) or (o, q - d), whichever does not cancel.
    fn eigenvector(&self, d: f64, o: f64, q: f64) -> DVec3 {
        let v = if d >= 0.0 {
            DVec2::new(d + q, o)
        } else {
            DVec2::new(o, q - d)
        };
        let v = v.try_normalize().unwrap_or(DVec2::X);
        self.tangents[0] * v.x + self.tangents[1] * v.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Noise = Noise {
        normal: 1e-9,
        offset: 0.0,
    };

    /// Rays half a unit to each side of the origin on the height `(xx x^2 + 2 xy x y + yy y^2) / 2`, rotated by `turn`.
    fn sides_of([xx, xy, yy]: [f64; 3], turn: glam::DMat3) -> (DVec3, [Sides; 2]) {
        let ray = |x: f64, y: f64| NormalRay {
            offset: turn * DVec3::new(x, y, 0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y)),
            normal: turn * DVec3::new(-xx * x - xy * y, -xy * x - yy * y, 1.0),
        };
        let sides = |x: f64, y: f64| Sides {
            before: Some(ray(-x, -y)),
            after: Some(ray(x, y)),
            step_px: 1.0,
        };
        (turn * DVec3::Z, [sides(0.5, 0.0), sides(0.0, 0.5)])
    }

    fn curvatures(height: [f64; 3]) -> PrincipalCurvatures {
        let turn = glam::DMat3::from_rotation_x(0.7) * glam::DMat3::from_rotation_y(-0.4);
        let (normal, sides) = sides_of(height, turn);
        let mut found = principal_curvatures(normal, sides, EXACT).unwrap();
        found.directions = found.directions.map(|t| turn.transpose() * t);
        found
    }

    #[test]
    fn curvatures_are_those_of_the_height_convex_negative() {
        // A convex ridge, -0.02 along 30 degrees, +0.005 across it: slopes of 0.01 bring rays off by
        // their square, 1e-4.
        let (c, s) = (0.75_f64.sqrt(), 0.5);
        let (u, v) = (-0.02, 0.005);
        let found = curvatures([
            u * c * c + v * s * s,
            (u - v) * c * s,
            u * s * s + v * c * c,
        ]);
        assert_eq!(found.form, LocalShape::General);
        assert!((found.curvatures[0] / u - 1.0).abs() < 1e-4, "{found:?}");
        assert!((found.curvatures[1] / v - 1.0).abs() < 1e-4, "{found:?}");
        assert!(found.directions[0].cross(DVec3::new(c, s, 0.0)).length() < 1e-4);
        assert!(found.directions[1].cross(DVec3::new(-s, c, 0.0)).length() < 1e-4);
    }

    #[test]
    fn a_ball_is_exact_at_any_step() {
        // The rays of a ball of radius 2 meet in its middle: at 40 degrees to each side too.
        let ray = |angle: f64, axis: DVec3| NormalRay {
            offset: 2.0 * (angle.sin() * axis + (angle.cos() - 1.0) * DVec3::Z),
            normal: angle.sin() * axis + angle.cos() * DVec3::Z,
        };
        let sides = |axis| Sides {
            before: Some(ray(-0.7, axis)),
            after: Some(ray(0.7, axis)),
            step_px: 1.0,
        };
        let found = principal_curvatures(DVec3::Z, [sides(DVec3::X), sides(DVec3::Y)], EXACT);
        let found = found.unwrap();
        assert_eq!(found.form, LocalShape::Umbilic);
        assert!(
            found.curvatures.iter().all(|k| (k + 0.5).abs() < 1e-12),
            "{found:?}"
        );
        assert_eq!(found.direction(), None);
    }

    #[test]
    fn every_degenerate_form_is_told_in_any_unit_of_length() {
        let forms = [
            ([0.0, 0.0, 0.0], LocalShape::Planar),
            ([-0.02, 0.0, -0.02], LocalShape::Umbilic),
            ([0.0, 0.0, -0.02], LocalShape::Parabolic),
            ([0.03, 0.0, -0.02], LocalShape::General),
            // Curvatures of one size and opposite signs are no umbilic.
            ([0.02, 0.0, -0.02], LocalShape::General),
        ];
        for (height, form) in forms {
            let (normal, plain) = sides_of(height, glam::DMat3::IDENTITY);
            for unit in [1e-6, 1.0, 1e6] {
                let scaled = plain.map(|sides| Sides {
                    before: sides.before.map(|r| NormalRay {
                        offset: r.offset * unit,
                        ..r
                    }),
                    after: sides.after.map(|r| NormalRay {
                        offset: r.offset * unit,
                        ..r
                    }),
                    ..sides
                });
                let found = principal_curvatures(normal, scaled, EXACT).unwrap();
                assert_eq!(found.form, form, "{height:?} in units of {unit}: {found:?}");
            }
        }
    }

    #[test]
    fn differences_within_the_noise_are_no_direction() {
        // Half the difference of the slopes is 0.005, the greater 0.02; feet are a unit apart, so the former has the
        // noise of the normals, and ten times that is required.
        let (normal, sides) = sides_of([-0.02, 0.0, -0.01], glam::DMat3::IDENTITY);
        let form = |normal_noise| {
            let noise = Noise {
                normal: normal_noise,
                offset: 0.0,
            };
            principal_curvatures(normal, sides, noise).unwrap().form
        };
        assert_eq!(form(1e-4), LocalShape::General);
        assert_eq!(form(4e-4), LocalShape::General);
        assert_eq!(form(6e-4), LocalShape::Umbilic);
        assert_eq!(form(1.9e-3), LocalShape::Umbilic);
        assert_eq!(form(2.1e-3), LocalShape::Planar);
    }

    #[test]
    fn one_side_serves_and_none_does_not() {
        let (normal, mut sides) = sides_of([-0.02, 0.0, 0.005], glam::DMat3::IDENTITY);
        sides[0].before = None;
        let found = principal_curvatures(normal, sides, EXACT).unwrap();
        assert!(
            (found.curvatures[0] / -0.02 - 1.0).abs() < 0.01,
            "{found:?}"
        );
        sides[0].after = None;
        assert_eq!(principal_curvatures(normal, sides, EXACT), None);
    }

    #[test]
    fn hostile_rays_give_nothing() {
        let (normal, sides) = sides_of([-0.02, 0.0, 0.005], glam::DMat3::IDENTITY);
        assert_eq!(principal_curvatures(DVec3::ZERO, sides, EXACT), None);
        for (offset, lean) in [
            (DVec3::NAN, DVec3::Z),
            (DVec3::INFINITY, DVec3::Z),
            (DVec3::X, DVec3::ZERO),
            (DVec3::X, DVec3::NAN),
            (DVec3::X, DVec3::NEG_Z),
            (DVec3::X, DVec3::X),
        ] {
            let ray = Some(NormalRay {
                offset,
                normal: lean,
            });
            let bad = Sides {
                before: ray,
                after: ray,
                step_px: 1.0,
            };
            assert_eq!(principal_curvatures(normal, [bad, sides[1]], EXACT), None);
        }
        // Both axes of the picture along one line of the surface.
        assert_eq!(principal_curvatures(normal, [sides[0]; 2], EXACT), None);
    }
}
