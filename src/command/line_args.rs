//! The arguments of `hatch`.

use super::flags::Section;
use super::motion_arg::MotionArg;
use super::relight_args::RelightArgs;
use crate::params::{Group, LineParams, ObjectAngle, ToneSource};
use clap::Args;
use std::path::Path;

#[derive(Debug, Clone, Args)]
pub(crate) struct HatchArgs {
    #[command(flatten)]
    pub(crate) relight: RelightArgs,
    #[command(flatten)]
    _tone: Section<{ Group::Tone as u8 }>,
    #[command(flatten)]
    _directions: Section<{ Group::Directions as u8 }>,
    #[command(flatten)]
    _strokes: Section<{ Group::Strokes as u8 }>,
    #[command(flatten)]
    _contours: Section<{ Group::Contours as u8 }>,
    /// Where strokes go on one object that curvature does not lead, in place of --fallback: by its name in Cryptomatte,
    /// * and ? for any letters, or its number in an index pass. May be given several times; the last one counts.
    #[arg(
        hide_short_help = true,
        long = "object-angle",
        value_name = "NAME=DEG|surface",
        help_heading = "Directions"
    )]
    pub(crate) object_angles: Vec<ObjectAngle>,
    #[command(flatten)]
    pub(crate) motion: MotionArg,
}

impl HatchArgs {
    /// The folder of pictures that strokes are taken from, if any.
    pub(crate) fn pictures(&self) -> Option<&Path> {
        self.relight.work.flags.folder_of_strokes.as_deref()
    }

    pub(crate) fn tone(&self) -> ToneSource {
        self.relight.work.flags.params.tone
    }

    pub(crate) fn params(&self) -> LineParams {
        self.relight.work.flags.params.line
    }
}
