//! A batch of covered pixels and their light-independent samples, component by component, so that loops over a batch
//! vectorise.

use super::cosines::scalar_product;
use super::light_warping::{MOST_BRIGHTENED, WarpParts, factor};
use super::radiance_scaling::ScalingCurve;

/// Pixels of a batch. All its planes fit the first-level cache.
pub(crate) const BATCH: usize = 128;

/// One number per pixel of a batch. Structs of these start at an address that every vector divides, and have other
/// fields last: a load across the border of two cache lines takes twice the time.
pub(crate) type Lanes = [f32; BATCH];

/// One vector per pixel of a batch.
pub(crate) type Vectors = [Lanes; 3];

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
pub(crate) struct LitPixels {
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
    /// What a coat shows toward the eye; set for coated surfaces only.
    pub coat: CoatLanes,
    /// Inverse of Lambda: xx, xy, yy.
    pub unwarp: Vectors,
    /// Its square: xx, twice xy, yy.
    pub unwarp_squared: Vectors,
    /// One over the determinant of Lambda.
    pub spread: Lanes,
    /// Hessian of the height: xx, xy, yy; convex is negative.
    pub hessian: Vectors,
    /// Scaling curves, indexed by [`LitPixels::curve_of`].
    pub curves: [CurveLanes; 3],
    /// Index of the curve of ambient, diffuse and specular light: terms of equal magnitude share one.
    pub curve_of: [usize; 3],
    /// Number of lanes in use; the others hold arbitrary finite numbers.
    pub count: usize,
    /// Box around their normals.
    pub facing: Facing,
}

/// Squared length below which the grain is along the normal, and gives no tangent.
pub(crate) const SHORTEST_TANGENT: f32 = 1e-12;

/// The curve among [`LitPixels::curves`] that scales a term.
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

/// The eye of every pixel as the lobes of a coated surface see it.
#[derive(Debug, Clone)]
#[repr(align(64))]
pub(crate) struct CoatLanes {
    /// The components of the direction to the eye along the grain and across it.
    pub eye: [Lanes; 2],
    /// One over the cosine of the normal and the direction to the eye.
    pub per_cosine: Lanes,
    /// Share of the light in the base that leaves toward the eye.
    pub base: Lanes,
}

impl CoatLanes {
    const NONE: Self = Self {
        eye: [ZERO; 2],
        per_cosine: ZERO,
        base: ZERO,
    };
}

/// A box containing all normals of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Facing {
    middle: [f32; 3],
    /// From the middle to the faces.
    reach: [f32; 3],
}

/// Pixels of a batch for which a direction is above the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Above {
    /// None.
    Nowhere,
    /// Possibly some.
    Somewhere,
    /// All, by a wide margin: no warp can brighten it beyond the limit.
    Everywhere,
}

impl Facing {
    /// The box that contains every normal.
    pub(crate) const ANYWHERE: Self = Self {
        middle: [0.0; 3],
        reach: [1.0; 3],
    };

    /// Margin of cosines for rounding.
    const MARGIN: f32 = 1e-5;

    /// Cosines above this are never limited by [`MOST_BRIGHTENED`], since no cosine exceeds 1.
    const HIGH: f32 = 1.0 / MOST_BRIGHTENED + Self::MARGIN;

    /// The box around the first `count` normals.
    #[inline(always)]
    pub(crate) fn of(normals: &Vectors, count: usize) -> Self {
        let (mut middle, mut reach) = ([0.0; 3], [0.0; 3]);
        for ((middle, reach), values) in middle.iter_mut().zip(&mut reach).zip(normals) {
            let values = &values[..count];
            let (low, high) = (first(values, |a, b| a < b), first(values, |a, b| a > b));
            *middle = 0.5 * (low + high);
            *reach = 0.5 * (high - low);
        }
        Self { middle, reach }
    }

    /// For which pixels a unit direction is above the surface.
    #[inline]
    pub(crate) fn above(&self, direction: [f32; 3]) -> Above {
        let middle = scalar_product(self.middle, direction);
        let [x, y, z] = direction;
        let reach = scalar_product(self.reach, [x.abs(), y.abs(), z.abs()]);
        if middle + reach <= -Self::MARGIN {
            Above::Nowhere
        } else if middle - reach >= Self::HIGH {
            Above::Everywhere
        } else {
            Above::Somewhere
        }
    }
}

/// Independent partial results, where the order of operations does not matter.
const SIDE_BY_SIDE: usize = 16;

/// The value that comes before all others.
#[inline(always)]
fn first(values: &[f32], is_before: impl Fn(f32, f32) -> bool) -> f32 {
    let mut found = [values[0]; SIDE_BY_SIDE];
    let (chunks, rest) = values.as_chunks::<SIDE_BY_SIDE>();
    let sooner = |a: f32, b: f32| if is_before(b, a) { b } else { a };
    for chunk in chunks {
        for i in 0..SIDE_BY_SIDE {
            found[i] = sooner(found[i], chunk[i]);
        }
    }
    for (found, &value) in found.iter_mut().zip(rest) {
        *found = sooner(*found, value);
    }
    for half in [8, 4, 2, 1] {
        for i in 0..half {
            found[i] = sooner(found[i], found[i + half]);
        }
    }
    found[0]
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
        [self.vector[0][i], self.vector[1][i], self.vector[2][i]]
    }

    /// Sets the vector of lane `i`.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, vector: [f32; 3]) {
        self.vector[0][i] = vector[0];
        self.vector[1][i] = vector[1];
        self.vector[2][i] = vector[2];
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

