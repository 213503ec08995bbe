//! Normals of a depth in memory.

use super::work::Work;
use crate::error::{Error, Result};
use crate::frame::from_depth::{Precision, normals_of_depth};
use crate::frame::{DepthKind, Plane, Samples, StoredDepth, Window};
use crate::io::camera::camera_of_text;

/// Unit normals in view space of the surface that a depth shows, as planes of x, y and z; 0 where no surface is, or no
/// neighbour along one axis. Depth is read by the settings of `work`, without any along the view axis; the camera is the
/// text of a camera file.
///
/// # Errors
/// [`Error::BadParameter`] for samples that don't match the size, for depth that is no distance, and for a camera that
/// can't be used; [`Error::Arguments`] for settings that name layers.
pub fn normals_of(
    size: [usize; 2],
    depth: &Samples<'_>,
    camera: &str,
    pixel_aspect: f32,
    work: &Work,
) -> Result<[Plane; 3]> {
    work.refuse_names()?;
    let stored = work.inputs().depth_kind.unwrap_or(StoredDepth::Planar);
    let kind = stored.kind_of(depth.is_half());
    if kind == DepthKind::Relative {
        return Err(Error::BadParameter {
            name: "depth",
            found: format!("is {}, which shows no slopes", DepthKind::Relative),
            remedy: "give distances in scene units, in float32".into(),
        });
    }
    let window = Window::from_size(size[0], size[1]);
    let camera = camera_of_text(camera, window, pixel_aspect)?;
    let depth = depth.plane("depth", size)?;
    let seen = (camera.projection, window);
    let normals = normals_of_depth(&depth, stored, seen, |_, _| true, Precision::Float);
    Ok([normals.x, normals.y, normals.z])
}
