//! Frames: of arrays, or of files that are read as far as a command needs them.

use crate::arrays::{Borrowed, View, array_of};
use crate::watched::detached;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use relievo::frame::Plane;
use relievo::host::{File, Given, LoadedScene, Work};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// A setting by its name in recipes, and its value as typed.
pub(crate) type Settings = Vec<(String, String)>;

/// A surface seen from one viewpoint, and the picture of it.
#[pyclass(frozen, module = "pyrelievo")]
pub(crate) struct Frame {
    kind: Kind,
    /// How its layers are read.
    roles: Settings,
}

enum Kind {
    Arrays(Arc<LoadedScene>),
    File {
        file: File,
        /// What was read of it last.
        held: Mutex<Option<Arc<LoadedScene>>>,
    },
}

#[pymethods]
impl Frame {
    /// A frame of arrays: layers by the names of their arguments.
    #[staticmethod]
    #[pyo3(signature = (arrays, roles, camera = None, pixel_aspect = 1.0, height_scale = None))]
    fn of_arrays(
        py: Python<'_>,
        arrays: &Bound<'_, PyDict>,
        roles: Settings,
        camera: Option<String>,
        pixel_aspect: f32,
        height_scale: Option<f32>,
    ) -> PyResult<Self> {
        let mut borrowed = Vec::new();
        for (name, array) in arrays {
            let name: String = name.extract()?;
            let array = Borrowed::of(&name, &array)?;
            borrowed.push((name, array));
        }
        let views = borrowed
            .iter()
            .map(|(name, array)| (&name[..], array.view()));
        let views: HashMap<_, _> = views.collect();
        // Without any of these there is no surface, and that is said.
        let shown_by = ["normal", "height", "depth", "position"];
        let size = shown_by.into_iter().find_map(|name| views.get(name));
        let size = size.map_or([0, 0], View::size);
        let scene = detached(py, || {
            let samples = |name| views.get(name).map(View::samples);
            let linear = |name| views.get(name).and_then(View::linear);
            let (color, albedo) = (linear("color"), linear("albedo"));
            let given = Given {
                normal: samples("normal"),
                normal_is_unsigned: views.get("normal").is_some_and(View::is_integer),
                color: color.as_ref().map(Into::into).or(samples("color")),
                depth: samples("depth"),
                height: samples("height"),
                height_scale,
                position: samples("position"),
                mask: samples("mask"),
                object: samples("object"),
                coverage: samples("coverage"),
                occlusion: samples("occlusion"),
                importance: samples("importance"),
                albedo: albedo.as_ref().map(Into::into).or(samples("albedo")),
                camera: camera.as_deref(),
                pixel_aspect,
                ..Given::of_size(size)
            };
            given.scene(&Work::new("shape", &roles, None)?)
        });
        Ok(Self {
            kind: Kind::Arrays(Arc::new(scene?)),
            roles,
        })
    }

    /// A file, one frame of a sequence if it has a number, and how its layers are read.
    #[staticmethod]
    #[pyo3(signature = (path, roles, number = None))]
    fn of_file(path: PathBuf, roles: Settings, number: Option<i32>) -> Self {
        Self {
            kind: Kind::File {
                file: File { path, number },
                held: Mutex::default(),
            },
            roles,
        }
    }

    /// A layer as an array: color, normal, depth, mask, alpha, albedo; None where there is none.
    fn layer<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let scene = self.read(py)?;
        let frame = &scene.frame;
        let colors = |color: &Option<relievo::frame::ColorPlanes>| {
            let color = color.as_ref();
            color.map(|c| vec![c.r.clone(), c.g.clone(), c.b.clone()])
        };
        let planes = || match name {
            "normal" => Some(normals(frame).into()),
            "color" => colors(&frame.color),
            "albedo" => colors(&frame.albedo),
            "depth" => frame.depth.clone().map(|plane| vec![plane]),
            "alpha" => frame.alpha.clone().map(|plane| vec![plane]),
            "mask" => {
                let mask = frame.mask.plane();
                Some(vec![mask.map(|covered| f32::from(u8::from(covered)))])
            }
            _ => None,
        };
        let planes = detached(py, || Ok(planes()))?;
        let array = |planes: Vec<_>| array_of(py, &planes.iter().collect::<Vec<_>>(), None);
        planes.map(array).transpose()
    }

    /// Rows and columns.
    #[getter]
    fn shape(&self, py: Python<'_>) -> PyResult<(usize, usize)> {
        let scene = self.read(py)?;
        let mask = &scene.frame.mask;
        Ok((mask.height(), mask.width()))
    }

    /// What was concluded about the inputs: subject, conclusion, evidence, and the flag that would force it.
    #[getter]
    fn findings(&self, py: Python<'_>) -> PyResult<Vec<(String, String, String, String)>> {
        let scene = self.read(py)?;
        let findings = scene.findings.iter().cloned();
        let all = findings.map(|f| (f.subject, f.conclusion, f.evidence, f.flag));
        Ok(all.collect())
    }

    /// Warnings about the inputs.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        Ok(self.read(py)?.warnings.clone())
    }

    /// The camera in words; None if none is known.
    #[getter]
    fn camera(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let scene = self.read(py)?;
        Ok(scene.frame.camera.map(|camera| format!("{camera:?}")))
    }

    /// The file that it is read from; None for arrays.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        match &self.kind {
            Kind::Arrays(_) => None,
            Kind::File { file, .. } => Some(file.path.clone()),
        }
    }
}

impl Frame {
    /// The command with these settings, for this frame.
    pub(crate) fn work(&self, command: &str, settings: &Settings) -> relievo::Result<Work> {
        let roles = self.roles.iter().chain(settings).cloned();
        let settings: Vec<_> = roles.collect();
        Work::new(command, &settings, self.file())
    }

    /// The file that it is read from.
    pub(crate) fn file(&self) -> Option<&File> {
        match &self.kind {
            Kind::Arrays(_) => None,
            Kind::File { file, .. } => Some(file),
        }
    }

    /// How its layers are read.
    pub(crate) fn roles(&self) -> &Settings {
        &self.roles
    }

    /// The scene, read as far as `work` needs it.
    pub(crate) fn scene(&self, work: &Work) -> relievo::Result<Arc<LoadedScene>> {
        match &self.kind {
            Kind::Arrays(scene) => Ok(scene.clone()),
            Kind::File { file, held } => {
                // Nobody waits: the thread that holds it may be of a process that this one was forked off.
                let last = held.try_lock().ok().and_then(|held| held.clone());
                let scene = work.load(file, last)?;
                if let Ok(mut held) = held.try_lock() {
                    *held = Some(scene.clone());
                }
                Ok(scene)
            }
        }
    }

    /// The scene as the command line would describe it: with everything that there is.
    fn read(&self, py: Python<'_>) -> PyResult<Arc<LoadedScene>> {
        detached(py, || self.scene(&self.work("relight", &Settings::new())?))
    }
}

/// The normals as they came: of the length that a filter has left them, and 0 where no surface is.
fn normals(frame: &relievo::frame::Frame) -> [Plane; 3] {
    let normal = &frame.normal;
    let (width, height) = (frame.mask.width(), frame.mask.height());
    let length = |x: usize, y: usize| match (&frame.normal_length, frame.mask.at(x, y)) {
        (_, false) => 0.0,
        (Some(lengths), true) => lengths.row(y)[x],
        (None, true) => 1.0,
    };
    [&normal.x, &normal.y, &normal.z].map(|plane| {
        Plane::from_fn(width, height, |x, y| match length(x, y) {
            0.0 => 0.0,
            length => plane.row(y)[x] * length,
        })
    })
}
