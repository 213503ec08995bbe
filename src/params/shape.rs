//! The parameters of shape analysis.

use crate::error::{Error, Result};
use crate::params::range::in_range;
use crate::params::table::{Kind, Many, Unit, by_factors, even};
use crate::params::value::{Value, finite};
use crate::params::{Adaptive, Group, Param, Parameters};
use serde::Serialize;
use std::ops::RangeInclusive;

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
    #[inline(always)]
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

impl Value for SoftThreshold {
    const KIND: Kind = Kind::Pair;

    fn parse(text: &str, _: &Param) -> std::result::Result<Self, String> {
        let ends = text
            .split_once(',')
            .map(|(lo, hi)| (finite(lo), finite(hi)));
        match ends {
            Some((Some(lo), Some(hi))) if 0.0 <= lo && lo <= hi => Ok(Self { lo, hi }),
            _ => Err("expected two numbers LO,HI with 0 <= LO <= HI".into()),
        }
    }

    fn text(&self, _: &Param) -> Option<String> {
        Some(format!("{},{}", self.lo, self.hi))
    }

    /// The upper end is validated by the containing struct, against the lower one.
    fn outside(&self, row: &Param) -> Option<String> {
        self.lo.outside(row)
    }
}

/// Amount of diffusion of the gradient before differentiation: the size of features shown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// A number of explicit steps ([LW] section 4.3), at most those of the largest sigma. 0 keeps the finest detail and
    /// all noise.
    Iterations(u32),
    /// The standard deviation, 0 to 4096 pixels, of the Gaussian that diffusion equals away from edges.
    Sigma(f32),
    /// Several such standard deviations, each with its weight: results are added with weights in proportion to both. Those
    /// with a weight of 0 count for nothing.
    Mixed([(f32, f32); MAX_MIXED]),
}

/// The most scales that are mixed.
pub(crate) const MAX_MIXED: usize = 4;

impl Scale {
    /// At most four standard deviations, each with its weight; `None` of more, of none, and without a weight other than 0.
    pub fn mixed(scales: &[(f32, f32)]) -> Option<Self> {
        let mut mixed = [(0.0, 0.0); MAX_MIXED];
        mixed.get_mut(..scales.len())?.copy_from_slice(scales);
        let total: f32 = scales.iter().map(|(_, weight)| weight.abs()).sum();
        (total > 0.0 && total.is_finite()).then_some(Self::Mixed(mixed))
    }

    /// The standard deviations that are mixed, with their weights.
    pub(crate) fn weighted(&self) -> impl Iterator<Item = (f32, f32)> + use<> {
        let mixed = match self {
            Self::Mixed(mixed) => *mixed,
            _ => [(0.0, 0.0); MAX_MIXED],
        };
        mixed.into_iter().filter(|(_, weight)| *weight != 0.0)
    }
}

const DEFAULT_ITERATIONS: u32 = 10;

/// Two mutually exclusive parameters.
const _: () = {
    params!(
        @row Shape iterations ["Size of the features to find, as diffusion steps: more show larger ones only."]
        u32 = DEFAULT_ITERATIONS, flag: "--iterations", common: true, form: "N", useful: even(0.0, 200.0)
    );
    params!(
        @row Shape scale [
            "The same in pixels, as the sigma of a Gaussian, in place of --iterations. Of several `shape` makes layers, and"
            "`map` maps; `enhance` and `relight` mix up to four, see --sum."
        ]
        Option<f32> = None, flag: "--scale", common: true, alias: Some("feature-size"), form: "PX[,PX]", many: Many::Listed, unit: Unit::Pixels,
        valid: 0.0..=MAX_SIGMA_PX, useful: by_factors(0.5, 64.0), rival: Some("iterations")
    );

    impl Parameters for Scale {
        fn usual() -> Self {
            Self::Iterations(DEFAULT_ITERATIONS)
        }

        fn rows(table: &mut Vec<&'static Param>) {
            table.extend([&iterations, &scale]);
        }

        /// The first of several sigmas is the scale.
        fn set(&mut self, name: &str, text: &str) -> std::result::Result<bool, String> {
            let first = text.split(',').next().unwrap_or_default();
            *self = match name {
                "iterations" => Self::Iterations(Value::parse(text, &iterations)?),
                "scale" => Self::Sigma(Value::parse(first, &scale)?),
                _ => return Ok(false),
            };
            Ok(true)
        }

        fn check(&self) -> Result<()> {
            match self {
                Self::Iterations(_) => Ok(()),
                Self::Sigma(sigma) => scale.check(sigma.outside(&scale)),
                Self::Mixed(_) => {
                    let mut sigmas = self.weighted().map(|(sigma, _)| sigma);
                    scale.check(sigmas.find_map(|sigma| sigma.outside(&scale)))
                }
            }
        }
    }
};

