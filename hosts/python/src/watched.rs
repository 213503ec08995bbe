//! Work on other threads, so that the interpreter can interrupt it and hear how far it has come.

use crate::errors::caught;
use crate::threads::own_pool;
use pyo3::prelude::*;
use rayon::ThreadPool;
use relievo::engine::{CancelToken, Progress, Run};
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// The interpreter is asked this often whether it was interrupted.
const ASKED_EVERY: Duration = Duration::from_millis(50);

/// Calls `work` on the module's threads without the interpreter's lock. An interrupt is raised when it has ended.
pub(crate) fn detached<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> relievo::Result<T> + Send,
) -> PyResult<T> {
    watched(py, own_pool()?, None, |_| work())
}

/// Calls `work` on the threads of `pool` without the interpreter's lock; `progress` is called with the name of each stage
/// and the share done. An interrupt, or an exception of `progress`, cancels the work and is raised.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Run) -> relievo::Result<T> + Send,
) -> PyResult<T> {
    let token = CancelToken::new();
    let progress = progress.map(|tell| tell.clone().unbind());
    let tells = progress.is_some();
    py.detach(|| {
        let (tell, hear) = channel();
        let (end, ended) = channel();
        let cancel = &token;
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                let tell = Mutex::new(tell);
                let report = |at: Progress| {
                    if let Ok(tell) = tell.lock() {
                        // Nobody listens after an exception.
                        let _ = tell.send(at);
                    }
                };
                let run = Run::new().cancel(cancel);
                let run = match tells {
                    true => run.progress(&report),
                    false => run,
                };
                let _ = end.send(caught(|| work(&run)));
            });
            // Progress ends with the work.
            loop {
                let asked = match hear.recv_timeout(ASKED_EVERY) {
                    Ok(Progress { stage, done }) => Python::attach(|py| match &progress {
                        Some(tell) => tell.call1(py, (stage, done)).map(|_| ()),
                        None => Ok(()),
                    }),
                    Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                };
                if let Err(raised) = asked {
                    token.cancel();
                    return Err(raised);
                }
            }
        })?;
        ended.recv().expect("work that ends says so")
    })
}
