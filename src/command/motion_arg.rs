//! The argument that names the motion between the frames of a sequence.

use super::named::{Named, given};
use crate::io::motion::MotionConvention;
use crate::params::table::rows;
use crate::params::words::word_or;

rows! {
    /// The motion between frames.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Sequence")]
    pub(crate) struct MotionArg {
        /// Motion that strokes follow: a layer of IN or a file. By default it is searched for, else computed from depth and
        /// camera; none keeps strokes fixed in the picture. Its sign and unit are those that lead a frame to the previous
        /// one, or else previous minus current in pixels, y up.
        motion: Option<String> = [hide_short_help = true, long, value_name = "NAME|FILE|none", requires = "frames"];
        /// How to read the layer of --motion, whatever frames show: back to the previous frame or forward from it, y up or
        /// down, and its unit: pixels, half-frame (pixels over half a frame), pictures (widths and heights), half-pictures,
        /// half-pictures-0-1, 2048-0-1 (2048 pixels, both stored as 0..1). Words left out are those of back,up,pixels.
        motion_convention: std::option::Option<MotionConvention> =
            [hide_short_help = true, long, value_name = "WORDS", default_value = "auto", value_parser = word_or::<MotionConvention>("auto"), requires = "motion"];
    }
}

impl MotionArg {
    /// Whether strokes move with the surface.
    pub(crate) fn moves(&self) -> bool {
        self.motion.as_deref() != Some("none")
    }

    /// The convention of motion, where it was given.
    pub(crate) fn convention(&self) -> Option<MotionConvention> {
        self.motion_convention
    }

    /// The layer or file of motion, where it is named.
    pub(crate) fn layer(&self) -> Option<String> {
        self.motion.clone().filter(|_| self.moves())
    }

    /// Its name.
    pub(crate) fn names(&mut self) -> Vec<Named<'_>> {
        given([&mut self.motion], [])
    }
}
