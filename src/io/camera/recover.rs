//! The camera from a layer of world-space positions.
//!
//! The idea: every covered pixel pairs a point with its image position, so a few thousand of them fix the camera.
//! Guesses come from linear fits (Hartley-normalised direct linear transform, a homography for points in a plane, an
//! affine map for parallel projections) to all samples and to random subsets. The best few are polished by trimmed,
//! Huber-weighted Levenberg-Marquardt over the parameters of a render camera: rotation, centre and one focal length,
//! with square pixels times the pixel aspect and the principal point at the centre of the display window.
//!
//! In practice: positions in half float, 100 units off the origin, leave the view axis uncertain by 0.1 degree with the
//! eleven free parameters of the linear fit, and by less than 0.01 with these seven.
//!
//! How to use it: the layer must hold positions, not distances, in one space for the whole picture. A left-handed space
//! gives a mirroring rotation. Panoramas, fisheyes and layers in object space fit no camera and are refused.

use super::file::dmat3;
use super::hypotheses::{hypotheses, principal_axes};
use super::model::{CONVERGENCE, Covariance, Free, Model};
use super::samples::{PixelGrid, SeenPoint, UnitSamples, gather, quantile, spread_out};
use crate::frame::{Camera, Mask, OutOfRange, Projection, Vector3Planes, Window};
use glam::{DAffine3, DVec2, DVec3};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Fewer samples than this are refused.
const FEWEST: usize = 24;
/// Samples that rank the guesses.
const RANKING: usize = 600;
/// Number of guesses polished, and samples that this begins with: most guesses end at one camera, which few samples show.
const FINALISTS: usize = 8;
const ROUGHLY: usize = 150;
/// Number of cameras they may end at that are polished on all samples of the ranking.
const CAMERAS: usize = 3;
/// Errors below this many pixels do not rank one guess above another.
const LEAST_ERROR_PX: f64 = 0.01;
/// Rotation less certain than this, in degrees, is no answer.
const WORST_ROTATION_DEG: f64 = 1.0;
/// Largest uncertainty of the focal length, as a share, that is accepted if the points lie in a plane.
const WORST_FOCAL: f64 = 0.1;
/// Largest scatter of samples about their projections, as a multiple of that explained by rounding.
const MOST_SCATTER: f64 = 4.0;
/// Largest mean offset of scattered samples from their projections, as a share of that explained by rounding.
const LEAST_BESIDE: f64 = 0.5;
/// A perspective that moves no sample by more than this many pixels is called parallel.
const LEAST_PERSPECTIVE_PX: f64 = 0.02;
/// A parameter counts as different from zero from this many standard errors on.
const SIGNIFICANT: f64 = 6.0;

/// Converts between a left-handed and a right-handed world.
pub(super) const MIRROR: DVec3 = DVec3::new(1.0, -1.0, 1.0);

/// A camera found in a position layer, with the evidence for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecoveredCamera {
    /// The camera; its turn mirrors where the world is left-handed.
    pub camera: Camera,
    /// Median distance, in pixel widths, between samples and their projections.
    pub residual_px_median: f64,
    /// 95th percentile of the same distance.
    pub residual_px_p95: f64,
    /// Share of samples that agree with the camera within the noise of the others, 0..1.
    pub inlier_share: f64,
    /// Number of samples used.
    pub samples: usize,
}

