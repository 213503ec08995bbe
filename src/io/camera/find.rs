//! Which camera a picture was made by: from a file, from attributes, from positions, else from depth and normals.

use super::attributes::{CameraCandidate, candidates, is_mirrored};
use super::samples::quantile;
use super::{DepthCamera, RecoveryFailure, read_camera, recover_camera, recover_camera_from_depth};
use crate::error::{Error, Result};
use crate::frame::{Camera, Projection, Vector3Planes};
use crate::io::finding::Finding;
use crate::io::inputs::Inputs;
use crate::io::judge::surface::SurfaceSamples;
use crate::io::normal_space::NormalSamples;
use glam::DVec3;

/// Subject of findings about the camera.
pub(in crate::io) const CAMERA: &str = "camera";

/// Approximate number of positions for testing a camera.
const PROBES: usize = 2000;
/// A camera that positions contradict by more than this share of the picture's width is not theirs.
const MOST_OFF: f64 = 0.005;
/// Largest misfit, as a share, of normals that still count as evidence for a camera.
const WORST_MISFIT: f64 = 0.2;

/// A search for the camera, with its findings so far.
pub(in crate::io) struct CameraSearch<'a> {
    inputs: &'a Inputs,
    surface: &'a SurfaceSamples<'a>,
    failure: Option<RecoveryFailure>,
    /// Whether a camera was recovered from layers, rather than given.
    pub(in crate::io) has_recovered: bool,
    pub(in crate::io) findings: Vec<Finding>,
    /// Why the camera is a guess, if it is one.
    pub(in crate::io) doubt: Option<&'static str>,
}

/// A camera with its evidence.
#[derive(Debug, Clone)]
pub(in crate::io) struct FoundCamera {
    pub(in crate::io) camera: Camera,
    evidence: String,
    /// What was found of depth and normals, if it was.
    pub(in crate::io) by_depth: Option<DepthCamera>,
}

impl FoundCamera {
    fn new(camera: Camera, evidence: String) -> Self {
        Self {
            camera,
            evidence,
            by_depth: None,
        }
    }

    /// Why it is a guess, if it is one.
    fn doubt(&self) -> Option<&'static str> {
        match self.by_depth? {
            found if found.is_scattered => Some("blur scatters the depth"),
            found if found.has_equal => {
                Some("perspective and parallel lines of sight explain the depth nearly as well")
            }
            _ => None,
        }
    }
}

impl<'a> CameraSearch<'a> {
    pub(in crate::io) fn new(inputs: &'a Inputs, surface: &'a SurfaceSamples<'a>) -> Self {
        Self {
            inputs,
            surface,
            failure: None,
            has_recovered: false,
            findings: Vec::new(),
            doubt: None,
        }
    }

    /// The camera with a known world-space position: from a file, from attributes, or from positions. `normals` help to
    /// decide between readings of attributes.
    ///
    /// # Errors
    /// Those of reading the file.
    pub(in crate::io) fn placed(&mut self, normals: &NormalSamples) -> Result<Option<Camera>> {
        let surface = self.surface;
        if let Some(known) = self.inputs.known_camera {
            let checked = known.camera.check(surface.display_window);
            checked.map_err(|number| Error::BadParameter {
                name: "--still-camera",
                found: format!("is out of range: {}", number.found()),
                remedy: number.remedy(),
            })?;
            return Ok(known.is_placed.then_some(known.camera));
        }
        let found = match &self.inputs.camera {
            Some(path) => {
                let camera = read_camera(path, surface.display_window, surface.pixel_aspect)?;
                let evidence = format!("from {}", path.display());
                Some(FoundCamera::new(camera, evidence))
            }
            None => {
                let by_attributes = self.by_attributes(normals);
                by_attributes.or_else(|| self.by_positions())
            }
        };
        self.report(found.as_ref());
        Ok(found.map(|found| found.camera))
    }

    /// The reading of the attributes that agrees best with the positions, else with the normals, else the
    /// standard's.
    fn by_attributes(&self, normals: &NormalSamples) -> Option<FoundCamera> {
        let surface = self.surface;
        let aspect = f64::from(surface.pixel_aspect);
        let candidates = candidates(surface.attributes?, surface.display_window, aspect);
        let (chosen, agrees) = match surface.position {
            Some(position) => {
                let off = |c: &CameraCandidate| off_positions_px(&c.camera, surface, position);
                let (chosen, off) = best(&candidates, off)?;
                let limit = MOST_OFF * (surface.display_window.width() as f64).max(1.0);
                if off > limit {
                    return None;
                }
                (
                    chosen,
                    format!(", {off:.3} px off the positions in the median"),
                )
            }
            None => {
                let proper = candidates.iter().filter(|c| !is_mirrored(&c.camera));
                let mut sensible: Vec<CameraCandidate> = proper.cloned().collect();
                if sensible.is_empty() {
                    sensible = candidates;
                }
                let (chosen, misfit) = best(&sensible, |c| misfit(&c.camera, surface, normals))?;
                let agrees = match misfit < WORST_MISFIT {
                    true => ", by which the normals fit best".into(),
                    false => String::new(),
                };
                let spec = sensible.swap_remove(0);
                let chosen = if agrees.is_empty() { spec } else { chosen };
                (chosen, agrees)
            }
        };
        let evidence = format!("from its attributes: {}{agrees}", chosen.reading);
        Some(FoundCamera::new(chosen.camera, evidence))
    }

