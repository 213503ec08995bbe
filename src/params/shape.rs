//! What shape analysis can be told.

use crate::error::{Error, Result};
use crate::params::Adaptive;
use serde::Serialize;

/// A soft step: 0 up to `lo`, 1 from `hi`, linear between.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SoftThreshold {
    /// Where the weight starts to rise.
    pub lo: f32,
    /// Where the weight reaches 1.
    pub hi: f32,
}

impl SoftThreshold {
    /// The weight of `value`, 0..1. With `lo == hi` the step is hard.
    pub fn weight(&self, value: f32) -> f32 {
        if value >= self.hi {
            1.0
        } else if value <= self.lo {
            0.0
        } else {
            (value - self.lo) / (self.hi - self.lo)
        }
    }
}

impl std::fmt::Display for SoftThreshold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{}", self.lo, self.hi)
    }
}

impl std::str::FromStr for SoftThreshold {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parse = |s: &str| s.trim().parse::<f32>().ok().filter(|v| v.is_finite());
        match text.split_once(',').map(|(lo, hi)| (parse(lo), parse(hi))) {
            Some((Some(lo), Some(hi))) if 0.0 <= lo && lo <= hi => Ok(Self { lo, hi }),
            _ => Err("expected two numbers LO,HI with 0 <= LO <= HI".into()),
        }
    }
}

/// How far the gradient is diffused before it is differentiated: the size of the features looked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// As this number of explicit steps does ([LW] section 4.3). 0 keeps the finest detail and all
    /// noise.
    Iterations(u32),
    /// As a Gaussian of this standard deviation in pixels does in the open.
    Sigma(f32),
}

/// How diffusion is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Solver {
    /// A Chebyshev expansion within [`ShapeParams::tolerance`]; explicit steps where they are fewer.
    Chebyshev,
    /// The paper's steps, one by one.
    Explicit,
}

/// How silhouettes, creases and curvature are found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ShapeParams {
    /// Jump of depth across a pixel, as a share of the distance, that makes a silhouette. Lower
    /// values cut steep slopes apart; higher ones let curvature leak between objects.
    pub silhouette: SoftThreshold,
    /// The same for an occlusion or alpha map, as an absolute jump, where there is no depth.
    pub occlusion_silhouette: SoftThreshold,
    /// Angle by which the normal turns across a pixel, in degrees, that makes a crease. Lower values turn fine
    /// relief into creases, which are left alone; higher ones round off real edges.
    pub crease: SoftThreshold,
    /// Foreshortening exponent f of the gradient `-n_xy / n_z^f`, 0 or more. 0 measures the surface
    /// as an object seen from anywhere (k1 + k2); 1 measures the height field that the viewer sees,
    /// with slopes that grow without end toward silhouettes.
    pub foreshortening: f32,
    /// Floor of n_z in that gradient, in (0, 1]. Lower floors let one rim pixel rule the Hessian;
    /// higher ones flatten the surface near silhouettes.
    pub min_nz: f32,
    /// How far the gradient is diffused.
    pub scale: Scale,
    /// How it is diffused.
    pub solver: Solver,
    /// Largest error of the slope that the Chebyshev solver may add, above 0. The default changes the
    /// curvature by less than 2e-4 per pixel: at an ordinary gain a tenth of an 8-bit grey level.
    pub tolerance: f32,
    /// Length of one explicit step, in (0, 1/4]. Above 1/4 the scheme is unstable; at exactly 1/4
    /// a checkerboard never decays.
    pub time_step: f32,
    /// Height in pixels of the whole picture (its display window) for which the scale, and the gain of
    /// the curvature, are meant: 1 or more. In a picture f times as high the scale counts f times as many
    /// pixels, and curvature is told per pixel of the reference, f times what it is per pixel, so that a
    /// proxy and the final picture look alike. `None` counts everything in the picture's own pixels: a
    /// look then grows finer with resolution. The thresholds of silhouettes and creases are jumps across
    /// one pixel of the picture either way.
    pub reference_height: Option<u32>,
    /// How many pixels away normals are compared to find the directions of curvature: a whole number,
    /// 1 to [`MAX_DIRECTION_STEP_PX`]. `Auto` takes more the coarser normals were stored. Short steps
    /// see fine shapes, and noise; long ones round them off. Before an edge the step shrinks.
    pub direction_step: Adaptive,
}

/// Past this a step leaves the shapes it is to tell of.
pub const MAX_DIRECTION_STEP_PX: u32 = 64;

impl Default for ShapeParams {
    fn default() -> Self {
        Self {
            silhouette: SoftThreshold { lo: 0.03, hi: 0.04 },
            occlusion_silhouette: SoftThreshold { lo: 0.2, hi: 0.4 },
            crease: SoftThreshold { lo: 45.0, hi: 80.0 },
            foreshortening: 0.0,
            min_nz: 0.05,
            scale: Scale::Iterations(10),
            solver: Solver::Chebyshev,
            tolerance: 1e-4,
            time_step: 0.2,
            reference_height: None,
            direction_step: Adaptive::Auto,
        }
    }
}