/// Why no camera was found in a position layer, or in depth and normals.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecoveryFailure {
    /// Too few pixels hold a position.
    #[error("only {found} pixels hold a position, and a camera takes at least {needed}")]
    TooFewPoints {
        /// Pixels that hold one.
        found: usize,
        /// Fewest pixels required.
        needed: usize,
    },
    /// The points lie in a plane, or nearly so, in a way that many cameras fit.
    #[error("the positions lie in one plane seen too flatly to tell the camera")]
    CoplanarUndetermined,
    /// The points, or the normals, vary too little for their rounding.
    #[error("the view direction stays uncertain by {rotation_deg:.1} degrees")]
    Undetermined {
        /// One standard error of the rotation, in degrees.
        rotation_deg: f64,
    },
    /// The best camera is far from the samples: a panorama, a fisheye, or not world positions.
    #[error(
        "the positions fit neither a perspective nor a parallel camera (the best is {residual_px:.1} px off); \
         a panorama, or positions that are not in world space"
    )]
    NotACamera {
        /// Median residual of the best camera, in pixel widths.
        residual_px: f64,
    },
    /// The camera that fits is out of the range of cameras.
    #[error("the camera that fits is out of range: {}", .0.found())]
    OutOfRange(#[from] OutOfRange),
    /// A camera fits, but only with the scene mirrored, or with one axis of the normals reversed.
    #[error("the scene is mirrored: its axes are left-handed")]
    Mirrored,
    /// Too few pixels lie on smooth surface that has both a normal and depth.
    #[error(
        "only {found} places show smooth surface with normals and depth, and a camera takes at least {needed}"
    )]
    TooFewPatches {
        /// Places that show some.
        found: usize,
        /// Fewest patches required.
        needed: usize,
    },
    /// All normals point the same way, so the rotation about them is undetermined.
    #[error("the normals all point the same way, which leaves a turn about it open")]
    ParallelNormals,
    /// No rotation maps the normals onto the slopes of depth.
    #[error(
        "the normals do not follow the slopes of depth (the best camera is {residual_deg:.0} degrees off); \
         a panorama, or depth that is scaled or not a distance"
    )]
    NormalsDisagree {
        /// Median angle between the normals and the slopes, in degrees.
        residual_deg: f64,
    },
}

/// Recovers the camera from world-space positions.
///
/// `position` and `mask` hold the pixels of `data_window`; the camera is centred on
/// `display_window` unless the positions show a lens shift clearly. The same input always gives the
/// same bits.
///
/// A mirrored (left-handed) scene cannot be distinguished from a right-handed one if the camera is parallel or the
/// scene lies in a plane.
///
/// # Errors
/// If the positions do not determine a camera or fit none.
///
/// # Panics
/// If `position` or `mask` do not have the size of `data_window`.
pub fn recover_camera(
    position: &Vector3Planes,
    mask: &Mask,
    data_window: Window,
    display_window: Window,
    pixel_aspect: f32,
) -> Result<RecoveredCamera, RecoveryFailure> {
    let grid = PixelGrid::new(data_window, display_window, pixel_aspect);
    let wanted = (data_window.width(), data_window.height());
    let planes = [&position.x, &position.y, &position.z];
    let fill = planes
        .iter()
        .all(|plane| (plane.width(), plane.height()) == wanted);
    assert!(fill, "the positions do not fill the data window");
    let mut samples = gather(position, mask, grid);
    match BestFit::of(&samples, grid.display) {
        Err(RecoveryFailure::Mirrored) => {
            // Mirrored across its y axis the world is right-handed.
            samples.mirror();
            let found = BestFit::of(&samples, grid.display)?;
            let mut report = found.report(&samples, grid);
            report.camera.view_from_world *= DAffine3::from_scale(MIRROR);
            Ok(report)
        }
        found => Ok(found?.report(&samples, grid)),
    }
}

/// The camera that fits best, and how the samples scatter about it.
struct BestFit {
    model: Model,
    free: Free,
    /// Noise per coordinate, in pixel widths.
    sigma: f64,
    kept: Vec<SeenPoint>,
    /// The covariance of the parameters for a noise of 1; `None` where singular.
    covariance: Option<Covariance>,
}

