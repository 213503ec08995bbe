//! Arrays as samples, and planes as arrays.

use crate::watched::detached;
use half::f16;
use ndarray::ArrayView3;
use ndarray::{Axis, Ix3};
use numpy::{
    Element, PyArray1, PyArray3, PyArrayDescr, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods,
    PyReadonlyArrayDyn, PyReadwriteArray3, PyUntypedArray, PyUntypedArrayMethods, dtype,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use rayon::prelude::*;
use relievo::frame::{Plane, Samples};
use relievo::io::srgb::decoded;

/// What holds for an array of any of these types.
macro_rules! of_types {
    ($($kind:ident: $type:ty),*) => {
        /// An array of a caller, rows by columns, or by channels too, kept from being written to from Rust.
        pub(crate) enum Borrowed<'py> {
            $($kind(PyReadonlyArrayDyn<'py, $type>)),*
        }

        /// The same as a view that needs no interpreter.
        pub(crate) enum View<'a> {
            $($kind(ArrayView3<'a, $type>)),*
        }

        impl<'py> Borrowed<'py> {
            /// Borrows `array` where it holds one of the types.
            fn typed(array: &Bound<'py, PyAny>, held: &Bound<'py, PyArrayDescr>) -> PyResult<Option<Self>> {
                $(if held.is_equiv_to(&dtype::<$type>(array.py())) {
                    return Ok(Some(Self::$kind(borrowed(array)?)));
                })*
                Ok(None)
            }

            pub(crate) fn view(&self) -> View<'_> {
                match self {
                    $(Self::$kind(array) => View::$kind(three_axes(array))),*
                }
            }
        }

        impl<'a> View<'a> {
            /// Columns and rows.
            pub(crate) fn size(&self) -> [usize; 2] {
                let (rows, columns, _) = match self {
                    $(Self::$kind(view) => view.dim()),*
                };
                [columns, rows]
            }

            /// As samples of a frame.
            pub(crate) fn samples(&'a self) -> Samples<'a> {
                match self {
                    $(Self::$kind(view) => view.view().into()),*
                }
            }
        }
    };
}

of_types!(F32: f32, F16: f16, U8: u8, U16: u16, Bool: bool);

impl<'py> Borrowed<'py> {
    /// Borrows `array`, called `name` in errors.
    pub(crate) fn of(name: &str, array: &Bound<'py, PyAny>) -> PyResult<Self> {
        let untyped = array.cast::<PyUntypedArray>()?;
        if ![2, 3].contains(&untyped.ndim()) {
            let shape = shape_of(untyped.shape());
            let said = format!(
                "{name} has the shape {shape}; give (rows, columns), or (rows, columns, channels)"
            );
            return Err(PyValueError::new_err(said));
        }
        let held = untyped.dtype();
        Self::typed(array, &held)?.ok_or_else(|| {
            let said = format!(
                "{name} holds {held}; give float32, float16, float64, uint8, uint16 or bool"
            );
            PyTypeError::new_err(said)
        })
    }
}

fn borrowed<'py, T: Element>(array: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let typed = array.cast::<PyArrayDyn<T>>()?;
    let borrowed = typed.try_readonly();
    borrowed.map_err(|error| PyValueError::new_err(error.to_string()))
}

fn three_axes<'a, T: Element>(array: &'a PyReadonlyArrayDyn<'_, T>) -> ArrayView3<'a, T> {
    let view = array.as_array();
    let view = match view.ndim() {
        2 => view.insert_axis(Axis(2)),
        _ => view,
    };
    view.into_dimensionality::<Ix3>()
        .expect("it has three axes")
}

/// A shape as Python writes it.
fn shape_of(shape: &[usize]) -> String {
    let sides: Vec<_> = shape.iter().map(usize::to_string).collect();
    match &sides[..] {
        [one] => format!("({one},)"),
        _ => format!("({})", sides.join(", ")),
    }
}

impl View<'_> {
    /// Whether it holds integers of 0 to the largest one.
    pub(crate) fn is_integer(&self) -> bool {
        matches!(self, Self::U8(_) | Self::U16(_))
    }

    /// Colours of integers, which are sRGB, in linear light; alpha is linear as it is. `None` for colours of floats.
    pub(crate) fn linear(&self) -> Option<ndarray::Array3<f32>> {
        let table = |levels: usize| -> Vec<f32> {
            let level = |i| decoded(i as f64 / (levels - 1) as f64) as f32;
            (0..levels).map(level).collect()
        };
        let of = |shape: (usize, usize, usize), table: &[f32], at: &dyn Fn([usize; 3]) -> usize| {
            let most = (table.len() - 1) as f32;
            ndarray::Array3::from_shape_fn(shape, |(y, x, c)| match at([y, x, c]) {
                level if c == 3 => level as f32 / most,
                level => table[level],
            })
        };
        match self {
            Self::U8(view) => Some(of(view.dim(), &table(256), &|at| view[at].into())),
            Self::U16(view) => Some(of(view.dim(), &table(65536), &|at| view[at].into())),
            _ => None,
        }
    }
}

/// Planes as an array of rows, columns and components, written to `out` if it is given.
pub(crate) fn array_of<'py>(
    py: Python<'py>,
    planes: &[&Plane],
    out: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [planes[0].height(), planes[0].width(), planes.len()];
    let Some(out) = out else {
        let samples = detached(py, || {
            let mut samples = vec![0.0_f32; shape.iter().product()];
            interleave(planes, &mut samples);
            Ok(samples)
        })?;
        let array = PyArray1::from_vec(py, samples).reshape(shape)?;
        return Ok(array.into_any());
    };
    let bad = |what: &str| {
        let [rows, columns, components] = shape;
        let said = format!(
            "out {what}; give a writable float32 array of the shape ({rows}, {columns}, {components})"
        );
        PyValueError::new_err(said)
    };
    let Ok(array) = out.cast::<PyArray3<f32>>() else {
        return Err(bad("is something else"));
    };
    if array.shape() != shape {
        return Err(bad(&format!("has the shape {}", shape_of(array.shape()))));
    }
    let mut written: PyReadwriteArray3<'py, f32> = array
        .try_readwrite()
        .map_err(|_| bad("cannot be written to"))?;
    let mut view = written.as_array_mut();
    detached(py, || {
        match view.as_slice_mut() {
            Some(slice) => interleave(planes, slice),
            None => {
                for (mut component, plane) in view.axis_iter_mut(Axis(2)).zip(planes) {
                    component.assign(&plane.view());
                }
            }
        }
        Ok(())
    })?;
    drop(written);
    Ok(out)
}

