//! Normals of arrays without any: those of the surface that depth, heights or positions show, read as in files.

use super::given::Given;
use crate::error::{Result, bad};
use crate::frame::{Camera, Normals, Plane, Samples, StoredDepth, Window};
use crate::io::from_depth::{DepthAlone, ShownByDepth};

/// The normals of a frame, and what belongs to them.
pub(super) struct SurfaceSeen<'a> {
    pub(super) normals: Normals<'a>,
    pub(super) depth: Option<(Samples<'a>, StoredDepth)>,
    pub(super) camera: Option<Camera>,
}

/// The surface that depth shows.
pub(super) struct OfDepth {
    shown: ShownByDepth,
    depth: Plane,
}

impl OfDepth {
    /// The surface of arrays without normals.
    ///
    /// # Errors
    /// [`Error::BadParameter`] without anything that shows it, for positions without a camera, and for samples that don't
    /// match the size.
    pub(super) fn of(
        given: &Given<'_>,
        kind: Option<StoredDepth>,
        camera: Option<Camera>,
        warnings: &mut Vec<String>,
    ) -> Result<Self> {
        let size = given.size;
        let as_given = |kind| (kind, "as given".into());
        let (samples, known, mut depth) = match (&given.height, &given.depth, &given.position) {
            (Some(height), ..) => {
                let plane = height.plane("height", size)?;
                (height, Some(as_given(StoredDepth::Height)), plane)
            }
            (None, Some(depth), _) => (depth, kind.map(as_given), depth.plane("depth", size)?),
            (None, None, Some(position)) => {
                let Some(camera) = &camera else {
                    let found = "is in world space, and there is no camera";
                    return Err(bad("position", found, "give one, or depth instead"));
                };
                let plane = position.depths(size, camera)?;
                (position, Some(as_given(StoredDepth::Planar)), plane)
            }
            (None, None, None) => {
                return Err(bad(
                    "normal",
                    "is missing",
                    "give it, or what shows the surface: depth, height, or position with a camera",
                ));
            }
        };
        let window = Window::from_size(size[0], size[1]);
        let alone = DepthAlone {
            depth: &mut depth,
            known,
            is_half: samples.is_half(),
            is_layer: false,
            rounding: samples.rounding,
            height_scale: given.height_scale,
            height_unit_px: None,
            camera,
            data_window: window,
            display_window: window,
            pixel_aspect: given.pixel_aspect,
        };
        let color = given.color.as_ref();
        let color = color.map(|color| color.planes("color", size, &[1, 3, 4]));
        let alpha = color
            .transpose()?
            .and_then(|mut planes| planes.drain(..).nth(3));
        let shown = alone.surface(alpha.as_ref(), warnings)?;
        Ok(Self { shown, depth })
    }

    /// It as samples; depth that is not scaled stays that which was given.
    pub(super) fn seen<'a>(&'a self, given: Option<Samples<'a>>) -> SurfaceSeen<'a> {
        let ShownByDepth {
            normal,
            stored,
            camera,
            ..
        } = &self.shown;
        let given = given.filter(|_| *stored != StoredDepth::Height);
        SurfaceSeen {
            normals: Normals::view([&normal.x, &normal.y, &normal.z]),
            depth: Some((given.unwrap_or_else(|| (&self.depth).into()), *stored)),
            camera: *camera,
        }
    }
}

/// Refuses heights beside what they stand for, and their scale without them.
pub(super) fn check_heights(given: &Given<'_>, kind: Option<StoredDepth>) -> Result<()> {
    let beside = [
        ("normal", given.normal.is_some()),
        ("depth", given.depth.is_some()),
        ("depth_kind", kind.is_some()),
        ("camera", given.camera.is_some()),
    ];
    match (&given.height, beside.iter().find(|(_, is_given)| *is_given)) {
        (Some(_), Some((name, _))) => {
            let found = format!("stands for normals, depth and camera, and {name} is given too");
            Err(bad("height", found, "leave one of them out"))
        }
        (None, _) if given.height_scale.is_some() => {
            let found = "is given, and no height";
            Err(bad("height_scale", found, "give height, or leave it out"))
        }
        _ => Ok(()),
    }
}
