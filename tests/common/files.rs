//! Pictures read as the program reads them.

use super::exr::Part;
use relievo::Result;
use relievo::io::inputs::Inputs;
use relievo::io::{self, Loaded, Needs};
use std::path::PathBuf;

/// Loads a picture, with `change` made to what is given and to what is needed.
pub fn try_load(
    picture: impl Into<PathBuf>,
    change: impl FnOnce(&mut Inputs, &mut Needs),
) -> Result<Loaded> {
    let mut inputs = Inputs {
        picture: picture.into(),
        ..Inputs::default()
    };
    let mut needs = Needs::default();
    change(&mut inputs, &mut needs);
    io::load(&inputs, needs)
}

/// The same, of what can be loaded.
#[track_caller]
pub fn load(picture: impl Into<PathBuf>, change: impl FnOnce(&mut Inputs, &mut Needs)) -> Loaded {
    try_load(picture, change).unwrap()
}

/// Loads a file of this part.
pub fn try_read(part: Part, change: impl FnOnce(&mut Inputs, &mut Needs)) -> Result<Loaded> {
    let desk = tempfile::tempdir().unwrap();
    let picture = desk.path().join("in.exr");
    part.write(&picture);
    try_load(picture, change)
}

/// The same, of what can be loaded.
#[track_caller]
pub fn read(part: Part, change: impl FnOnce(&mut Inputs, &mut Needs)) -> Loaded {
    try_read(part, change).unwrap()
}
