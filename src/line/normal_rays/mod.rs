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

pub(crate) mod bundle;
pub(crate) mod cpu;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod setting;
pub(crate) mod stage;

use glam::{BVec2, DVec2, DVec3};

/// A normal ray beside the point looked at.
#[derive(Debug, Default, Clone, Copy, PartialEq)]
pub(crate) struct NormalRay {
    /// Whether there is one. A flag, so that loops over pixels have no branches.
    pub is_there: bool,
    /// Vector to a point on the ray, in view space, in any unit of length.
    pub offset: DVec3,
    /// Direction of the ray: the normal there, of any length.
    pub normal: DVec3,
}

impl NormalRay {
    /// The ray along `normal` at `offset`.
    #[inline(always)]
    pub(crate) fn new(offset: DVec3, normal: DVec3) -> Self {
        Self {
            is_there: true,
            offset,
            normal,
        }
    }
}

/// The rays on either side of a point along one axis of the picture, where they exist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sides {
    /// On the side of lesser x or y (y up).
    pub before: NormalRay,
    /// On the side of greater x or y.
    pub after: NormalRay,
    /// Distance in pixels.
    pub step_px: f64,
}

impl Sides {
    /// The rays `step_px` away, where there are such.
    #[inline]
    pub(crate) fn of(rays: [Option<NormalRay>; 2], step_px: f64) -> Self {
        let [before, after] = rays.map(Option::unwrap_or_default);
        Self {
            before,
            after,
            step_px,
        }
    }
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
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LocalShape {
    /// Not known: an axis has no usable ray, or the surface is seen edge-on.
    #[default]
    Unknown,
    /// The normal does not turn measurably: no direction.
    Planar,
    /// Equal curvature in all directions: no principal direction.
    Umbilic,
    /// Curvature in one direction only, as on a cylinder.
    Parabolic,
    /// Two curvatures.
    General,
}

impl LocalShape {
    /// Whether the larger curvature has a direction.
    #[inline(always)]
    pub(crate) fn has_direction(self) -> bool {
        (self == Self::Parabolic) | (self == Self::General)
    }
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
        self.form.has_direction().then_some(self.directions[0])
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
const MIN_UPRIGHT: f64 = 1e-6;

/// Principal curvatures at a point with the normal `normal`, from the rays beside it along x and y.
///
/// With rays on both sides of each axis the error is of second order in the step; a missing one is replaced by the
/// point's own, at first order. There are no branches, so that loops over pixels widen; squares are compared and
/// reciprocals shared, because divisions and roots take most of the time.
#[inline(always)]
pub(crate) fn principal_curvatures(
    normal: DVec3,
    [along_x, along_y]: [Sides; 2],
    noise: Noise,
) -> PrincipalCurvatures {
    let (is_normal, local) = Local::at(normal);
    let (x, y) = (local.difference(&along_x), local.difference(&along_y));
    let RaySlopes {
        is_there,
        mean,
        half_difference,
        off,
        area,
        spread,
    } = RaySlopes::of(&x, &y);
    let half_spread = DVec2::new(half_difference, off).length();
    let is_greater_larger = mean >= 0.0;
    let (greater, less) = (mean + half_spread, mean - half_spread);
    let larger = if is_greater_larger { greater } else { less };
    let lesser = if is_greater_larger { less } else { greater };
    let axis = eigenvector(half_difference, off, half_spread);
    let axis = DVec2::select(BVec2::splat(is_greater_larger), axis, axis.perp());
    let sample_error = noise.normal + larger.abs() * noise.offset;
    // Each slope errs by sqrt(2) of a sample, and the half difference of two entries of S U^-1 by that
    // over sqrt(2), times the size of U^-1, which is sqrt(2) where U is the identity.
    let error = CERTAINTY * sample_error * (0.5 * spread).sqrt() / area.abs();
    let is_planar = x.is_flat() & y.is_flat() | (larger.abs() <= error);
    let is_umbilic = half_spread <= (UMBILIC * mean.abs()).max(error);
    let is_parabolic = lesser.abs() < PARABOLIC * larger.abs();
    let form = if !(is_normal & is_there) {
        LocalShape::Unknown
    } else if is_planar {
        LocalShape::Planar
    } else if is_umbilic {
        LocalShape::Umbilic
    } else if is_parabolic {
        LocalShape::Parabolic
    } else {
        LocalShape::General
    };
    let lesser = if form == LocalShape::Parabolic {
        0.0
    } else {
        lesser
    };
    PrincipalCurvatures {
        form,
        curvatures: [larger, lesser],
        directions: [local.tangent(axis), local.tangent(axis.perp())],
    }
}

/// The tangents that become the picture's x and y when the unit normal is rotated to the viewer by the shortest way, and
/// whether there are any: it may point straight away.
#[inline(always)]
pub(crate) fn upright(normal: DVec3) -> (bool, [DVec3; 2]) {
    let both = normal + DVec3::Z;
    let tangent = |axis: DVec3| axis - axis.dot(normal) / both.z * both;
    (both.z > MIN_UPRIGHT, [tangent(DVec3::X), tangent(DVec3::Y)])
}

/// M, made symmetric, and negated: its eigenvalues are the curvatures.
pub(crate) struct RaySlopes {
    /// Whether both axes have a usable ray and the surface is not seen edge-on.
    pub(crate) is_there: bool,
    pub(crate) mean: f64,
    pub(crate) half_difference: f64,
    pub(crate) off: f64,
    /// The area between the feet, and the sum of their squares.
    pub(crate) area: f64,
    pub(crate) spread: f64,
}

impl RaySlopes {
    #[inline(always)]
    pub(crate) fn of(x: &Difference, y: &Difference) -> Self {
        let (u, v) = (x.foot, y.foot);
        let area = u.perp_dot(v);
        let spread = u.length_squared() + v.length_squared();
        let is_square_on = area.abs() > MIN_SINE * spread;
        // M U = S: the columns of U are feet, those of S slopes. Height above the tangent plane decreases where a ray
        // leans outward, so its second derivatives are -M.
        let over_area = 1.0 / area;
        let column_x = (y.slope * u.y - x.slope * v.y) * over_area;
        let column_y = (x.slope * v.x - y.slope * u.x) * over_area;
        Self {
            is_there: (x.samples > 0.0) & (y.samples > 0.0) & is_square_on,
            mean: 0.5 * (column_x.x + column_y.y),
            half_difference: 0.5 * (column_x.x - column_y.y),
            off: 0.5 * (column_x.y + column_y.x),
            area,
            spread,
        }
    }
}

/// The frame of a point: two tangents and the normal.
pub(crate) struct Local {
    pub(crate) tangents: [DVec3; 2],
    pub(crate) normal: DVec3,
}

/// Where a ray meets the plane of the point's tangents, and its slope there; both 0 without a ray.
pub(crate) struct Foot {
    pub(crate) is_there: bool,
    pub(crate) foot: DVec2,
    pub(crate) slope: DVec2,
}

/// Feet and slopes of two rays, one less the other, or of one ray in the point's own frame.
pub(crate) struct Difference {
    pub(crate) foot: DVec2,
    pub(crate) slope: DVec2,
    /// Pixels between both; 0 without any ray.
    pub(crate) samples: f64,
}

impl Difference {
    /// Whether the normal does not turn measurably.
    #[inline(always)]
    fn is_flat(&self) -> bool {
        let least = PLANAR_TURN * self.samples;
        self.slope.length_squared() < least * least
    }
}

impl Local {
    /// The frame of a point with this normal, and whether it is one.
    #[inline(always)]
    fn at(normal: DVec3) -> (bool, Self) {
        let over_length = normal.length_recip();
        let normal = normal * over_length;
        let (a, b) = normal.any_orthonormal_pair();
        let local = Self {
            tangents: [a, b],
            normal,
        };
        ((over_length > 0.0) & (over_length < f64::INFINITY), local)
    }

