//! The kind of file that an output's name tells.

use crate::error::{Error, Result, bad};
#[cfg(feature = "cli")]
use crate::io::picture::ArrayFormat;
use crate::io::picture::PictureFormat;
use crate::untrusted::shown;
use std::path::Path;

/// The kind of file that an output path names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutputKind {
    Exr,
    Picture(PictureFormat),
    /// Lines of a drawing.
    Svg,
    /// Planes as numbers.
    #[cfg(feature = "cli")]
    Numbers(ArrayFormat),
}

impl OutputKind {
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let ends_in = |extension: &str| {
            let own = path.extension();
            own.is_some_and(|own| own.eq_ignore_ascii_case(extension))
        };
        match PictureFormat::of_path(path) {
            _ if ends_in("exr") => Ok(Self::Exr),
            _ if ends_in("svg") => Ok(Self::Svg),
            #[cfg(feature = "cli")]
            _ if ends_in("npy") => Ok(Self::Numbers(ArrayFormat::Npy)),
            Some(format) => Ok(Self::Picture(format)),
            None => Err(Self::unknown(path)),
        }
    }

    /// Error for a name that tells no kind of file, or one that a result does not go to.
    pub(crate) fn unknown(path: &Path) -> Error {
        let pictures = PictureFormat::endings().map(|ending| format!(", .{ending}"));
        let pictures: String = pictures.collect();
        bad(
            "-o",
            format!("{} has no known extension", shown(path)),
            format!("end it in .exr{pictures} or .npy"),
        )
    }
}
