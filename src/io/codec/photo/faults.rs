//! What is refused, in one line.

use crate::error::Error;
use crate::io::text::one_line;
use image::ImageError;
use std::path::Path;

/// Most bytes for the samples of a picture, and as many again for its decoder.
pub(super) const MAX_BYTES: u64 = 1 << 30;

pub(in crate::io) fn unsupported(path: &Path, found: &str) -> Error {
    Error::Unsupported {
        path: path.to_path_buf(),
        found: found.into(),
        remedy: "save it as PNG or OpenEXR".into(),
    }
}

pub(super) fn image_error(path: &Path) -> impl Fn(ImageError) -> Error {
    move |error| match error {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Error::Damaged {
            path: path.to_path_buf(),
            found: "the file ends too early".into(),
        },
        ImageError::IoError(source) => Error::io(path, "read")(source),
        ImageError::Decoding(e) => damaged(path, &e),
        ImageError::Limits(_) => unsupported(path, "is too large"),
        other => unsupported(
            path,
            &format!("cannot be read ({})", one_line(&other.to_string())),
        ),
    }
}

pub(super) fn damaged(path: &Path, found: &dyn std::fmt::Display) -> Error {
    Error::Damaged {
        path: path.to_path_buf(),
        found: format!("is damaged ({})", one_line(&found.to_string())),
    }
}
