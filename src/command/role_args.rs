//! Arguments that assign roles to layers and files.

use super::flags::{Flag, Given, one_of, word_or};
use super::named::{Named, given};
use super::still_camera::StillCamera;
use crate::frame::NormalSpace;
use crate::io::colorspace::ColorSpace;
use crate::io::inputs::{Conventions, Flip, Inputs, NormalEncoding, StoredDepth, Wrap};
use clap::Args;
use clap::builder::TypedValueParser;
use std::path::PathBuf;

/// Their heading in help.
pub(crate) const INPUTS: &str = "Inputs";

/// Which layers and files play which role.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = INPUTS)]
pub(crate) struct RoleArgs {
    /// View to take all layers from (as in left), for files with several; the default view if not given.
    #[arg(hide_short_help = true, long, value_name = "NAME")]
    view: Option<String>,
    /// Group to take all layers from, such as a view layer (FG for FG.Normal.X), for files with several; that with
    /// normals, the default picture, or the first if not given. inspect lists them.
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,
    /// Normals: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    normal: Option<String>,
    /// Depth: a layer of IN or a file; none leaves it out.
    #[arg(long, value_name = "NAME|FILE|none")]
    depth: Option<String>,
    /// Heights of the surface, seen from above, in place of normals and depth: a layer of IN or a file.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE", conflicts_with_all = ["depth", "normal", "depth_kind", "camera"])]
    height: Option<String>,
    /// Pixels that a height of 1 is high. By default floats are pixels, and white is a tenth of the longer side in
    /// pictures of integers.
    #[arg(
        hide_short_help = true,
        long,
        value_name = "PIXELS",
        requires = "height"
    )]
    height_scale: Option<f32>,
    /// World-space positions: a layer of IN or a file; none leaves it out.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE|none")]
    position: Option<String>,
    /// The picture to be enhanced: a layer of IN or a file.
    #[arg(long, value_name = "NAME|FILE")]
    color: Option<String>,
    /// Ambient occlusion, for silhouettes in place of depth: a layer of IN or a file; none leaves it out. computed
    /// is that of the shape: for relight --sky-shadows on without a layer, for enhance what --scaling-ambient scales.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE|none|computed")]
    occlusion: Option<String>,
    /// How far each pixel is diffused, from 0 (keep all detail) to 1 (in full): a layer of IN or a file.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE")]
    importance: Option<String>,
    /// Where and how far the picture is changed, 0 to 1: a layer of IN or a file. Shape is computed over the whole
    /// picture, and the gain is that of this part; drawings and measurements cover the pixels where the mask is above one
    /// half.
    #[arg(long, value_name = "NAME|FILE")]
    mask: Option<String>,
    /// Only this object, by its name in Cryptomatte, * and ? for any letters, its hash, as in 0x05777012, or its number in
    /// an index pass; !NAME leaves one out. May be given several times.
    #[arg(long = "object", value_name = "NAME")]
    objects: Vec<String>,
    /// File with the Cryptomatte or the index passes that tell objects apart, where IN has none; of the same size.
    #[arg(long, value_name = "FILE")]
    cryptomatte: Option<PathBuf>,
    /// Where a surface is seen, above one half: a layer of IN or a file. Normals elsewhere are ignored.
    #[arg(hide_short_help = true, long, value_name = "NAME|FILE")]
    coverage: Option<String>,
    /// Space of the normals.
    #[arg(hide_short_help = true, long, value_name = "SPACE", default_value = "auto", value_parser = auto_or(NORMAL_SPACES))]
    normal_space: Given<NormalSpace>,
    /// Encoding of the normals: signed (-1..1), unsigned (0..1), or two channels of which z is rebuilt: xy (red, green), ag
    /// (x in alpha, y in green), oct (octahedral).
    #[arg(hide_short_help = true, long, value_name = "ENCODING", default_value = "auto", value_parser = auto_or(NORMAL_ENCODINGS))]
    normal_encoding: Given<NormalEncoding>,
    /// Axes of the normals that point the wrong way: as in y or xz, none, or auto; or who wrote them: opengl (none),
    /// directx (y), opencv (yz), stablenormal, dsine or bae (x).
    #[arg(long, value_name = "AXES", default_value = "auto", value_parser = word_or::<Flip>("auto"))]
    normal_flip: Given<Flip>,
    /// Quantity stored as depth.
    #[arg(hide_short_help = true, long, value_name = "KIND", default_value = "auto", value_parser = auto_or(StoredDepth::ALL))]
    depth_kind: Given<StoredDepth>,
    /// Colour space of the inputs: linear, srgb, acescg, aces2065-1; auto goes by what files say, else photos are srgb
    /// and EXR files linear. Layers are written in the same space, pictures for a display in sRGB.
    #[arg(hide_short_help = true, long, value_name = "SPACE", default_value = "auto", value_parser = auto_or(ColorSpace::ALL))]
    colorspace: Given<ColorSpace>,
    /// Opposite borders that continue each other, in a picture that is a tile: none, x (left and right), y, xy, or auto,
    /// those across which normals change no more than beside them. Results then continue across them.
    #[arg(hide_short_help = true, long, value_name = "BORDERS", default_value = "none", value_parser = one_of(wraps()))]
    pub(crate) wrap: Wrap,
    /// The camera shared by all frames of a sequence, as --save-recipe writes it where it was recovered and stands
    /// still.
    #[arg(
        hide_short_help = true,
        long,
        value_name = "JSON",
        conflicts_with = "camera"
    )]
    still_camera: Option<StillCamera>,
    /// Camera as JSON: world_to_camera and focal_px, or other keys listed in docs/guide/files.md.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
}

