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
use tempfile::NamedTempFile;

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

/// A file being written, locked so that other programs can tell; removed unless it is published.
pub(super) struct Temporary {
    file: NamedTempFile,
    _unfinished: Unfinished,
}

impl Temporary {
    /// A new file to become `target`, with the permissions that any new file gets.
    pub(super) fn beside(target: &Path) -> io::Result<Self> {
        let prefix = format!("{}{}-", prefix_of_host(), std::process::id());
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // The system applies the user's umask.
            builder.permissions(Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(directory_of(target))?;
        let _ = file.as_file().try_lock();
        Ok(Self {
            _unfinished: Unfinished::note(file.path()),
            file,
        })
    }

    /// Another handle of the file, to write through.
    pub(super) fn writer(&self) -> io::Result<File> {
        self.file.as_file().try_clone()
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
        let (file, mut synced) = (self.file.as_file(), 0);
        while is_whole.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
            let written = file.metadata()?.len();
            if written >= synced + WORTH_SYNCING {
                file.sync_data()?;
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
            self.file.as_file().set_permissions(permissions)?;
        }
        self.file.as_file().sync_all()?;
        let renamed = match replaces {
            true => self.file.persist(target),
            false => self.file.persist_noclobber(target),
        };
        renamed.map_err(|failed| failed.error)?;
        // The new name lasts once the directory is on disk; not every file system can promise that.
        if let Ok(directory) = File::open(directory_of(target)) {
            let _ = directory.sync_all();
        }
        Ok(())
    }
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