impl ShapeParams {
    /// Refuses values outside their ranges.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the first one.
    pub fn validate(&self) -> Result<()> {
        let bad = |name, found: String, remedy: &str| {
            Err(Error::BadParameter {
                name,
                found,
                remedy: remedy.into(),
            })
        };
        if !(0.0..=4.0).contains(&self.foreshortening) {
            return bad(
                "--foreshortening",
                format!("is {}", self.foreshortening),
                "give 0 to 4",
            );
        }
        if !(self.min_nz > 0.0 && self.min_nz <= 1.0) {
            return bad(
                "min_nz",
                format!("is {}", self.min_nz),
                "give more than 0, at most 1",
            );
        }
        if !(self.time_step > 0.0 && self.time_step <= 0.25) {
            return bad(
                "time_step",
                format!("is {}", self.time_step),
                "explicit diffusion is stable only from 0 to 0.25",
            );
        }
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return bad(
                "--tolerance",
                format!("is {}", self.tolerance),
                "give more than 0",
            );
        }
        if self.reference_height == Some(0) {
            return bad("--reference-height", "is 0".into(), "give 1 or more");
        }
        if let Adaptive::Fixed(step) = self.direction_step
            && !(step.fract() == 0.0 && (1.0..=MAX_DIRECTION_STEP_PX as f32).contains(&step))
        {
            return bad(
                "--direction-step",
                format!("is {step} px"),
                "give a whole number from 1 to 64, or auto",
            );
        }
        match self.scale {
            Scale::Sigma(sigma) if !(0.0..=MAX_SIGMA_PX).contains(&sigma) => {
                bad("--scale", format!("is {sigma} px"), "give 0 to 4096 pixels")
            }
            _ => Ok(()),
        }
    }

    /// How many pixels of a picture of this height stand for one of the reference; 1 without a reference.
    pub fn resolution_factor(&self, image_height: usize) -> f64 {
        let factor = |reference| image_height.max(1) as f64 / f64::from(reference);
        self.reference_height.map_or(1.0, factor)
    }

    /// Refuses a scale that grows past all pictures in one of `image_height` pixels.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the reference height.
    pub fn validate_for(&self, image_height: usize) -> Result<()> {
        let sigma = self.scale_px() * self.resolution_factor(image_height);
        if self.reference_height.is_none() || sigma <= f64::from(MAX_SIGMA_PX) {
            return Ok(());
        }
        Err(Error::BadParameter {
            name: "--reference-height",
            found: format!("makes the scale {sigma:.0} px in a picture of {image_height} lines"),
            remedy: "give a height nearer to the picture's, or a smaller scale".into(),
        })
    }

    /// The time of the diffusion equation that [`ShapeParams::scale`] stands for, where a pixel is one of
    /// the reference.
    pub fn diffusion_time(&self) -> f64 {
        match self.scale {
            Scale::Iterations(count) => f64::from(count) * f64::from(self.time_step),
            Scale::Sigma(sigma) => Self::time_of(sigma),
        }
    }

    /// The time of the diffusion equation after which a point is a Gaussian of this sigma in pixels.
    pub fn time_of(sigma: f32) -> f64 {
        0.5 * f64::from(sigma).powi(2)
    }

    /// The least and the greatest [`ShapeParams::direction_step`], in pixels, for normals rounded by up to
    /// `normal_rounding`. A pixel takes the least, and up to the greatest where that tells no direction.
    ///
    /// Noise turns directions by rounding / step, and the surface's own change by step^2.
    pub fn direction_steps_px(&self, normal_rounding: f32) -> [usize; 2] {
        match self.direction_step {
            Adaptive::Fixed(step) => [step as usize; 2],
            Adaptive::Auto if normal_rounding > COARSE_ROUNDING => [COARSE_STEP_PX, WIDEST_STEP_PX],
            Adaptive::Auto if normal_rounding > 0.0 => [1, WIDEST_STEP_PX],
            Adaptive::Auto => [1; 2],
        }
    }

    /// The steepest slope that the gradient can have: n_xy is at most 1, n_z at least its floor.
    pub fn largest_slope(&self) -> f64 {
        f64::from(self.min_nz).powf(-f64::from(self.foreshortening))
    }

    /// Standard deviation, in pixels of the reference, of the Gaussian that the diffusion equals away
    /// from edges.
    pub fn scale_px(&self) -> f64 {
        (2.0 * self.diffusion_time()).sqrt()
    }
}

/// Past this a Gaussian is flat over any picture.
const MAX_SIGMA_PX: f32 = 4096.0;

/// Normals rounded by more than this are coarse: those of 8 bits (1/255), not half floats (1/4096).
const COARSE_ROUNDING: f32 = 1e-3;

/// The first step over coarse normals, and the last over any that are not exact. On 8-bit ellipsoids of
/// 32, 64, 128 and 256 px the 95th percentile of the directions' error is 7, 5, 8, 27 degrees at 4 px alone,
/// 13, 17, 7, 5 at 16 px alone, and 7, 7, 6, 6 with 16 px where 4 px tell nothing.
const COARSE_STEP_PX: usize = 4;
const WIDEST_STEP_PX: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    fn referring_to(reference_height: u32, scale: Scale) -> ShapeParams {
        ShapeParams {
            reference_height: Some(reference_height),
            scale,
            ..ShapeParams::default()
        }
    }

    #[test]
    fn the_factor_is_the_ratio_of_heights() {
        assert_eq!(ShapeParams::default().resolution_factor(1080), 1.0);
        let half = referring_to(540, Scale::Sigma(1.0));
        assert_eq!(half.resolution_factor(1080), 2.0);
        assert_eq!(half.resolution_factor(135), 0.25);
    }

    #[test]
    fn references_out_of_range_are_refused() {
        assert!(referring_to(0, Scale::Sigma(1.0)).validate().is_err());
        // A sigma of 100 at one line is 108,000 at 1080.
        let one = referring_to(1, Scale::Sigma(100.0));
        assert!(one.validate().is_ok() && one.validate_for(1080).is_err());
        assert!(one.validate_for(40).is_ok());
        let steps = referring_to(1, Scale::Iterations(10));
        assert!(steps.validate_for(4320).is_err());
    }
}
