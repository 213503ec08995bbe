//! The surface that a camera, the space of normals and the sense of depth are judged from.

use super::points::Points;
use crate::frame::{Mask, Plane, Window};
use std::collections::BTreeMap;

/// Evidence for the camera and the space of the normals.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceSamples<'a> {
    pub(crate) mask: &'a Mask,
    pub(crate) position: Option<Points<'a>>,
    pub(crate) depth: Option<&'a Plane>,
    /// Attributes of the picture's file.
    pub(crate) attributes: Option<&'a BTreeMap<String, String>>,
    pub(crate) data_window: Window,
    pub(crate) display_window: Window,
    pub(crate) pixel_aspect: f32,
}
