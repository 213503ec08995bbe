//! Output files: written atomically, and never in place of an input.

#[cfg(feature = "cli")]
mod files;
mod kind;
mod layer_names;
pub(crate) mod layers;
#[cfg(feature = "cli")]
mod leftovers;
pub(crate) mod page;
pub(crate) mod picture;
mod rec709;
mod save;
mod target;
mod temporary;

#[cfg(feature = "cli")]
pub(crate) use files::Files;
pub(crate) use kind::OutputKind;
pub(crate) use layer_names::full_name;
#[cfg(feature = "cli")]
pub(crate) use layer_names::names_of;
#[cfg(feature = "cli")]
pub(crate) use leftovers::{drop_unfinished, remove_leftovers};
pub use target::Replace;
pub(crate) use target::directory_of;

use crate::error::{Error, Result};
use crate::io::exr::{ExrFile, Limits};
use crate::io::open::open_input;
use crate::untrusted::shown;
use std::fs::{self, File};
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;
use target::{OutputTarget, exists_already};
use temporary::Temporary;

/// The software named in written files.
pub(crate) fn software() -> String {
    format!("relievo {}", env!("CARGO_PKG_VERSION"))
}

/// Writes the file `path` through `write`, atomically: it holds the whole result or is unchanged.
///
/// The data go to a temporary file in the same directory, which is finally renamed and gets the permissions of the file
/// it replaces. A link is followed, as by an ordinary write, even to a file that does not exist. With
/// [`Replace::Never`] an existing file is never replaced, not even one that appears meanwhile.
///
/// # Errors
/// That of `write`, and [`Error::Io`] as of [`check_writable`] and of the system.
pub fn write_atomically(
    path: &Path,
    replace: Replace,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<()>,
) -> Result<()> {
    let failed = |source| Error::io(path, "write")(source);
    let target = OutputTarget::of(path, replace).map_err(failed)?;
    let temporary = Temporary::beside(&target.path).map_err(failed)?;
    let file = temporary.writer().map_err(failed)?;
    let written = temporary.synced_meanwhile(move || {
        let mut buffered = BufWriter::new(file);
        write(&mut buffered)?;
        // Dropped with it: some systems rename no open file.
        buffered.flush().map_err(failed)
    });
    written.map_err(failed)??;
    let replaces = replace != Replace::Never;
    let published = temporary.publish(&target.path, replaces, target.permissions);
    published.map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => failed(exists_already()),
        _ => failed(error),
    })
}

/// [`write_atomically`] for a text.
///
/// # Errors
/// As for [`write_atomically`].
#[cfg(any(test, feature = "cli"))]
pub(crate) fn write_text(path: &Path, replace: Replace, text: &str) -> Result<()> {
    write_atomically(path, replace, |w| {
        w.write_all(text.as_bytes())
            .map_err(Error::io(path, "write"))
    })
}

/// Whether the file `path` exists and is complete by its format: an EXR has all its blocks, a PNG, JPEG or SVG its end,
/// others at least one byte.
pub fn is_whole(path: &Path) -> bool {
    let Ok(data) = fs::metadata(path) else {
        return false;
    };
    let ends_with = |end: &[u8]| tail(path, end.len()).is_ok_and(|tail| tail == end);
    data.is_file()
        && data.len() > 0
        && match OutputKind::of(path) {
            Ok(OutputKind::Exr) => {
                ExrFile::open(path, &Limits::default()).is_ok_and(|exr| exr.is_whole())
            }
            Ok(OutputKind::Svg) => ends_with(b"</svg>\n"),
            Ok(OutputKind::Picture(format)) => ends_with(format.last_bytes()),
            _ => true,
        }
}

