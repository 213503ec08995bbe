//! Scenes from arrays.

use super::scene::Scene;
use super::work::Work;
use crate::error::{Error, Result};
use crate::frame::{
    Flip, Frame, FrameBuilder, NormalSpace, Normals, Samples, StoredDepth, Window, strength_of,
};
use crate::io::camera::camera_of_text;
use crate::io::inputs::NormalEncoding;

/// Layers of a frame in memory: see [`FrameBuilder`](crate::frame::FrameBuilder) for what each holds.
pub struct Given<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Normals, 3 or 4 channels.
    pub normal: Samples<'a>,
    /// Whether normals are stored as 0..1, unless a setting tells.
    pub normal_is_unsigned: bool,
    /// The picture, scene-linear, 1, 3 or 4 channels.
    pub color: Option<Samples<'a>>,
    /// Depth.
    pub depth: Option<Samples<'a>>,
    /// World-space positions.
    pub position: Option<Samples<'a>>,
    /// Where and how far a picture is changed, 0..1; for commands that change none, where a surface is.
    pub mask: Option<Samples<'a>>,
    /// How much of each pixel the chosen objects cover, 0..1, by which the mask is multiplied.
    pub object: Option<Samples<'a>>,
    /// Where a surface is, above one half.
    pub coverage: Option<Samples<'a>>,
    /// Ambient occlusion.
    pub occlusion: Option<Samples<'a>>,
    /// The share of the diffusion that each pixel gets.
    pub importance: Option<Samples<'a>>,
    /// The surface's own colour, scene-linear.
    pub albedo: Option<Samples<'a>>,
    /// The camera as the text of a camera file: see [`read_camera`](crate::io::camera::read_camera).
    pub camera: Option<&'a str>,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
}

impl<'a> Given<'a> {
    /// Nothing but normals.
    pub fn of_normals(size: [usize; 2], normal: Samples<'a>) -> Self {
        Self {
            size,
            normal,
            normal_is_unsigned: false,
            color: None,
            depth: None,
            position: None,
            mask: None,
            object: None,
            coverage: None,
            occlusion: None,
            importance: None,
            albedo: None,
            camera: None,
            pixel_aspect: 1.0,
        }
    }

    /// The scene, read by the settings of `work` for normals and depth. Nothing is concluded from the samples: without
    /// settings normals are of view space, and depth lies along the view axis.
    ///
    /// # Errors
    /// As [`FrameBuilder::build`](crate::frame::FrameBuilder::build); [`Error::Unsupported`] for a camera that cannot be
    /// used; [`Error::Arguments`] for settings that name layers, which arrays have none of.
    pub fn scene(self, work: &Work) -> Result<Scene> {
        work.refuse_names()?;
        let inputs = work.inputs();
        let [width, height] = self.size;
        let camera = match self.camera {
            Some(text) => {
                let window = Window::from_size(width, height);
                Some(camera_of_text(text, window, self.pixel_aspect)?)
            }
            None => None,
        };
        let normals = match (inputs.normal_space, &camera) {
            (Some(space @ (NormalSpace::World | NormalSpace::Sight)), None) => {
                return Err(Error::BadParameter {
                    name: "camera",
                    found: format!("is missing, and normals are of {} space", space.name()),
                    remedy: "give one".into(),
                });
            }
            (Some(NormalSpace::World), Some(camera)) => Normals::world(self.normal, camera),
            (Some(NormalSpace::Sight), Some(camera)) => Normals::sight(self.normal, camera),
            _ => Normals::view(self.normal),
        };
        let own = match self.normal_is_unsigned {
            true => NormalEncoding::Unsigned,
            false => NormalEncoding::Signed,
        };
        let normals = normals.encoded(inputs.normal_encoding.unwrap_or(own));
        let normals = normals.flipped(inputs.normal_flip.unwrap_or(Flip::NONE));
        let stored = inputs.depth_kind.unwrap_or(StoredDepth::Planar);
        let builder = Frame::builder(width, height)
            .normals(normals)
            .pixel_aspect(self.pixel_aspect)
            .with_confidence();
        let builder = with(builder, camera.as_ref(), FrameBuilder::camera);
        let builder = with(builder, self.color, FrameBuilder::color);
        let builder = with(builder, self.depth, |b, samples| b.depth(samples, stored));
        let builder = with(builder, self.position, FrameBuilder::position);
        let builder = with(builder, self.coverage, FrameBuilder::mask);
        let builder = with(builder, self.occlusion, FrameBuilder::occlusion);
        let builder = with(builder, self.importance, FrameBuilder::importance);
        let builder = with(builder, self.albedo, FrameBuilder::albedo);
        let plane = |name, samples: Option<Samples<'_>>| {
            let plane = samples.map(|samples| samples.plane(name, self.size));
            plane.transpose()
        };
        let (mask, object) = (plane("mask", self.mask)?, plane("object", self.object)?);
        Ok(Scene {
            mask: strength_of(mask, object),
            ..Scene::of_frame(builder.build()?)
        })
    }
}

/// Adds what there is to a builder.
fn with<'a, T>(
    builder: FrameBuilder<'a>,
    given: Option<T>,
    add: impl FnOnce(FrameBuilder<'a>, T) -> FrameBuilder<'a>,
) -> FrameBuilder<'a> {
    match given {
        Some(given) => add(builder, given),
        None => builder,
    }
}
