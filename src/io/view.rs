//! The turn to view space: which camera, which space the normals were in, and why.

use super::camera::{RecoveryFailure, read_camera, recover_camera, recover_camera_from_depth};
use super::inputs::Inputs;
use super::load::Finding;
use super::normal_space::{NormalSpaceConclusion, judge_normal_space};
use crate::error::{Error, Result};
use crate::frame::{Camera, Mask, NormalSpace, Plane, Projection, Vector3Planes, Window};
use glam::{DVec3, Mat3};

/// What the camera and the space of the normals are judged from.
pub(super) struct Surface<'a> {
    pub(super) mask: &'a Mask,
    pub(super) position: Option<&'a Vector3Planes>,
    pub(super) depth: Option<&'a Plane>,
    pub(super) data_window: Window,
    pub(super) display_window: Window,
    pub(super) pixel_aspect: f32,
}

/// The camera, where one was found, and what was concluded.
pub(super) struct View {
    pub(super) camera: Option<Camera>,
    /// Whether it is known where in the world the camera stands, and not only how it is turned.
    pub(super) is_placed: bool,
    /// How the stored normals were read.
    pub(super) normals: NormalReading,
    pub(super) findings: Vec<Finding>,
}

/// Turns unit normals to view space, in place. A camera is looked for where it is needed: to turn
/// normals, to know their space, or because the projection is asked for.
pub(super) fn turn_to_view(
    inputs: &Inputs,
    surface: &Surface,
    projection: bool,
    normal: &mut Vector3Planes,
) -> Result<View> {
    let mut findings = Vec::new();
    let spared = !projection && inputs.camera.is_none();
    let unaided = spared.then(|| Reading::of(inputs, surface, normal, None, &[]).ok());
    let in_view_already = unaided
        .flatten()
        .filter(|r| r.normals.space == NormalSpace::View);
    let (reading, camera) = match in_view_already {
        Some(reading) => (reading, None),
        None => {
            let camera = find_camera(inputs, surface, normal, &mut findings)?;
            let reading = Reading::of(inputs, surface, normal, camera.as_ref(), &findings)?;
            (reading, camera)
        }
    };
    findings.push(reading.finding());
    let normals = reading.normals;
    if normals.space == NormalSpace::World && camera.is_none() {
        return Err(no_camera(inputs, &reading.reason, &findings));
    }
    normals.turn(normal, camera.as_ref());
    let is_placed = inputs.camera.is_some() || surface.position.is_some();
    Ok(View {
        is_placed: is_placed && camera.is_some(),
        camera,
        normals,
        findings,
    })
}

/// How stored normals are to be read.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalReading {
    space: NormalSpace,
    flip_z: bool,
}

impl NormalReading {
    /// Turns stored normals to view space, in place. Those in world space take a camera.
    pub(super) fn turn(self, normal: &mut Vector3Planes, camera: Option<&Camera>) {
        match (self.space, camera) {
            (NormalSpace::World, Some(camera)) => rotate(normal, camera),
            (NormalSpace::View, _) if self.flip_z => {
                normal.z.samples_mut().iter_mut().for_each(|z| *z = -*z);
            }
            _ => {}
        }
    }
}

/// How the stored normals are to be read.
struct Reading {
    normals: NormalReading,
    reason: String,
}

impl Reading {
    /// The reading that was asked for, else the one that the data tell.
    fn of(
        inputs: &Inputs,
        surface: &Surface,
        normal: &Vector3Planes,
        camera: Option<&Camera>,
        findings: &[Finding],
    ) -> Result<Self> {
        match inputs.normal_space {
            Some(space) => Ok(Self {
                normals: NormalReading {
                    space,
                    flip_z: false,
                },
                reason: "as told".into(),
            }),
            None => judged(inputs, surface, normal, camera, findings),
        }
    }

    fn finding(&self) -> Finding {
        let (name, flag) = match (self.normals.space, self.normals.flip_z) {
            (NormalSpace::World, _) => ("world", "--normal-space world"),
            (NormalSpace::View, false) => ("view", "--normal-space view"),
            (NormalSpace::View, true) => (
                "view, z away from the viewer",
                "--normal-space view --normal-flip z",
            ),
        };
        Finding {
            subject: "normal space".into(),
            conclusion: name.into(),
            evidence: self.reason.clone(),
            flag: flag.into(),
        }
    }
}