impl BestFit {
    fn of(samples: &UnitSamples, display: Window) -> Result<BestFit, RecoveryFailure> {
        let found = samples.list.len();
        if found < FEWEST {
            return Err(RecoveryFailure::TooFewPoints {
                found,
                needed: FEWEST,
            });
        }
        let (extent, _) = principal_axes(&samples.list);
        // A line or a single point leaves the rotation about it undetermined.
        let length = extent.x.sqrt();
        let rounding = samples.quantum / samples.spread.max(f64::MIN_POSITIVE);
        if samples.spread <= 0.0 || extent.y.sqrt() <= (1e-6 + rounding) * length {
            return Err(RecoveryFailure::CoplanarUndetermined);
        }
        let fit = Self::chosen(&samples.list, samples.half, display.width() as f64)
            .ok_or(RecoveryFailure::Undetermined { rotation_deg: 90.0 })?;
        fit.check_residual(samples, display)?;
        fit.check_handedness(&samples.list)?;
        let fit = fit.simplest(&samples.list);
        fit.check_certainty()?;
        Ok(fit)
    }

    fn new(model: Model, samples: &[SeenPoint], free: Free) -> Self {
        let (sigma, kept) = model.trimmed(samples);
        Self {
            model,
            free,
            sigma,
            covariance: model.covariance(&kept, free),
            kept,
        }
    }

    /// The best perspective fit, with lens shift where that is called for.
    fn chosen(samples: &[SeenPoint], half: bool, width: f64) -> Option<Self> {
        let ranking = spread_out(samples, RANKING);
        let finalists = distinct(ranked(hypotheses(&ranking, width), &ranking), FINALISTS);
        let best = |free: Free| best_polished(&finalists, &ranking, free);
        let centred = best(Free::Perspective)?;
        let whole = |fit: Self| {
            let model = fit.model.polished(samples, fit.free, 1);
            Self::new(model, samples, fit.free)
        };
        if centred.sigma < 1e-3 {
            return Some(whole(centred));
        }
        let shifted = best(Free::Shifted)?;
        let is_shifted = shifted.shift_is_real(centred.sigma, half);
        Some(whole(if is_shifted { shifted } else { centred }))
    }

    /// Whether a lens shift explains the residual of the centred camera.
    fn shift_is_real(&self, centred_sigma: f64, half: bool) -> bool {
        let gain = if half { 0.4 } else { 0.7 };
        let Some(covariance) = self.covariance(self.sigma) else {
            return false;
        };
        let error = (covariance[(7, 7)] + covariance[(8, 8)]).sqrt();
        self.sigma < gain * centred_sigma && self.model.principal.norm() > SIGNIFICANT * error
    }

    /// The covariance of the parameters for a noise of `sigma`.
    fn covariance(&self, sigma: f64) -> Option<Covariance> {
        self.covariance.map(|of_one| sigma * sigma * of_one)
    }

    /// Refuses a camera whose residual exceeds the combined effect of rounding, jitter and compression.
    fn check_residual(
        &self,
        samples: &UnitSamples,
        display: Window,
    ) -> Result<(), RecoveryFailure> {
        let residual_px = self.model.median_error(&samples.list);
        let rounding_px = samples.quantum / samples.spread * self.model.scale;
        let diagonal = (display.width() as f64).hypot(display.height() as f64);
        let limit = 1.0 + 0.002 * diagonal.min(2000.0) + rounding_px;
        // Out of focus and in motion positions scatter about the projected point, without bias.
        let is_scatter = || {
            let width = display.width() as f64;
            residual_px <= MOST_SCATTER * limit
                && self.model.mean_error(&samples.list, width) <= LEAST_BESIDE * limit
        };
        let half_kept = 2 * self.kept.len() >= samples.list.len();
        if half_kept && (residual_px <= limit || is_scatter()) {
            Ok(())
        } else {
            Err(RecoveryFailure::NotACamera { residual_px })
        }
    }

    /// The most that perspective moves a sample, in pixel widths.
    fn perspective_px(&self) -> f64 {
        let moved = |s: &SeenPoint| {
            let depth = (self.model.rotation * s.point).z;
            (self.model.convergence * depth).abs() * s.seen.norm()
        };
        let mut all: Vec<f64> = self.kept.iter().map(moved).collect();
        quantile(&mut all, 0.99)
    }

