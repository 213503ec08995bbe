//! The surface that a camera, the space of normals and the sense of depth are judged from.

use crate::frame::{Mask, Plane, Vector3Planes, Window};
use std::collections::BTreeMap;

/// Evidence for the camera and the space of the normals.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceSamples<'a> {
    pub(crate) mask: &'a Mask,
    pub(crate) position: Option<&'a Vector3Planes>,
    pub(crate) depth: Option<&'a Plane>,
    /// Attributes of the picture's file.
    pub(crate) attributes: Option<&'a BTreeMap<String, String>>,
    pub(crate) data_window: Window,
    pub(crate) display_window: Window,
    pub(crate) pixel_aspect: f32,
}
