//! How polylines are smoothed: how far apart their steps are, and the curve of least squares.

use crate::params::ContourParams;

/// Parameters of smoothing a polyline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Smoothing {
    /// Width of the stair steps that its points make, in pixels.
    pub step_px: f32,
    /// Largest deviation of its points from the true line, in such steps.
    pub tolerance: f32,
    /// Most points to either side that are looked at together.
    pub reach: usize,
    /// Whether its points are on stairs of pixels, not known to less.
    pub is_stepped: bool,
}

impl Smoothing {
    /// Smoothing of lines whose points deviate from the edge by up to `tolerance` steps.
    pub(crate) fn of(params: &ContourParams, tolerance: f32) -> Self {
        Self {
            step_px: params.step_px,
            tolerance,
            reach: params.smoothing_px as usize,
            is_stepped: true,
        }
    }

    /// Largest deviation of its points from the true line, in pixels.
    pub(super) fn tolerance_px(self) -> f32 {
        self.tolerance * self.step_px
    }

    /// So many steps, in pixels.
    pub(crate) fn steps(self, count: usize) -> usize {
        (count as f32 * self.step_px).round() as usize
    }
}

/// One coordinate of a parabola of least squares through samples that follow each other evenly.
pub(super) struct Parabola {
    /// Half the steps from the first sample to the last.
    pub(super) half: f32,
    mean_square: f32,
    /// Coefficients of 1, t and t^2 - mean(t^2), which are orthogonal; t counts samples from the middle.
    coefficients: [f32; 3],
}

impl Parabola {
    /// Sums over t = -half, -half + 1, ... half, n samples: of t^2 it is n (n^2 - 1)/12, and of (t^2 - mean)^2
    /// n (n^2 - 1)(n^2 - 4)/180.
    pub(super) fn through(samples: &[f32]) -> Self {
        let n = samples.len() as f32;
        let squares = n * (n * n - 1.0) / 12.0;
        let fourths = n * (n * n - 1.0) * (n * n - 4.0) / 180.0;
        let (half, mean_square) = (0.5 * (n - 1.0), squares / n);
        // Relative to the first sample: differences keep their digits far from the origin.
        let origin = samples[0];
        let [mut constant, mut linear, mut bent] = [0.0; 3];
        for (k, sample) in samples.iter().enumerate() {
            let t = k as f32 - half;
            let p = sample - origin;
            constant += p;
            linear += t * p;
            bent += (t * t - mean_square) * p;
        }
        let over = |sum: f32, squares: f32| if squares > 0.0 { sum / squares } else { 0.0 };
        Self {
            half,
            mean_square,
            coefficients: [
                origin + constant / n,
                over(linear, squares),
                over(bent, fourths),
            ],
        }
    }

    /// How far its middle is off the straight line through its ends.
    pub(super) fn rise(&self) -> f32 {
        (self.coefficients[2] * self.half * self.half).abs()
    }

    pub(super) fn at(&self, t: f32) -> f32 {
        let [a, b, c] = self.coefficients;
        a + t * b + (t * t - self.mean_square) * c
    }

    pub(super) fn slope(&self, t: f32) -> f32 {
        let [_, b, c] = self.coefficients;
        b + 2.0 * t * c
    }
}
