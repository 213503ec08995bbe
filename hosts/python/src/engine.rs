//! The engine: threads, devices, and memory that is used again.

use crate::errors::raised;
use crate::frame::{Frame, Settings};
use crate::made::Made;
use crate::process::PerProcess;
use crate::threads::{own_pool, pool_of};
use crate::watched::watched;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use relievo::cli::recipe::Recipe;
use relievo::engine;
use relievo::host::{MOST_THREADS, Work, chosen_for_all};
use std::path::{Path, PathBuf};

/// Runs commands, on the CPU or a GPU, and keeps their memory for the next run.
#[pyclass(frozen, module = "pyrelievo")]
pub(crate) struct Engine {
    make_backend: Make,
    threads: Option<usize>,
    engine: PerProcess<engine::Engine>,
    pool: PerProcess<ThreadPool>,
}

type Make = fn() -> relievo::Result<engine::Engine>;

fn backend_named(name: &str) -> PyResult<Make> {
    match name {
        "auto" => Ok(|| Ok(engine::Engine::auto())),
        "cpu" => Ok(|| Ok(engine::Engine::cpu())),
        "gpu" => Ok(engine::Engine::gpu),
        other => {
            let said = format!("backend is {other:?}; give auto, cpu or gpu");
            Err(PyValueError::new_err(said))
        }
    }
}

#[pymethods]
impl Engine {
    #[new]
    #[pyo3(signature = (*, threads = None, backend = "auto"))]
    fn new(threads: Option<u16>, backend: &str) -> PyResult<Self> {
        if let Some(count) = threads.filter(|count| !(1..=MOST_THREADS).contains(count)) {
            let said = format!("threads is {count}; give 1 to {MOST_THREADS}");
            return Err(PyValueError::new_err(said));
        }
        let engine = Self {
            make_backend: backend_named(backend)?,
            threads: threads.map(usize::from),
            engine: PerProcess::new(),
            pool: PerProcess::new(),
        };
        // A GPU that is missing, or threads, are told of now.
        engine.own()?;
        Ok(engine)
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
        let (engine, pool) = self.own()?;
        watched(py, pool, progress, |run| {
            chosen_for_all(engine, command, &settings, &pattern, &frames, run)
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
        let (engine, pool) = self.own()?;
        watched(py, pool, progress, |run| {
            let work = work()?;
            let work = match form {
                "lines" => work.in_lines()?,
                _ => work,
            };
            let scene = frame.scene(&work)?;
            let mut made = work.run(engine, &scene, run)?;
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
    }

    /// The engine of this process, and its threads.
    fn own(&self) -> PyResult<(&engine::Engine, &ThreadPool)> {
        let engine = self.engine.get(|| (self.make_backend)().map_err(raised))?;
        let pool = match self.threads {
            Some(threads) => self.pool.get(|| pool_of(threads))?,
            None => own_pool()?,
        };
        Ok((engine, pool))
    }
}

/// A recipe from its text, or else from a file or a preset.
pub(crate) fn recipe_of(path: &Path, text: Option<&str>) -> relievo::Result<Recipe> {
    match text {
        Some(text) => Recipe::parse(path, text),
        None => Recipe::read(path),
    }
}
