//! Output files: whole or not at all, and never in place of an input.

use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Writes the file `path` through `write`, so that it holds all of the result or is left as it was.
///
/// The data go to a temporary file in the same directory, which takes the name at the end. A link is
/// followed, as an ordinary write would. With `clobber` false a file that exists is never replaced,
/// not even one that appears meanwhile.
pub fn write_atomically(
    path: &Path,
    clobber: bool,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
) -> Result<()> {
    let failed = |source| Error::io(path, "write")(source);
    let target = check_target(path, clobber).map_err(failed)?;
    let (file, temporary) = temporary_beside(&target).map_err(failed)?.into_parts();
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush().map_err(failed)?;
    buffered.get_ref().sync_all().map_err(failed)?;
    drop(buffered); // some systems rename no open file
    persist(temporary, &target, clobber).map_err(failed)
}

/// Refuses a `path` that [`write_atomically`] could not write to, before any work is done for it.
///
/// # Errors
/// [`Error::Io`] if its directory is missing, if it is a directory or another thing that is not a
/// file, or if it exists and `clobber` is false.
pub fn check_writable(path: &Path, clobber: bool) -> Result<()> {
    check_target(path, clobber)
        .map(|_| ())
        .map_err(Error::io(path, "write"))
}

/// Refuses an `output`, given as the flag `name`, that is one of the `inputs`, by whatever name or
/// link.
pub fn refuse_overwriting_input<'a>(
    name: &'static str,
    output: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<()> {
    match inputs.into_iter().find(|input| same_file(output, input)) {
        None => Ok(()),
        Some(input) => Err(Error::BadParameter {
            name,
            found: format!("{} is the input {}", output.display(), input.display()),
            remedy: "write to another file".into(),
        }),
    }
}

/// The file to be replaced: `path`, or where it links to.
fn check_target(path: &Path, clobber: bool) -> io::Result<PathBuf> {
    let existing = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        other => Some(other?),
    };
    match existing {
        Some(data) if data.is_dir() => Err(io::ErrorKind::IsADirectory.into()),
        Some(data) if !data.is_file() => Err(io::Error::other("it is not a regular file")),
        Some(_) if !clobber => Err(exists_already()),
        Some(_) => fs::canonicalize(path),
        None if !directory_of(path).is_dir() => Err(io::Error::new(
            io::ErrorKind::NotFound,
            format!("there is no directory {}", directory_of(path).display()),
        )),
        None => Ok(path.to_path_buf()),
    }
}

fn exists_already() -> io::Error {
    io::Error::new(
        io::ErrorKind::AlreadyExists,
        "the file exists already and is not to be replaced",
    )
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A new file beside `target` with the rights any new file would get.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".relievo-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The system takes away what the user's mask forbids.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(directory_of(target))
}

fn persist(temporary: TempPath, target: &Path, clobber: bool) -> io::Result<()> {
    if clobber {
        temporary.persist(target).map_err(|e| e.error)?;
    } else {
        temporary
            .persist_noclobber(target)
            .map_err(|e| match e.error.kind() {
                io::ErrorKind::AlreadyExists => exists_already(),
                _ => e.error,
            })?;
    }
    // The new name lasts once the directory is on disk; not every file system can promise that.
    if let Ok(directory) = File::open(directory_of(target)) {
        let _ = directory.sync_all();
    }
    Ok(())
}

#[cfg(unix)]
fn same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write_text(path: &Path, clobber: bool, text: &str) -> Result<()> {
        write_atomically(path, clobber, |w| {
            w.write_all(text.as_bytes())
                .map_err(Error::io(path, "write"))
        })
    }

    fn entries(directory: &Path) -> usize {
        fs::read_dir(directory).unwrap().count()
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        write_text(&path, true, "old").unwrap();
        let result = write_atomically(&path, true, |w| {
            w.write_all(b"half of it").unwrap();
            Err(exists_already()).map_err(Error::io(&path, "write"))
        });
        assert!(result.is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(entries(directory.path()), 1);
    }

    #[test]
    fn without_clobber_no_file_is_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        write_text(&path, false, "first").unwrap();
        let refused = write_text(&path, false, "second").unwrap_err().to_string();
        assert!(refused.contains("exists already"), "{refused}");
        // One that appears while the result is made.
        let late = directory.path().join("late.exr");
        let result = write_atomically(&late, false, |_| {
            fs::write(&late, "theirs").map_err(Error::io(&late, "write"))
        });
        assert!(result.unwrap_err().to_string().contains("exists already"));
        assert_eq!(fs::read_to_string(&late).unwrap(), "theirs");
        assert_eq!(entries(directory.path()), 2);
    }

    #[test]
    fn a_missing_directory_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("none").join("a.exr");
        let message = write_text(&path, true, "x").unwrap_err().to_string();
        assert!(message.contains("there is no directory"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn the_file_has_the_rights_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let (ours, ordinary) = (directory.path().join("a"), directory.path().join("b"));
        write_text(&ours, true, "x").unwrap();
        fs::write(&ordinary, "x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&ordinary));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_recognised() {
        let directory = tempfile::tempdir().unwrap();
        let (file, link) = (directory.path().join("a"), directory.path().join("b"));
        write_text(&file, true, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let hard = directory.path().join("c");
        fs::hard_link(&file, &hard).unwrap();
        assert!(refuse_overwriting_input("-o", &link, [file.as_path()]).is_err());
        assert!(refuse_overwriting_input("-o", &hard, [file.as_path()]).is_err());
        let other = directory.path().join("d");
        assert!(refuse_overwriting_input("-o", &other, [file.as_path()]).is_ok());
        write_text(&link, true, "new").unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
