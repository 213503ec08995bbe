//! What belongs to one process: threads and devices are dead in the processes that are forked off it.

use pyo3::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// Forks that led to this process.
static FORKS: AtomicU32 = AtomicU32::new(0);

/// Whether the command line has run here: it handles signals from then on.
static HANDLES_SIGNALS: AtomicBool = AtomicBool::new(false);

/// A process: one that has ended may have had the same number, so forks count too.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Process {
    number: u32,
    forks: u32,
}

impl Process {
    fn this() -> Self {
        Self {
            number: std::process::id(),
            forks: FORKS.load(Ordering::Relaxed),
        }
    }
}

/// A value that each process makes for itself. Nobody waits for a lock here: a thread that holds it may not exist in the
/// process that asks.
pub(crate) struct PerProcess<T>(OnceLock<Box<Owned<T>>>);

struct Owned<T> {
    process: Process,
    /// Always there until it is dropped.
    value: Option<T>,
    /// That of a process forked off this one.
    next: PerProcess<T>,
}

impl<T> PerProcess<T> {
    pub(crate) const fn new() -> Self {
        Self(OnceLock::new())
    }

    /// The value of this process, made by `make` unless there is one.
    pub(crate) fn get<E>(&self, make: impl Fn() -> Result<T, E>) -> Result<&T, E> {
        let this = Process::this();
        let mut at = self;
        loop {
            match at.0.get() {
                Some(owned) if owned.process == this => {
                    return Ok(owned.value.as_ref().expect("it is not dropped"));
                }
                Some(owned) => at = &owned.next,
                None => {
                    // Of several threads the first one's is taken.
                    let _ = at.0.set(Box::new(Owned {
                        process: this,
                        value: Some(make()?),
                        next: Self::new(),
                    }));
                }
            }
        }
    }
}

impl<T> Drop for Owned<T> {
    /// Leaves alone what another process owns: its threads cannot be joined here, nor its device be closed.
    fn drop(&mut self) {
        if self.process != Process::this() {
            std::mem::forget(self.value.take());
        }
    }
}

/// Notes that the command line handles signals.
pub(crate) fn handle_signals() {
    HANDLES_SIGNALS.store(true, Ordering::Relaxed);
}

/// Called in every process that Python forks off this one. The thread that hears signals for the command line is not in
/// it: they do again what Python knows of.
#[pyfunction]
pub(crate) fn forked(py: Python<'_>) -> PyResult<()> {
    FORKS.fetch_add(1, Ordering::Relaxed);
    if !HANDLES_SIGNALS.load(Ordering::Relaxed) {
        return Ok(());
    }
    let signal = py.import("signal")?;
    for name in ["SIGINT", "SIGTERM"] {
        let number = signal.getattr(name)?;
        let handler = signal.call_method1("getsignal", (&number,))?;
        if !handler.is_none() {
            signal.call_method1("signal", (number, handler))?;
        }
    }
    Ok(())
}
