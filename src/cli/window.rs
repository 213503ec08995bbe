//! `relievo view`: opens the window, which saves through the command line.

use super::{run_typed, threads};
use crate::command::commands::ViewArgs;
use crate::command::error_line::line_of;
use crate::command::flags::Flag;
use crate::error::Result;
use crate::untrusted::shown;
use crate::view::View;
use crate::view::look::{Look, OneLine, Opening};
use eframe::egui::Context;
use std::path::Path;
use std::sync::Arc;

/// Opens the window.
pub(super) fn view(args: &ViewArgs, typed: &[Flag]) -> Result<i32> {
    threads::use_threads(args.compute.threads);
    let opening = Opening::of(args, typed, save)?;
    crate::view::open(opening).map(|()| 0)
}

/// Saves the result of a look on `input` to `output`, by running the look's command line.
fn save(look: &Look, input: &Path, output: &Path) -> std::result::Result<(), OneLine> {
    let typed = look.invocation(input, output);
    match run_typed(typed.with(&[Flag::switch("quiet")])) {
        Ok(0) => Ok(()),
        Ok(code) => Err(format!("{} was not written ({code})", shown(output))),
        Err(error) => Err(line_of(&error)),
    }
}

impl View {
    /// A viewer that begins with `input`, in new light; pictures are saved by the command line.
    pub fn new(context: &Context, input: Option<&Path>) -> Self {
        let opening = Opening {
            input: input.map(Path::to_path_buf),
            frames: None,
            look: Look::default(),
            engine: Arc::default(),
            save,
        };
        Self::of(opening, context)
    }
}
