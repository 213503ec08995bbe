//! Scenes from arrays.

use super::from_depth::{OfDepth, SurfaceSeen, check_heights};
use super::given::Given;
use super::scene::LoadedScene;
use super::work::Work;
use crate::error::{Result, bad};
use crate::frame::{
    Camera, Flip, Frame, NormalSpace, Normals, Samples, StoredDepth, Window, strength_of,
};
use crate::io::camera::camera_of_text;
use crate::io::inputs::{Inputs, NormalEncoding};

impl Given<'_> {
    /// The scene, read by the settings of `work` for normals and depth. With normals nothing is concluded from the samples:
    /// without settings these are of view space, and depth lies along the view axis. Without them depth is read as in files
    /// that have none, and what has to be guessed is among the warnings.
    ///
    /// # Errors
    /// As [`FrameBuilder::build`](crate::frame::FrameBuilder::build); [`Unsupported`](crate::Error::Unsupported) for a camera that cannot be
    /// used; [`Arguments`](crate::Error::Arguments) for settings that name layers, which arrays have none of.
    pub fn scene(mut self, work: &Work) -> Result<LoadedScene> {
        work.refuse_names()?;
        let inputs = work.inputs();
        check_heights(&self, inputs.depth_kind)?;
        let [width, height] = self.size;
        let window = Window::from_size(width, height);
        let camera = |text| camera_of_text(text, window, self.pixel_aspect);
        let camera = self.camera.map(camera).transpose()?;
        let (is_stored, mut warnings) = (self.normal.is_some(), Vec::new());
        // Outlives the samples that are borrowed from it.
        let of_depth;
        let stored = inputs.depth_kind;
        let SurfaceSeen {
            normals,
            depth,
            camera,
        } = match self.normal.take() {
            Some(normal) => SurfaceSeen {
                normals: as_stored(normal, self.normal_is_unsigned, &inputs, camera.as_ref())?,
                depth: (self.depth.take()).map(|d| (d, stored.unwrap_or(StoredDepth::Planar))),
                camera,
            },
            None => {
                of_depth = OfDepth::of(&self, stored, camera, &mut warnings)?;
                of_depth.seen(self.depth.take())
            }
        };
        let mut builder = Frame::builder(width, height)
            .normals(normals)
            .pixel_aspect(self.pixel_aspect)
            .with_confidence();
        if let Some(camera) = &camera {
            builder = builder.camera(camera);
        }
        if let Some((samples, stored)) = depth {
            builder = builder.depth(samples, stored);
        }
        let builder = builder
            .layer("color", self.color)
            .layer("position", self.position)
            .layer("mask", self.coverage)
            .layer("occlusion", self.occlusion)
            .layer("importance", self.importance)
            .layer("albedo", self.albedo);
        let plane = |name, samples: Option<Samples<'_>>| {
            let plane = samples.map(|samples| samples.plane(name, self.size));
            plane.transpose()
        };
        let (mask, object) = (plane("mask", self.mask)?, plane("object", self.object)?);
        let mut frame = builder.build()?;
        // No filter has shortened normals of depth.
        frame.normal_length = frame.normal_length.filter(|_| is_stored);
        Ok(LoadedScene {
            warnings,
            mask: strength_of(mask, object),
            ..LoadedScene::of_frame(frame)
        })
    }
}

/// Normals as the settings tell that they are stored.
fn as_stored<'a>(
    samples: Samples<'a>,
    is_unsigned: bool,
    inputs: &Inputs,
    camera: Option<&Camera>,
) -> Result<Normals<'a>> {
    let normals = match (inputs.normal_space, camera) {
        (Some(space @ (NormalSpace::World | NormalSpace::Sight)), None) => {
            let found = format!("is missing, and normals are of {} space", space.name());
            return Err(bad("camera", found, "give one"));
        }
        (Some(NormalSpace::World), Some(camera)) => Normals::world(samples, camera),
        (Some(NormalSpace::Sight), Some(camera)) => Normals::sight(samples, camera),
        _ => Normals::view(samples),
    };
    let own = match is_unsigned {
        true => NormalEncoding::Unsigned,
        false => NormalEncoding::Signed,
    };
    let normals = normals.encoded(inputs.normal_encoding.unwrap_or(own));
    Ok(normals.flipped(inputs.normal_flip.unwrap_or(Flip::NONE)))
}
