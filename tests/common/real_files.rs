//! Real inputs that are no part of this project: tests that want them go without where they are absent.

use std::io::Write;
use std::path::{Path, PathBuf};

/// A file or folder of the collection; `None`, said aloud, where it is absent.
pub fn real(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    // Not by `eprintln!`: of a test that passes, the runner shows nothing that was printed.
    let _ = writeln!(std::io::stderr(), "skipped: {} is not here", path.display());
    None
}
