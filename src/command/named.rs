//! The inputs and outputs that a command names: which are files, and what they are called in one frame of a sequence.

use crate::io::sequence::{of_frame, path_of_frame};
use std::path::{Path, PathBuf};

/// An input or output, by its name.
pub(crate) enum Named<'a> {
    /// A layer of IN or a file, of each frame.
    Layer(&'a mut String),
    /// A file of each frame.
    Input(&'a mut PathBuf),
    /// A file for all frames.
    Shared(&'a Path),
    /// A file that is written of each frame.
    Output(&'a mut PathBuf),
}

impl Named<'_> {
    /// Replaces the placeholder of a frame's number.
    pub(crate) fn number(self, frame: i32) {
        match self {
            Self::Layer(name) => {
                if let Some(own) = of_frame(name, frame) {
                    *name = own;
                }
            }
            Self::Input(path) | Self::Output(path) => {
                if let Some(own) = path_of_frame(path, frame) {
                    *path = own;
                }
            }
            Self::Shared(_) => {}
        }
    }

    /// The file that is read, if it is one.
    pub(crate) fn file(self) -> Option<PathBuf> {
        match self {
            Self::Layer(name) => Some(PathBuf::from(&*name)).filter(|path| path.exists()),
            Self::Input(path) => Some(path.clone()),
            Self::Shared(path) => Some(path.into()),
            Self::Output(_) => None,
        }
    }
}

/// Those of layers and files that are given.
pub(crate) fn given<'a, const LAYERS: usize, const FILES: usize>(
    layers: [&'a mut Option<String>; LAYERS],
    files: [&'a mut Option<PathBuf>; FILES],
) -> Vec<Named<'a>> {
    let layers = layers.into_iter().flatten().map(Named::Layer);
    let files = files.into_iter().flatten().map(Named::Input);
    layers.chain(files).collect()
}
