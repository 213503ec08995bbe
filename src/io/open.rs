//! Opening inputs: ordinary files alone, and never waiting for one.

use crate::error::{Error, Result};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// Opens `path` for reading.
///
/// # Errors
/// Any error of the system, and a clear one if `path` is a directory, a pipe, a socket or a device: a plain open of a
/// pipe waits until a writer appears, and a device may never end.
pub(crate) fn open_input(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        // Converts the flags to the type of the system call.
        options.custom_flags((OFlags::NONBLOCK | OFlags::NOCTTY).bits().cast_signed());
    }
    let file = options.open(path)?;
    let data = file.metadata()?;
    match data.is_file() {
        true => Ok(file),
        false => Err(io::Error::other(match data.is_dir() {
            true => "it is a directory; name a file",
            false => "it is a pipe or a device; save what it gives as a file first",
        })),
    }
}

/// [`open_input`], read through a buffer.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn open_buffered(path: &Path) -> Result<BufReader<File>> {
    let file = open_input(path).map_err(Error::io(path, "read"))?;
    Ok(BufReader::new(file))
}

/// What is in a folder, by name.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let paths = || -> io::Result<Vec<PathBuf>> {
        let entries = fs::read_dir(folder)?;
        entries.map(|entry| Ok(entry?.path())).collect()
    };
    let mut files = paths().map_err(Error::io(folder, "read"))?;
    files.sort();
    Ok(files)
}

/// The text of the file `path`, of at most `most` bytes.
///
/// # Errors
/// [`Error::Io`], also where the file is larger or is not UTF-8.
pub(crate) fn read_text(path: &Path, most: u64) -> Result<String> {
    let read = || {
        let mut text = String::new();
        open_input(path)?.take(most + 1).read_to_string(&mut text)?;
        match text.len() as u64 > most {
            true => Err(io::Error::other(format!("it is larger than {most} bytes"))),
            false => Ok(text),
        }
    };
    read().map_err(Error::io(path, "read"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_refused_without_waiting() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        rustix::fs::mkfifoat(
            rustix::fs::CWD,
            &pipe,
            rustix::fs::Mode::from_raw_mode(0o600),
        )
        .unwrap();
        let refused = |path: &Path| open_input(path).unwrap_err().to_string();
        assert!(refused(&pipe).contains("pipe"));
        assert!(refused(Path::new("/dev/zero")).contains("device"));
        assert!(refused(directory.path()).contains("directory"));
    }

    #[test]
    fn no_more_text_is_read_than_is_allowed() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "12345").unwrap();
        assert_eq!(read_text(file.path(), 5).unwrap(), "12345");
        let refused = read_text(file.path(), 4).unwrap_err().to_string();
        assert!(refused.contains("larger than 4 bytes"), "{refused}");
    }
}