/// Planes one after another, as an array of planes, rows and columns.
pub(crate) fn stacked<'py>(py: Python<'py>, planes: &[&Plane]) -> PyResult<Bound<'py, PyAny>> {
    let size = |side: fn(&Plane) -> usize| planes.first().map_or(0, |plane| side(plane));
    let (width, height) = (size(Plane::width), size(Plane::height));
    let samples = detached(py, || {
        let mut samples = vec![0.0_f32; planes.len() * width * height];
        let rows = samples.par_chunks_mut(width.max(1)).enumerate();
        rows.for_each(|(at, row)| row.copy_from_slice(planes[at / height].row(at % height)));
        Ok(samples)
    })?;
    let array = PyArray1::from_vec(py, samples).reshape([planes.len(), height, width])?;
    Ok(array.into_any())
}

fn interleave(planes: &[&Plane], samples: &mut [f32]) {
    let (width, count) = (planes[0].width(), planes.len());
    let rows = samples.par_chunks_mut((width * count).max(1)).enumerate();
    rows.for_each(|(y, row)| {
        for (component, plane) in planes.iter().enumerate() {
            let pixels = row[component..].iter_mut().step_by(count);
            pixels
                .zip(plane.row(y))
                .for_each(|(out, value)| *out = *value);
        }
    });
}
