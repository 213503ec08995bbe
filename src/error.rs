//! The error type, split by what a caller can do about each case.

use crate::untrusted::shown;
use std::fmt::{Display, LowerExp};
use std::path::{Path, PathBuf};

/// The result of every fallible function of the crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error. Each message is one line: the file, what was found, what to do next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A required layer is neither in the file nor named.
    #[error("{}: {found}; {remedy}", shown(path))]
    MissingAov {
        /// The file searched.
        path: PathBuf,
        /// The missing layer, and what the file holds instead.
        found: String,
        /// The flag that would name it.
        remedy: String,
    },
    /// Two inputs that must have the same pixels do not.
    #[error("{}: is {found}, but {expected}; give inputs of one size", shown(path))]
    SizeMismatch {
        /// The file that does not fit.
        path: PathBuf,
        /// Window of that file.
        found: String,
        /// The input it has to match, and its window.
        expected: String,
    },
    /// A parameter lies outside its range, or two contradict each other.
    #[error("{name} {found}; {remedy}")]
    BadParameter {
        /// Its name on the command line.
        name: &'static str,
        /// The value given.
        found: String,
        /// The values accepted.
        remedy: String,
    },
    /// Arguments of a command, given from a program, that are not understood.
    #[error("{found}")]
    Arguments {
        /// What is wrong with them, and what to give.
        found: String,
    },
    /// The file is of a kind, or uses a feature, that cannot be read or written.
    #[error("{}: {found}; {remedy}", shown(path))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The unsupported feature.
        found: String,
        /// How to make a file that is supported.
        remedy: String,
    },
    /// The file contradicts itself or ends too early.
    #[error("{}: {found}; write or copy the file again", shown(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The contradiction.
        found: String,
    },
    /// The data leave a required property ambiguous.
    #[error("{}: {found}; {remedy}", shown(path))]
    Undetermined {
        /// The file.
        path: PathBuf,
        /// The ambiguity, with the evidence.
        found: String,
        /// The flag that settles it.
        remedy: String,
    },
    /// This build has no viewer, or no window can be opened.
    #[error("view: {found}; {remedy}")]
    Window {
        /// The missing component.
        found: String,
        /// How to get it.
        remedy: String,
    },
    /// A recipe cannot be used as it stands.
    #[error("{}: {found}; {remedy}", shown(path))]
    Recipe {
        /// The recipe.
        path: PathBuf,
        /// The setting, or what is wrong with the file.
        found: String,
        /// The setting or value to write instead.
        remedy: String,
    },
    /// No suitable device for the GPU backend.
    #[error("no GPU: {found}; {remedy}")]
    NoGpu {
        /// The devices looked for.
        found: String,
        /// What to install or use instead.
        remedy: &'static str,
    },
    /// A device failed: out of memory, lost, or a refused operation.
    #[error("{device}: {found}; use --backend cpu")]
    Gpu {
        /// Name of the device.
        device: String,
        /// The failure reported.
        found: String,
    },
    /// A plan is run on inputs other than those it was made for.
    #[error("{found}; {remedy}")]
    Unfit {
        /// Inputs the plan expects, and those given.
        found: String,
        /// The input to give.
        remedy: &'static str,
    },
    /// The run was cancelled by its token.
    #[error("the run was cancelled")]
    Cancelled,
    /// A bug in this program: it panicked.
    #[error(
        "{}: a fault of relievo itself ({found}); please report it, with this file",
        shown(path)
    )]
    Fault {
        /// The file being processed.
        path: PathBuf,
        /// The panic's message and location.
        found: String,
    },
    /// A result is not finite where all inputs are.
    #[error(
        "{}: {found} is not finite, from inputs that are; give numbers that are less extreme",
        shown(path)
    )]
    NotFinite {
        /// The picture being processed.
        path: PathBuf,
        /// The first result that is not, and where.
        found: String,
    },
    /// The system refused a file operation.
    #[error("{}: cannot {action}: {source}", shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The attempted operation, as a verb: "read", "write".
        action: &'static str,
        /// Why the system refused.
        source: std::io::Error,
    },
}

/// [`Error::BadParameter`].
pub(crate) fn bad(
    name: &'static str,
    found: impl Into<String>,
    remedy: impl Into<String>,
) -> Error {
    Error::BadParameter {
        name,
        found: found.into(),
        remedy: remedy.into(),
    }
}

impl Error {
    /// Attaches the file and the action to a system error: `map_err(Error::io(path, "read"))`.
    pub(crate) fn io(path: &Path, action: &'static str) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.to_path_buf();
        move |source| Error::Io {
            path,
            action,
            source,
        }
    }
}

/// A number for messages, with an exponent where it is tiny or huge.
pub(crate) fn short<T: Copy + Display + LowerExp + Into<f64>>(number: T) -> String {
    let size = number.into().abs();
    match size == 0.0 || (1e-3..1e6).contains(&size) {
        true => number.to_string(),
        false => format!("{number:e}"),
    }
}