    /// Convergence in standard errors.
    fn convergence_significance(&self) -> f64 {
        let error = self
            .covariance(self.sigma)
            .map_or(f64::INFINITY, |c| c[(CONVERGENCE, CONVERGENCE)].sqrt());
        self.model.convergence / error.max(f64::MIN_POSITIVE)
    }

    fn check_handedness(&self, samples: &[SeenPoint]) -> Result<(), RecoveryFailure> {
        let reversed = self.convergence_significance() < -SIGNIFICANT
            && self.perspective_px() > LEAST_PERSPECTIVE_PX + self.sigma / 4.0;
        if reversed && !self.is_flat(samples) {
            return Err(RecoveryFailure::Mirrored);
        }
        Ok(())
    }

    /// A parallel camera where perspective explains nothing.
    fn simplest(self, samples: &[SeenPoint]) -> Self {
        let perspective = self.convergence_significance() > SIGNIFICANT
            && self.perspective_px() > LEAST_PERSPECTIVE_PX;
        if perspective {
            return self;
        }
        let parallel = Model {
            convergence: 0.0,
            shift: self.model.shift + self.model.principal,
            principal: nalgebra::Vector2::zeros(),
            ..self.model
        };
        let parallel = parallel.polished(samples, Free::Parallel, 4);
        Self::new(parallel, samples, Free::Parallel)
    }

    /// Whether the samples deviate from a plane by no more than their noise.
    fn is_flat(&self, samples: &[SeenPoint]) -> bool {
        let (_, axes) = principal_axes(&self.kept);
        let normal: Vector3<f64> = axes.column(2).into_owned();
        let mut heights: Vec<f64> = samples.iter().map(|s| s.point.dot(&normal)).collect();
        let middle = quantile(&mut heights, 0.5);
        let mut off: Vec<f64> = heights.iter().map(|h| (h - middle).abs()).collect();
        quantile(&mut off, 0.75) * self.model.scale < 2.0 * self.sigma.max(5e-3)
    }

    fn check_certainty(&self) -> Result<(), RecoveryFailure> {
        let flat = self.is_flat(&self.kept);
        if flat && self.free == Free::Parallel {
            return Err(RecoveryFailure::CoplanarUndetermined);
        }
        // Exact data are not certain without end: their model of the lens is not exact.
        let covariance = self.covariance(self.sigma.max(0.02));
        let rotation_deg = covariance.map_or(90.0, |c| {
            let of_rotation = c.fixed_view::<3, 3>(0, 0).into_owned();
            let most = of_rotation.symmetric_eigenvalues().max();
            most.max(0.0).sqrt().to_degrees()
        });
        if rotation_deg > WORST_ROTATION_DEG {
            return Err(if flat {
                RecoveryFailure::CoplanarUndetermined
            } else {
                RecoveryFailure::Undetermined { rotation_deg }
            });
        }
        let focal_error = covariance.map_or(1.0, |c| {
            c[(CONVERGENCE, CONVERGENCE)].sqrt() / self.model.convergence
        });
        if flat && focal_error > WORST_FOCAL {
            return Err(RecoveryFailure::CoplanarUndetermined);
        }
        Ok(())
    }

    fn report(&self, samples: &UnitSamples, grid: PixelGrid) -> RecoveredCamera {
        let list = &samples.list;
        let mut errors: Vec<f64> = list.iter().map(|s| self.model.error(s)).collect();
        RecoveredCamera {
            camera: self.camera(samples, grid),
            residual_px_median: quantile(&mut errors, 0.5),
            residual_px_p95: quantile(&mut errors, 0.95),
            inlier_share: self.kept.len() as f64 / list.len() as f64,
            samples: list.len(),
        }
    }

