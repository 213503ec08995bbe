//! Layers of a frame in memory.

use crate::frame::Samples;

/// Layers of a frame in memory: see [`FrameBuilder`](crate::frame::FrameBuilder) for what each holds.
#[derive(Default)]
pub struct Given<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Normals, 3 or 4 channels; without them those of the surface that depth, heights or positions show.
    pub normal: Option<Samples<'a>>,
    /// Whether normals are stored as 0..1, unless a setting tells.
    pub normal_is_unsigned: bool,
    /// The picture, scene-linear, 1, 3 or 4 channels.
    pub color: Option<Samples<'a>>,
    /// Depth.
    pub depth: Option<Samples<'a>>,
    /// Heights of the surface, seen from above, in the place of normals, depth and camera.
    pub height: Option<Samples<'a>>,
    /// Pixels that a height of 1 is high; by default floats are pixels, and white is a tenth of the longer side in integers.
    pub height_scale: Option<f32>,
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
            normal: Some(normal),
            ..Self::of_size(size)
        }
    }

    /// Nothing yet.
    pub fn of_size(size: [usize; 2]) -> Self {
        Self {
            size,
            pixel_aspect: 1.0,
            ..Self::default()
        }
    }
}
