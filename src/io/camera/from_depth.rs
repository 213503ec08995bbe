//! The camera's rotation and lens from depth and world-space normals, without positions.
//!
//! The idea: once the focal length is known, depth alone gives the normal of every small patch of surface in view
//! space; the normal map gives the same normals in world space. One rotation maps the latter onto the former, and the
//! right focal length is the one that fits best. So: the best rotation for each focal length (Wahba's problem, by
//! singular values, reweighted against outliers), a scan over focal lengths, then both together by Gauss-Newton.
//!
//! In practice: the errors of smoothed normals on flat facets and of depth rounded to half floats cancel over thousands
//! of patches. The focal length scales every slope, so wherever normals differ enough to fix the rotation they fix it
//! too: to about a hundredth where the rotation is known to a tenth of a degree.
//!
//! How to use it: give a normal map in any space. For view space the rotation comes out as the identity. The eye's
//! position stays unknown: the translation is zero.

use super::depth_fit::Fit;
use super::depth_lens::{Lens, LensKind};
use super::depth_samples::{Facet, NormalsAndDepth};
use super::file::dmat3;
use super::recover::{MIRROR, RecoveryFailure};
use super::samples::{PixelGrid, quantile};
use crate::frame::{Camera, DepthKind, Mask, Plane, Projection, Vector3Planes, Window};
use glam::{DAffine3, DVec3};

/// Fewer patches than this are refused.
const FEWEST: usize = 24;
/// Focal lengths that are tried, in widths of the display window: 137 degrees of view to 2.
const FOCAL_SHARES: (f64, f64) = (0.2, 30.0);
/// Range of pixels per unit tried, as multiples of the value at which the typical slope is 45 degrees.
const UNIT_FACTORS: (f64, f64) = (0.03, 30.0);
/// Share of the telling step below which the median is that of a wall that faces the viewer.
const FACING: f64 = 0.01;
/// Steps of the scan over either.
const STEPS: usize = 16;
/// A focal length less certain than this share is called uncertain.
const UNCERTAIN_FOCAL: f64 = 0.1;
/// Typical offset of depth samples from the centres of their pixels, in pixels, from which on they come from farther than
/// their own pixel: random places within it give 0.3 to 0.4.
const SCATTERED: f64 = 0.6;
/// Typical angle between normals and slopes, in degrees, from which a fit is rejected.
const WORST_RESIDUAL_DEG: f64 = 15.0;
/// From this angle on, in degrees, a mirrored fit is tried; it is accepted if its angle is below this and below this
/// share of the other.
const MIRRORED_RESIDUAL_DEG: f64 = 6.0;
const MIRRORED_SHARE: f64 = 0.4;
/// Rotation less certain than this, in degrees, is no answer.
const WORST_ROTATION_DEG: f64 = 3.0;
/// Mean square sine of the normals about their main direction below which they count as parallel.
const LEAST_SPREAD: f64 = 1e-6;

/// A camera recovered from depth and normals, with the evidence for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthCamera {
    /// The camera. Its translation is zero, since normals carry no positions; its rotation mirrors if the normals are
    /// left-handed or have one axis reversed.
    pub camera: Camera,
    /// Kind of distance in the depth layer. Under a parallel camera both kinds are the same: `Planar`.
    pub depth_kind: DepthKind,
    /// Median angle between the turned normals and the slopes of depth, in degrees.
    pub residual_deg_median: f64,
    /// One standard error of the rotation about its least certain axis, in degrees.
    pub rotation_uncertainty_deg: f64,
    /// One standard error of the focal length (or of pixels per unit), as a share of it.
    pub focal_uncertainty: f64,
    /// Whether the standard error of the focal length is more than a tenth of it.
    pub focal_uncertain: bool,
    /// Whether parallel lines of sight explain the depth nearly as well as a perspective, or the other way round.
    pub has_equal: bool,
    /// Whether depth is scattered as out of focus or in motion: then errors may be larger than these.
    pub is_scattered: bool,
    /// Number of surface patches used.
    pub samples: usize,
}

/// Recovers the rotation and focal length of the camera from depth and normals.
///
/// `normal` holds signed components in world space, shorter than 1 where a filter mixed them; `depth`
/// holds distances in scene units; both and `mask` fill `data_window`. The camera is centred on
/// `display_window`. The same input always gives the same bits.
///
/// # Errors
/// If too little smooth surface is seen, if its normals all point the same way, or if no rotation
/// carries them onto the slopes of depth: a panorama, depth that was scaled.
///
/// # Panics
/// If `normal`, `depth` or `mask` do not have the size of `data_window`.
pub fn recover_camera_from_depth(
    normal: &Vector3Planes,
    depth: &Plane,
    mask: &Mask,
    data_window: Window,
    display_window: Window,
    pixel_aspect: f32,
) -> Result<DepthCamera, RecoveryFailure> {
    for plane in [&normal.x, &normal.y, &normal.z, depth] {
        let size = (plane.width(), plane.height());
        let wanted = (data_window.width(), data_window.height());
        assert_eq!(size, wanted, "a plane does not fill the data window");
    }
    let surface = NormalsAndDepth {
        normal,
        depth,
        mask,
        grid: PixelGrid::new(data_window, display_window, pixel_aspect),
    };
    let mut patches = surface.patches();
    if patches.len() < FEWEST {
        return Err(RecoveryFailure::TooFewPatches {
            found: patches.len(),
            needed: FEWEST,
        });
    }
    let failure = match surface.fitted(&patches) {
        Err(failure @ (RecoveryFailure::Mirrored | RecoveryFailure::NormalsDisagree { .. })) => {
            failure
        }
        other => return other,
    };
    // Mirrored across its y axis, a left-handed world is right-handed.
    for patch in &mut patches {
        patch.normal.y = -patch.normal.y;
    }
    match surface.fitted(&patches) {
        Ok(mut found) if found.residual_deg_median <= MIRRORED_RESIDUAL_DEG => {
            found.camera.view_from_world *= DAffine3::from_scale(MIRROR);
            Ok(found)
        }
        _ => Err(failure),
    }
}

