//! The axes that normals are written in.

use crate::error::{Result, bad};
use crate::frame::{Frame, Plane, Vector3Planes};
use glam::{DMat3, DVec3};

/// Axes of normals, named by who writes them so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NormalAxes {
    /// x right, y up, z toward the viewer: view space.
    OpenGl,
    /// y down.
    DirectX,
    /// y down, z away from the viewer.
    OpenCv,
    /// x to the left.
    StableNormal,
    /// The scene's own.
    World,
    /// View space without z.
    Xy,
}

impl NormalAxes {
    pub(crate) const ALL: [(Self, &'static str); 6] = [
        (Self::OpenGl, "opengl"),
        (Self::DirectX, "directx"),
        (Self::OpenCv, "opencv"),
        (Self::StableNormal, "stablenormal"),
        (Self::World, "world"),
        (Self::Xy, "xy"),
    ];

    /// The components of normals of a frame, 0 outside its mask.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for the scene's axes where no camera tells them.
    pub(crate) fn of_view(self, frame: &Frame, normal: &Vector3Planes) -> Result<Vec<Plane>> {
        let turn = match self {
            Self::OpenGl | Self::Xy => DMat3::IDENTITY,
            Self::DirectX => DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)),
            Self::OpenCv => DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)),
            Self::StableNormal => DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
            Self::World => {
                let camera = frame.camera.ok_or_else(|| {
                    bad(
                        "--as",
                        "world takes a camera, and none is known",
                        "give one with --camera FILE",
                    )
                })?;
                camera.view_from_world.matrix3.transpose()
            }
        };
        let mask = &frame.mask;
        let component = |axis: usize| {
            let row = turn.row(axis);
            Plane::from_fn(mask.width(), mask.height(), |x, y| match mask.at(x, y) {
                true => row.dot(normal.at(x, y)) as f32,
                false => 0.0,
            })
        };
        let count = if self == Self::Xy { 2 } else { 3 };
        Ok((0..count).map(component).collect())
    }
}
