//! From planes to the output file.

use super::args::{LayersArg, OutputArgs, SampleArg};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane};
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, OutputPart, OutputType, append_part, write_results};
use crate::io::output::write_atomically;
use crate::io::picture::PictureFormat;
use std::path::Path;

/// Name of the part that holds our results, and of the layer that holds the enhanced picture in it.
const PART: &str = "relievo";

/// What kind of file an output path stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Exr,
    Picture(PictureFormat),
}

impl Kind {
    pub(super) fn of(path: &Path) -> Result<Self> {
        let is_exr = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        match PictureFormat::of_path(path) {
            _ if is_exr => Ok(Self::Exr),
            Some(format) => Ok(Self::Picture(format)),
            None => Err(Error::BadParameter {
                name: "-o",
                found: format!("{} has no known extension", path.display()),
                remedy: "end it in .exr, .png, .jpg, .tif or .hdr".into(),
            }),
        }
    }
}

/// Writes planes to an EXR: beside the input's own where there are any to keep, else alone.
pub(super) fn write_exr(
    args: &OutputArgs,
    loaded: &Loaded,
    channels: Vec<OutputChannel>,
) -> Result<()> {
    let path = &args.output;
    let frame = &loaded.frame;
    let part = OutputPart {
        name: PART.into(),
        data_window: frame.data_window,
        display_window: frame.display_window,
        pixel_aspect: frame.pixel_aspect,
        channels,
        attributes: vec![(
            "software".into(),
            format!("relievo {}", env!("CARGO_PKG_VERSION")),
        )],
        chromaticities: loaded.exr().and_then(|file| file.chromaticities),
        compression: Default::default(),
    };
    let kept = loaded.exr().filter(|_| args.layers == LayersArg::Keep);
    write_atomically(path, !args.no_clobber, |w| match kept {
        Some(input) => append_part(input, w, path, &part),
        None => write_results(w, path, &part),
    })
}

/// The prefix of our colour channels: none in a file of our own, where they are the picture.
pub(super) fn color_layer(args: &OutputArgs, loaded: &Loaded) -> Option<&'static str> {
    let beside = loaded.exr().is_some() && args.layers == LayersArg::Keep;
    beside.then_some(PART)
}

/// Colour planes as channels, with alpha where the picture has one.
pub(super) fn color_channels<'a>(
    layer: Option<&str>,
    color: &'a ColorPlanes,
    alpha: Option<&'a Plane>,
    sample_type: OutputType,
) -> Vec<OutputChannel<'a>> {
    let planes = [
        ("R", Some(&color.r)),
        ("G", Some(&color.g)),
        ("B", Some(&color.b)),
        ("A", alpha),
    ];
    let name = |component: &str| match layer {
        Some(layer) => format!("{layer}.{component}"),
        None => component.to_string(),
    };
    planes
        .into_iter()
        .filter_map(|(component, plane)| plane.map(|plane| (name(component), plane)))
        .map(|(name, plane)| OutputChannel {
            name,
            plane,
            sample_type,
        })
        .collect()
}

impl From<SampleArg> for OutputType {
    fn from(arg: SampleArg) -> Self {
        match arg {
            SampleArg::Half => Self::Half,
            SampleArg::Float => Self::Float,
        }
    }
}