choices! {
    /// Numerical scheme of the diffusion.
    pub enum Solver {
        /// A Chebyshev expansion within the tolerance; explicit steps where fewer suffice.
        Chebyshev = "chebyshev",
        /// The paper's explicit steps.
        Explicit = "explicit",
    }
}

params! {
    /// Silhouettes, creases and curvature.
    pub struct ShapeParams in Shape {
        /// Amount of diffusion of the gradient.
        scale: Scale;
        /// Height in pixels of the whole picture that the scale and the curvature gain refer to, so that a look carries
        /// over to another resolution. none uses the picture's own pixels.
        ///
        /// The height is that of the display window. In a picture f times as high the scale covers f times as many
        /// pixels, and curvature is given per pixel of the reference, f times its value per pixel, so that a proxy and
        /// the final picture look alike. Without a reference a look grows finer with resolution. Thresholds of
        /// silhouettes and creases always apply to jumps across one pixel of the picture.
        reference_height: Option<u32> = None,
            flag: "--reference-height", form: "PX|none", unit: Unit::Pixels,
            kind: Kind::Number { whole: true, word: Some("none") },
            valid: 1.0..=f32::INFINITY, useful: by_factors(256.0, 8192.0);
        /// Numerical scheme of the diffusion.
        solver: Solver = Solver::Chebyshev, flag: "--solver", form: "SOLVER";
        /// Largest error of a slope that the Chebyshev solver may add.
        ///
        /// The default changes the curvature by less than 2e-4 per pixel: at an ordinary gain a tenth of an 8-bit grey
        /// level.
        tolerance: f32 = 1e-4, flag: "--tolerance", form: "E", valid: 1e-9..=1000.0, useful: by_factors(1e-6, 1e-2);
        /// Foreshortening of the gradient: 0 treats the surface as an object, 1 as the viewer's height field.
        ///
        /// The exponent f of the gradient `-n_xy / n_z^f`. 0 measures the surface independently of the view (k1 + k2);
        /// 1 measures the height field seen by the viewer, whose slopes grow without bound toward silhouettes.
        foreshortening: f32 = 0.0, flag: "--foreshortening", form: "F", valid: 0.0..=4.0, useful: even(0.0, 2.0);
        /// Floor of n_z in that gradient.
        ///
        /// Lower floors let one rim pixel rule the Hessian; higher ones flatten the surface near silhouettes. The
        /// steepest slope is the floor's -4th power: at most 1e12, whose square fits single precision.
        min_nz: f32 = 0.05, valid: 1e-3..=1.0;
        /// Length of one explicit step.
        ///
        /// Above 1/4 the scheme is unstable; at exactly 1/4 a checkerboard never decays.
        time_step: f32 = 0.2, valid: 0.001..=0.25,
            why: Some("explicit diffusion is stable only up to there");
        /// Gap between two surfaces that makes a silhouette, as a share of the picture's longer side.
        ///
        /// The distance of each pixel's point from the tangent plane of its neighbour, at least 1.5 and 2.5 pixels: a floor
        /// has none, however grazing. Lower values outline small steps; higher ones let curvature leak between objects.
        silhouette: SoftThreshold = SoftThreshold { lo: 0.008, hi: 0.012 },
            flag: "--silhouette", form: "LO,HI", valid: THRESHOLDS;
        /// Jump in an occlusion or alpha map that makes a silhouette where there is no depth, absolute.
        occlusion_silhouette: SoftThreshold = SoftThreshold { lo: 0.2, hi: 0.4 }, valid: THRESHOLDS;
        /// Angle across a pixel, in degrees, that makes a crease.
        ///
        /// The angle between the normals. Lower values turn fine relief into creases, which diffusion leaves alone;
        /// higher ones round off real edges.
        crease: SoftThreshold = SoftThreshold { lo: 45.0, hi: 80.0 },
            flag: "--crease", form: "LO,HI", unit: Unit::Degrees, valid: THRESHOLDS;
        /// Distance in pixels between the normals compared for directions, or auto: larger for coarse normals.
        ///
        /// Short steps resolve fine shapes, and noise; long ones round them off. The step shrinks near edges.
        direction_step: Adaptive = Adaptive::Auto,
            flag: "--direction-step", form: "PX|auto", unit: Unit::Pixels,
            kind: Kind::Number { whole: true, word: Some("auto") },
            valid: 1.0..=MAX_DIRECTION_STEP_PX as f32, useful: even(1.0, 32.0);
        /// Largest error of the height, in relation to the height itself, where it is found round by round.
        height_tolerance: f32 = 1e-4, flag: "--height-tolerance", form: "E", group: Group::Relief,
            valid: 1e-7..=0.1, useful: by_factors(1e-6, 1e-2);
        /// Distance in pixels over which normals alone shape the height; over longer ones it follows depth, where there
        /// is any.
        height_detail: f32 = 32.0, flag: "--height-detail", form: "PX", group: Group::Relief, unit: Unit::Pixels,
            valid: 1.0..=4096.0, useful: by_factors(4.0, 256.0);
        /// Radius in pixels within which higher parts hide the sky; `map` makes a map of several.
        occlusion_radius: f32 = 32.0, flag: "--occlusion-radius", common: true, form: "PX[,PX]", group: Group::Relief,
            many: Many::Listed, unit: Unit::Pixels, valid: 1.0..=1024.0, useful: by_factors(4.0, 256.0);
        /// Slices of the sky in which horizons are looked for, to both sides.
        ///
        /// The error of a groove is below 2 % with 8.
        occlusion_slices: u32 = 8, flag: "--occlusion-slices", form: "N", group: Group::Relief,
            valid: 1.0..=64.0, useful: even(2.0, 32.0);
    }
    relations ShapeParams::relations;
}

