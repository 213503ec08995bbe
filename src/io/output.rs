//! Output files: whole or not at all, and never in place of an input.

use super::exr::{ExrFile, Limits};
use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, SystemTime};
use tempfile::{NamedTempFile, TempPath};

/// How the names of temporary files end.
const SUFFIX: &str = ".part";

/// How they begin: with the name of this machine, for locks of files may not reach others.
fn prefix() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    format!(".relievo-{host}-")
}

/// A temporary file that is younger may be held by its writer any moment.
const JUST_MADE: Duration = Duration::from_secs(2);

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
    let _unfinished = Unfinished::note(&temporary);
    // Held until the file has its name or is gone: so a file that nobody writes any more is known.
    let _ = file.try_lock();
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush().map_err(failed)?;
    buffered.get_ref().sync_all().map_err(failed)?;
    drop(buffered); // some systems rename no open file
    persist(temporary, &target, clobber).map_err(failed)
}

/// Temporary files that are being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A note of a temporary file, for as long as it is written.
struct Unfinished(PathBuf);

impl Unfinished {
    fn note(path: &Path) -> Self {
        if let Ok(mut all) = UNFINISHED.lock() {
            all.push(path.into());
        }
        Self(path.into())
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Ok(mut all) = UNFINISHED.lock() {
            all.retain(|path| *path != self.0);
        }
    }
}

/// Removes what is being written, for a program that is about to end. Nothing can be written after it.
pub fn drop_unfinished() {
    if let Ok(all) = UNFINISHED.lock() {
        for path in all.iter() {
            // What is gone already needs no removing.
            let _ = fs::remove_file(path);
        }
        // Whoever begins another file waits for the lock until the program ends.
        std::mem::forget(all);
    }
}

/// Removes what programs that were killed on this machine have left in `directory`: temporary files that nobody
/// writes.
pub fn remove_leftovers(directory: &Path) {
    let prefix = prefix();
    let Ok(entries) = fs::read_dir(directory) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().and_then(|name| name.to_str());
        let ours = name.is_some_and(|n| n.starts_with(&prefix) && n.ends_with(SUFFIX));
        if ours && is_left(&path) {
            // Another program may have been faster.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether nobody holds the temporary file `path`. One that was just made may not be held yet.
fn is_left(path: &Path) -> bool {
    let Ok(file) = File::open(path) else {
        return false;
    };
    let written = file.metadata().and_then(|data| data.modified()).ok();
    let age = written.and_then(|at| SystemTime::now().duration_since(at).ok());
    age.is_some_and(|age| age > JUST_MADE) && file.try_lock().is_ok()
}

/// Whether the file `path` is there and holds all that its format promises: an EXR all its blocks, a PNG, JPEG or
/// SVG its end, others at least one byte.
pub fn is_whole(path: &Path) -> bool {
    let Ok(data) = fs::metadata(path) else {
        return false;
    };
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let ends_with = |end: &[u8]| tail(path, end.len()).is_ok_and(|tail| tail == end);
    data.is_file()
        && data.len() > 0
        && match extension.to_ascii_lowercase().as_str() {
            "exr" => ExrFile::open(path, &Limits::default()).is_ok_and(|exr| exr.is_whole()),
            "png" => ends_with(b"IEND\xae\x42\x60\x82"),
            "jpg" | "jpeg" => ends_with(&[0xff, 0xd9]),
            "svg" => ends_with(b"</svg>\n"),
            _ => true,
        }
}

/// The last `count` bytes of a file.
fn tail(path: &Path, count: usize) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    file.seek(SeekFrom::End(-(count as i64)))?;
    let mut bytes = vec![0; count];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
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
    let prefix = prefix();
    builder.prefix(&prefix).suffix(SUFFIX);
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
