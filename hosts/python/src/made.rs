//! What a command has made, as arrays.

use crate::arrays::{array_of, stacked};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

/// The name of a layer, its scale, and how many planes it has.
type Named = (String, Option<f32>, usize);

/// What a command has made of a frame.
#[pyclass(frozen, module = "pyrelievo")]
pub(crate) struct Made {
    pub(crate) made: relievo::host::Made,
    pub(crate) recipe: String,
    /// The picture as a file of 8 bits would hold it, if it was asked for.
    pub(crate) shown: Option<([usize; 2], Vec<[u8; 4]>)>,
}

#[pymethods]
impl Made {
    /// The picture, scene-linear, written to `out` if it is given; None for layers alone.
    #[pyo3(signature = (out = None))]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        out: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let color = self.made.picture();
        let array = color.map(|c| array_of(py, &[&c.r, &c.g, &c.b], out));
        array.transpose()
    }

    /// The picture as a PNG holds it, rows by columns by 4, if it was asked for.
    fn shown<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let array = self.shown.as_ref().map(|([width, height], pixels)| {
            let array = PyArray1::from_slice(py, pixels.as_flattened());
            Ok(array.reshape([*height, *width, 4])?.into_any())
        });
        array.transpose()
    }

    /// The layers: for each its name, its scale if it is of a further one, and how many planes it has; and all planes,
    /// in that order, as one array of planes, rows and columns.
    fn layers<'py>(&self, py: Python<'py>) -> PyResult<(Vec<Named>, Bound<'py, PyAny>)> {
        let layers = self.made.layers();
        let planes: Vec<_> = layers
            .iter()
            .flat_map(|layer| layer.planes.clone())
            .collect();
        let names = layers.into_iter();
        let names = names.map(|layer| (layer.name, layer.sigma_px, layer.planes.len()));
        Ok((names.collect(), stacked(py, &planes)?))
    }

    /// The names of the maps among the layers.
    #[getter]
    fn map_names(&self) -> Vec<String> {
        self.made.map_names().map(String::from).collect()
    }

    /// A drawing as the text of an SVG, if lines were asked for.
    #[getter]
    fn svg(&self) -> Option<&str> {
        self.made.svg.as_deref()
    }

    /// Warnings about settings.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.made.warnings.clone()
    }

    /// What was chosen by itself, by the names of settings.
    #[getter]
    fn choices(&self) -> Vec<(String, String)> {
        self.made.choices()
    }

    /// The settings and choices as a recipe.
    #[getter]
    fn recipe(&self) -> &str {
        &self.recipe
    }
}