/// The last `count` bytes of a file.
fn tail(path: &Path, count: usize) -> io::Result<Vec<u8>> {
    let mut file = open_input(path)?;
    file.seek(SeekFrom::End(-(count as i64)))?;
    let mut bytes = vec![0; count];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Refuses a `path` that [`write_atomically`] could not write to, before any work is done for it.
///
/// # Errors
/// [`Error::Io`] if its directory is missing or takes no file, if it is a directory or another thing that is not a file, and if it exists
/// and `replace` keeps it.
pub fn check_writable(path: &Path, replace: Replace) -> Result<()> {
    let target = OutputTarget::of(path, replace).map_err(Error::io(path, "write"))?;
    can_hold(directory_of(&target.path), path)
}

/// Refuses a `folder`, perhaps still to be made, that no file can be written in.
///
/// # Errors
/// [`Error::Io`].
#[cfg(feature = "cli")]
pub(crate) fn check_folder(folder: &Path) -> Result<()> {
    let mut above = folder
        .ancestors()
        .filter(|path| !path.as_os_str().is_empty());
    let existing = above.find(|path| path.exists());
    can_hold(existing.unwrap_or(Path::new(".")), folder)
}

/// Tries to make a file in `directory`, for `path`: only that tells for all file systems and users.
fn can_hold(directory: &Path, path: &Path) -> Result<()> {
    let made = Temporary::beside(&directory.join("file"));
    let made = made.map_err(|error| {
        let (folder, why) = (shown(directory), error.kind());
        io::Error::new(why, format!("no file can be made in {folder} ({why})"))
    });
    made.map(|_| ()).map_err(Error::io(path, "write"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(directory: &Path) -> usize {
        fs::read_dir(directory).unwrap().count()
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr");
        write_text(&path, Replace::IfWritable, "old").unwrap();
        let result = write_atomically(&path, Replace::IfWritable, |w| {
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
        write_text(&path, Replace::Never, "first").unwrap();
        let refused = write_text(&path, Replace::Never, "second")
            .unwrap_err()
            .to_string();
        assert!(refused.contains("exists already"), "{refused}");
        // A file that appears while the result is computed.
        let late = directory.path().join("late.exr");
        let result = write_atomically(&late, Replace::Never, |_| {
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
        let message = write_text(&path, Replace::IfWritable, "x")
            .unwrap_err()
            .to_string();
        assert!(message.contains("there is no directory"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn the_file_has_the_rights_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let (ours, ordinary) = (directory.path().join("a"), directory.path().join("b"));
        write_text(&ours, Replace::IfWritable, "x").unwrap();
        fs::write(&ordinary, "x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&ordinary));
    }

    #[cfg(unix)]
    #[test]
    fn what_is_replaced_keeps_its_permissions_and_stays_if_write_protected() {
        use std::os::unix::fs::PermissionsExt;
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a");
        let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        let set = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        write_text(&path, Replace::IfWritable, "old").unwrap();
        set(0o640);
        write_text(&path, Replace::IfWritable, "new").unwrap();
        assert_eq!((mode(), read(&path)), (0o640, "new".into()));
        set(0o440);
        let refused = write_text(&path, Replace::IfWritable, "x").unwrap_err();
        assert!(refused.to_string().contains("--force"), "{refused}");
        assert_eq!(read(&path), "new");
        write_text(&path, Replace::Always, "forced").unwrap();
        assert_eq!((mode(), read(&path)), (0o440, "forced".into()));
        assert_eq!(entries(directory.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_even_to_files_that_do_not_exist_yet() {
        use std::os::unix::fs::symlink;
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        write_text(&at("file"), Replace::IfWritable, "old").unwrap();
        symlink("file", at("link")).unwrap();
        write_text(&at("link"), Replace::IfWritable, "new").unwrap();
        assert_eq!(read(&at("file")), "new");
        symlink("later", at("dangling")).unwrap();
        write_text(&at("dangling"), Replace::IfWritable, "made").unwrap();
        assert_eq!(read(&at("later")), "made");
        for link in ["link", "dangling"] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink());
        }
        symlink("round", at("round")).unwrap();
        let refused = write_text(&at("round"), Replace::IfWritable, "x").unwrap_err();
        assert!(refused.to_string().contains("circle"), "{refused}");
    }

    fn read(path: &Path) -> String {
        fs::read_to_string(path).unwrap()
    }
}
