//! Sequences: frame numbers, and the names of their files.

use super::grid::CellSize;
use crate::error::{Result, bad};
use crate::io::sequence::{FrameList, is_pattern, path_of_frame};
use crate::params::table::rows;
use crate::params::words::word_or;
use crate::untrusted::shown;
use clap::ValueEnum;
use std::path::Path;

/// Number of frames sampled for automatic choices.
const SAMPLES: usize = 5;

rows! {
    /// The frames of a sequence.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Sequence")]
    pub(crate) struct FramesArg {
        /// Frames of a sequence, whose numbers go where IN and -o have #### or %04d: 1-12, every second one
        /// 1-12x2 or 1-12:2, the others 1-12y2, or 1,5,9.
        frames: Option<FrameList> = [long, value_name = "LIST", allow_hyphen_values = true];
    }
}

rows! {
    /// Options for processing a sequence.
    #[derive(Debug, Clone)]
    #[command(next_help_heading = "Sequence")]
    pub(crate) struct SequenceArgs {
        pub(super) frames: FramesArg as flatten;
        /// Frames that all automatic settings are chosen from, once for the sequence; by default five spread over --frames.
        /// none lets each frame choose for itself.
        sample_frames: Option<std::option::Option<FrameList>> =
            [hide_short_help = true, long, value_name = "LIST|none", value_parser = word_or::<FrameList>("none"), allow_hyphen_values = true, conflicts_with = "grid"];
        /// Skip frames whose output exists and is complete.
        pub(crate) skip_existing: bool = [long, requires = "frames"];
        /// How to treat frames without an input.
        pub(crate) missing_frame: MissingArg =
            [hide_short_help = true, long, value_name = "WHAT", value_enum, default_value = "error", requires = "frames"];
        /// Go on after a frame that failed; the exit code is then 3.
        pub(crate) keep_going: bool = [hide_short_help = true, long, requires = "frames"];
        /// Columns and rows of a sprite, in pixels, as in 32x32: IN and all other files are sheets of them. Each is processed as
        /// a picture of its own, by automatic settings chosen once for the sheet.
        pub(crate) grid: Option<CellSize> =
            [hide_short_help = true, long, value_name = "WxH", conflicts_with = "frames"];
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MissingArg {
    Error,
    Skip,
}

impl FramesArg {
    /// Whether frames were given.
    pub(super) fn is_given(&self) -> bool {
        self.frames.is_some()
    }

    /// The frames that were given.
    #[cfg(feature = "view")]
    pub(crate) fn numbers(&self) -> Option<Vec<i32>> {
        Some(self.frames.as_ref()?.numbers().to_vec())
    }

    /// The frames, for names with a placeholder for the number; `None` for a single picture.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for frames without such names, and for such names without frames.
    pub(crate) fn of(&self, input: &Path, output: Option<&Path>) -> Result<Option<&[i32]>> {
        frames_of(self.frames.as_ref(), input, output)
    }
}

impl SequenceArgs {
    /// The frames to sample: those given, else some of `frames`.
    pub(crate) fn samples(&self, frames: &[i32]) -> Vec<i32> {
        match &self.sample_frames {
            Some(None) => Vec::new(),
            Some(Some(list)) => list.numbers().to_vec(),
            None => spread(frames),
        }
    }
}

/// The requested frames, for names with a placeholder; `None` for a single picture.
///
/// # Errors
/// [`Error::BadParameter`] for names that have a place for frame numbers without `frames`, and for `frames`
/// without a place for them in `input` or `output`.
fn frames_of<'a>(
    frames: Option<&'a FrameList>,
    input: &Path,
    output: Option<&Path>,
) -> Result<Option<&'a [i32]>> {
    let named = [("IN", Some(input)), ("-o", output)];
    let named = named.into_iter();
    let mut named = named.filter_map(|(name, path)| Some((name, path?)));
    let bad = |name, path: &Path, what: &str, remedy: &str| {
        Err(bad(name, format!("{} {what}", shown(path)), remedy))
    };
    match frames {
        None => match named.find(|(_, path)| path.to_str().is_some_and(is_pattern)) {
            Some((name, path)) => bad(
                name,
                path,
                "names a file of each frame, and no frames are given",
                "give them, as in --frames 1-12",
            ),
            None => Ok(None),
        },
        Some(frames) => match named.find(|(_, path)| path_of_frame(path, 0).is_none()) {
            Some((name, path)) => bad(
                name,
                path,
                "has no place for the numbers of --frames",
                "put #### or %04d where they go, or leave out --frames",
            ),
            None => Ok(Some(frames.numbers())),
        },
    }
}

/// The first frame, the last, and some evenly between them.
fn spread(frames: &[i32]) -> Vec<i32> {
    let last = frames.len() - 1;
    let count = SAMPLES.min(frames.len());
    let place = |i: usize| i * last / (count - 1).max(1);
    (0..count).map(|i| frames[place(i)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_lie_across_the_frames() {
        let frames: Vec<i32> = (1001..=1101).collect();
        assert_eq!(spread(&frames), [1001, 1026, 1051, 1076, 1101]);
        assert_eq!(spread(&[4, 9]), [4, 9]);
        assert_eq!(spread(&[7]), [7]);
    }

    #[test]
    fn names_and_frames_go_together() {
        let frames: FrameList = "1-3".parse().unwrap();
        let [many, out, one] = ["in.####.exr", "out.%04d.png", "one.png"].map(Path::new);
        let found = frames_of(Some(&frames), many, Some(out)).unwrap();
        assert_eq!(found, Some([1, 2, 3].as_slice()));
        assert_eq!(frames_of(Some(&frames), many, None).unwrap(), found);
        assert_eq!(frames_of(None, one, Some(one)).unwrap(), None);
        let says =
            |frames, input, output| frames_of(frames, input, output).unwrap_err().to_string();
        assert!(
            says(None, many, Some(out)).starts_with("IN in.####.exr names a file of each frame")
        );
        assert!(
            says(None, one, Some(out)).starts_with("-o out.%04d.png names a file of each frame")
        );
        assert!(says(Some(&frames), one, Some(out)).starts_with("IN one.png has no place"));
        assert!(says(Some(&frames), many, Some(one)).starts_with("-o one.png has no place"));
    }
}
