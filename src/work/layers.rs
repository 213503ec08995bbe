//! The colours of a result as layers of an EXR.

use crate::command::args::{LayersArg, OutputArgs};
use crate::frame::{ColorPlanes, Plane};
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, OutputType};
use crate::product::PART;

/// A picture made of `loaded`.
pub(super) fn of_picture<'a>(
    output: &OutputArgs,
    loaded: &'a Loaded,
    color: &'a ColorPlanes,
) -> Vec<OutputChannel<'a>> {
    let (layer, alpha) = (output.color_layer(loaded), loaded.frame.alpha.as_ref());
    of_color(layer, color, alpha, output.sample_type(loaded))
}

/// Colour planes as channels, with alpha where the picture has one.
pub(super) fn of_color<'a>(
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

impl OutputArgs {
    /// The prefix of our colour channels: none in a file of our own, where they are the picture.
    pub(crate) fn color_layer(&self, loaded: &Loaded) -> Option<&'static str> {
        let beside = loaded.exr().is_some() && self.layers != LayersArg::Results;
        beside.then_some(PART)
    }

    /// How samples of a picture are stored.
    fn sample_type(&self, loaded: &Loaded) -> OutputType {
        match self.depth_of_output {
            Some(chosen) => chosen,
            None if loaded.color_is_half => OutputType::Half,
            None => OutputType::Float,
        }
    }
}
