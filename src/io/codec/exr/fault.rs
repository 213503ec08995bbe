//! Faults of a file, before its path is attached.

use crate::error::Error;
use crate::io::text::one_line;
use std::io;
use std::path::Path;

/// Something wrong with a file whose path is known further up.
#[derive(Debug)]
pub(super) enum Fault {
    /// The file contradicts itself or ends too early.
    Damaged(String),
    /// The file is sound, but of a kind that cannot be read.
    Unsupported { found: String, remedy: &'static str },
    /// The system refused to read.
    Read(io::Error),
}

pub(super) type Parsed<T> = Result<T, Fault>;

impl Fault {
    pub(super) fn damaged(found: impl Into<String>) -> Fault {
        Fault::Damaged(found.into())
    }

    /// Attaches the path.
    pub(super) fn at(self, path: &Path) -> Error {
        let (own, path) = (path, path.to_path_buf());
        match self {
            Fault::Damaged(found) => Error::Damaged { path, found },
            Fault::Unsupported { found, remedy } => Error::Unsupported {
                path,
                found,
                remedy: remedy.into(),
            },
            Fault::Read(source) => Error::io(own, "read")(source),
        }
    }
}

impl From<io::Error> for Fault {
    fn from(source: io::Error) -> Fault {
        match source.kind() {
            io::ErrorKind::UnexpectedEof => Fault::damaged("the file ends too early"),
            _ => Fault::Read(source),
        }
    }
}

impl From<::exr::error::Error> for Fault {
    fn from(error: ::exr::error::Error) -> Fault {
        use ::exr::error::Error as Exr;
        match error {
            Exr::NotSupported(what) => Fault::Unsupported {
                found: format!("uses a feature that is not supported ({})", one_line(&what)),
                remedy: "rewrite it: oiiotool in.exr --compression zip -o out.exr",
            },
            Exr::Invalid(what) => Fault::damaged(format!("is damaged ({})", one_line(&what))),
            Exr::Io(source) => Fault::from(source),
            Exr::Aborted => Fault::damaged("is damaged (reading stopped)"),
        }
    }
}
