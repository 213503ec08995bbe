//! What a user may say about the inputs; everything left out is found from names and data.

use super::colorspace::ColorSpace;
use crate::frame::{Camera, DepthKind, NormalSpace, Plane};
use glam::Vec3;
use std::ops::Range;
use std::path::PathBuf;

/// Which files and layers a frame is made of, and how they are to be read.
///
/// A role that is `None` is found by its layer's name; one that is named is a layer of the picture
/// or, where no layer is called so, another file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inputs {
    /// The picture: an EXR with its layers, or a photo.
    pub picture: PathBuf,
    /// Which view of a file of several all layers are taken from; `None` takes the default.
    pub view: Option<String>,
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
    /// Importance; read only where it is named here.
    pub importance: Option<String>,
    /// Motion since the frame before, in pixels, y up, as previous minus current; read only where
    /// [`super::Needs`] ask for it.
    pub motion: Option<String>,
    /// Coverage: a surface was seen where it is above one half.
    pub mask: Option<String>,
    /// A camera file.
    pub camera: Option<PathBuf>,
    /// The space of the normals; `None` decides from the data.
    pub normal_space: Option<NormalSpace>,
    /// The encoding of the normals; `None` decides from the data.
    pub normal_encoding: Option<NormalEncoding>,
    /// Axes of the normals, as stored, that point the wrong way. `None` decides from the data; where only
    /// this is given and not the space, z is still turned toward the viewer if it points away.
    pub normal_flip: Option<Flip>,
    /// What the layer of depth holds; `None` decides from the data.
    pub depth_kind: Option<StoredDepth>,
    /// What colours mean; `None` goes by what files say: photos are sRGB, EXR files linear.
    pub colorspace: Option<ColorSpace>,
    /// Light layers; read only where they are asked for here.
    pub light: Option<LightInputs>,
    /// Rows of the frame to be read, counted from the top of its data window; all where not given.
    pub rows: Option<Range<usize>>,
    /// The camera, where it is known already; it goes before all others.
    pub known_camera: Option<KnownCamera>,
}

/// A camera that need not be looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownCamera {
    /// The camera.
    pub camera: Camera,
    /// Whether it is known where in the world it stands; else only how it is turned.
    pub is_placed: bool,
}

/// Which layers of light are wanted. A lobe that is not named is found by its layers' names.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LightInputs {
    /// Whether lobes are wanted.
    pub lobes: LobeChoice,
    /// Leaves out lobes of diffuse light, whatever they are called.
    pub without_diffuse: bool,
    /// Leaves out all other lobes.
    pub without_specular: bool,
    /// Diffuse light, the surface's colour included.
    pub diffuse: Option<String>,
    /// Specular light, the surface's colour included.
    pub specular: Option<String>,
    /// The surface's diffuse colour.
    pub albedo: Option<String>,
    /// Light groups; where there are any, lobes are not read.
    pub groups: Vec<GroupInput>,
    /// Whether ambient occlusion is wanted.
    pub occlusion: bool,
}

pub use crate::params::LobeChoice;

/// A light group and where its light comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupInput {
    /// Its name, without the renderer's prefix.
    pub name: String,
    /// Unit directions in view space to its lights.
    pub to_light: Vec<Vec3>,
}

/// How a normal's components were stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NormalEncoding {
    /// As they are, -1..1.
    Signed,
    /// As (n + 1) / 2, 0..1.
    Unsigned,
}

/// Axes to be turned round, in the space the normals were stored in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flip {
    /// Negate x.
    pub x: bool,
    /// Negate y: DirectX normal maps store green downward.
    pub y: bool,
    /// Negate z.
    pub z: bool,
}

impl Flip {
    /// No axis.
    pub const NONE: Self = Self {
        x: false,
        y: false,
        z: false,
    };

    /// Both flips, one after the other.
    pub fn and(self, other: Self) -> Self {
        Self {
            x: self.x ^ other.x,
            y: self.y ^ other.y,
            z: self.z ^ other.z,
        }
    }
}

