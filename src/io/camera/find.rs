//! Which camera a picture was made by: from a file, from positions, else from depth and normals.

use super::{RecoveryFailure, read_camera, recover_camera, recover_camera_from_depth};
use crate::error::Result;
use crate::frame::{Camera, Projection, Vector3Planes};
use crate::io::inputs::Inputs;
use crate::io::load::Finding;
use crate::io::view::Surface;
use glam::DVec3;

/// What findings about the camera are called.
pub(in crate::io) const CAMERA: &str = "camera";

/// A search for the camera, with what it found on the way.
pub(in crate::io) struct CameraSearch<'a> {
    inputs: &'a Inputs,
    surface: &'a Surface<'a>,
    failure: Option<RecoveryFailure>,
    pub(in crate::io) findings: Vec<Finding>,
}

/// A camera, and what it rests on.
#[derive(Debug, Clone)]
pub(in crate::io) struct FoundCamera {
    pub(in crate::io) camera: Camera,
    evidence: String,
    /// One standard error of its turn, and the angle that is left between normals and depth, in degrees.
    pub(in crate::io) turn_error_deg: Option<f64>,
    pub(in crate::io) residual_deg: Option<f64>,
}

impl FoundCamera {
    fn new(camera: Camera, evidence: String) -> Self {
        Self {
            camera,
            evidence,
            turn_error_deg: None,
            residual_deg: None,
        }
    }
}

impl<'a> CameraSearch<'a> {
    pub(in crate::io) fn new(inputs: &'a Inputs, surface: &'a Surface<'a>) -> Self {
        Self {
            inputs,
            surface,
            failure: None,
            findings: Vec::new(),
        }
    }

    /// The camera whose place in the world is told: by a file, or by positions.
    ///
    /// # Errors
    /// Those of reading the file.
    pub(in crate::io) fn placed(&mut self) -> Result<Option<Camera>> {
        let Surface {
            position,
            display_window,
            pixel_aspect,
            ..
        } = *self.surface;
        if let Some(camera) = self.inputs.known_camera {
            return Ok(Some(camera));
        }
        let found = match (&self.inputs.camera, position) {
            (Some(path), _) => {
                let camera = read_camera(path, display_window, pixel_aspect)?;
                FoundCamera::new(camera, format!("from {}", path.display()))
            }
            (None, Some(position)) => match self.from_positions(position) {
                Ok(found) => found,
                Err(failure) => {
                    self.failure = Some(failure);
                    self.tell(None);
                    return Ok(None);
                }
            },
            (None, None) => return Ok(None),
        };
        self.tell(Some(&found));
        Ok(Some(found.camera))
    }

    fn from_positions(
        &self,
        position: &Vector3Planes,
    ) -> std::result::Result<FoundCamera, RecoveryFailure> {
        let surface = self.surface;
        let found = recover_camera(
            position,
            surface.mask,
            surface.data_window,
            surface.display_window,
            surface.pixel_aspect,
        )?;
        let evidence = format!(
            "recovered from {} positions, median residual {:.4} px, 95 % under {:.4} px",
            found.samples, found.residual_px_median, found.residual_px_p95
        );
        Ok(FoundCamera::new(found.camera, evidence))
    }

    /// The turn and lens that depth and `normal` tell; no place. Not told yet.
    pub(in crate::io) fn by_depth(&mut self, normal: &Vector3Planes) -> Option<FoundCamera> {
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
        let found = match found {
            Ok(found) => found,
            Err(failure) => {
                self.failure = Some(failure);
                return None;
            }
        };
        let evidence = format!(
            "recovered from normals and {}, rotation within {:.2} degrees, focal within {:.1} %",
            found.depth_kind,
            found.rotation_uncertainty_deg,
            100.0 * found.focal_uncertainty
        );
        Some(FoundCamera {
            turn_error_deg: Some(found.rotation_uncertainty_deg),
            residual_deg: Some(found.residual_deg_median),
            ..FoundCamera::new(found.camera, evidence)
        })
    }

    /// Notes the camera that was found, or why none was.
    pub(in crate::io) fn tell(&mut self, found: Option<&FoundCamera>) {
        let evidence = match (found, self.failure) {
            (Some(found), _) => found.evidence.clone(),
            (None, Some(failure)) => failure.to_string(),
            (None, None) => return,
        };
        self.findings.push(Finding {
            subject: CAMERA.into(),
            conclusion: found.map_or("unknown".into(), |found| described(&found.camera)),
            evidence,
            flag: "--camera FILE".into(),
        });
    }
}

/// The camera in words; its place only where something told it.
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
