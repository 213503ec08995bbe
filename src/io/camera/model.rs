//! One seven-parameter camera for perspective and parallel projection, and its polishing.
//!
//! A normalised point `q` turned to the view, `p = R q`, is seen at
//! `(scale p_x + a, scale p_y + b) / (1 - convergence p_z)`. Zero convergence is a parallel
//! projection; otherwise the eye lies `1 / convergence` from the centroid and the focal length is
//! `scale / convergence`. Long lenses are thus no singular case, and a negative convergence is the
//! mark of a mirrored scene.

use super::samples::{SeenPoint, quantile};
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector2, Vector3};
use std::collections::BTreeMap;

/// Turn 3, shift 2, logarithm of the scale 1, convergence 1, principal point 2.
const PARAMETERS: usize = 9;
pub(super) const CONVERGENCE: usize = 6;
type Delta = SVector<f64, PARAMETERS>;
type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;
pub(super) type Covariance = Normal;

/// Median distance of a 2-vector of unit normal noise from its mean, `sqrt(2 ln 2)`.
const MEDIAN_RADIUS: f64 = 1.177_410_022_515_474_7;
/// Residuals beyond this many standard deviations are discarded: 1 in 90 if they are normally distributed.
const TRIM: f64 = 3.0;
/// Residuals beyond this many standard deviations are pulled linearly (Huber).
const HUBER: f64 = 1.5;
/// Depths along the view, in units of the centroid's, below which a point counts as behind the eye.
const NEAREST: f64 = 1e-6;

/// Squares across the picture's width for averaging residuals, and the fewest samples for a mean.
const SQUARES_ACROSS: u32 = 8;
const FEWEST_IN_SQUARE: usize = 16;

/// The rotation nearest to `near`; `None` where it is singular or not finite.
pub(super) fn orthonormal(near: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    if !near.iter().all(|e| e.is_finite()) {
        return None;
    }
    let svd = near.svd(true, true);
    let rotation = svd.u? * svd.v_t?;
    (svd.singular_values.min() > 1e-9 && rotation.determinant() > 0.0).then_some(rotation)
}

/// The proper rotation, or with `mirrored` the improper one, that best maps vectors onto others, given the `sum` of the
/// products of the latter and the transposed former (Wahba's problem).
pub(super) fn wahba(sum: &Matrix3<f64>, mirrored: bool) -> Option<Matrix3<f64>> {
    if !sum.iter().all(|e| e.is_finite()) {
        return None;
    }
    let svd = sum.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let sign = (u * v_t).determinant().signum() * if mirrored { -1.0 } else { 1.0 };
    // Singular values come in falling order: the last direction is the cheapest one to reverse.
    Some(u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v_t)
}

/// Which parameters a fit may move, by their number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Free {
    /// A parallel projection.
    Parallel = 6,
    /// A perspective with the principal point at the centre of the display window.
    Perspective = 7,
    /// A perspective with lens shift.
    Shifted = 9,
}

impl Free {
    fn count(self) -> usize {
        self as usize
    }
}

/// A camera in the normalised frame of the samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Model {
    /// View from normalised world.
    pub(super) rotation: Rotation3<f64>,
    /// Image position of the centroid relative to the principal point.
    pub(super) shift: Vector2<f64>,
    /// Pixel widths per unit at the depth of the centroid.
    pub(super) scale: f64,
    /// One over the centroid's depth.
    pub(super) convergence: f64,
    /// Image position of the view axis.
    pub(super) principal: Vector2<f64>,
}

/// Derivatives of a sample's position by the parameters.
type Derivatives = SMatrix<f64, 2, PARAMETERS>;

fn huber(error: f64, threshold: f64) -> f64 {
    if error <= threshold {
        0.5 * error * error
    } else {
        threshold * (error - 0.5 * threshold)
    }
}

impl Model {
    pub(super) fn new(rotation: Matrix3<f64>, shift: Vector2<f64>, scale: f64, c: f64) -> Self {
        Self {
            rotation: Rotation3::from_matrix_unchecked(rotation),
            shift,
            scale,
            convergence: c,
            principal: Vector2::zeros(),
        }
    }

    /// The model of opposite convergence with the same image of the plane through the first two of `axes`.
    pub(super) fn facing_plane(&self, axes: &Matrix3<f64>) -> Self {
        // Depth along the plane changes sign with the convergence; the third axis follows from the two.
        let turned = self.rotation.matrix() * axes;
        let mirror = Vector3::new(1.0, 1.0, -1.0);
        let flip = |i: usize| turned.column(i).component_mul(&mirror);
        let (a, b) = (flip(0), flip(1));
        let view_from_axes = Matrix3::from_columns(&[a, b, a.cross(&b)]);
        Self {
            rotation: Rotation3::from_matrix_unchecked(view_from_axes * axes.transpose()),
            convergence: -self.convergence,
            ..*self
        }
    }