impl NormalsAndDepth<'_> {
    /// The camera that fits these patches, if it passes.
    fn fitted(&self, patches: &[Facet]) -> Result<DepthCamera, RecoveryFailure> {
        let display = self.grid.display;
        let (fit, has_equal, patches) = chosen(patches, display.width() as f64)
            .ok_or(RecoveryFailure::NormalsDisagree { residual_deg: 90.0 })?;
        check_residual(&fit, &patches)?;
        let cost = fit.cost(&patches);
        if cost.spread() < LEAST_SPREAD {
            return Err(RecoveryFailure::ParallelNormals);
        }
        let certainty = fit
            .certainty(&cost, &patches)
            .ok_or(RecoveryFailure::Undetermined { rotation_deg: 90.0 })?;
        let rotation_deg = certainty.turn.to_degrees();
        if rotation_deg > WORST_ROTATION_DEG {
            return Err(RecoveryFailure::Undetermined { rotation_deg });
        }
        let Lens { kind, number } = fit.lens;
        let per_unit = [number, number * self.grid.aspect];
        let turn = dmat3(fit.turn.matrix());
        Ok(DepthCamera {
            camera: Camera {
                view_from_world: DAffine3::from_mat3_translation(turn, DVec3::ZERO),
                projection: Projection::new(kind == LensKind::Parallel, per_unit, display.center()),
            },
            depth_kind: if kind == LensKind::Ray {
                DepthKind::Ray
            } else {
                DepthKind::Planar
            },
            residual_deg_median: angle_deg(fit.residual),
            rotation_uncertainty_deg: rotation_deg,
            focal_uncertainty: certainty.lens,
            focal_uncertain: certainty.lens > UNCERTAIN_FOCAL,
            has_equal,
            is_scattered: self.off_centre().is_some_and(|px| px > SCATTERED),
            samples: patches.len(),
        })
    }
}

/// The angle between unit vectors a distance apart.
fn angle_deg(distance: f64) -> f64 {
    (2.0 * (0.5 * distance).min(1.0).asin()).to_degrees()
}

/// The best fit over kinds of lens and depth, whether lines of sight of the other kind fit nearly as well, and the
/// patches it was determined from.
fn chosen(patches: &[Facet], width: f64) -> Option<(Fit, bool, Vec<Facet>)> {
    let scanned: Vec<Fit> = [LensKind::Planar, LensKind::Ray, LensKind::Parallel]
        .into_iter()
        .filter_map(|kind| Fit::scanned(kind, range(kind, patches, width)?, STEPS, patches))
        .collect();
    let scanned = Fit::ranked(&scanned, patches);
    let facing = Fit::best(&scanned)?.facing(patches);
    let patches = if facing.len() >= FEWEST {
        facing
    } else {
        patches.to_vec()
    };
    let (fit, has_equal) = Fit::chosen(&scanned, &patches)?;
    Some((fit, has_equal, patches))
}

/// The range of parameters to try for a kind of lens; `None` if depth is constant.
fn range(kind: LensKind, patches: &[Facet], width: f64) -> Option<(f64, f64)> {
    let ((low, high), unit) = match kind {
        LensKind::Planar | LensKind::Ray => (FOCAL_SHARES, width),
        LensKind::Parallel => (UNIT_FACTORS, 1.0 / telling_step(patches)),
    };
    (unit.is_finite() && unit > 0.0).then_some((low * unit, high * unit))
}

/// A typical change of depth per pixel: the median. Most of a picture may be a wall that faces the viewer, whose steps tell
/// nothing; then it is that of the steps which make up half of the sum of all.
fn telling_step(patches: &[Facet]) -> f64 {
    let mut steps: Vec<f64> = patches.iter().map(|p| p.depth * p.slope.norm()).collect();
    let median = quantile(&mut steps, 0.5);
    steps.sort_by(f64::total_cmp);
    let mut left = 0.5 * steps.iter().sum::<f64>();
    let middle = steps.into_iter().find(|step| {
        left -= step;
        left <= 0.0
    });
    middle
        .filter(|middle| median < FACING * middle)
        .unwrap_or(median)
}

fn check_residual(fit: &Fit, patches: &[Facet]) -> Result<(), RecoveryFailure> {
    let residual_deg = angle_deg(fit.telling_residual(patches));
    if residual_deg > MIRRORED_RESIDUAL_DEG {
        let mirrored_deg = angle_deg(fit.mirrored_residual(patches));
        if mirrored_deg < MIRRORED_SHARE * residual_deg {
            return Err(RecoveryFailure::Mirrored);
        }
    }
    if residual_deg > WORST_RESIDUAL_DEG {
        return Err(RecoveryFailure::NormalsDisagree { residual_deg });
    }
    Ok(())
}
