//! The argument that names the motion between the frames of a sequence.

use super::sequence::numbered;
use clap::Args;

/// The motion between frames.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Sequence")]
pub(crate) struct MotionArg {
    /// Motion that strokes follow: a layer of IN or a file. By default it is searched for, else computed from depth and
    /// camera; none keeps strokes fixed in the picture. Its sign and unit are those that lead a frame to the previous
    /// one, or else previous minus current in pixels, y up.
    #[arg(long, value_name = "NAME|FILE|none", requires = "frames")]
    motion: Option<String>,
}

impl MotionArg {
    /// Whether strokes move with the surface.
    pub(crate) fn moves(&self) -> bool {
        self.motion.as_deref() != Some("none")
    }

    /// The named layer or file of motion, for one frame.
    pub(crate) fn of_frame(&self, frame: i32) -> Option<String> {
        let named = self.motion.as_deref().filter(|_| self.moves())?;
        Some(numbered(named, frame))
    }
}
