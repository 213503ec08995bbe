//! What a user may say about the inputs; everything left out is found from names and data.

use crate::frame::NormalSpace;
use glam::Vec3;
use std::path::PathBuf;

/// Which files and layers a frame is made of, and how they are to be read.
///
/// A role that is `None` is found by its layer's name; one that is named is a layer of the picture
/// or, where no layer is called so, another file.
#[derive(Debug, Clone, Default)]
pub struct Inputs {
    /// The picture: an EXR with its layers, or a photo.
    pub picture: PathBuf,
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
    /// Axes of the normals that point the wrong way.
    pub normal_flip: Flip,
    /// Light layers; read only where they are asked for here.
    pub light: Option<LightInputs>,
}

/// Which layers of light are wanted. A lobe that is not named is found by its layers' names.
#[derive(Debug, Clone, Default)]
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

/// Whether the lobes of a picture's light are used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LobeChoice {
    /// Where there are any, unless a layer was named for the picture and none for a lobe.
    #[default]
    Auto,
    /// Yes: it is an error if there are none.
    On,
    /// No.
    Off,
}

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

impl std::str::FromStr for Flip {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut flip = Self::default();
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
