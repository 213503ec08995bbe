//! The surface that a camera, the space of normals and the sense of depth are judged from.

use super::points::Points;
use crate::frame::{Mask, Plane, Window};
use std::collections::BTreeMap;

/// Evidence for the camera and the space of the normals.
#[derive(Clone, Copy)]
pub(super) struct SurfaceSamples<'a> {
    pub(super) mask: &'a Mask,
    pub(super) position: Option<Points<'a>>,
    pub(super) depth: Option<&'a Plane>,
    /// Attributes of the picture's file.
    pub(super) attributes: Option<&'a BTreeMap<String, String>>,
    pub(super) data_window: Window,
    pub(super) display_window: Window,
    pub(super) pixel_aspect: f32,
}
