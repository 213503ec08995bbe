//! A batch of covered pixels and their light-independent samples, component by component, so that loops over a batch
//! vectorise.

use super::cosines::{at_most_1, positive, scalar_product};
use super::light_warping::Warp;
use super::radiance_scaling::ScalingCurve;

/// Pixels of a batch. All its planes fit the first-level cache.
pub(crate) const BATCH: usize = 128;

/// One number per pixel of a batch. Structs of these start at an address that every vector divides, and have other
/// fields last: a load across the border of two cache lines takes twice the time.
pub(crate) type Lanes = [f32; BATCH];

/// One vector per pixel of a batch.
pub(crate) type Vectors = [Lanes; 3];

/// The vector of a lane.
#[inline(always)]
pub(crate) fn at(vectors: &Vectors, lane: usize) -> [f32; 3] {
    let [x, y, z] = vectors;
    [x[lane], y[lane], z[lane]]
}

/// Sets the vector of a lane.
#[inline(always)]
pub(crate) fn put(vectors: &mut Vectors, lane: usize, vector: [f32; 3]) {
    let [x, y, z] = vectors;
    [x[lane], y[lane], z[lane]] = vector;
}

/// A vector per pixel, and its image under the inverse of the warp: the two inputs of its dot product with an unwarped
/// direction.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Axis {
    /// The vector.
    pub vector: Vectors,
    /// Its x and y multiplied by the inverse of Lambda.
    pub unwarped: [Lanes; 2],
}

/// The pixels of a batch.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub(crate) struct Pixels {
    /// Unit normals.
    pub normal: Axis,
    /// Unit directions to the eye; along z unless set otherwise.
    pub to_eye: Axis,
    /// The directions to the eye mirrored at the normal, for Phong's lobe.
    pub mirrored: Axis,
    /// Unit tangents along the grain, perpendicular to the normal.
    pub along: Axis,
    /// Unit tangents across it.
    pub across: Axis,
    /// Inverse of Lambda: xx, xy, yy.
    pub unwarp: Vectors,
    /// Its square: xx, twice xy, yy.
    pub unwarp_squared: Vectors,
    /// One over the determinant of Lambda.
    pub spread: Lanes,
    /// Hessian of the height: xx, xy, yy; convex is negative.
    pub hessian: Vectors,
    /// Scaling curves of ambient, diffuse and specular light.
    pub curves: [CurveLanes; 3],
    /// Number of lanes in use; the others hold arbitrary finite numbers.
    pub count: usize,
    /// Box around their normals.
    pub facing: Facing,
}

/// Squared length below which the grain is along the normal, and gives no tangent.
pub(crate) const SHORTEST_TANGENT: f32 = 1e-12;

/// A term of the light, by its place among [`Pixels::curves`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Term {
    Ambient,
    Diffuse,
    Specular,
}

/// Scaling curves of a batch.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct CurveLanes {
    /// See [`ScalingCurve::dark`].
    pub dark: Lanes,
    /// See [`ScalingCurve::bright`].
    pub bright: Lanes,
}

impl CurveLanes {
    /// Curves that change nothing.
    pub(crate) const FLAT: Self = Self {
        dark: [1.0; BATCH],
        bright: [1.0; BATCH],
    };

    /// The curve of lane `i`.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> ScalingCurve {
        ScalingCurve {
            dark: self.dark[i],
            bright: self.bright[i],
        }
    }

    /// Sets the curve of lane `i`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, curve: ScalingCurve) {
        self.dark[i] = curve.dark;
        self.bright[i] = curve.bright;
    }
}

/// A box containing all normals of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Facing {
    middle: [f32; 3],
    /// From the middle to the faces.
    reach: [f32; 3],
}

impl Facing {
    /// Margin of cosines for rounding.
    const MARGIN: f32 = 1e-5;

    /// The box around all lanes: numbers in lanes that are not in use only make it larger.
    #[inline(always)]
    fn of(normals: &Vectors) -> Self {
        let (mut middle, mut reach) = ([0.0; 3], [0.0; 3]);
        for ((middle, reach), values) in middle.iter_mut().zip(&mut reach).zip(normals) {
            let (low, high) = (first(values, |a, b| a < b), first(values, |a, b| a > b));
            *middle = 0.5 * (low + high);
            *reach = 0.5 * (high - low);
        }
        Self { middle, reach }
    }

    /// Whether a unit direction may be above the surface at any of the pixels.
    #[inline]
    pub(crate) fn may_see(&self, direction: [f32; 3]) -> bool {
        let reach = scalar_product(self.reach, direction.map(f32::abs));
        scalar_product(self.middle, direction) + reach > -Self::MARGIN
    }
}

/// The value that comes before all others, found in several columns at a time.
#[inline(always)]
fn first(values: &Lanes, is_before: impl Fn(f32, f32) -> bool) -> f32 {
    let sooner = |a: f32, b: f32| if is_before(b, a) { b } else { a };
    let (chunks, _) = values.as_chunks::<16>();
    let mut found = chunks[0];
    for chunk in chunks {
        for (found, &value) in found.iter_mut().zip(chunk) {
            *found = sooner(*found, value);
        }
    }
    found.into_iter().fold(found[0], sooner)
}

const ZERO: Lanes = [0.0; BATCH];

impl Axis {
    const NONE: Self = Self {
        vector: [ZERO; 3],
        unwarped: [ZERO; 2],
    };

    /// The vector of lane `i`.
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> [f32; 3] {
        at(&self.vector, i)
    }

    /// The vector of lane `i`, and its image's x and y.
    #[inline(always)]
    pub(crate) fn pair(&self, i: usize) -> ([f32; 3], [f32; 2]) {
        let [x, y] = &self.unwarped;
        (self.at(i), [x[i], y[i]])
    }

