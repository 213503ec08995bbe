//! The Python module of relievo. What it offers to Python programs stands in `python/pyrelievo`; here are the types that
//! need Rust: frames of arrays or files, the engine, and what it has made.

mod arrays;
mod engine;
mod errors;
mod frame;
mod made;
mod process;
mod threads;
mod watched;

use crate::errors::caught;
use crate::watched::detached;
use numpy::PyReadonlyArray3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use relievo::host::{SettingKind, Work, frames_of, settings_of, thumbnail};
use std::ffi::OsString;
use std::path::PathBuf;

/// The settings of a command, each as a dict, in the order of its help.
#[pyfunction]
fn settings<'py>(py: Python<'py>, command: &str) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let of_setting = |setting: relievo::host::Setting| {
        let row = PyDict::new(py);
        row.set_item("name", setting.name)?;
        row.set_item("group", setting.family)?;
        row.set_item("help", setting.help)?;
        row.set_item("common", setting.is_common)?;
        row.set_item("unit", setting.unit)?;
        row.set_item("default", setting.default)?;
        let kind = match setting.kind {
            SettingKind::Switch => "switch",
            SettingKind::Choice(words) => {
                row.set_item("words", words)?;
                "choice"
            }
            SettingKind::Number {
                range,
                is_whole,
                word,
            } => {
                row.set_item("range", (range.from, range.to))?;
                row.set_item("logarithmic", range.logarithmic)?;
                row.set_item("whole", is_whole)?;
                row.set_item("words", word.into_iter().collect::<Vec<_>>())?;
                "number"
            }
            SettingKind::Text {
                form,
                is_repeatable,
            } => {
                row.set_item("form", form)?;
                row.set_item("repeatable", is_repeatable)?;
                "text"
            }
        };
        row.set_item("kind", kind)?;
        Ok(row)
    };
    let all = caught(|| Ok(settings_of(command)))?;
    all.into_iter().map(of_setting).collect()
}

/// The frames of a sequence that are on disk, by a name with #### or %04d; None for a single file.
#[pyfunction]
fn frames_on_disk(py: Python<'_>, pattern: PathBuf) -> PyResult<Option<Vec<i32>>> {
    detached(py, || Ok(frames_of(&pattern)))
}

/// Runs a command line, with the program's name first; returns its exit code.
#[pyfunction]
fn run_command_line(py: Python<'_>, words: Vec<OsString>) -> PyResult<i32> {
    process::handle_signals();
    let pool = threads::own_pool()?;
    // It hears signals by itself.
    py.detach(|| caught(|| Ok(pool.install(|| relievo::cli::run_words(words)))))
}

#[pymodule(gil_used = false)]
mod _relievo {
    #[pymodule_export]
    use super::engine::Engine;
    #[pymodule_export]
    use super::frame::Frame;
    #[pymodule_export]
    use super::made::Made;
    #[pymodule_export]
    use super::process::forked;
    #[pymodule_export]
    use super::{
        commands, frames_on_disk, png, read_recipe, recipe, recipe_settings, run_command_line,
        settings,
    };
}

/// The commands that make something of a frame.
#[pyfunction]
fn commands() -> Vec<&'static str> {
    relievo::host::COMMANDS.to_vec()
}

/// A command with its settings, as a recipe.
#[pyfunction]
fn recipe(py: Python<'_>, command: &str, settings: frame::Settings) -> PyResult<String> {
    detached(py, || Ok(Work::new(command, &settings, None)?.recipe(None)))
}

/// The command of a recipe and its text: of a file or a preset, or of `text`, called by the path in errors.
#[pyfunction]
fn read_recipe(py: Python<'_>, path: PathBuf, text: Option<String>) -> PyResult<(String, String)> {
    detached(py, || {
        let recipe = engine::recipe_of(&path, text.as_deref())?;
        Ok((recipe.command().into(), recipe.text()))
    })
}

/// The settings of a recipe, by their names on the command line.
#[pyfunction]
fn recipe_settings(py: Python<'_>, path: PathBuf, text: String) -> PyResult<frame::Settings> {
    detached(py, || {
        let recipe = engine::recipe_of(&path, Some(&text))?;
        let work = Work::of_recipe(&recipe, &[], None)?;
        Ok(work.settings().to_vec())
    })
}

/// A small picture of an array of rows, columns and 3 channels, as a PNG: of linear light, or of values as they are.
#[pyfunction]
fn png<'py>(
    py: Python<'py>,
    array: PyReadonlyArray3<'py, f32>,
    is_linear: bool,
) -> PyResult<Bound<'py, PyBytes>> {
    let view = array.as_array();
    let (rows, columns, channels) = view.dim();
    if channels < 3 {
        return Err(PyValueError::new_err("a picture has 3 channels"));
    }
    let pixels = detached(py, || {
        thumbnail([columns, rows], |x, y, c| view[[y, x, c]], is_linear)
    })?;
    Ok(PyBytes::new(py, &pixels))
}