    /// Difference between the observed and the projected position, as a vector.
    pub(super) fn residual(&self, sample: &SeenPoint) -> Option<Vector2<f64>> {
        let p = self.rotation * sample.point;
        let w = 1.0 - self.convergence * p.z;
        (w > NEAREST).then(|| (self.scale * p.xy() + self.shift) / w + self.principal - sample.seen)
    }

    /// Length of the residual; infinite for a point behind the eye.
    pub(super) fn error(&self, sample: &SeenPoint) -> f64 {
        self.residual(sample).map_or(f64::INFINITY, |r| r.norm())
    }

    /// Median error, a measure that outliers do not move.
    pub(super) fn median_error(&self, samples: &[SeenPoint]) -> f64 {
        let mut errors: Vec<f64> = samples.iter().map(|s| self.error(s)).collect();
        quantile(&mut errors, 0.5)
    }

    /// Median over squares of the picture, of which there are a fixed number across its `width`, of their samples' mean
    /// error: insensitive to samples scattered about their positions.
    pub(super) fn mean_error(&self, samples: &[SeenPoint], width: f64) -> f64 {
        let side = width.max(1.0) / f64::from(SQUARES_ACROSS);
        let mut squares: BTreeMap<[i64; 2], (Vector2<f64>, usize)> = BTreeMap::new();
        for sample in samples {
            let Some(residual) = self.residual(sample) else {
                continue;
            };
            let square = [sample.seen.x, sample.seen.y].map(|at| (at / side).floor() as i64);
            let (sum, count) = squares.entry(square).or_default();
            *sum += residual;
            *count += 1;
        }
        let means = squares
            .values()
            .filter(|(_, count)| *count >= FEWEST_IN_SQUARE);
        let mut means: Vec<f64> = means
            .map(|(sum, count)| sum.norm() / *count as f64)
            .collect();
        match means.is_empty() {
            true => f64::INFINITY,
            false => quantile(&mut means, 0.5),
        }
    }

    /// Mean square error, each one counted up to `limit`, as a share of the limit's square: 0..1.
    pub(super) fn unexplained(&self, samples: &[SeenPoint], limit: f64) -> f64 {
        let share = |s: &SeenPoint| (self.error(s) / limit).min(1.0).powi(2);
        samples.iter().map(share).sum::<f64>() / samples.len().max(1) as f64
    }

    fn moved(&self, step: &Delta) -> Self {
        let turn = Rotation3::new(Vector3::new(step[0], step[1], step[2]));
        Self {
            rotation: turn * self.rotation,
            shift: self.shift + Vector2::new(step[3], step[4]),
            scale: self.scale * step[5].clamp(-2.0, 2.0).exp(),
            convergence: self.convergence + step[CONVERGENCE],
            principal: self.principal + Vector2::new(step[7], step[8]),
        }
    }

    /// Sum of Huber losses; infinite where a sample falls behind the eye.
    fn loss(&self, samples: &[SeenPoint], threshold: f64) -> f64 {
        let losses = samples.iter().map(|s| huber(self.error(s), threshold));
        losses.sum()
    }

    /// The residual of a sample, and its derivatives.
    fn linearised(&self, sample: &SeenPoint) -> Option<(Vector2<f64>, Derivatives)> {
        let residual = self.residual(sample)?;
        let p = self.rotation * sample.point;
        let w = 1.0 - self.convergence * p.z;
        let (image, per_depth) = ((self.scale * p.xy() + self.shift) / w, 1.0 / w);
        let s = self.scale * per_depth;
        let nearer = image * self.convergence * per_depth;
        let converging = image * p.z * per_depth;
        let by = [
            [nearer.x * p.y, nearer.y * p.y - s * p.z],
            [s * p.z - nearer.x * p.x, -nearer.y * p.x],
            [-s * p.y, s * p.x],
            [per_depth, 0.0],
            [0.0, per_depth],
            [s * p.x, s * p.y],
            [converging.x, converging.y],
            [1.0, 0.0],
            [0.0, 1.0],
        ];
        Some((residual, by.into()))
    }

    /// Sums over samples of the products of derivatives, and of those with residuals, each weighted by the threshold
    /// over the residual, at most 1.
    fn normal_equations(
        &self,
        samples: &[SeenPoint],
        threshold: f64,
        free: Free,
    ) -> (Normal, Delta) {
        let (mut normal, mut gradient) = (Normal::zeros(), Delta::zeros());
        for (residual, by) in samples.iter().filter_map(|sample| self.linearised(sample)) {
            let weighted = by * (threshold / residual.norm()).min(1.0);
            normal += weighted.tr_mul(&by);
            gradient += weighted.tr_mul(&residual);
        }
        for i in free.count()..PARAMETERS {
            normal.row_mut(i).fill(0.0);
            normal.column_mut(i).fill(0.0);
            (normal[(i, i)], gradient[i]) = (1.0, 0.0);
        }
        (normal, gradient)
    }

