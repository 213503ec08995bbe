//! The builder of frames from samples in memory.

mod build;
mod light;
mod samples;

pub(crate) use build::PIXEL_ASPECTS;
pub use samples::{Sample, Samples};

use super::{
    Camera, Flip, Frame, Lobe, LobeLayer, NormalEncoding, NormalSpace, StoredDepth, Window,
};
use glam::Vec3;
use samples::{Name, Size};
use std::collections::BTreeMap;

/// Normals in memory, and their encoding: signed in -1..1 by default, no axis flipped.
///
/// Three channels x, y, z; a fourth is ignored. They need not have unit length: shorter normals count as mixed by a
/// filter. Zero, NaN and infinite ones mark pixels without surface.
pub struct Normals<'a> {
    samples: Samples<'a>,
    space: NormalSpace,
    encoding: NormalEncoding,
    flip: Flip,
    camera: Option<Camera>,
}

impl<'a> Normals<'a> {
    /// Normals in view space: x right, y up, z toward the viewer.
    pub fn view(samples: impl Into<Samples<'a>>) -> Self {
        Self {
            samples: samples.into(),
            space: NormalSpace::View,
            encoding: NormalEncoding::Signed,
            flip: Flip::NONE,
            camera: None,
        }
    }

    /// Normals in world space, which `camera` transforms to view space. It becomes the frame's camera.
    pub fn world(samples: impl Into<Samples<'a>>, camera: &Camera) -> Self {
        Self {
            space: NormalSpace::World,
            camera: Some(*camera),
            ..Self::view(samples)
        }
    }

    /// Normals turned to their own sight lines, as V-Ray writes them, with x to the left there. `camera` becomes the
    /// frame's camera.
    pub fn sight(samples: impl Into<Samples<'a>>, camera: &Camera) -> Self {
        Self {
            space: NormalSpace::Sight,
            ..Self::world(samples, camera)
        }
    }

    /// Stored as `(n + 1) / 2`, 0..1, as in integer normal maps; black is no normal.
    pub fn unsigned(self) -> Self {
        self.encoded(NormalEncoding::Unsigned)
    }

    /// Stored in this way; of two components z is ignored, and they are signed.
    pub(crate) fn encoded(self, encoding: NormalEncoding) -> Self {
        Self { encoding, ..self }
    }

    /// Reversed axes: y in DirectX normal maps, z if it points away from the viewer.
    pub fn flipped(self, flip: Flip) -> Self {
        Self { flip, ..self }
    }
}

