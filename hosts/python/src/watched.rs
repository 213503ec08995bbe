//! Work on a thread of its own, so that the interpreter can interrupt it and hear how far it has come.

use crate::errors::raised;
use pyo3::prelude::*;
use relievo::engine::{CancelToken, Progress, Run};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// The interpreter is asked this often whether it was interrupted.
const ASKED_EVERY: Duration = Duration::from_millis(50);

enum Said<T> {
    Progress(Progress),
    Done(T),
}

/// Calls `work` without the interpreter's lock; `progress` is called with the name of each stage and the share done. An
/// interrupt, or an exception of `progress`, cancels the work and is raised.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Run) -> relievo::Result<T> + Send,
) -> PyResult<T> {
    let token = CancelToken::new();
    let progress = progress.map(|tell| tell.clone().unbind());
    py.detach(|| {
        std::thread::scope(|scope| {
            let (tell, hear) = channel();
            let (cancel, tells) = (&token, progress.is_some());
            scope.spawn(move || {
                let report = |at| {
                    // Nobody listens after an exception.
                    let _ = tell.send(Said::Progress(at));
                };
                let report = std::sync::Mutex::new(report);
                let locked = |at| {
                    if let Ok(report) = report.lock() {
                        report(at);
                    }
                };
                let run = Run::new().cancel(cancel);
                let run = match tells {
                    true => run.progress(&locked),
                    false => run,
                };
                let made = work(&run);
                drop(run);
                let _ = tell.send(Said::Done(made));
            });
            loop {
                let interrupted = match hear.recv_timeout(ASKED_EVERY) {
                    Ok(Said::Done(made)) => return made.map_err(raised),
                    Ok(Said::Progress(at)) => Python::attach(|py| {
                        let Some(tell) = &progress else { return Ok(()) };
                        tell.call1(py, (at.stage, at.done)).map(|_| ())
                    }),
                    Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                    Err(RecvTimeoutError::Disconnected) => {
                        let fault =
                            "a fault of relievo itself: its thread has ended; please report it";
                        return Err(pyo3::exceptions::PyRuntimeError::new_err(fault));
                    }
                };
                if let Err(raised) = interrupted {
                    token.cancel();
                    return Err(raised);
                }
            }
        })
    })
}
