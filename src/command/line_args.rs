//! The arguments of `hatch`.

use super::flags::Section;
use super::motion_arg::MotionArg;
use super::relight_args::RelightArgs;
use crate::params::{Group, LineParams, ToneSource};
use clap::Args;
use std::path::Path;

#[derive(Debug, Args)]
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
    #[command(flatten)]
    pub(crate) motion: MotionArg,
}

impl HatchArgs {
    /// The folder of pictures that strokes are taken from, if any.
    pub(crate) fn pictures(&self) -> Option<&Path> {
        self.relight.work.flags.folder_of_strokes.as_deref()
    }

    pub(super) fn tone(&self) -> ToneSource {
        self.relight.work.flags.params.tone
    }

    pub(super) fn params(&self) -> LineParams {
        self.relight.work.flags.params.line
    }
}