    /// Foot and slope of a ray; none if it leans too far.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &NormalRay) -> Foot {
        let along = |v: DVec3| DVec2::new(self.tangents[0].dot(v), self.tangents[1].dot(v));
        let (rise, up) = (self.normal.dot(ray.offset), self.normal.dot(ray.normal));
        let lean = along(ray.normal);
        let least_square = MIN_COSINE * MIN_COSINE * (lean.length_squared() + up * up);
        let leans_little = (up > 0.0) & (up * up > least_square);
        let slope = lean * (1.0 / up);
        let foot = along(ray.offset) - rise * slope;
        // A sum that is finite has no term that is not.
        let sizes = foot.abs() + slope.abs();
        let is_there = ray.is_there & leans_little & (sizes.x + sizes.y < f64::INFINITY);
        let kept = |v: DVec2| DVec2::select(BVec2::splat(is_there), v, DVec2::ZERO);
        Foot {
            is_there,
            foot: kept(foot),
            slope: kept(slope),
        }
    }

    /// Difference of the rays after and before; the point's own ray, all zero, replaces a missing one.
    #[inline(always)]
    pub(crate) fn difference(&self, sides: &Sides) -> Difference {
        let (before, after) = (self.ray(&sides.before), self.ray(&sides.after));
        let steps = |side: &Foot| if side.is_there { sides.step_px } else { 0.0 };
        Difference {
            foot: after.foot - before.foot,
            slope: after.slope - before.slope,
            samples: steps(&before) + steps(&after),
        }
    }

