//! What can go wrong, split by what a caller can do about it.

use std::fmt::{Display, LowerExp};
use std::path::{Path, PathBuf};

/// The result of everything here that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// What went wrong. Each message is one line: the file, what was found, what to do next.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A layer that the work needs is neither in the file nor named.
    #[error("{}: {found}; {remedy}", path.display())]
    MissingAov {
        /// The file looked into.
        path: PathBuf,
        /// What is missing and what the file holds instead.
        found: String,
        /// The flag that would name it.
        remedy: String,
    },
    /// Two inputs that must have the same pixels do not.
    #[error("{}: is {found}, but {expected}; give inputs of one size", path.display())]
    SizeMismatch {
        /// The file that does not fit.
        path: PathBuf,
        /// Its window.
        found: String,
        /// What it had to fit, and its window.
        expected: String,
    },
    /// A parameter lies outside its range, or two contradict each other.
    #[error("{name} {found}; {remedy}")]
    BadParameter {
        /// The parameter, as it is called on the command line.
        name: &'static str,
        /// What was given.
        found: String,
        /// What it may be.
        remedy: String,
    },
    /// The file is of a kind, or uses a feature, that cannot be read or written.
    #[error("{}: {found}; {remedy}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The feature.
        found: String,
        /// How to make a file that can be.
        remedy: String,
    },
    /// The file contradicts itself or ends too early.
    #[error("{}: {found}; write or copy the file again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The contradiction.
        found: String,
    },
    /// The data leave open something that must be known.
    #[error("{}: {found}; {remedy}", path.display())]
    Undetermined {
        /// The file.
        path: PathBuf,
        /// What stays open, with the evidence.
        found: String,
        /// The flag that settles it.
        remedy: String,
    },
    /// This build has no window, or none can be opened.
    #[error("view: {found}; {remedy}")]
    Window {
        /// What is missing.
        found: String,
        /// How to come by it.
        remedy: String,
    },
    /// A recipe cannot be used as it stands.
    #[error("{}: {found}; {remedy}", path.display())]
    Recipe {
        /// The recipe.
        path: PathBuf,
        /// The setting, or what is wrong with the file.
        found: String,
        /// What to write instead.
        remedy: String,
    },
    /// There is no device for the GPU backend, or none that will do.
    #[error("no GPU: {found}; {remedy}")]
    NoGpu {
        /// What was looked for.
        found: String,
        /// What to install, or to use instead.
        remedy: &'static str,
    },
    /// A device failed: out of memory, lost, or refusing what it was asked to do.
    #[error("{device}: {found}; use --backend cpu, or a smaller picture")]
    Gpu {
        /// Its name.
        device: String,
        /// What happened.
        found: String,
    },
    /// A plan is run on other inputs than it was made for.
    #[error("{found}; {remedy}")]
    Unfit {
        /// What the plan takes, and what there is.
        found: String,
        /// What to give.
        remedy: &'static str,
    },
    /// The run was cancelled by its token.
    #[error("the run was cancelled")]
    Cancelled,
    /// This program is at fault: it panicked.
    #[error("{}: a fault of relievo itself ({found}); please report it, with this file", path.display())]
    Fault {
        /// The file that was being worked on.
        path: PathBuf,
        /// What the panic said, and where.
        found: String,
    },
    /// A stage gave samples that are not finite from inputs that are.
    #[error("{}: {stage} gives {found}, from inputs that are; give numbers that are less extreme", path.display())]
    NotFinite {
        /// The picture that was worked on.
        path: PathBuf,
        /// The first stage that did.
        stage: String,
        /// How many samples, and where.
        found: String,
    },
    /// The system refused a file operation.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried, as a verb: "read", "write".
        action: &'static str,
        /// Why the system refused.
        source: std::io::Error,
    },
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

/// A number as messages have it: with an exponent where it is tiny or huge.
pub(crate) fn short<T: Copy + Display + LowerExp + Into<f64>>(number: T) -> String {
    let size = number.into().abs();
    match size == 0.0 || (1e-3..1e6).contains(&size) {
        true => number.to_string(),
        false => format!("{number:e}"),
    }
}