/// Thresholds well within single precision.
const THRESHOLDS: RangeInclusive<f32> = 0.0..=1e30;

/// Longer steps leave the local shape they should describe.
pub(crate) const MAX_DIRECTION_STEP_PX: u32 = 64;

impl ShapeParams {
    /// What is likely meant otherwise than it is read now.
    #[cfg(feature = "cli")]
    pub(crate) fn outdated(&self) -> Option<&'static str> {
        let former = SoftThreshold { lo: 0.03, hi: 0.04 };
        (self.silhouette == former).then_some(
            "--silhouette 0.03,0.04 was the default while it was a share of the distance; it is a share of the picture's \
             longer side now: leave it out, or compare with --silhouette 0.008,0.012",
        )
    }

    fn relations(&self) -> Result<()> {
        for (name, threshold) in [
            ("--silhouette", self.silhouette),
            ("occlusion_silhouette", self.occlusion_silhouette),
            ("--crease", self.crease),
        ] {
            in_range(name, threshold.hi, threshold.lo..=*THRESHOLDS.end())?;
        }
        if self.scale_px() > f64::from(MAX_SIGMA_PX) {
            let most = (Self::time_of(MAX_SIGMA_PX) / f64::from(self.time_step)).floor();
            return Err(Error::BadParameter {
                name: "--iterations",
                found: format!("is {}", self.steps(1.0)),
                remedy: format!("give 0 to {most:.0}"),
            });
        }
        self.check_steps(1.0)
    }

    /// Refuses more explicit steps than the limit, where `factor` pixels correspond to one of the reference.
    fn check_steps(&self, factor: f64) -> Result<()> {
        let steps = self.steps(factor);
        if self.solver == Solver::Chebyshev || steps <= MAX_EXPLICIT_STEPS {
            return Ok(());
        }
        Err(Error::BadParameter {
            name: "--solver",
            found: format!("takes {steps:.0} explicit steps"),
            remedy: format!(
                "leave it out: chebyshev needs far fewer, or lower the scale to {MAX_EXPLICIT_STEPS} steps"
            ),
        })
    }

    /// Explicit steps of the scale, where `factor` pixels correspond to one of the reference.
    fn steps(&self, factor: f64) -> f64 {
        let time = self.diffusion_time() * factor * factor;
        (time / f64::from(self.time_step) * (1.0 - 1e-12)).ceil()
    }

    /// Pixels of a picture of this height per pixel of the reference; 1 without a reference.
    pub fn resolution_factor(&self, image_height: usize) -> f64 {
        let factor = |reference| image_height.max(1) as f64 / f64::from(reference);
        self.reference_height.map_or(1.0, factor)
    }

    /// Refuses a scale that exceeds its limit in a picture of `image_height` pixels.
    ///
    /// # Errors
    /// [`Error::BadParameter`] naming the reference height.
    pub fn validate_for(&self, image_height: usize) -> Result<()> {
        let factor = self.resolution_factor(image_height);
        let sigma = self.scale_px() * factor;
        if self.reference_height.is_none() || sigma <= f64::from(MAX_SIGMA_PX) {
            return self.check_steps(factor);
        }
        Err(Error::BadParameter {
            name: "--reference-height",
            found: format!("makes the scale {sigma:.0} px in a picture of {image_height} lines"),
            remedy: "give a height nearer to the picture's, or a smaller scale".into(),
        })
    }

    /// Diffusion time of [`ShapeParams::scale`], of the larger one if two are mixed, in pixels of the reference squared.
    pub fn diffusion_time(&self) -> f64 {
        match self.scale {
            Scale::Iterations(count) => f64::from(count) * f64::from(self.time_step),
            Scale::Sigma(sigma) => Self::time_of(sigma),
            Scale::Mixed(_) => {
                let sigmas = self.scale.weighted().map(|(sigma, _)| sigma);
                Self::time_of(sigmas.fold(0.0, f32::max))
            }
        }
    }

    /// Diffusion time that turns a point into a Gaussian of this sigma in pixels.
    pub fn time_of(sigma: f32) -> f64 {
        0.5 * f64::from(sigma).powi(2)
    }

    /// Smallest and largest [`ShapeParams::direction_step`], in pixels, for normals rounded by up to `normal_rounding`.
    /// A pixel uses the smallest, and longer ones where that gives no direction.
    ///
    /// The directions' error grows with rounding / step from noise, and with step^2 from the surface's own change.
    pub fn direction_steps_px(&self, normal_rounding: f32) -> [usize; 2] {
        match self.direction_step {
            Adaptive::Fixed(step) => [step as usize; 2],
            Adaptive::Auto if normal_rounding > COARSE_ROUNDING => [COARSE_STEP_PX, WIDEST_STEP_PX],
            Adaptive::Auto if normal_rounding > 0.0 => [1, WIDEST_STEP_PX],
            Adaptive::Auto => [1; 2],
        }
    }

    /// Upper bound of the gradient's slope: n_xy is at most 1, n_z at least its floor.
    pub fn largest_slope(&self) -> f64 {
        f64::from(self.min_nz).powf(-f64::from(self.foreshortening))
    }

    /// Standard deviation, in pixels of the reference, of the Gaussian that the diffusion equals away
    /// from edges.
    pub fn scale_px(&self) -> f64 {
        (2.0 * self.diffusion_time()).sqrt()
    }

    /// The same for each scale that is mixed.
    pub(crate) fn scales_px(&self) -> Vec<f64> {
        match self.scale {
            Scale::Mixed(_) => self
                .scale
                .weighted()
                .map(|(sigma, _)| sigma.into())
                .collect(),
            _ => vec![self.scale_px()],
        }
    }
}

