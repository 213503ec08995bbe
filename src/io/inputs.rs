//! The user's choices about inputs; everything else follows from names and data.

use crate::frame::{Camera, Frame, NormalSpace, Plane, confidence};
pub use crate::frame::{Flip, NormalEncoding, StoredDepth};
use crate::io::colorspace::ColorSpace;
use crate::io::roles::Role;
use crate::params::ObjectAngle;
use crate::params::table::rows;
#[cfg(feature = "cli")]
use crate::params::words::{auto_or, one_of, word_or};
use glam::Vec3;
use std::ops::Range;
use std::path::PathBuf;

/// The heading of their flags in help.
#[cfg(feature = "cli")]
pub(crate) const INPUTS: &str = "Inputs";

/// Spaces of normals. For an object that is not rotated, object space equals world space.
#[cfg(feature = "cli")]
const NORMAL_SPACES: [(NormalSpace, &str); 4] = [
    (NormalSpace::View, NormalSpace::View.name()),
    (NormalSpace::World, NormalSpace::World.name()),
    (NormalSpace::World, "object"),
    (NormalSpace::Sight, NormalSpace::Sight.name()),
];

/// Encodings of normals, by their words.
#[cfg(feature = "cli")]
pub(crate) const NORMAL_ENCODINGS: [(NormalEncoding, &str); 5] = [
    (NormalEncoding::Signed, "signed"),
    (NormalEncoding::Unsigned, "unsigned"),
    (NormalEncoding::Xy, "xy"),
    (NormalEncoding::Ag, "ag"),
    (NormalEncoding::Oct, "oct"),
];

#[cfg(feature = "cli")]
fn wraps() -> impl Iterator<Item = (Wrap, &'static str)> {
    let words = Wrap::CHOICES.iter().map(|choice| choice.name);
    words.filter_map(|word| Some((Wrap::named(word)?, word)))
}

rows! {
    /// Files and layers of a frame, and how to read them: each field with a flag is a row of the table of inputs.
    ///
    /// A role that is `None` is found by its layer's name or numbers; a name refers to a layer of the picture or, if there
    /// is no such layer, to another file; [`Inputs::NONE`] leaves the role out. Without normals they are
    /// those of depth or positions, and of heights, whatever else there is.
    #[derive(Debug, Clone, Default, PartialEq)]
    #[cfg_attr(feature = "cli", command(next_help_heading = INPUTS))]
    pub struct Inputs {
        /// The picture: an EXR with its layers, or a photo.
        pub picture: PathBuf = [skip];
        /// View to take all layers from (as in left), for files with several; the default view if not given.
        pub view: Option<String> = [long, value_name = "NAME", hide_short_help = true];
        /// Group to take all layers from, such as a view layer (FG for FG.Normal.X), for files with several; that with
        /// normals, the default picture, or the first if not given. inspect lists them.
        pub layer: Option<String> = [long, value_name = "NAME"];
        /// Normals: a layer of IN or a file.
        pub normal: Option<String> = [long, value_name = "NAME|FILE"];
        /// Depth: a layer of IN or a file; none leaves it out.
        pub depth: Option<String> = [long, value_name = "NAME|FILE|none"];
        /// World-space positions: a layer of IN or a file; none leaves it out.
        pub position: Option<String> = [long, value_name = "NAME|FILE|none", hide_short_help = true];
        /// The picture to be enhanced: a layer of IN or a file.
        pub color: Option<String> = [long, value_name = "NAME|FILE"];
        /// Ambient occlusion, for silhouettes in place of depth: a layer of IN or a file; none leaves it out. computed
        /// is that of the shape: for relight --sky-shadows on without a layer, for enhance what --scaling-ambient scales.
        pub occlusion: Option<String> = [long, value_name = "NAME|FILE|none|computed", hide_short_help = true];
        /// Colour of the surface itself.
        pub albedo: Option<String> = [skip];
        /// How far each pixel is diffused, from 0 (keep all detail) to 1 (in full): a layer of IN or a file.
        pub importance: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
        /// Motion since the previous frame, in any convention; read only if [`Needs`] ask for it.
        pub motion: Option<String> = [skip];
        /// Where and how far the picture is changed, 0 to 1: a layer of IN or a file. Shape is computed over the whole
        /// picture, and the gain is that of this part; drawings and measurements cover the pixels where the mask is above one
        /// half.
        pub mask: Option<String> = [long, value_name = "NAME|FILE"];
        /// Only this object, by its name in Cryptomatte, * and ? for any letters, its hash, as in 0x05777012, or its number in
        /// an index pass; !NAME leaves one out. May be given several times.
        pub objects: Vec<String> = [long = "object", value_name = "NAME"];
        /// File with the Cryptomatte or the index passes that tell objects apart, where IN has none; of the same size.
        pub cryptomatte: Option<PathBuf> = [long, value_name = "FILE"];
        /// Stroke angles of single objects, overriding curvature.
        pub object_angles: Vec<ObjectAngle> = [skip];
        /// Where a surface is seen, above one half: a layer of IN or a file. Normals elsewhere are ignored.
        pub coverage: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
        /// Space of the normals.
        pub normal_space: std::option::Option<NormalSpace> =
            [long, value_name = "SPACE", hide_short_help = true, default_value = "auto", value_parser = auto_or(NORMAL_SPACES)];
        /// Encoding of the normals: signed (-1..1), unsigned (0..1), or two channels of which z is rebuilt: xy (red, green), ag
        /// (x in alpha, y in green), oct (octahedral).
        pub normal_encoding: std::option::Option<NormalEncoding> =
            [long, value_name = "ENCODING", hide_short_help = true, default_value = "auto", value_parser = auto_or(NORMAL_ENCODINGS)];
        /// Axes of the normals that point the wrong way: as in y or xz, none, or auto; or who wrote them: opengl (none),
        /// directx (y), opencv (yz), stablenormal, dsine or bae (x).
        pub normal_flip: std::option::Option<Flip> =
            [long, value_name = "AXES", default_value = "auto", value_parser = word_or::<Flip>("auto")];
        /// Quantity stored as depth.
        pub depth_kind: std::option::Option<StoredDepth> =
            [long, value_name = "KIND", hide_short_help = true, default_value = "auto", value_parser = auto_or(StoredDepth::ALL)];
        /// Pixels that a height of 1 is high. By default floats are pixels, or in the unit of --pixel-size where it is given,
        /// and white is a tenth of the longer side in pictures of integers.
        pub height_scale: Option<f32> = [long, value_name = "PIXELS", hide_short_help = true, requires = "height"];
        /// Pixels that a unit of heights in floats is high, where no scale is given.
        pub height_unit_px: Option<f32> = [skip];
        /// Colour space of the inputs: linear, srgb, acescg, aces2065-1; auto goes by what files say, else photos are srgb
        /// and EXR files linear. Layers are written in the same space, pictures for a display in sRGB.
        pub colorspace: std::option::Option<ColorSpace> =
            [long, value_name = "SPACE", hide_short_help = true, default_value = "auto", value_parser = auto_or(ColorSpace::ALL)];
        /// Opposite borders that continue each other, in a picture that is a tile: none, x (left and right), y, xy, or auto,
        /// those across which normals change no more than beside them. Results then continue across them.
        pub wrap: Wrap =
            [long, value_name = "BORDERS", hide_short_help = true, default_value = "none", value_parser = one_of(wraps())];
        /// Camera as JSON: world_to_camera and focal_px, or other keys listed in docs/guide/files.md.
        pub camera: Option<PathBuf> = [long, value_name = "FILE"];
        /// Light layers; read only if requested here.
        pub light: Option<LightInputs> = [skip];
        /// Rows of the frame to be read, counted from the top of its data window; all where not given.
        pub rows: Option<Range<usize>> = [skip];
        /// The camera, if already known; it takes precedence over all others.
        pub known_camera: Option<KnownCamera> = [skip];
    }
}