    /// The tangent with these coordinates.
    #[inline(always)]
    fn tangent(&self, at: DVec2) -> DVec3 {
        self.tangents[0] * at.x + self.tangents[1] * at.y
    }
}

/// The unit eigenvector of the larger eigenvalue of [m + d, o; o, m - d], q = |(d, o)|: along (d + q, o) or (o, q - d),
/// whichever does not cancel.
#[inline(always)]
fn eigenvector(d: f64, o: f64, q: f64) -> DVec2 {
    let is_ahead = d >= 0.0;
    let v = DVec2::new(
        if is_ahead { d + q } else { o },
        if is_ahead { o } else { q - d },
    );
    v * v.length_recip()
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
        let ray = |x: f64, y: f64| {
            let height = 0.5 * (xx * x * x + 2.0 * xy * x * y + yy * y * y);
            let normal = DVec3::new(-xx * x - xy * y, -xy * x - yy * y, 1.0);
            NormalRay::new(turn * DVec3::new(x, y, height), turn * normal)
        };
        let sides = |x: f64, y: f64| Sides {
            before: ray(-x, -y),
            after: ray(x, y),
            step_px: 1.0,
        };
        (turn * DVec3::Z, [sides(0.5, 0.0), sides(0.0, 0.5)])
    }

    fn curvatures(height: [f64; 3]) -> PrincipalCurvatures {
        let turn = glam::DMat3::from_rotation_x(0.7) * glam::DMat3::from_rotation_y(-0.4);
        let (normal, sides) = sides_of(height, turn);
        let mut found = principal_curvatures(normal, sides, EXACT);
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
        let ray = |angle: f64, axis: DVec3| {
            let normal = angle.sin() * axis + angle.cos() * DVec3::Z;
            NormalRay::new(2.0 * (normal - DVec3::Z), normal)
        };
        let sides = |axis| Sides {
            before: ray(-0.7, axis),
            after: ray(0.7, axis),
            step_px: 1.0,
        };
        let found = principal_curvatures(DVec3::Z, [sides(DVec3::X), sides(DVec3::Y)], EXACT);
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
                    before: NormalRay::new(sides.before.offset * unit, sides.before.normal),
                    after: NormalRay::new(sides.after.offset * unit, sides.after.normal),
                    ..sides
                });
                let found = principal_curvatures(normal, scaled, EXACT);
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
            principal_curvatures(normal, sides, noise).form
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
        sides[0].before = NormalRay::default();
        let found = principal_curvatures(normal, sides, EXACT);
        assert!(
            (found.curvatures[0] / -0.02 - 1.0).abs() < 0.01,
            "{found:?}"
        );
        sides[0].after = NormalRay::default();
        let found = principal_curvatures(normal, sides, EXACT);
        assert_eq!(found.form, LocalShape::Unknown);
    }

    #[test]
    fn hostile_rays_give_nothing() {
        let (normal, sides) = sides_of([-0.02, 0.0, 0.005], glam::DMat3::IDENTITY);
        let form = |normal, sides| principal_curvatures(normal, sides, EXACT).form;
        assert_eq!(form(DVec3::ZERO, sides), LocalShape::Unknown);
        for (offset, lean) in [
            (DVec3::NAN, DVec3::Z),
            (DVec3::INFINITY, DVec3::Z),
            (DVec3::X, DVec3::ZERO),
            (DVec3::X, DVec3::NAN),
            (DVec3::X, DVec3::NEG_Z),
            (DVec3::X, DVec3::X),
        ] {
            let ray = NormalRay::new(offset, lean);
            let bad = Sides {
                before: ray,
                after: ray,
                step_px: 1.0,
            };
            assert_eq!(form(normal, [bad, sides[1]]), LocalShape::Unknown);
        }
        // Both axes of the picture along one line of the surface.
        assert_eq!(form(normal, [sides[0]; 2]), LocalShape::Unknown);
    }
}
