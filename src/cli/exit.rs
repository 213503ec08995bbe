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

/// All codes and what they mean, as the reference lists them.
pub(super) const TABLE: [(i32, &str); 6] = [
    (DONE, "done"),
    (FAILED, "failed"),
    (MISUSED, "wrong usage: the command line or a recipe"),
    (
        SOME_FAILED,
        "some frames of a sequence, or some of several pictures, failed",
    ),
    (STOPPED + 2, "stopped by SIGINT"),
    (STOPPED + 15, "stopped by SIGTERM"),
];
