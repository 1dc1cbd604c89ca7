//! Threads that work at arrays.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// Those of a process: a forked one has none of its parent's.
static THREADS: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// All threads of the machine, or as many as RAYON_NUM_THREADS says. To be called with the interpreter's lock, so that no other
/// thread forks meanwhile.
///
/// # Errors
/// RuntimeError where the system gives no threads.
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
    // The parent's are not told to end: nobody would hear.
    std::mem::forget(known.replace((process, threads.clone())));
    Ok(threads)
}
