//! The threads of the module: never rayon's own, which a forked process does not have.

use crate::process::PerProcess;
use pyo3::PyResult;
use pyo3::exceptions::PyRuntimeError;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Bytes of a thread's stack: as many as a main thread usually has.
const STACK_BYTES: usize = 8 << 20;

/// The threads of calls that name no engine with its own.
static POOL: PerProcess<ThreadPool> = PerProcess::new();

/// The module's own threads, as many as the machine grants this process.
pub(crate) fn own_pool() -> PyResult<&'static ThreadPool> {
    POOL.get(|| pool_of(0))
}

/// A pool of this many threads; 0 is as many as the machine grants.
pub(crate) fn pool_of(threads: usize) -> PyResult<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads);
    let pool = builder.stack_size(STACK_BYTES).build();
    pool.map_err(|error| PyRuntimeError::new_err(format!("threads cannot be started: {error}")))
}
