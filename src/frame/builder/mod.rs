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
use light::Light;
use samples::Size;

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
#[must_use = "nothing is made before build()"]
pub struct FrameBuilder<'a> {
    size: Size,
    origin: [i32; 2],
    display_window: Option<Window>,
    pixel_aspect: f32,
    camera: Option<Camera>,
    normals: Option<Normals<'a>>,
    depth: Option<(Samples<'a>, StoredDepth)>,
    position: Option<Samples<'a>>,
    mask: Option<Samples<'a>>,
    color: Option<Samples<'a>>,
    alpha: Option<Samples<'a>>,
    albedo: Option<Samples<'a>>,
    occlusion: Option<Samples<'a>>,
    importance: Option<Samples<'a>>,
    luminance_weights: Option<[f32; 3]>,
    finds_confidence: bool,
    light: Light<'a>,
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
            origin: [0, 0],
            display_window: None,
            pixel_aspect: 1.0,
            camera: None,
            normals: None,
            depth: None,
            position: None,
            mask: None,
            color: None,
            alpha: None,
            albedo: None,
            occlusion: None,
            importance: None,
            luminance_weights: None,
            finds_confidence: false,
            light: Light::default(),
        }
    }
}

impl<'a> FrameBuilder<'a> {
    /// Normals. Without depth, mask and alpha the surface is wherever they have a direction.
    pub fn normals(self, normals: Normals<'a>) -> Self {
        Self {
            normals: Some(normals),
            ..self
        }
    }

    /// Depth of any kind, 1 channel, in scene units if it is a distance. Pixels without surface are 0, negative, 65504,
    /// 1e9 or more, or not finite; [`StoredDepth::WhiteFar`] and [`StoredDepth::NormalizedNearIsOne`] do not mark them,
    /// so the mask or alpha must. An inverse in half floats is too coarse for distances and counts as relative.
    pub fn depth(self, samples: impl Into<Samples<'a>>, stored: StoredDepth) -> Self {
        Self {
            depth: Some((samples.into(), stored)),
            ..self
        }
    }

    /// Positions in world space, 3 channels, in scene units: they give the depth if there is no other, and need a
    /// camera. Depth from half floats is relative, from floats along the view axis.
    pub fn position(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            position: Some(samples.into()),
            ..self
        }
    }

    /// Coverage of the surface, 1 channel: covered above 0.5.
    pub fn mask(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            mask: Some(samples.into()),
            ..self
        }
    }

    /// The picture, scene-linear: 1 channel (grey), 3, or 4 with coverage 0..1 by which the colour is premultiplied.
    /// NaN becomes 0, infinity 65504. Integers are refused.
    pub fn color(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            color: Some(samples.into()),
            ..self
        }
    }

    /// Coverage of the picture, 0..1, 1 channel; it overrides a fourth channel of the colour. Without a mask, and
    /// without depth that marks coverage, the surface is where alpha is above 0.5.
    pub fn alpha(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            alpha: Some(samples.into()),
            ..self
        }
    }

    /// Albedo, scene-linear, 1 or 3 channels. NaN becomes 0, infinity 65504.
    pub fn albedo(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            albedo: Some(samples.into()),
            ..self
        }
    }

    /// Ambient occlusion, 0 (hidden) to 1 (open), 1 channel: gives silhouettes without depth. Without it, varying alpha
    /// is used instead.
    pub fn occlusion(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            occlusion: Some(samples.into()),
            ..self
        }
    }

    /// Importance: the share of the diffusion that each pixel gets, 0 (keeps all detail) to 1, 1 channel.
    pub fn importance(self, samples: impl Into<Samples<'a>>) -> Self {
        Self {
            importance: Some(samples.into()),
            ..self
        }
    }

    /// A layer of one lobe of the picture's light, scene-linear, 1 or 3 channels. The lobe's radiance is `(direct +
    /// indirect) * color`; if a layer is given twice, the last counts.
    pub fn lobe(mut self, lobe: Lobe, layer: LobeLayer, samples: impl Into<Samples<'a>>) -> Self {
        self.light.lobes.push((lobe, layer, samples.into()));
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
        self.light
            .groups
            .push((name.into(), samples.into(), to_light));
        self
    }

    /// Ambient occlusion to scale by curvature as part of the light, 1 where the surface is open, 1 channel.
    pub fn light_occlusion(mut self, samples: impl Into<Samples<'a>>) -> Self {
        self.light.occlusion = Some(samples.into());
        self
    }

    /// Marks the picture as ambient occlusion, to be scaled as such.
    pub fn picture_is_occlusion(mut self) -> Self {
        self.light.picture_is_occlusion = true;
        self
    }

    /// The camera, in pixels of the picture's coordinates. [`Normals::world`] gives it too; two must be equal.
    pub fn camera(self, camera: &Camera) -> Self {
        Self {
            camera: Some(*camera),
            ..self
        }
    }

    /// Column and row of the first sample in the picture's coordinates, (0, 0) by default; negative for overscan.
    pub fn origin(self, x: i32, y: i32) -> Self {
        Self {
            origin: [x, y],
            ..self
        }
    }

    /// The pixels meant to be shown; by default those of the samples.
    pub fn display_window(self, window: Window) -> Self {
        Self {
            display_window: Some(window),
            ..self
        }
    }

    /// Width of a pixel over its height, 0.001 to 1000; 1 by default.
    pub fn pixel_aspect(self, aspect: f32) -> Self {
        Self {
            pixel_aspect: aspect,
            ..self
        }
    }

    /// Weights of linear red, green and blue in luminance, non-negative with sum 1; those of Rec. 709 by default.
    pub fn luminance_weights(self, weights: [f32; 3]) -> Self {
        Self {
            luminance_weights: Some(weights),
            ..self
        }
    }

    /// Finds where pixels blend several surfaces: see [`Frame::confidence`].
    pub fn with_confidence(self) -> Self {
        Self {
            finds_confidence: true,
            ..self
        }
    }
}
