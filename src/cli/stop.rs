//! Signals: the current frame is finished or dropped, never half written.

use super::exit::STOPPED;
use crate::io::output::drop_unfinished;
use std::sync::atomic::{AtomicI32, Ordering};

/// The signal that requested a stop; 0 before.
static ASKED: AtomicI32 = AtomicI32::new(0);

/// Whether the first signal abandons the frames in progress.
#[cfg(unix)]
static DROPS: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);

/// Effect of the first signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum First {
    /// Lets the frames in hand be finished.
    Finish,
    /// Drops them.
    Drop,
}

/// Exit code of a run that was asked to stop; `None` if it was not.
pub(super) fn asked() -> Option<i32> {
    match ASKED.load(Ordering::Relaxed) {
        0 => None,
        signal => Some(STOPPED + signal),
    }
}

/// Handles SIGINT and SIGTERM from now on. A second signal always abandons the work in progress. A program that runs
/// several command lines has one signal thread, and the last command line decides the effect of the first signal.
#[cfg(unix)]
pub(super) fn mind_signals(first: First) {
    static MINDED: std::sync::Once = std::sync::Once::new();
    DROPS.store(first == First::Drop, Ordering::Relaxed);
    MINDED.call_once(|| {
        let (ready, begun) = std::sync::mpsc::channel();
        let waiting = move || wait_for_signals(ready);
        // Without a thread or a handler, a signal still ends the program, leaving at worst a temporary file.
        if std::thread::Builder::new().spawn(waiting).is_ok() {
            // Received once the handlers are installed; an error if they could not be.
            let _ = begun.recv();
        }
    });
}

#[cfg(unix)]
fn wait_for_signals(ready: std::sync::mpsc::Sender<()>) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
        return;
    };
    let _ = ready.send(());
    for signal in signals.forever() {
        let again = ASKED.swap(signal, Ordering::Relaxed) != 0;
        if again || DROPS.load(Ordering::Relaxed) {
            drop_unfinished();
            std::process::exit(STOPPED + signal);
        }
        super::message::say("stopping after the frames in hand; once more drops them");
    }
}

/// Makes a write beyond the system's size limit fail instead of ending the program.
#[cfg(unix)]
pub(super) fn outlive_full_files() {
    static OUTLIVED: std::sync::Once = std::sync::Once::new();
    OUTLIVED.call_once(|| {
        let noticed = std::sync::Arc::default();
        // Otherwise the signal ends the program, leaving at worst a temporary file.
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, noticed);
    });
}

/// There is no such signal here.
#[cfg(not(unix))]
pub(super) fn outlive_full_files() {}

/// There are no such signals here: the system ends the program.
#[cfg(not(unix))]
pub(super) fn mind_signals(_first: First) {
    let _ = drop_unfinished;
}
