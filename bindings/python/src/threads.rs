//! Thread pool for work on arrays.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// Pool of the process with this id: a forked process has none of its parent's threads.
static THREADS: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Returns the thread pool: one thread per core, or RAYON_NUM_THREADS. Must be called with the interpreter's lock, so that no other
/// thread forks meanwhile.
///
/// # Errors
/// Returns RuntimeError if the system cannot start threads.
pub fn threads(_: Python<'_>) -> PyResult<Arc<ThreadPool>> {
    let mut known = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    if let Some((of, threads)) = known.as_ref()
        && *of == process
    {
        return Ok(threads.clone());
    }
    let threads = ThreadPoolBuilder::new().build().map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let threads = Arc::new(threads);
    // Do not drop the parent's pool: its threads do not exist here.
    std::mem::forget(known.replace((process, threads.clone())));
    Ok(threads)
}
