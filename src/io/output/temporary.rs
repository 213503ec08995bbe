//! Files being written, and leftovers of killed programs.

use super::target::directory_of;
use std::fs::{self, File, Permissions};
use std::io;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;
use tempfile::TempPath;

/// Suffix of temporary files.
pub(super) const SUFFIX: &str = ".part";

/// Prefix of this machine's temporary files: locks and process numbers mean nothing to others.
pub(super) fn prefix_of_host() -> String {
    let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host: String = host.chars().filter(char::is_ascii_alphanumeric).collect();
    format!(".relievo-{host}-")
}

/// Bytes that are worth bringing to disk before a file is whole, and how often it is looked at whether there are as many.
const WORTH_SYNCING: u64 = 4 << 20;
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// A file being written, locked so that other programs can tell.
pub(super) struct Temporary {
    file: File,
    /// Its name, where the system has no files without one.
    named: Option<Named>,
}

impl Temporary {
    /// A new file to become `target`: nameless if the system supports that, so that a killed program leaves nothing
    /// behind.
    pub(super) fn beside(target: &Path) -> io::Result<Self> {
        let directory = directory_of(target);
        if let Some(file) = anonymous_in(directory) {
            let _ = file.try_lock();
            return Ok(Self { file, named: None });
        }
        let (file, named) = Named::new(directory)?;
        Ok(Self {
            file,
            named: Some(named),
        })
    }

    /// Another handle of the file, to write through.
    pub(super) fn writer(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Writes it by `write`, while what is written is brought to disk: little is left to wait for once it is whole.
    ///
    /// # Errors
    /// Those of the disk: the system tells each of them only once.
    pub(super) fn synced_meanwhile<T>(&self, write: impl FnOnce() -> T) -> io::Result<T> {
        thread::scope(|scope| {
            let (goes_on, is_whole) = mpsc::channel::<()>();
            let sync = move || self.sync_until(&is_whole);
            let Ok(syncing) = thread::Builder::new().spawn_scoped(scope, sync) else {
                // No more threads are allowed: all is brought to disk at the end.
                return Ok(write());
            };
            let written = write();
            drop(goes_on);
            let synced = syncing.join().unwrap_or_else(|panic| resume_unwind(panic));
            synced.map(|()| written)
        })
    }

    /// Brings what is written to disk, some at a time, until the other end of the channel is gone.
    fn sync_until(&self, is_whole: &Receiver<()>) -> io::Result<()> {
        let mut synced = 0;
        while is_whole.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
            let written = self.file.metadata()?.len();
            if written >= synced + WORTH_SYNCING {
                self.file.sync_data()?;
                synced = written;
            }
        }
        Ok(())
    }

    /// Gives the file, which is whole, the name `target` and these permissions, in place of an older file if `replaces`.
    pub(super) fn publish(
        self,
        target: &Path,
        replaces: bool,
        permissions: Option<Permissions>,
    ) -> io::Result<()> {
        if let Some(permissions) = permissions {
            self.file.set_permissions(permissions)?;
        }
        self.file.sync_all()?;
        match self.named {
            Some(named) => named.renamed(target, replaces)?,
            None => publish_anonymous(&self.file, target, replaces)?,
        }
        // The new name lasts once the directory is on disk; not every file system can promise that.
        if let Ok(directory) = File::open(directory_of(target)) {
            let _ = directory.sync_all();
        }
        Ok(())
    }
}

/// A file without a name, if this system has such files and can name them later.
#[cfg(target_os = "linux")]
fn anonymous_in(directory: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = File::from(open(directory, flags, Mode::from_raw_mode(0o666)).ok()?);
    // Its descriptor is the only way to name it.
    link_of(&file).exists().then_some(file)
}

#[cfg(not(target_os = "linux"))]
fn anonymous_in(_: &Path) -> Option<File> {
    None
}

#[cfg(target_os = "linux")]
fn link_of(file: &File) -> PathBuf {
    use std::os::fd::AsRawFd;
    format!("/proc/self/fd/{}", file.as_raw_fd()).into()
}

#[cfg(target_os = "linux")]
fn publish_anonymous(file: &File, target: &Path, replaces: bool) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    let link = |path: &Path| {
        linkat(CWD, link_of(file), CWD, path, AtFlags::SYMLINK_FOLLOW).map_err(io::Error::from)
    };
    match link(target) {
        // A link cannot replace a file: the file gets a second name first, and is renamed over the old one.
        Err(error) if replaces && error.kind() == io::ErrorKind::AlreadyExists => {
            Named::linked(directory_of(target), link)?.renamed(target, true)
        }
        linked => linked,
    }
}

#[cfg(not(target_os = "linux"))]
fn publish_anonymous(_: &File, _: &Path, _: bool) -> io::Result<()> {
    unreachable!("every temporary file has a name here")
}

/// The name of a temporary file; the file is removed with it.
struct Named {
    path: TempPath,
    _unfinished: Unfinished,
}

impl Named {
    /// A new file with the permissions that any new file gets.
    fn new(directory: &Path) -> io::Result<(File, Self)> {
        let prefix = prefix();
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // The system applies the user's umask.
            builder.permissions(Permissions::from_mode(0o666));
        }
        let (file, path) = builder.tempfile_in(directory)?.into_parts();
        let _ = file.try_lock();
        Ok((file, Self::noted(path)))
    }

    /// The name that `link` gives a file.
    #[cfg(target_os = "linux")]
    fn linked(directory: &Path, link: impl FnMut(&Path) -> io::Result<()>) -> io::Result<Self> {
        let prefix = prefix();
        let mut builder = tempfile::Builder::new();
        let linked = builder
            .prefix(&prefix)
            .suffix(SUFFIX)
            .make_in(directory, link)?;
        Ok(Self::noted(linked.into_temp_path()))
    }

    fn noted(path: TempPath) -> Self {
        Self {
            _unfinished: Unfinished::note(&path),
            path,
        }
    }

    fn renamed(self, target: &Path, replaces: bool) -> io::Result<()> {
        let renamed = match replaces {
            true => self.path.persist(target),
            false => self.path.persist_noclobber(target),
        };
        renamed.map_err(|failed| failed.error)
    }
}

/// Prefix of this process's temporary files.
fn prefix() -> String {
    format!("{}{}-", prefix_of_host(), std::process::id())
}

/// Names of temporary files that are being written.
pub(super) static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A note of such a name, for as long as it lasts.
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
