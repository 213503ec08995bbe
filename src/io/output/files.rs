//! The files that a run reads and writes.

use super::target::{directory_of, followed};
use crate::error::{Result, bad};
use crate::untrusted::shown;
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

/// Identity of a file, independent of names and links, whether it exists or not.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct FileId {
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
    fn of(path: &Path) -> Option<Self> {
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
    /// [`crate::Error::BadParameter`] if it is an input, lies in a folder that is one, or is already an output.
    pub(crate) fn writes(&mut self, name: &'static str, path: &Path) -> Result<()> {
        // Unreachable paths fail later, on writing.
        let Some(id) = FileId::of(path) else {
            return Ok(());
        };
        let refused = |found: String| {
            let found = format!("{} {found}", shown(path));
            Err(bad(name, found, "write to another file"))
        };
        if let Some(input) = self.read.get(&id) {
            return refused(format!("is the input {}", shown(input)));
        }
        let directory = followed(path).ok();
        let directory = directory.and_then(|path| FileId::of(directory_of(&path)));
        if let Some(folder) = directory.and_then(|directory| self.folders.get(&directory)) {
            let folder = shown(folder);
            return refused(format!("lies in {folder}, all of which is read"));
        }
        if let Some((other, theirs)) = self.written.insert(id, (name, path.into())) {
            return refused(match other == name {
                true => format!("is {} too, of another frame", shown(&theirs)),
                false => format!("is the output of {other} too"),
            });
        }
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn files_are_compared_whatever_they_are_called() {
        use std::os::unix::fs::symlink;
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("in"), "x").unwrap();
        fs::hard_link(at("in"), at("hard")).unwrap();
        symlink("in", at("soft")).unwrap();
        symlink("none", at("dangling")).unwrap();
        fs::create_dir(at("style")).unwrap();
        symlink("style", at("styles")).unwrap();
        let refusal = |outputs: &[&str]| {
            let mut files = Files::default();
            files.reads(&at("in"));
            files.reads_all_in(&at("style"));
            let mut written = outputs.iter().map(|output| files.writes("-o", &at(output)));
            written
                .find_map(std::result::Result::err)
                .map(|e| e.to_string())
        };
        for same in ["in", "./in", "style/../in", "hard", "soft"] {
            assert!(refusal(&[same]).unwrap().contains("is the input"), "{same}");
        }
        for inside in ["style/1.png", "styles/1.png"] {
            assert!(refusal(&[inside]).unwrap().contains("lies in"), "{inside}");
        }
        // Outputs that do not exist are distinguished by their directory and name.
        for twice in [["out", "./out"], ["none", "dangling"]] {
            assert!(refusal(&twice).unwrap().contains("too"), "{twice:?}");
        }
        assert_eq!(refusal(&["out", "other", "style2"]), None);
    }
}
