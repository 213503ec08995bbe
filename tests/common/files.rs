//! Pictures read as the program reads them.

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