/// Spaces of normals. For an object that is not rotated, object space equals world space.
const NORMAL_SPACES: [(NormalSpace, &str); 4] = [
    (NormalSpace::View, NormalSpace::View.name()),
    (NormalSpace::World, NormalSpace::World.name()),
    (NormalSpace::World, "object"),
    (NormalSpace::Sight, NormalSpace::Sight.name()),
];

const NORMAL_ENCODINGS: [(NormalEncoding, &str); 5] = [
    (NormalEncoding::Signed, "signed"),
    (NormalEncoding::Unsigned, "unsigned"),
    (NormalEncoding::Xy, "xy"),
    (NormalEncoding::Ag, "ag"),
    (NormalEncoding::Oct, "oct"),
];

fn wraps() -> impl Iterator<Item = (Wrap, &'static str)> {
    let words = Wrap::CHOICES.iter().map(|choice| choice.name);
    words.filter_map(|word| Some((Wrap::named(word)?, word)))
}

/// Parser for `auto` and the names of `all`.
fn auto_or<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (T, &'static str)>,
) -> impl TypedValueParser<Value = Given<T>> {
    let all = all.into_iter().map(|(value, name)| (Some(value), name));
    one_of(std::iter::once((None, "auto")).chain(all)).map(Given)
}

/// The flags that make layers be read by these conventions.
pub(super) fn flags_of(conventions: &Conventions) -> Vec<Flag> {
    let Conventions {
        normal_space,
        normal_encoding,
        normal_flip,
        depth_kind,
    } = conventions;
    // Heights have a flag of their own, and names that say so say it of all frames.
    let depth = depth_kind.filter(|kind| *kind != StoredDepth::Height);
    let depth = depth.map(|kind| Flag::new("depth-kind", kind.name()));
    [
        Flag::new("normal-space", normal_space.name()),
        Flag::new("normal-encoding", name(&NORMAL_ENCODINGS, normal_encoding)),
        Flag::new("normal-flip", normal_flip),
    ]
    .into_iter()
    .chain(depth)
    .collect()
}

/// The first name of a value.
fn name<T: PartialEq>(all: &[(T, &'static str)], value: &T) -> &'static str {
    let named = all.iter().find(|(one, _)| one == value);
    named.expect("every value has a word").1
}

/// What --occlusion calls that of the surface itself.
const COMPUTED: &str = "computed";

impl RoleArgs {
    /// Whether occlusion is computed rather than read.
    pub(crate) fn computes_occlusion(&self) -> bool {
        self.occlusion.as_deref() == Some(COMPUTED)
    }

    pub(crate) fn inputs(&self, picture: &std::path::Path) -> Inputs {
        Inputs {
            picture: picture.to_path_buf(),
            view: self.view.clone(),
            layer: self.layer.clone(),
            color: self.color.clone(),
            normal: self.normal.clone(),
            depth: self.height.clone().or_else(|| self.depth.clone()),
            position: self.position.clone(),
            occlusion: self.occlusion.clone(),
            importance: self.importance.clone(),
            mask: self.mask.clone(),
            objects: self.objects.clone(),
            cryptomatte: self.cryptomatte.clone(),
            coverage: self.coverage.clone(),
            camera: self.camera.clone(),
            normal_space: self.normal_space.0,
            normal_encoding: self.normal_encoding.0,
            normal_flip: self.normal_flip.0,
            depth_kind: match self.height {
                Some(_) => Some(StoredDepth::Height),
                None => self.depth_kind.0,
            },
            height_scale: self.height_scale,
            colorspace: self.colorspace.0,
            wrap: self.wrap,
            known_camera: self.still_camera.map(|still| still.0),
            ..Inputs::default()
        }
    }

    /// The layers and files that are named.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        let layers = [
            &mut self.normal,
            &mut self.depth,
            &mut self.height,
            &mut self.position,
            &mut self.color,
            &mut self.occlusion,
            &mut self.importance,
            &mut self.mask,
            &mut self.coverage,
        ];
        given(layers, [&mut self.camera, &mut self.cryptomatte])
    }
}
