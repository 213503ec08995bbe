//! The surface of a frame as its files store it, for references in double precision.

use super::frame_sources::FrameSources;
use super::inputs::{Inputs, Needs};
use super::light_layers::LightSources;
use super::load::Loaded;
use super::roles::Role;
use crate::error::Result;
use crate::frame::{Plane, Vector3Planes};

/// The planes that a frame's surface is made of, before they become unit normals in view space and distances. The steps
/// of coarse codes are already removed from the normals.
pub(crate) struct StoredSurface {
    pub(crate) normal: Vector3Planes,
    pub(crate) depth: Option<Plane>,
    pub(crate) position: Option<Vector3Planes>,
}

impl Loaded {
    /// Reads the surface of `inputs`, whose frame this is, once more.
    ///
    /// # Errors
    /// As [`super::load`].
    pub(crate) fn stored_surface(&self, inputs: &Inputs) -> Result<StoredSurface> {
        let light = LightSources::resolve(inputs, &self.main)?;
        let sources =
            FrameSources::resolve(inputs, &self.main, Needs::default(), !light.is_empty())?;
        let window = self.frame.data_window;
        let (mut planes, _) = sources.read(&light, window, None, None)?;
        Ok(StoredSurface {
            normal: planes
                .vector(Role::Normal)
                .expect("normals are always resolved"),
            depth: planes.scalar(Role::Depth),
            position: planes.vector(Role::Position),
        })
    }
}