    /// The model back in scene units and absolute pixels.
    fn camera(&self, samples: &UnitSamples, grid: PixelGrid) -> Camera {
        let model = &self.model;
        let per_unit = model.scale / samples.spread;
        let are_parallel = self.free == Free::Parallel;
        let (scale, distance) = match are_parallel {
            true => {
                let depths = self.kept.iter().map(|s| (model.rotation * s.point).z);
                let nearest = depths.fold(f64::NEG_INFINITY, f64::max);
                (per_unit, samples.spread * (nearest + 1.0))
            }
            false => {
                let focal = model.scale / model.convergence;
                (focal, samples.spread / model.convergence)
            }
        };
        let off = DVec2::new(model.principal.x, -(grid.aspect * model.principal.y));
        let axis = grid.display.center() + off;
        let turned = model.rotation * samples.centroid;
        let offset = model.shift / per_unit;
        let translation = DVec3::new(
            offset.x - turned.x,
            offset.y - turned.y,
            -distance - turned.z,
        );
        let turn = dmat3(model.rotation.matrix());
        Camera {
            view_from_world: DAffine3::from_mat3_translation(turn, translation),
            projection: Projection::new(are_parallel, [scale, scale * grid.aspect], axis),
        }
    }
}

/// Models ordered by the share of samples they leave unexplained, best first.
///
/// A sample counts as explained within a few times the least median error of all models. Comparing the medians
/// themselves would fail: if most samples lie in a plane, models that fit nothing else tie.
fn ranked(models: Vec<Model>, samples: &[SeenPoint]) -> Vec<(f64, Model)> {
    let medians = models.iter().map(|m| m.median_error(samples));
    let limit = 3.0 * medians.fold(f64::INFINITY, f64::min).max(LEAST_ERROR_PX);
    let mut ranked: Vec<(f64, Model)> = models
        .into_iter()
        .map(|m| (m.unexplained(samples, limit), m))
        .collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked
}

/// The best of the models once each is polished: roughly, on some of the samples, and those cameras that they end at on
/// all.
fn best_polished(models: &[Model], samples: &[SeenPoint], free: Free) -> Option<BestFit> {
    let (_, axes) = principal_axes(samples);
    let some = spread_out(samples, ROUGHLY);
    let rough = polished(models, &some, free, &axes);
    let cameras = distinct(ranked(rough, samples), CAMERAS);
    let ranked = ranked(polished(&cameras, samples, free, &axes), samples);
    let &(least, first) = ranked.first()?;
    let as_good = |(unexplained, m): &(f64, Model)| {
        m.convergence >= 0.0 && *unexplained <= 1.05 * least + 1e-6
    };
    let best = ranked.iter().find(|r| as_good(r)).map_or(first, |r| r.1);
    Some(BestFit::new(best, samples, free))
}

/// The models, polished; with those that face the plane through the first two of `axes` from behind, from in front.
fn polished(
    models: &[Model],
    samples: &[SeenPoint],
    free: Free,
    axes: &Matrix3<f64>,
) -> Vec<Model> {
    let polished = models.par_iter().flat_map_iter(|model| {
        let model = model.polished(samples, free, 4);
        // A plane has the same image for an eye in front of it and a reversed one behind it.
        let facing =
            (model.convergence < 0.0).then(|| model.facing_plane(axes).polished(samples, free, 4));
        std::iter::once(model).chain(facing)
    });
    polished.collect()
}

/// The first `count` distinct ones among ranked models.
fn distinct(ranked: Vec<(f64, Model)>, count: usize) -> Vec<Model> {
    let mut chosen: Vec<Model> = Vec::new();
    for (_, model) in ranked {
        let new = chosen.iter().all(|c| {
            c.rotation.angle_to(&model.rotation) > 0.02
                || (c.convergence - model.convergence).abs() > 0.05 * c.convergence.abs()
        });
        if new {
            chosen.push(model);
        }
        if chosen.len() == count {
            break;
        }
    }
    chosen
}
