//! Exit codes.

/// Everything that was asked for is done.
pub(super) const DONE: i32 = 0;
/// It failed.
pub(super) const FAILED: i32 = 1;
/// The command line or a recipe is wrong.
pub(super) const MISUSED: i32 = 2;
/// Some of several pictures or frames failed.
pub(super) const SOME_FAILED: i32 = 3;
/// Stopped by a signal, to be added to its number.
pub(super) const STOPPED: i32 = 128;
