//! Which layers and files play which role: the names of the inputs.

use super::still_camera::StillCamera;
use crate::frame::NormalSpace;
use crate::io::colorspace::ColorSpace;
use crate::io::inputs::{Flip, Inputs, NormalEncoding, StoredDepth};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Which layers and files play which role.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Inputs")]
pub(super) struct RoleArgs {
    /// View that all layers are taken from, of a file with several: left. Not given: the default one.
    #[arg(long, value_name = "NAME")]
    view: Option<String>,
    /// Normals: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    normal: Option<String>,
    /// Depth: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    depth: Option<String>,
    /// World-space positions: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    position: Option<String>,
    /// The picture to be enhanced: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    color: Option<String>,
    /// Ambient occlusion, for silhouettes in place of depth: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    occlusion: Option<String>,
    /// How far each pixel is diffused, from 0, all detail, to 1, as far as asked for: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    importance: Option<String>,
    /// Coverage, a surface where above one half: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    mask: Option<String>,
    /// Space of the normals.
    #[arg(long, value_name = "SPACE", default_value = "auto")]
    normal_space: SpaceArg,
    /// Encoding of the normals.
    #[arg(long, value_name = "ENCODING", default_value = "auto")]
    normal_encoding: EncodingArg,
    /// Axes of the normals that point the wrong way: y for DirectX normal maps, none, or auto.
    #[arg(long, value_name = "AXES", default_value = "auto")]
    normal_flip: FlipArg,
    /// What depth measures.
    #[arg(long, value_name = "KIND", default_value = "auto", value_parser = auto_or(StoredDepth::ALL))]
    depth_kind: Told<StoredDepth>,
    /// What the colours of the inputs mean: linear, srgb, acescg, aces2065-1; auto goes by what files say, else photos
    /// are srgb and EXR files linear. Layers are written in the same space, pictures for a display in sRGB.
    #[arg(long, value_name = "SPACE", default_value = "auto", value_parser = auto_or(ColorSpace::ALL))]
    colorspace: Told<ColorSpace>,
    /// The camera of all frames of a sequence, as --save-recipe writes it where it was recovered and stands still.
    #[arg(long, value_name = "JSON", conflicts_with = "camera")]
    still_camera: Option<StillCamera>,
    /// Camera as JSON: world_to_camera and focal_px, or what the README lists.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum SpaceArg {
    Auto,
    View,
    World,
    // Of an object that was not turned: as the world. No doc comment: it would change the layout of all help.
    Object,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum EncodingArg {
    Auto,
    Signed,
    Unsigned,
}

impl From<NormalSpace> for SpaceArg {
    fn from(space: NormalSpace) -> Self {
        match space {
            NormalSpace::View => Self::View,
            NormalSpace::World => Self::World,
        }
    }
}

impl From<NormalEncoding> for EncodingArg {
    fn from(encoding: NormalEncoding) -> Self {
        match encoding {
            NormalEncoding::Signed => Self::Signed,
            NormalEncoding::Unsigned => Self::Unsigned,
        }
    }
}

/// Axes that were told, or none told.
#[derive(Debug, Clone, Copy)]
struct FlipArg(Option<Flip>);

impl std::str::FromStr for FlipArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self(None)),
            axes => axes.parse().map(|flip| Self(Some(flip))),
        }
    }
}

/// One of several that was told, or `auto`.
#[derive(Debug, Clone, Copy)]
struct Told<T>(Option<T>);

/// Offers `auto` and the names of `all`.
fn auto_or<T, const N: usize>(all: [(T, &'static str); N]) -> impl TypedValueParser<Value = Told<T>>
where
    T: Copy + Send + Sync + 'static,
{
    let names = all.map(|(_, name)| name);
    PossibleValuesParser::new(std::iter::once("auto").chain(names)).map(move |told| {
        let known = all.iter().find(|(_, name)| *name == told);
        Told(known.map(|(value, _)| *value))
    })
}

impl RoleArgs {
    pub(super) fn inputs(&self, picture: &std::path::Path) -> Inputs {
        Inputs {
            picture: picture.to_path_buf(),
            view: self.view.clone(),
            color: self.color.clone(),
            normal: self.normal.clone(),
            depth: self.depth.clone(),
            position: self.position.clone(),
            occlusion: self.occlusion.clone(),
            albedo: None,
            importance: self.importance.clone(),
            motion: None,
            mask: self.mask.clone(),
            camera: self.camera.clone(),
            normal_space: match self.normal_space {
                SpaceArg::Auto => None,
                SpaceArg::View => Some(NormalSpace::View),
                SpaceArg::World | SpaceArg::Object => Some(NormalSpace::World),
            },
            normal_encoding: match self.normal_encoding {
                EncodingArg::Auto => None,
                EncodingArg::Signed => Some(NormalEncoding::Signed),
                EncodingArg::Unsigned => Some(NormalEncoding::Unsigned),
            },
            normal_flip: self.normal_flip.0,
            depth_kind: self.depth_kind.0,
            colorspace: self.colorspace.0,
            light: None,
            rows: None,
            known_camera: self.still_camera.map(|still| still.0),
        }
    }

    /// Gives every layer and file the name that `name` makes of its own.
    pub(super) fn rename(&mut self, name: impl Fn(&str) -> String) {
        let named = [
            &mut self.normal,
            &mut self.depth,
            &mut self.position,
            &mut self.color,
            &mut self.occlusion,
            &mut self.importance,
            &mut self.mask,
        ];
        for own in named.into_iter().flatten() {
            *own = name(own);
        }
        if let Some(camera) = &mut self.camera
            && let Some(own) = camera.to_str()
        {
            *camera = name(own).into();
        }
    }

    /// Every input that is a file of its own.
    pub(super) fn files(&self, picture: &std::path::Path) -> Vec<PathBuf> {
        let named = [
            &self.normal,
            &self.depth,
            &self.position,
            &self.color,
            &self.occlusion,
            &self.importance,
            &self.mask,
        ];
        let named = named
            .into_iter()
            .flatten()
            .map(PathBuf::from)
            .filter(|path| path.exists());
        std::iter::once(picture.to_path_buf())
            .chain(named)
            .chain(self.camera.clone())
            .collect()
    }
}