    fn by_positions(&mut self) -> Option<FoundCamera> {
        let surface = self.surface;
        let found = recover_camera(
            surface.position?,
            surface.mask,
            surface.data_window,
            surface.display_window,
            surface.pixel_aspect,
        );
        let found = self.recovered(found, |found| found.camera)?;
        let evidence = format!(
            "recovered from {} positions, median residual {:.4} px, 95 % under {:.4} px",
            found.samples, found.residual_px_median, found.residual_px_p95
        );
        Some(FoundCamera::new(found.camera, evidence))
    }

    /// What was recovered, unless that failed or its camera is out of range, which is noted.
    fn recovered<T>(
        &mut self,
        found: std::result::Result<T, RecoveryFailure>,
        camera: impl Fn(&T) -> Camera,
    ) -> Option<T> {
        let in_range = found.and_then(|found| {
            camera(&found).check(self.surface.display_window)?;
            Ok(found)
        });
        self.has_recovered |= in_range.is_ok();
        in_range
            .map_err(|failure| self.failure = Some(failure))
            .ok()
    }

    /// Rotation and lens recovered from depth and `normal`, without a place. It makes no finding.
    pub(in crate::io) fn by_depth(&mut self, normal: &Vector3Planes) -> Option<FoundCamera> {
        if let Some(known) = self.inputs.known_camera {
            let given = FoundCamera::new(known.camera, "as given".into());
            return (!known.is_placed).then_some(given);
        }
        let surface = self.surface;
        let depth = surface.depth?;
        let found = recover_camera_from_depth(
            normal,
            depth,
            surface.mask,
            surface.data_window,
            surface.display_window,
            surface.pixel_aspect,
        );
        let found = self.recovered(found, |found| found.camera)?;
        let evidence = format!(
            "recovered from normals and {}, rotation within {:.2} degrees, focal within {:.1} %",
            found.depth_kind,
            found.rotation_uncertainty_deg,
            100.0 * found.focal_uncertainty
        );
        Some(FoundCamera {
            by_depth: Some(found),
            ..FoundCamera::new(found.camera, evidence)
        })
    }

    /// Notes the camera that was found, or why none was.
    pub(in crate::io) fn report(&mut self, found: Option<&FoundCamera>) {
        let evidence = match (found, self.failure) {
            (Some(found), _) => found.evidence.clone(),
            (None, Some(failure)) => failure.to_string(),
            (None, None) => return,
        };
        self.doubt = found.and_then(FoundCamera::doubt);
        self.findings.push(Finding {
            subject: CAMERA.into(),
            conclusion: found.map_or("unknown".into(), |found| described(&found.camera)),
            evidence,
            flag: "--camera FILE".into(),
        });
    }
}

/// The candidate with the least cost, and that; the first of equals.
fn best(
    candidates: &[CameraCandidate],
    cost: impl Fn(&CameraCandidate) -> f64,
) -> Option<(CameraCandidate, f64)> {
    let costs = candidates.iter().map(|c| (c, cost(c)));
    let better = |best: (_, f64), next: (_, f64)| {
        if next.1 < 0.9 * best.1 - 1e-9 {
            next
        } else {
            best
        }
    };
    let (candidate, cost) = costs.reduce(better)?;
    Some((candidate.clone(), cost))
}

/// Median distance, in pixels, between the pixels of positions and their projections by the camera.
fn off_positions_px(camera: &Camera, surface: &SurfaceSamples, position: &Vector3Planes) -> f64 {
    let covered = surface.mask.sample(PROBES).filter_map(|(x, y)| {
        let point = position.at(x, y);
        (point.is_finite() && point != DVec3::ZERO).then_some((x, y, point))
    });
    let mut off: Vec<f64> = covered
        .map(|(x, y, point)| {
            let seen = camera.pixel_of(point);
            let at = surface.data_window.middle(x, y);
            seen.map_or(f64::INFINITY, |seen| seen.distance(at))
        })
        .collect();
    match off.is_empty() {
        true => f64::INFINITY,
        false => quantile(&mut off, 0.5),
    }
}

/// Misfit between a camera and normals assumed to be in world space: 0 for a good fit, 1 for none.
fn misfit(camera: &Camera, surface: &SurfaceSamples, normals: &NormalSamples) -> f64 {
    let verdict = normals.judge(Some(camera), surface.data_window);
    let evidence = verdict.evidence;
    let averted = 1.0 - evidence.world.facing;
    averted.max(evidence.world.slope_deg.unwrap_or(0.0) / 90.0)
}

/// The camera in words; its position only if known.
fn described(camera: &Camera) -> String {
    let turn = camera.view_from_world.matrix3;
    let eye = camera.view_from_world.inverse().translation;
    let axis = turn.transpose() * DVec3::NEG_Z;
    let place = if eye == DVec3::ZERO {
        String::new()
    } else {
        format!(" from ({:.3}, {:.3}, {:.3})", eye.x, eye.y, eye.z)
    };
    let world = match turn.determinant() > 0.0 {
        true => "",
        false => ", in a left-handed world",
    };
    let looks = format!(
        "looking along ({:.3}, {:.3}, {:.3}){place}{world}",
        axis.x, axis.y, axis.z
    );
    match camera.projection {
        Projection::Perspective { fx, .. } => {
            format!("perspective, focal {fx:.1} px, {looks}")
        }
        Projection::Orthographic { sx, .. } => {
            format!("orthographic, {sx:.2} px per unit, {looks}")
        }
    }
}
