//! A batch of covered pixels and their light-independent samples, component by component, so that loops over a batch
//! vectorise.

use super::light_warping::{MOST_BRIGHTENED, Warp};
use super::radiance_scaling::ScalingCurve;

/// Pixels of a batch. All its planes fit the first-level cache.
pub(crate) const BATCH: usize = 128;

/// One number per pixel of a batch.
pub(crate) type Lanes = [f32; BATCH];

/// One vector per pixel of a batch.
pub(crate) type Vectors = [Lanes; 3];

/// A vector per pixel, and its image under the inverse of the warp: the two inputs of its dot product with an unwarped
/// direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    /// The vector.
    pub vector: Vectors,
    /// Its x and y multiplied by the inverse of Lambda.
    pub unwarped: [Lanes; 2],
}

/// The pixels of a batch.
#[derive(Debug, Clone)]
pub(crate) struct Pixels {
    /// Number of lanes in use; the others hold arbitrary finite numbers.
    pub count: usize,
    /// Unit normals.
    pub normal: Axis,
    /// Cone of their normals.
    pub facing: Facing,
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
    /// Scaling curves, indexed by [`Pixels::curve_of`].
    pub curves: [CurveLanes; 3],
    /// Index of the curve of ambient, diffuse and specular light: terms of equal magnitude share one.
    pub curve_of: [usize; 3],
}

/// Scaling curves of a batch.
#[derive(Debug, Clone, Copy)]
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

/// A cone containing all normals of a batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Facing {
    axis: [f32; 3],
    /// Sine and cosine of the half angle; a sine above 1 means unknown.
    sine: f32,
    cosine: f32,
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
    /// The cone that contains every normal.
    pub(crate) const ANYWHERE: Self = Self {
        axis: [0.0, 0.0, 1.0],
        sine: 2.0,
        cosine: 0.0,
    };

    /// Margin of the cone for rounding, as a sine.
    const MARGIN: f32 = 1e-4;

    /// Cosines above this are never limited by [`MOST_BRIGHTENED`], since no cosine exceeds 1.
    const HIGH: f32 = 1.0 / MOST_BRIGHTENED + Self::MARGIN;

    /// The cone about the mean of the first `count` normals.
    #[inline(always)]
    pub(crate) fn of(normals: &Vectors, count: usize) -> Self {
        let [x, y, z] = normals;
        let sum = [sum(&x[..count]), sum(&y[..count]), sum(&z[..count])];
        let length = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Self::ANYWHERE;
        }
        let axis = [sum[0] / length, sum[1] / length, sum[2] / length];
        let mut cosines = [1.0; BATCH];
        for i in 0..count {
            cosines[i] = axis[0] * x[i] + axis[1] * y[i] + axis[2] * z[i];
        }
        let cosine = least(&cosines);
        match cosine > 0.0 {
            true => Self {
                axis,
                sine: (1.0 - cosine * cosine).max(0.0).sqrt() + Self::MARGIN,
                cosine,
            },
            false => Self::ANYWHERE,
        }
    }

    /// For which pixels a unit direction is above the surface.
    #[inline]
    pub(crate) fn above(&self, direction: [f32; 3]) -> Above {
        let [x, y, z] = self.axis;
        let cosine = x * direction[0] + y * direction[1] + z * direction[2];
        let aside = (1.0 - cosine * cosine).max(0.0).sqrt();
        // The smallest cosine with any normal of the cone; a direction at least 90 degrees from all of them.
        let least = cosine * self.cosine - aside * self.sine;
        if cosine <= -self.sine {
            Above::Nowhere
        } else if least >= Self::HIGH {
            Above::Everywhere
        } else {
            Above::Somewhere
        }
    }
}

/// Independent partial results, where the order of operations does not matter.
const SIDE_BY_SIDE: usize = 16;

/// The sum, by several partial sums.
#[inline(always)]
fn sum(values: &[f32]) -> f32 {
    let mut sums = [0.0; SIDE_BY_SIDE];
    let (chunks, rest) = values.as_chunks::<SIDE_BY_SIDE>();
    for chunk in chunks {
        for i in 0..SIDE_BY_SIDE {
            sums[i] += chunk[i];
        }
    }
    sums.iter().sum::<f32>() + rest.iter().sum::<f32>()
}

/// The minimum of a batch; NaN counts as smallest.
#[inline(always)]
fn least(values: &Lanes) -> f32 {
    let mut least = [f32::MAX; SIDE_BY_SIDE];
    for chunk in values.as_chunks::<SIDE_BY_SIDE>().0 {
        for i in 0..SIDE_BY_SIDE {
            least[i] = if chunk[i] >= least[i] {
                least[i]
            } else {
                chunk[i]
            };
        }
    }
    least
        .iter()
        .fold(f32::MAX, |a, &b| if b >= a { a } else { b })
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

impl Pixels {
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

    /// Sets the inverse warps, their squares and determinants from the Hessians, for strength `alpha`.
    #[inline(always)]
    pub(crate) fn warp_by(&mut self, alpha: f32) {
        let [h_xx, h_xy, h_yy] = &self.hessian;
        let [xx, xy, yy] = &mut self.unwarp;
        let [square_xx, square_xy, square_yy] = &mut self.unwarp_squared;
        for i in 0..BATCH {
            // The warp of the opposite strength.
            let inverse = Warp::of([h_xx[i], h_xy[i], h_yy[i]], -alpha);
            (xx[i], xy[i], yy[i]) = (inverse.xx, inverse.xy, inverse.yy);
            square_xx[i] = inverse.xx * inverse.xx + inverse.xy * inverse.xy;
            square_xy[i] = 2.0 * inverse.xy * (inverse.xx + inverse.yy);
            square_yy[i] = inverse.xy * inverse.xy + inverse.yy * inverse.yy;
            self.spread[i] = inverse.determinant();
        }
        self.normal.unwarp(&self.unwarp);
    }
}

impl Default for Pixels {
    fn default() -> Self {
        Self::new()
    }
}
