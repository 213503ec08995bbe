//! The user's choices about inputs; everything else follows from names and data.

use crate::frame::{Camera, Frame, NormalSpace, Plane, confidence};
pub use crate::frame::{Flip, NormalEncoding, StoredDepth};
use crate::io::colorspace::ColorSpace;
use crate::params::ObjectAngle;
use glam::Vec3;
use std::ops::Range;
use std::path::PathBuf;

/// The name of no layer: a role called so is left out, where no layer and no file is called so.
pub const NONE: &str = "none";

/// Files and layers of a frame, and how to read them.
///
/// A role that is `None` is found by its layer's name or numbers; a name refers to a layer of the picture or, if there
/// is no such layer, to another file; [`NONE`] leaves the role out. Without normals they are
/// those of depth or positions, and of heights, whatever else there is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inputs {
    /// The picture: an EXR with its layers, or a photo.
    pub picture: PathBuf,
    /// View of a multi-view file that all layers are taken from; `None` takes the default.
    pub view: Option<String>,
    /// Group of layers that all layers are taken from, such as a view layer; `None` takes the default.
    pub layer: Option<String>,
    /// The colour to be enhanced.
    pub color: Option<String>,
    /// Normals.
    pub normal: Option<String>,
    /// Depth.
    pub depth: Option<String>,
    /// World-space positions.
    pub position: Option<String>,
    /// Ambient occlusion.
    pub occlusion: Option<String>,
    /// Colour of the surface itself.
    pub albedo: Option<String>,
    /// Importance; read only if named here.
    pub importance: Option<String>,
    /// Motion since the previous frame, in any convention; read only if [`Needs`] ask for it.
    pub motion: Option<String>,
    /// Layer of the effect's strength, 0..1, if [`Needs`] ask for it; otherwise treated as coverage.
    pub mask: Option<String>,
    /// Objects the effect is limited to, by their Cryptomatte names, with `*` and `?` as wildcards, or by their
    /// numbers; a `!` before a name excludes an object. Empty means all.
    pub objects: Vec<String>,
    /// The file that tells objects apart, by Cryptomatte or by index passes, if not the picture.
    pub cryptomatte: Option<PathBuf>,
    /// Stroke angles of single objects, overriding curvature.
    pub object_angles: Vec<ObjectAngle>,
    /// Coverage: pixels above one half show a surface.
    pub coverage: Option<String>,
    /// A camera file.
    pub camera: Option<PathBuf>,
    /// The space of the normals; `None` decides from the data.
    pub normal_space: Option<NormalSpace>,
    /// The encoding of the normals; `None` decides from the data.
    pub normal_encoding: Option<NormalEncoding>,
    /// Axes of the normals, as stored, that point the wrong way. `None` decides from the data; if this is given without
    /// the space, z is still turned toward the viewer if it points away.
    pub normal_flip: Option<Flip>,
    /// Kind of depth in its layer; `None` decides from the data.
    pub depth_kind: Option<StoredDepth>,
    /// Pixels that a height of 1 is high, where depth holds heights; `None` takes floats for pixels.
    pub height_scale: Option<f32>,
    /// Colour space; `None` follows the files: photos are sRGB, EXR files linear.
    pub colorspace: Option<ColorSpace>,
    /// Whether the picture is a tile.
    pub wrap: Wrap,
    /// Light layers; read only if requested here.
    pub light: Option<LightInputs>,
    /// Rows of the frame to be read, counted from the top of its data window; all where not given.
    pub rows: Option<Range<usize>>,
    /// The camera, if already known; it takes precedence over all others.
    pub known_camera: Option<KnownCamera>,
}

/// Requirements of a run on the frame, beyond its shape.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Needs {
    /// The picture.
    pub color: bool,
    /// The picture, if there is one.
    pub color_if_any: bool,
    /// The albedo, if there is one.
    pub albedo: bool,
    /// The camera's projection: for gaps of depth, a foreshortened gradient and much else. Where it is not needed a camera is
    /// not searched for.
    pub projection: bool,
    /// Motion since the previous frame, if there is any.
    pub motion: bool,
    /// Masks and objects as strengths of the change; else they are coverage.
    pub strength: bool,
    /// The objects, for lines between them, if they are told apart.
    pub objects: bool,
    /// The confidence that each pixel shows one surface alone; see [`Frame::confidence`].
    pub confidence: bool,
    /// The same only where it is below 1 anywhere.
    pub confidence_if_any: bool,
}

impl Needs {
    /// The confidence of the pixels of a frame, as it is needed.
    pub(super) fn confidence(&self, frame: &Frame) -> Option<Plane> {
        let found = (self.confidence_if_any || self.confidence).then(|| confidence(frame));
        let full = || Plane::filled(frame.mask.width(), frame.mask.height(), 1.0);
        found.flatten().or_else(|| self.confidence.then(full))
    }
}

/// A camera that need not be looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownCamera {
    /// The camera.
    pub camera: Camera,
    /// Whether its position in the world is known; if not, only its rotation.
    pub is_placed: bool,
}

/// Which layers of light are wanted. A lobe that is not named is found by its layers' names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LightInputs {
    /// Whether lobes are read.
    pub lobes: LobeChoice,
    /// Leaves out diffuse lobes of any name.
    pub without_diffuse: bool,
    /// Leaves out all other lobes.
    pub without_specular: bool,
    /// Diffuse light, the surface's colour included.
    pub diffuse: Option<String>,
    /// Specular light, the surface's colour included.
    pub specular: Option<String>,
    /// The surface's diffuse colour.
    pub albedo: Option<String>,
    /// Light groups; if there are any, lobes are not read.
    pub groups: Vec<GroupInput>,
    /// Whether ambient occlusion is read.
    pub occlusion: bool,
    /// Whether the light is read that a diffuse colour does not tell of.
    pub gloss: bool,
    /// Whether colours of gloss are tints, where that is known.
    pub gloss_is_tint: Option<bool>,
}

pub use crate::params::{LobeChoice, Wrap};

/// A light group and where its light comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupInput {
    /// Its name, without the renderer's prefix.
    pub name: String,
    /// Unit directions in view space to its lights.
    pub to_light: Vec<Vec3>,
}

/// Conventions by which the layers of a frame were read.
///
/// Passed on by [`Conventions::force`] to the inputs of another frame of the same kind, they save judging it, and the
/// frame is the same, bit for bit, as long as the judgement would be. They belong to the [`Needs`] they were loaded
/// for: unneeded conventions may not have been judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conventions {
    /// The space of the normals.
    pub normal_space: NormalSpace,
    /// The encoding of the normals.
    pub normal_encoding: NormalEncoding,
    /// Axes of the normals, as stored, that were flipped: those given, and those found.
    pub normal_flip: Flip,
    /// Kind of depth in its layer; `None` without depth.
    pub depth_kind: Option<StoredDepth>,
}

impl Conventions {
    /// Makes `inputs` be read by these conventions.
    pub fn force(&self, inputs: &mut Inputs) {
        inputs.normal_space = Some(self.normal_space);
        inputs.normal_encoding = Some(self.normal_encoding);
        inputs.normal_flip = Some(self.normal_flip);
        inputs.depth_kind = self.depth_kind.or(inputs.depth_kind);
    }
}