fn judged(
    inputs: &Inputs,
    surface: &Surface,
    normal: &Vector3Planes,
    camera: Option<&Camera>,
    findings: &[Finding],
) -> Result<Reading> {
    let Surface {
        mask,
        position,
        depth,
        data_window,
        ..
    } = *surface;
    let verdict = judge_normal_space(normal, mask, position, depth, camera, data_window);
    let reason = verdict.reason;
    match verdict.conclusion {
        NormalSpaceConclusion::Certain { space, flip_z } => Ok(Reading {
            normals: NormalReading { space, flip_z },
            reason,
        }),
        NormalSpaceConclusion::WorldWithoutCamera => Err(no_camera(inputs, &reason, findings)),
        // An empty mask has no normals to be read either way.
        NormalSpaceConclusion::Ambiguous if surface.mask.count() == 0 => Ok(Reading {
            normals: NormalReading {
                space: NormalSpace::View,
                flip_z: false,
            },
            reason,
        }),
        NormalSpaceConclusion::Ambiguous => Err(Error::Undetermined {
            path: inputs.picture.clone(),
            found: format!("the space of the normals is unclear ({reason})"),
            remedy: "name it with --normal-space view or --normal-space world".into(),
        }),
    }
}

/// World-space normals that nothing can turn; says what was tried to find a camera.
fn no_camera(inputs: &Inputs, reason: &str, findings: &[Finding]) -> Error {
    let tried: Vec<_> = findings
        .iter()
        .filter(|f| f.subject == CAMERA)
        .map(|f| format!("; {}", f.evidence))
        .collect();
    Error::Undetermined {
        path: inputs.picture.clone(),
        found: format!(
            "normals in world space, and no camera ({reason}{})",
            tried.concat()
        ),
        remedy: "give --camera FILE, or --normal-space view if they are not".into(),
    }
}

/// What findings about the camera are called.
const CAMERA: &str = "camera";

fn find_camera(
    inputs: &Inputs,
    surface: &Surface,
    normal: &Vector3Planes,
    findings: &mut Vec<Finding>,
) -> Result<Option<Camera>> {
    let (camera, evidence) = if let Some(path) = &inputs.camera {
        let camera = read_camera(path, surface.display_window, surface.pixel_aspect)?;
        (Some(camera), format!("from {}", path.display()))
    } else {
        let recovered = match (surface.position, surface.depth) {
            (Some(position), _) => from_positions(surface, position),
            (None, Some(depth)) => from_depth(surface, normal, depth),
            (None, None) => return Ok(None),
        };
        match recovered {
            Ok((camera, evidence)) => (Some(camera), evidence),
            Err(failure) => (None, failure.to_string()),
        }
    };
    findings.push(Finding {
        subject: CAMERA.into(),
        conclusion: camera.map_or("unknown".into(), |camera| described(&camera)),
        evidence,
        flag: "--camera FILE".into(),
    });
    Ok(camera)
}

/// A recovered camera, and what it was recovered from.
type Recovered = std::result::Result<(Camera, String), RecoveryFailure>;

fn from_positions(surface: &Surface, position: &Vector3Planes) -> Recovered {
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
    Ok((found.camera, evidence))
}

fn from_depth(surface: &Surface, normal: &Vector3Planes, depth: &Plane) -> Recovered {
    let found = recover_camera_from_depth(
        normal,
        depth,
        surface.mask,
        surface.data_window,
        surface.display_window,
        surface.pixel_aspect,
    )?;
    let evidence = format!(
        "recovered from normals and {}, rotation within {:.2} degrees, focal within {:.1} %",
        found.depth_kind,
        found.rotation_uncertainty_deg,
        100.0 * found.focal_uncertainty
    );
    Ok((found.camera, evidence))
}

/// The camera in words; its place only where something told it.
fn described(camera: &Camera) -> String {
    let eye = camera.view_from_world.inverse().translation;
    let axis = camera.view_from_world.matrix3.transpose() * DVec3::NEG_Z;
    let place = if eye == DVec3::ZERO {
        String::new()
    } else {
        format!(" from ({:.3}, {:.3}, {:.3})", eye.x, eye.y, eye.z)
    };
    let looks = format!(
        "looking along ({:.3}, {:.3}, {:.3}){place}",
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

fn rotate(normal: &mut Vector3Planes, camera: &Camera) {
    let turn = Mat3::from_cols_array(
        &camera
            .view_from_world
            .matrix3
            .to_cols_array()
            .map(|v| v as f32),
    );
    let components = normal
        .x
        .samples_mut()
        .iter_mut()
        .zip(normal.y.samples_mut())
        .zip(normal.z.samples_mut());
    for ((x, y), z) in components {
        let turned = turn * glam::Vec3::new(*x, *y, *z);
        (*x, *y, *z) = (turned.x, turned.y, turned.z);
    }
}
