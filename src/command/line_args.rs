//! The arguments of `hatch`.

use super::flags::Section;
use super::motion_arg::MotionArg;
use super::relight_args::RelightArgs;
use crate::params::table::rows;
use crate::params::{Group, LineParams, ObjectAngle, ToneSource};
use std::path::Path;

rows! {
    #[derive(Debug, Clone)]
    pub(crate) struct HatchArgs {
        pub(crate) relight: RelightArgs as flatten;
        _tone: Section<{ Group::Tone as u8 }> as flatten;
        _directions: Section<{ Group::Directions as u8 }> as flatten;
        _strokes: Section<{ Group::Strokes as u8 }> as flatten;
        _contours: Section<{ Group::Contours as u8 }> as flatten;
        /// Where strokes go on one object that curvature does not lead, in place of --fallback: by its name in Cryptomatte,
        /// * and ? for any letters, or its number in an index pass. May be given several times; the last one counts.
        pub(crate) object_angles: Vec<ObjectAngle> =
            [hide_short_help = true, long = "object-angle", value_name = "NAME=DEG|surface", help_heading = "Directions"];
        pub(crate) motion: MotionArg as flatten;
    }
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