/// Makes a [`Frame`] from borrowed samples: see [`Frame::builder`].
#[derive(Default)]
#[must_use = "nothing is made before build()"]
pub struct FrameBuilder<'a> {
    size: Size,
    origin: [i32; 2],
    display_window: Option<Window>,
    pixel_aspect: f32,
    camera: Option<Camera>,
    normals: Option<Normals<'a>>,
    /// All other layers of the surface and of the picture, by the name of their method.
    layers: BTreeMap<Name, Samples<'a>>,
    stored_depth: Option<StoredDepth>,
    lobes: Vec<(Lobe, LobeLayer, Samples<'a>)>,
    groups: Vec<(String, Samples<'a>, Vec<Vec3>)>,
    picture_is_occlusion: bool,
    luminance_weights: Option<[f32; 3]>,
    finds_confidence: bool,
}

impl Frame {
    /// Starts a frame of `width` x `height` pixels from samples in memory. They are borrowed, in any layout that
    /// [`Samples`] supports, and copied once by [`build`](FrameBuilder::build), which decodes, transforms and sanitises
    /// them as [`io::load`](crate::io::load) does for files. Normals are required.
    ///
    /// ```
    /// use relievo::frame::{Frame, Normals, StoredDepth};
    ///
    /// # fn main() -> relievo::Result<()> {
    /// // A plane that leans to the right, of 4x2 pixels: RGB interleaved, depth and alpha planar.
    /// let normals = [[0.6_f32, 0.0, 0.8]; 8].concat();
    /// let (depth, alpha) = ([5.0_f32; 8], [1.0_f32; 8]);
    /// let frame = Frame::builder(4, 2)
    ///     .normals(Normals::view(&normals))
    ///     .depth(&depth[..], StoredDepth::Planar)
    ///     .mask(&alpha[..])
    ///     .build()?;
    /// assert_eq!(frame.normal.x.view()[[1, 3]], 0.6);
    /// # Ok(())
    /// # }
    /// ```
    pub fn builder<'a>(width: usize, height: usize) -> FrameBuilder<'a> {
        FrameBuilder {
            size: [width, height],
            pixel_aspect: 1.0,
            ..FrameBuilder::default()
        }
    }
}

impl<'a> FrameBuilder<'a> {
    /// The layer of this name, if it is given.
    pub(crate) fn layer(mut self, name: Name, samples: Option<Samples<'a>>) -> Self {
        self.layers.extend(samples.map(|samples| (name, samples)));
        self
    }

    /// Normals. Without depth, mask and alpha the surface is wherever they have a direction.
    pub fn normals(mut self, normals: Normals<'a>) -> Self {
        self.normals = Some(normals);
        self
    }

    /// Depth of any kind, 1 channel, in scene units if it is a distance. Pixels without surface are 0, negative, 65504,
    /// 1e9 or more, or not finite; [`StoredDepth::WhiteFar`] and [`StoredDepth::NormalizedNearIsOne`] do not mark them,
    /// so the mask or alpha must. An inverse in half floats is too coarse for distances and counts as relative.
    pub fn depth(self, samples: impl Into<Samples<'a>>, stored: StoredDepth) -> Self {
        Self {
            stored_depth: Some(stored),
            ..self.layer("depth", Some(samples.into()))
        }
    }

    /// Positions in world space, 3 channels, in scene units: they give the depth if there is no other, and need a
    /// camera. Depth from half floats is relative, from floats along the view axis.
    pub fn position(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("position", Some(samples.into()))
    }

    /// Coverage of the surface, 1 channel: covered above 0.5.
    pub fn mask(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("mask", Some(samples.into()))
    }

    /// The picture, scene-linear: 1 channel (grey), 3, or 4 with coverage 0..1 by which the colour is premultiplied.
    /// NaN becomes 0, infinity 65504. Integers are refused.
    pub fn color(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("color", Some(samples.into()))
    }

    /// Coverage of the picture, 0..1, 1 channel; it overrides a fourth channel of the colour. Without a mask, and
    /// without depth that marks coverage, the surface is where alpha is above 0.5.
    pub fn alpha(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("alpha", Some(samples.into()))
    }

    /// Albedo, scene-linear, 1 or 3 channels. NaN becomes 0, infinity 65504.
    pub fn albedo(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("albedo", Some(samples.into()))
    }

    /// Ambient occlusion, 0 (hidden) to 1 (open), 1 channel: gives silhouettes without depth. Without it, varying alpha
    /// is used instead.
    pub fn occlusion(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("occlusion", Some(samples.into()))
    }

    /// Importance: the share of the diffusion that each pixel gets, 0 (keeps all detail) to 1, 1 channel.
    pub fn importance(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("importance", Some(samples.into()))
    }

    /// A layer of one lobe of the picture's light, scene-linear, 1 or 3 channels. The lobe's radiance is `(direct +
    /// indirect) * color`; if a layer is given twice, the last counts.
    pub fn lobe(mut self, lobe: Lobe, layer: LobeLayer, samples: impl Into<Samples<'a>>) -> Self {
        self.lobes.push((lobe, layer, samples.into()));
        self
    }

    /// A light group: its part of the picture, scene-linear, 1 or 3 channels, and unit directions in view space to its
    /// lights, or to samples of an area light.
    pub fn light_group(
        mut self,
        name: impl Into<String>,
        samples: impl Into<Samples<'a>>,
        to_light: impl IntoIterator<Item = Vec3>,
    ) -> Self {
        let to_light = to_light.into_iter().collect();
        self.groups.push((name.into(), samples.into(), to_light));
        self
    }

    /// Ambient occlusion to scale by curvature as part of the light, 1 where the surface is open, 1 channel.
    pub fn light_occlusion(self, samples: impl Into<Samples<'a>>) -> Self {
        self.layer("light_occlusion", Some(samples.into()))
    }

    /// Marks the picture as ambient occlusion, to be scaled as such.
    pub fn picture_is_occlusion(mut self) -> Self {
        self.picture_is_occlusion = true;
        self
    }

    /// The camera, in pixels of the picture's coordinates. [`Normals::world`] gives it too; two must be equal.
    pub fn camera(mut self, camera: &Camera) -> Self {
        self.camera = Some(*camera);
        self
    }

    /// Column and row of the first sample in the picture's coordinates, (0, 0) by default; negative for overscan.
    pub fn origin(mut self, x: i32, y: i32) -> Self {
        self.origin = [x, y];
        self
    }

    /// The pixels meant to be shown; by default those of the samples.
    pub fn display_window(mut self, window: Window) -> Self {
        self.display_window = Some(window);
        self
    }

    /// Width of a pixel over its height, 0.001 to 1000; 1 by default.
    pub fn pixel_aspect(mut self, aspect: f32) -> Self {
        self.pixel_aspect = aspect;
        self
    }

    /// Weights of linear red, green and blue in luminance, non-negative with sum 1; those of Rec. 709 by default.
    pub fn luminance_weights(mut self, weights: [f32; 3]) -> Self {
        self.luminance_weights = Some(weights);
        self
    }

    /// Finds where pixels blend several surfaces: see [`Frame::confidence`].
    pub fn with_confidence(mut self) -> Self {
        self.finds_confidence = true;
        self
    }
}
