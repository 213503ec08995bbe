//! Errors as Python's, with the sentence that the command line would print.

use pyo3::exceptions::{
    PyKeyboardInterrupt, PyNotImplementedError, PyOSError, PyRuntimeError, PyValueError,
};
use pyo3::{PyErr, PyResult};
use relievo::Error;
use relievo::host::without_fault;

/// The exception for an error: what the caller can mend in the arguments is a ValueError, a file that cannot be read or
/// written an OSError.
pub(crate) fn raised(error: Error) -> PyErr {
    let said = error.to_string().replace('\n', " ");
    match error {
        Error::Io { source, .. } => match source.raw_os_error() {
            // Python chooses the class, FileNotFoundError and others, by the number.
            Some(number) => PyOSError::new_err((number, said)),
            None => PyOSError::new_err(said),
        },
        Error::Damaged { .. } => PyOSError::new_err(said),
        Error::Unsupported { .. } => PyNotImplementedError::new_err(said),
        Error::Cancelled => PyKeyboardInterrupt::new_err(said),
        Error::NoGpu { .. } | Error::Gpu { .. } | Error::Fault { .. } | Error::NotFinite { .. } => {
            PyRuntimeError::new_err(said)
        }
        _ => PyValueError::new_err(said),
    }
}

/// The result of `work`; its errors, and panics too, are exceptions.
pub(crate) fn caught<T>(work: impl FnOnce() -> relievo::Result<T>) -> PyResult<T> {
    match without_fault(work) {
        Ok(made) => made.map_err(raised),
        Err(fault) => Err(PyRuntimeError::new_err(fault)),
    }
}
