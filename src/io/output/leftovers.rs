//! Temporary files of programs that end, or were killed.

use super::temporary::{SUFFIX, UNFINISHED, prefix_of_host};
use crate::io::open::open_input;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// A temporary file that is younger may get its lock any moment.
const JUST_MADE: Duration = Duration::from_secs(2);

/// Removes unfinished files, for a program about to end. Nothing can be written after it.
pub(crate) fn drop_unfinished() {
    if let Ok(all) = UNFINISHED.lock() {
        for path in all.iter() {
            // Files already gone need no removal.
            let _ = fs::remove_file(path);
        }
        // Whoever begins another file waits for the lock until the program ends.
        std::mem::forget(all);
    }
}

/// Removes the leftovers of programs killed on this machine from `directory`: temporary files no longer being written.
pub(crate) fn remove_leftovers(directory: &Path) {
    let prefix = prefix_of_host();
    let Ok(entries) = fs::read_dir(directory) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().and_then(|name| name.to_str());
        let rest = name
            .and_then(|name| name.strip_prefix(&prefix))
            .and_then(|rest| rest.strip_suffix(SUFFIX));
        if rest.is_some_and(|rest| is_left(&path, rest)) {
            // Another program may have been faster.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether the temporary file `path`, named `rest` after the machine's prefix, is no longer being written: its process
/// has ended or it is old, and it is not locked.
fn is_left(path: &Path, rest: &str) -> bool {
    let Ok(file) = open_input(path) else {
        return false;
    };
    let written = file.metadata().and_then(|data| data.modified()).ok();
    let age = written.and_then(|at| SystemTime::now().duration_since(at).ok());
    let is_orphan = rest.split('-').next().is_some_and(has_ended);
    (is_orphan || age.is_some_and(|age| age > JUST_MADE)) && file.try_lock().is_ok()
}

/// Whether `process` is the number of an ended process.
#[cfg(unix)]
fn has_ended(process: &str) -> bool {
    use rustix::process::{Pid, test_kill_process};
    let pid = process.parse().ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| test_kill_process(pid) == Err(rustix::io::Errno::SRCH))
}

#[cfg(not(unix))]
fn has_ended(_: &str) -> bool {
    false
}
