//! Target of a result: the file behind a path, and whether it may be replaced.

use crate::error::{Error, Result};
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs::{self, Permissions};
use std::io;
use std::path::{Path, PathBuf};

/// Policy for files that already exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Replace {
    /// Kept; the run fails.
    Never,
    /// Replaced unless write-protected.
    IfWritable,
    /// Replaced.
    Always,
}

/// Target of a result.
pub(super) struct Target {
    pub(super) path: PathBuf,
    /// Permissions of the file that is replaced.
    pub(super) permissions: Option<Permissions>,
}

/// Links that are followed before a circle is assumed.
const MOST_LINKS: usize = 40;

impl Target {
    /// The file to write for `path`: itself, or the target of its links, existing or not.
    pub(super) fn of(path: &Path, replace: Replace) -> io::Result<Self> {
        let path = followed(path)?;
        let existing = match fs::metadata(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            other => Some(other?),
        };
        let Some(data) = existing else {
            let directory = directory_of(&path);
            return match directory.is_dir() {
                true => Ok(Self {
                    path,
                    permissions: None,
                }),
                false => Err(io::Error::new(
                    io::ErrorKind::NotFound,
                    format!("there is no directory {}", directory.display()),
                )),
            };
        };
        if data.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        if !data.is_file() {
            return Err(io::Error::other("it is not a regular file"));
        }
        match replace {
            Replace::Never => Err(exists_already()),
            Replace::IfWritable if !is_writable(&path, &data) => Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "it is write-protected; --force replaces it",
            )),
            _ => Ok(Self {
                path,
                permissions: Some(data.permissions()),
            }),
        }
    }
}

pub(super) fn exists_already() -> io::Error {
    io::Error::new(
        io::ErrorKind::AlreadyExists,
        "the file exists already and is not to be replaced",
    )
}

/// Checks the permission bits as well, since the superuser may write even to write-protected files.
#[cfg(unix)]
fn is_writable(path: &Path, data: &fs::Metadata) -> bool {
    use rustix::fs::{Access, access};
    !data.permissions().readonly() && access(path, Access::WRITE_OK).is_ok()
}

#[cfg(not(unix))]
fn is_writable(_: &Path, data: &fs::Metadata) -> bool {
    !data.permissions().readonly()
}

/// `path` with the links at its end followed, up to the first name that is not a link.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let is_link = fs::symlink_metadata(&path).is_ok_and(|data| data.is_symlink());
        if !is_link {
            return Ok(path);
        }
        path = directory_of(&path).join(fs::read_link(&path)?);
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// The directory that the file `path` is in.
pub(crate) fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Identity of a file, independent of names and links, whether it exists or not.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct FileId {
    /// The file, or its directory if it does not exist.
    place: Place,
    name: Option<OsString>,
}

#[cfg(unix)]
type Place = (u64, u64);
#[cfg(not(unix))]
type Place = PathBuf;

impl FileId {
    /// The file reached by reading or writing `path`; `None` if it cannot be reached.
    pub(super) fn of(path: &Path) -> Option<Self> {
        if let Some(place) = place_of(path) {
            return Some(Self { place, name: None });
        }
        let path = followed(path).ok()?;
        Some(Self {
            place: place_of(directory_of(&path))?,
            name: Some(path.file_name()?.into()),
        })
    }
}

#[cfg(unix)]
fn place_of(path: &Path) -> Option<Place> {
    use std::os::unix::fs::MetadataExt;
    let data = fs::metadata(path).ok()?;
    Some((data.dev(), data.ino()))
}

#[cfg(not(unix))]
fn place_of(path: &Path) -> Option<Place> {
    fs::canonicalize(path).ok()
}

/// The files that a run reads and writes: no output may be an input or another output.
#[derive(Debug, Default)]
pub(crate) struct Files {
    read: HashMap<FileId, PathBuf>,
    /// Directories with all their files as inputs.
    folders: HashMap<FileId, PathBuf>,
    written: HashMap<FileId, (&'static str, PathBuf)>,
}

impl Files {
    /// Registers an input. One that does not exist cannot be overwritten.
    pub(crate) fn reads(&mut self, path: &Path) {
        if let Some(id) = FileId::of(path) {
            self.read.insert(id, path.into());
        }
    }

    /// Registers a folder with all its files as inputs.
    pub(crate) fn reads_all_in(&mut self, folder: &Path) {
        if let Some(id) = FileId::of(folder) {
            self.folders.insert(id, folder.into());
        }
    }

    /// Registers an output, given as the flag `name`. All inputs are registered before.
    ///
    /// # Errors
    /// [`Error::BadParameter`] if it is an input, lies in a folder that is one, or is already an output.
    pub(crate) fn writes(&mut self, name: &'static str, path: &Path) -> Result<()> {
        // Unreachable paths fail later, on writing.
        let Some(id) = FileId::of(path) else {
            return Ok(());
        };
        let refused = |found: String| {
            Err(Error::BadParameter {
                name,
                found: format!("{} {found}", path.display()),
                remedy: "write to another file".into(),
            })
        };
        if let Some(input) = self.read.get(&id) {
            return refused(format!("is the input {}", input.display()));
        }
        let directory = followed(path).ok();
        let directory = directory.and_then(|path| FileId::of(directory_of(&path)));
        if let Some(folder) = directory.and_then(|directory| self.folders.get(&directory)) {
            let folder = folder.display();
            return refused(format!("lies in {folder}, all of which is read"));
        }
        if let Some((other, theirs)) = self.written.insert(id, (name, path.into())) {
            return refused(match other == name {
                true => format!("is {} too, of another frame", theirs.display()),
                false => format!("is the output of {other} too"),
            });
        }
        Ok(())
    }
}