impl std::fmt::Display for Flip {
    /// The axes, `xz`, or `none`: what `--normal-flip` takes.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let axes = [(self.x, "x"), (self.y, "y"), (self.z, "z")];
        let turned: String = axes.iter().filter(|a| a.0).map(|a| a.1).collect();
        f.write_str(if turned.is_empty() { "none" } else { &turned })
    }
}

/// What a layer of depth holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StoredDepth {
    /// Distance along the view axis.
    Planar,
    /// Distance along the sight line, from the eye.
    Ray,
    /// One over the distance along the view axis; 0 where nothing was seen.
    Inverse,
    /// Something that grows with distance, or a distance too coarse for more: 0 where nothing was seen.
    Relative,
    /// Distance mapped to 0..1, black near and white far, perhaps clamped. It does not tell where nothing was
    /// seen.
    WhiteFar,
    /// The same the other way round, white near and black far.
    WhiteNear,
}

impl StoredDepth {
    /// All of them, with the names that `--depth-kind` gives them.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Planar, "z"),
        (Self::Ray, "distance"),
        (Self::Inverse, "inverse"),
        (Self::Relative, "relative"),
        (Self::WhiteFar, "white-far"),
        (Self::WhiteNear, "white-near"),
    ];

    /// The name that `--depth-kind` gives it.
    pub fn name(self) -> &'static str {
        let named = Self::ALL.iter().find(|(kind, _)| *kind == self);
        named.expect("every kind has a name").1
    }

    /// What the depth of a frame measures that was made of it.
    pub fn kind(self) -> DepthKind {
        match self {
            Self::Planar | Self::Inverse => DepthKind::Planar,
            Self::Ray => DepthKind::Ray,
            Self::Relative | Self::WhiteFar | Self::WhiteNear => DepthKind::Relative,
        }
    }

    /// Whether the layer tells where nothing was seen.
    pub(super) fn tells_coverage(self) -> bool {
        !matches!(self, Self::WhiteFar | Self::WhiteNear)
    }
}

impl std::fmt::Display for StoredDepth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Planar | Self::Ray | Self::Relative => self.kind().fmt(f),
            Self::Inverse => f.write_str("one over the depth along the view axis"),
            Self::WhiteFar => f.write_str("relative depth, white far"),
            Self::WhiteNear => f.write_str("relative depth, white near"),
        }
    }
}

/// How the layers of a frame were read.
///
/// Given back by [`Conventions::force`] to the inputs of another frame of the same make, they spare judging it, and
/// the frame comes out as it would where the judgement is the same, bit for bit. They go with the
/// [`super::Needs`] they were loaded for: what was not needed may not have been judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conventions {
    /// The space of the normals.
    pub normal_space: NormalSpace,
    /// The encoding of the normals.
    pub normal_encoding: NormalEncoding,
    /// Axes of the normals, as stored, that were turned round: those told, and those found.
    pub normal_flip: Flip,
    /// What the layer of depth holds; `None` without depth.
    pub depth_kind: Option<StoredDepth>,
}

impl Conventions {
    /// A layer of depth made to grow with distance.
    pub(super) fn distances(&self, mut depth: Plane) -> Plane {
        if let Some(stored) = self.depth_kind {
            super::depth::to_distances(&mut depth, stored);
        }
        depth
    }

    /// Makes `inputs` be read by these conventions.
    pub fn force(&self, inputs: &mut Inputs) {
        inputs.normal_space = Some(self.normal_space);
        inputs.normal_encoding = Some(self.normal_encoding);
        inputs.normal_flip = Some(self.normal_flip);
        inputs.depth_kind = self.depth_kind.or(inputs.depth_kind);
    }
}

impl std::str::FromStr for Flip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut flip = Self::default();
        if text == "none" {
            return Ok(flip);
        }
        for axis in text.chars().filter(|&c| c != ',') {
            match axis.to_ascii_lowercase() {
                'x' => flip.x = true,
                'y' => flip.y = true,
                'z' => flip.z = true,
                _ => return Err("expected axes out of x, y and z, as in y or xz".into()),
            }
        }
        Ok(flip)
    }
}
