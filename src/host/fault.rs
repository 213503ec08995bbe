//! Faults of this crate, as a host reports them.

use crate::cli::panics::{keep_quiet, unless_panicked};
use crate::error::Result;

/// The result of `work`; of a panic, which then prints nothing by itself, a sentence that tells what and where it was.
///
/// # Errors
/// That sentence.
pub fn without_fault<T>(
    work: impl FnOnce() -> Result<T>,
) -> std::result::Result<Result<T>, String> {
    keep_quiet();
    unless_panicked(work)
        .map_err(|found| format!("a fault of relievo itself ({found}); please report it"))
}