    /// Sets the vector of lane `i`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, vector: [f32; 3]) {
        put(&mut self.vector, i, vector);
    }

    /// Recomputes the images under the inverse warps.
    #[inline(always)]
    pub(crate) fn unwarp(&mut self, unwarp: &Vectors) {
        let [xx, xy, yy] = unwarp;
        let [x, y, _] = &self.vector;
        let [unwarped_x, unwarped_y] = &mut self.unwarped;
        for i in 0..BATCH {
            unwarped_x[i] = xx[i] * x[i] + xy[i] * y[i];
            unwarped_y[i] = xy[i] * x[i] + yy[i] * y[i];
        }
    }
}

impl Pixels {
    /// No pixels.
    pub(crate) const NONE: Self = Self {
        count: 0,
        normal: Axis::NONE,
        facing: Facing {
            middle: [0.0; 3],
            reach: [1.0; 3],
        },
        to_eye: Axis {
            vector: [ZERO, ZERO, [1.0; BATCH]],
            ..Axis::NONE
        },
        mirrored: Axis::NONE,
        along: Axis::NONE,
        across: Axis::NONE,
        unwarp: [ZERO; 3],
        unwarp_squared: [ZERO; 3],
        spread: ZERO,
        hessian: [ZERO; 3],
        curves: [CurveLanes::FLAT; 3],
    };

    /// The scaling curves of a term.
    #[inline(always)]
    pub(crate) fn curve(&self, term: Term) -> &CurveLanes {
        &self.curves[term as usize]
    }

    /// The inverse warp of lane `i`.
    #[inline(always)]
    pub(crate) fn inverse_warp(&self, i: usize) -> Warp {
        let [xx, xy, yy] = at(&self.unwarp, i);
        Warp { xx, xy, yy }
    }

    /// The cosine of the normal and the direction to the eye.
    #[inline(always)]
    pub(crate) fn normal_eye(&self, i: usize) -> f32 {
        let cosine = scalar_product(self.normal.at(i), self.to_eye.at(i));
        at_most_1(positive(cosine))
    }

    /// Finds the box around the normals.
    #[inline(always)]
    pub(crate) fn find_facing(&mut self) {
        self.facing = Facing::of(&self.normal.vector);
    }

    /// Sets the unit tangents, along the `grain` and across it, of the surface or of what faces the eye.
    #[inline(always)]
    pub(crate) fn set_tangents(&mut self, faces_eye: bool, grain: impl Fn(usize) -> [f32; 2]) {
        for i in 0..BATCH {
            let axis = if faces_eye {
                &self.to_eye
            } else {
                &self.normal
            };
            let n = axis.at(i);
            let [x, y] = grain(i);
            // The part of (x, y, 0) perpendicular to the normal; if that vanishes any tangent will do.
            let along = x * n[0] + y * n[1];
            let tangent = [x - along * n[0], y - along * n[1], -along * n[2]];
            let square = scalar_product(tangent, tangent);
            let inverse = 1.0 / square.max(SHORTEST_TANGENT).sqrt();
            let u = match square > SHORTEST_TANGENT {
                true => tangent.map(|t| t * inverse),
                false => [0.0, 0.0, 1.0],
            };
            self.along.set(i, u);
            let v = [
                n[1] * u[2] - n[2] * u[1],
                n[2] * u[0] - n[0] * u[2],
                n[0] * u[1] - n[1] * u[0],
            ];
            self.across.set(i, v);
        }
    }

    /// Sets the inverse warps, their squares and determinants from the Hessians, for strength `alpha`, and the images of
    /// all axes.
    #[inline(always)]
    pub(crate) fn warp_by(&mut self, alpha: f32) {
        for i in 0..BATCH {
            // The inverse is the warp of the opposite strength.
            let inverse = Warp::of(at(&self.hessian, i), -alpha);
            let Warp { xx, xy, yy } = inverse;
            put(&mut self.unwarp, i, [xx, xy, yy]);
            let square = [xx * xx + xy * xy, 2.0 * xy * (xx + yy), xy * xy + yy * yy];
            put(&mut self.unwarp_squared, i, square);
            self.spread[i] = inverse.determinant();
        }
        let axes = [&mut self.normal, &mut self.to_eye, &mut self.mirrored];
        for axis in axes.into_iter().chain([&mut self.along, &mut self.across]) {
            axis.unwarp(&self.unwarp);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions all around: a spiral from -z to z.
    fn spiral(count: usize) -> impl Iterator<Item = [f32; 3]> {
        (0..count).map(move |i| {
            let z = (2 * i + 1) as f32 / count as f32 - 1.0;
            let (angle, across) = (2.4 * i as f32, (1.0 - z * z).sqrt());
            [across * angle.cos(), across * angle.sin(), z]
        })
    }

    #[test]
    fn a_direction_is_above_what_it_is_said_to_be() {
        for axis in spiral(40) {
            let mut normals = Axis::NONE;
            let near = |i: usize, k: usize| axis[k] + 0.2 * (0.7 * i as f32 + k as f32).sin();
            for i in 0..BATCH {
                let n = [near(i, 0), near(i, 1), near(i, 2)];
                let length = scalar_product(n, n).sqrt();
                normals.set(i, n.map(|c| c / length));
            }
            let facing = Facing::of(&normals.vector);
            for direction in spiral(500) {
                let cosines = (0..BATCH).map(|i| scalar_product(normals.at(i), direction));
                let most = cosines.fold(-1.0, f32::max);
                assert!(most <= 0.0 || facing.may_see(direction), "{most}");
            }
            // The normals are within asin(0.2 sqrt 3), 20 degrees, of the axis.
            assert!(facing.may_see(axis) && !facing.may_see(axis.map(|a| -a)));
        }
    }
}
