//! Interrupts that stop long work between two steps.

use crate::CliError;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that is set by the first interrupt. The second ends the process at once: files are renamed into place, so none is
/// ever half written.
pub fn watch() -> Result<Arc<AtomicBool>, CliError> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::Internal(format!("cannot watch for interrupts: {error}")))?;
    Ok(cancelled)
}
