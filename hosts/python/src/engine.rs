//! The engine: threads, devices, and memory that is used again.

use crate::errors::raised;
use crate::frame::{Frame, Settings};
use crate::made::Made;
use crate::watched::watched;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use relievo::cli::recipe::Recipe;
use relievo::engine;
use relievo::host::{Work, chosen_for_all};
use std::path::{Path, PathBuf};

/// Runs commands, on the CPU or a GPU, and keeps their memory for the next run.
#[pyclass(frozen, module = "pyrelievo")]
pub(crate) struct Engine {
    engine: engine::Engine,
    pool: Option<ThreadPool>,
}

#[pymethods]
impl Engine {
    #[new]
    #[pyo3(signature = (*, threads = None, backend = "auto"))]
    fn new(threads: Option<u16>, backend: &str) -> PyResult<Self> {
        let engine = match backend {
            "auto" => engine::Engine::auto(),
            "cpu" => engine::Engine::cpu(),
            "gpu" => engine::Engine::gpu().map_err(raised)?,
            other => {
                let said = format!("backend is {other:?}; give auto, cpu or gpu");
                return Err(PyValueError::new_err(said));
            }
        };
        let pool = threads.map(|count| {
            if count == 0 {
                return Err(PyValueError::new_err("threads is 0; give 1 or more"));
            }
            let pool = ThreadPoolBuilder::new().num_threads(count.into()).build();
            pool.map_err(|error| PyValueError::new_err(error.to_string()))
        });
        Ok(Self {
            engine,
            pool: pool.transpose()?,
        })
    }

    /// What a command makes of a frame with these settings: planes, or a picture shown in 8 bits too, or lines.
    #[pyo3(signature = (command, settings, frame, form = "planes", progress = None))]
    fn run(
        &self,
        py: Python<'_>,
        command: &str,
        settings: Settings,
        frame: &Bound<'_, Frame>,
        form: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Made> {
        let frame = frame.get();
        self.make(py, frame, form, progress, || frame.work(command, &settings))
    }

    /// What a recipe makes of a frame, with settings that overrule it. The recipe is a file, a preset, or, if `text` is
    /// given, that, called by the path in errors.
    #[pyo3(signature = (path, text, settings, frame, form = "planes", progress = None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "they are those of the Python function"
    )]
    fn run_recipe(
        &self,
        py: Python<'_>,
        path: PathBuf,
        text: Option<String>,
        settings: Settings,
        frame: &Bound<'_, Frame>,
        form: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Made> {
        let frame = frame.get();
        self.make(py, frame, form, progress, || {
            let recipe = recipe_of(&path, text.as_deref())?;
            let settings: Vec<_> = frame.roles().iter().chain(&settings).cloned().collect();
            Work::of_recipe(&recipe, &settings, frame.file())
        })
    }

    /// The settings of a command with everything that it chooses by itself, chosen once for the frames of a sequence.
    #[pyo3(signature = (command, settings, pattern, frames, progress = None))]
    fn choose(
        &self,
        py: Python<'_>,
        command: &str,
        settings: Settings,
        pattern: PathBuf,
        frames: Vec<i32>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Settings> {
        watched(py, progress, |run| {
            let engine = &self.engine;
            self.install(|| chosen_for_all(engine, command, &settings, &pattern, &frames, run))
        })
    }
}

impl Engine {
    fn make(
        &self,
        py: Python<'_>,
        frame: &Frame,
        form: &str,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl Fn() -> relievo::Result<Work> + Send + Sync,
    ) -> PyResult<Made> {
        watched(py, progress, |run| {
            self.install(|| {
                let work = work()?;
                let work = match form {
                    "lines" => work.in_lines()?,
                    _ => work,
                };
                let scene = frame.scene(&work)?;
                let mut made = work.run(&self.engine, &scene, run)?;
                let shown = match form {
                    "shown" => work.shown(&scene, &mut made),
                    _ => None,
                };
                Ok(Made {
                    recipe: work.recipe(Some(&made)),
                    shown,
                    made,
                })
            })
        })
    }

    fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

/// A recipe from its text, or else from a file or a preset.
pub(crate) fn recipe_of(path: &Path, text: Option<&str>) -> relievo::Result<Recipe> {
    match text {
        Some(text) => Recipe::parse(path, text),
        None => Recipe::read(path),
    }
}
