//! Target of a result: the file behind a path, and whether it may be replaced.

use crate::untrusted::shown;
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
pub(super) struct OutputTarget {
    pub(super) path: PathBuf,
    /// Permissions of the file that is replaced.
    pub(super) permissions: Option<Permissions>,
}

/// Links that are followed before a circle is assumed.
const MOST_LINKS: usize = 40;

impl OutputTarget {
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
                    format!("there is no directory {}", shown(directory)),
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
pub(super) fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let data = fs::symlink_metadata(&path);
        let Some(link) = data.ok().filter(fs::Metadata::is_symlink) else {
            return Ok(path);
        };
        if !may_follow(&link, directory_of(&path))? {
            return Err(io::Error::new(
                io::ErrorKind::PermissionDenied,
                "it is a link of another user in a folder that all may write to; remove it, or write elsewhere",
            ));
        }
        path = directory_of(&path).join(fs::read_link(&path)?);
    }
    Err(io::Error::other("its links lead in a circle"))
}

/// Whether the `link` in `directory` is followed. In a sticky folder that all may write to, such as /tmp, it has to belong
/// to the user or the folder's owner. That is Linux's rule too (`protected_symlinks`), for links that it reads itself.
#[cfg(unix)]
fn may_follow(link: &fs::Metadata, directory: &Path) -> io::Result<bool> {
    use rustix::fs::Mode;
    use std::os::unix::fs::MetadataExt;
    let folder = fs::metadata(directory)?;
    let is_shared = Mode::from_raw_mode(folder.mode()).contains(Mode::SVTX | Mode::WOTH);
    let owners = [rustix::process::geteuid().as_raw(), folder.uid()];
    Ok(!is_shared || owners.contains(&link.uid()))
}

#[cfg(not(unix))]
fn may_follow(_: &fs::Metadata, _: &Path) -> io::Result<bool> {
    Ok(true)
}

/// The directory that the file `path` is in.
pub(crate) fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, lchown, symlink};

    /// In a sticky folder that all may write to, a link is followed where it is the user's own or that of the folder's
    /// owner. Only the superuser can make links of others.
    #[test]
    fn links_of_others_in_shared_folders_are_not_followed() {
        const OTHER: u32 = 12_345;
        const THIRD: u32 = 12_346;
        let desk = tempfile::tempdir().unwrap();
        let victim = desk.path().join("victim");
        fs::write(&victim, "").unwrap();
        let folder = desk.path().join("shared");
        fs::create_dir(&folder).unwrap();
        let link = folder.join("link");
        let place = |mode: u32, owners: [Option<u32>; 2]| {
            let _ = fs::remove_file(&link);
            symlink(&victim, &link)?;
            lchown(&link, owners[0], None)?;
            lchown(&folder, owners[1], None)?;
            fs::set_permissions(&folder, fs::Permissions::from_mode(mode))
        };
        place(0o1777, [None, None]).unwrap();
        assert_eq!(followed(&link).unwrap(), victim);
        if place(0o1777, [Some(OTHER), None]).is_err() {
            println!("SKIPPED: only the superuser makes links of other users");
            return;
        }
        let refused = followed(&link).unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::PermissionDenied);
        assert!(OutputTarget::of(&link, Replace::Always).is_err());
        for (mode, link_owner, folder_owner, is_followed) in [
            (0o1777, OTHER, THIRD, false),
            (0o1777, OTHER, OTHER, true),
            (0o1777, 0, OTHER, true),
            // Not sticky, and not for all to write to.
            (0o777, OTHER, THIRD, true),
            (0o1755, OTHER, THIRD, true),
        ] {
            place(mode, [Some(link_owner), Some(folder_owner)]).unwrap();
            let case = format!("{mode:o} {link_owner} {folder_owner}");
            assert_eq!(followed(&link).is_ok(), is_followed, "{case}");
        }
        // One more link in front of it changes nothing.
        place(0o1777, [Some(OTHER), Some(THIRD)]).unwrap();
        let first = desk.path().join("first");
        symlink(&link, &first).unwrap();
        assert!(followed(&first).is_err());
    }
}