impl Inputs {
    /// The name of no layer: a role called so is left out, where no layer and no file is called so.
    pub const NONE: &str = "none";

    /// The layers that are read only where they are named, and their names.
    pub(crate) fn only_named(&self) -> impl Iterator<Item = (Role, &str)> {
        let layers = [
            (Role::Mask, &self.mask),
            (Role::Coverage, &self.coverage),
            (Role::Importance, &self.importance),
        ];
        let named = layers.into_iter();
        named.filter_map(|(role, name)| Some((role, name.as_deref()?)))
    }
}

#[cfg(feature = "cli")]
impl Inputs {
    /// The rows that name a layer or a file, and those that name a file: each may be another one for each frame of a
    /// sequence.
    pub(crate) fn names(&mut self) -> ([&mut Option<String>; 8], [&mut Option<PathBuf>; 2]) {
        let layers = [
            &mut self.normal,
            &mut self.depth,
            &mut self.position,
            &mut self.color,
            &mut self.occlusion,
            &mut self.importance,
            &mut self.mask,
            &mut self.coverage,
        ];
        (layers, [&mut self.camera, &mut self.cryptomatte])
    }
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
    /// The picture as a map of normals, where it is a photo and nothing else shows the surface.
    pub map: bool,
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

rows! {
    /// Which layers of light are wanted. A lobe that is not named is found by its layers' names.
    #[derive(Debug, Clone, Default, PartialEq)]
    pub struct LightInputs {
        /// Whether lobes are read.
        pub lobes: LobeChoice = [skip];
        /// Leaves out diffuse lobes of any name.
        pub without_diffuse: bool = [skip];
        /// Leaves out all other lobes.
        pub without_specular: bool = [skip];
        /// Diffuse light, the surface's colour included: a layer of IN or a file.
        pub diffuse: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
        /// Specular light, the surface's colour included: a layer of IN or a file.
        pub specular: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
        /// The surface's diffuse colour, used to judge diffuse light: a layer of IN or a file.
        pub albedo: Option<String> = [long, value_name = "NAME|FILE", hide_short_help = true];
        /// Light groups; if there are any, lobes are not read.
        pub groups: Vec<GroupInput> = [skip];
        /// Whether ambient occlusion is read.
        pub occlusion: bool = [skip];
        /// Whether the light is read that a diffuse colour does not tell of.
        pub gloss: bool = [skip];
        /// Whether colours of gloss are tints, where that is known.
        pub gloss_is_tint: Option<bool> = [skip];
    }
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