/// A larger Gaussian is flat over any picture.
pub(crate) const MAX_SIGMA_PX: f32 = 4096.0;

/// Explicit steps for a sigma of 140 pixels: minutes for a large picture, where the expansion takes a second.
const MAX_EXPLICIT_STEPS: f64 = 50_000.0;

/// Maximum number of scales of one run: twelve octaves in steps of a fifth.
pub(crate) const MAX_SCALES: usize = 64;

/// Refuses more than [`MAX_SCALES`] scales.
///
/// # Errors
/// [`Error::BadParameter`].
pub(crate) fn check_scales(count: usize) -> Result<()> {
    match count <= MAX_SCALES {
        true => Ok(()),
        false => Err(Error::BadParameter {
            name: "--scale",
            found: format!("names {count} scales"),
            remedy: format!("give at most {MAX_SCALES}"),
        }),
    }
}

/// Normals rounded by more than this are coarse: 8 bits (1/255), not half floats (1/4096).
pub(crate) const COARSE_ROUNDING: f32 = 1e-3;

/// The first step for coarse normals, and the last for any that are not exact. On 8-bit ellipsoids of 32, 64, 128 and
/// 256 px the 95th percentile of the directions' error is 7, 5, 8, 27 degrees with 4 px alone, 13, 17, 7, 5 with 16 px
/// alone, and 7, 7, 6, 6 with 16 px where 4 px give no direction.
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
    fn scales_that_nobody_waits_for_are_refused() {
        let of = |scale, solver| ShapeParams {
            scale,
            solver,
            ..ShapeParams::default()
        };
        let said = |params: ShapeParams| params.validate().unwrap_err().to_string();
        // 4096^2 / 2 / 0.2 steps are a sigma of 4096 px: 41943040, less one as 0.2 is slightly larger in single
        // precision.
        let most = Scale::Iterations(41_943_039);
        of(most, Solver::Chebyshev).validate().unwrap();
        let more = said(of(Scale::Iterations(u32::MAX), Solver::Chebyshev));
        assert_eq!(more, "--iterations is 4294967295; give 0 to 41943039");
        let stepped = said(of(most, Solver::Explicit));
        assert!(
            stepped.starts_with("--solver takes 41943039 explicit steps"),
            "{stepped}"
        );
        of(Scale::Iterations(50_000), Solver::Explicit)
            .validate()
            .unwrap();
        // A sigma of 150 px is a time of 11250: 56,250 steps of 0.2; so is one of 15 px in a picture ten times as high.
        assert!(
            of(Scale::Sigma(150.0), Solver::Explicit)
                .validate()
                .is_err()
        );
        let proxy = ShapeParams {
            reference_height: Some(108),
            ..of(Scale::Sigma(15.0), Solver::Explicit)
        };
        proxy.validate().unwrap();
        assert!(proxy.validate_for(1080).is_err() && proxy.validate_for(108).is_ok());
    }

    #[test]
    fn thresholds_rise() {
        for [lo, hi] in [[2.0, 1.0], [f32::NAN, 1.0], [1.0, f32::NAN]] {
            let crease = SoftThreshold { lo, hi };
            let params = ShapeParams {
                crease,
                ..ShapeParams::default()
            };
            assert!(params.validate().is_err(), "{crease:?}");
        }
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