    /// Levenberg-Marquardt on all of `samples`.
    fn descend(mut self, samples: &[SeenPoint], threshold: f64, free: Free, steps: usize) -> Self {
        let mut loss = self.loss(samples, threshold);
        let mut damping = 1e-4;
        for _ in 0..steps {
            let (normal, gradient) = self.normal_equations(samples, threshold, free);
            let before = loss;
            while damping < 1e8 {
                let mut damped = normal;
                for i in 0..PARAMETERS {
                    damped[(i, i)] += damping * normal[(i, i)] + 1e-300;
                }
                let next = damped.cholesky().map(|c| self.moved(&c.solve(&-gradient)));
                let better = next
                    .map(|m| (m, m.loss(samples, threshold)))
                    .filter(|(_, l)| *l <= loss);
                if let Some((model, lower)) = better {
                    (self, loss) = (model, lower);
                    damping = (damping * 0.1).max(1e-12);
                    break;
                }
                damping *= 10.0;
            }
            if damping >= 1e8 || before - loss <= 1e-8 * before {
                break;
            }
        }
        self
    }

    /// The polished model: alternates trimming and descent, re-estimating the noise each time.
    pub(super) fn polished(mut self, samples: &[SeenPoint], free: Free, rounds: usize) -> Self {
        for _ in 0..rounds {
            let (sigma, kept) = self.trimmed(samples);
            if kept.len() < free.count() {
                break;
            }
            self = self.descend(&kept, HUBER * sigma, free, 12);
        }
        self
    }

    /// Noise per coordinate in pixel widths, and the samples within three times it.
    pub(super) fn trimmed(&self, samples: &[SeenPoint]) -> (f64, Vec<SeenPoint>) {
        // The floor keeps exact data from trimming itself to the last bit.
        let sigma = (self.median_error(samples) / MEDIAN_RADIUS).max(1e-9);
        let limit = TRIM * sigma * MEDIAN_RADIUS;
        let kept = samples.iter().filter(|s| self.error(s) <= limit);
        (sigma, kept.copied().collect())
    }

    /// Covariance of the parameters for a noise of 1 per coordinate; `None` where singular.
    pub(super) fn covariance(&self, samples: &[SeenPoint], free: Free) -> Option<Covariance> {
        let (normal, _) = self.normal_equations(samples, f64::INFINITY, free);
        let count = free.count();
        // Scaled to a unit diagonal, so that the test for singularity does not depend on units.
        let size = Delta::from_fn(|i, _| normal[(i, i)].sqrt().max(1e-300));
        let scaled = Normal::from_fn(|r, c| normal[(r, c)] / (size[r] * size[c]));
        let inverse = scaled.cholesky()?.inverse();
        let mut covariance = Normal::from_fn(|r, c| inverse[(r, c)] / (size[r] * size[c]));
        for i in count..PARAMETERS {
            covariance.row_mut(i).fill(0.0);
            covariance.column_mut(i).fill(0.0);
        }
        let is_finite = covariance.iter().all(|e| e.is_finite());
        is_finite.then_some(covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        let turn = Rotation3::from_euler_angles(0.3, -0.8, 1.1);
        let mut model = Model::new(*turn.matrix(), Vector2::new(30.0, -12.0), 200.0, 0.3);
        model.principal = Vector2::new(5.0, 7.0);
        let sample = SeenPoint {
            point: Vector3::new(0.4, -0.7, 0.9),
            seen: Vector2::new(3.0, 4.0),
        };
        let ahead_of = |i: usize, by: f64| {
            let mut step = Delta::zeros();
            step[i] = by;
            model.moved(&step).residual(&sample).unwrap()
        };
        let slopes: Vec<Vector2<f64>> = (0..PARAMETERS)
            .map(|i| (ahead_of(i, 1e-6) - ahead_of(i, -1e-6)) / 2e-6)
            .collect();
        // One sample of weight 1 has the products of its derivatives, and these times its residual.
        let (normal, gradient) = model.normal_equations(&[sample], f64::INFINITY, Free::Shifted);
        let residual = model.residual(&sample).unwrap();
        for (i, a) in slopes.iter().enumerate() {
            let off = (gradient[i] - a.dot(&residual)).abs();
            let size = (a.norm() * residual.norm()).max(1.0);
            assert!(off < 1e-5 * size, "parameter {i}: {off}");
            for (k, b) in slopes.iter().enumerate() {
                let off = (normal[(i, k)] - a.dot(b)).abs();
                let size = (a.norm() * b.norm()).max(1.0);
                assert!(off < 1e-5 * size, "parameters {i} and {k}: {off}");
            }
        }
    }
}