impl LitPixels {
    /// No pixels.
    pub(crate) fn new() -> Self {
        Self {
            count: 0,
            normal: Axis::NONE,
            facing: Facing::ANYWHERE,
            to_eye: Axis {
                vector: [ZERO, ZERO, [1.0; BATCH]],
                ..Axis::NONE
            },
            mirrored: Axis::NONE,
            along: Axis::NONE,
            across: Axis::NONE,
            coat: CoatLanes::NONE,
            unwarp: [ZERO; 3],
            unwarp_squared: [ZERO; 3],
            spread: ZERO,
            hessian: [ZERO; 3],
            curves: [CurveLanes::FLAT; 3],
            curve_of: [0, 1, 2],
        }
    }

    /// The scaling curves of ambient (0), diffuse (1) or specular (2) light.
    #[inline(always)]
    pub(crate) fn curve(&self, term: usize) -> &CurveLanes {
        &self.curves[self.curve_of[term]]
    }

    /// Sets the unit tangents, along the `grain` and across it, of the surface or of what faces the eye.
    #[inline(always)]
    pub(crate) fn set_tangents(&mut self, faces_eye: bool, grain: impl Fn(usize) -> [f32; 2]) {
        for i in 0..BATCH {
            let n = match faces_eye {
                true => self.to_eye.at(i),
                false => self.normal.at(i),
            };
            let [x, y] = grain(i);
            // The part of (x, y, 0) perpendicular to the normal; if that vanishes any tangent will do.
            let along = x * n[0] + y * n[1];
            let tangent = [x - along * n[0], y - along * n[1], -along * n[2]];
            let square =
                tangent[0] * tangent[0] + tangent[1] * tangent[1] + tangent[2] * tangent[2];
            let seen = square > SHORTEST_TANGENT;
            let inverse = 1.0 / square.max(SHORTEST_TANGENT).sqrt();
            let u = [
                if seen { tangent[0] * inverse } else { 0.0 },
                if seen { tangent[1] * inverse } else { 0.0 },
                if seen { tangent[2] * inverse } else { 1.0 },
            ];
            self.along.set(i, u);
            let v = [
                n[1] * u[2] - n[2] * u[1],
                n[2] * u[0] - n[0] * u[2],
                n[0] * u[1] - n[1] * u[0],
            ];
            self.across.set(i, v);
        }
    }

    /// Sets the inverse warps, their squares and determinants from the Hessians, for strength `alpha`.
    #[inline(always)]
    pub(crate) fn warp_by(&mut self, alpha: f32) {
        let [h_xx, h_xy, h_yy] = &self.hessian;
        let [xx, xy, yy] = &mut self.unwarp;
        let [square_xx, square_xy, square_yy] = &mut self.unwarp_squared;
        for i in 0..BATCH {
            // The inverse is the warp of the opposite strength.
            let bend = WarpParts::of([h_xx[i], h_xy[i], h_yy[i]], -alpha);
            [xx[i], xy[i], yy[i]] = bend.turn;
            [square_xx[i], square_yy[i]] = bend.principal;
        }
        for lanes in [&mut *square_xx, &mut *square_yy] {
            for x in lanes {
                *x = factor(*x);
            }
        }
        for i in 0..BATCH {
            let bend = WarpParts {
                principal: [square_xx[i], square_yy[i]],
                turn: [xx[i], xy[i], yy[i]],
            };
            let inverse = bend.warp();
            (xx[i], xy[i], yy[i]) = (inverse.xx, inverse.xy, inverse.yy);
            square_xx[i] = inverse.xx * inverse.xx + inverse.xy * inverse.xy;
            square_xy[i] = 2.0 * inverse.xy * (inverse.xx + inverse.yy);
            square_yy[i] = inverse.xy * inverse.xy + inverse.yy * inverse.yy;
            self.spread[i] = inverse.determinant();
        }
        self.normal.unwarp(&self.unwarp);
    }
}

impl Default for LitPixels {
    fn default() -> Self {
        Self::new()
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
        // A batch that is not full: the other lanes say nothing.
        for axis in spiral(40) {
            let mut normals = Axis::NONE;
            let near = |i: usize, k: usize| axis[k] + 0.2 * (0.7 * i as f32 + k as f32).sin();
            let count = 101;
            for i in 0..count {
                let n = [near(i, 0), near(i, 1), near(i, 2)];
                let length = scalar_product(n, n).sqrt();
                normals.set(i, n.map(|c| c / length));
            }
            let facing = Facing::of(&normals.vector, count);
            for direction in spiral(500) {
                let cosines = (0..count).map(|i| scalar_product(normals.at(i), direction));
                let (least, most) = cosines.fold((1.0_f32, -1.0_f32), |(least, most), c| {
                    (least.min(c), most.max(c))
                });
                match facing.above(direction) {
                    Above::Nowhere => assert!(most <= 0.0, "{most}"),
                    Above::Everywhere => assert!(least * MOST_BRIGHTENED >= 1.0, "{least}"),
                    Above::Somewhere => {}
                }
            }
            // The normals are within asin(0.2 sqrt 3), 20 degrees, of the axis.
            assert_eq!(facing.above(axis), Above::Everywhere);
            assert_eq!(facing.above(axis.map(|a| -a)), Above::Nowhere);
        }
    }
}
