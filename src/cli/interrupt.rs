//! Interrupts: stop long work between two steps, or end the process if the next step is far.

use crate::Error;
use crate::output::tell;
use brdfc::ErrorKind;
use brdfc::scene::abandon;
use brdfc_terminal::INTERRUPTED;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time that a step gets to finish; people wait at most half a second.
const PATIENCE: Duration = Duration::from_millis(250);

static AT_WORK: AtomicBool = AtomicBool::new(true);
static ASKED: AtomicBool = AtomicBool::new(false);

/// Sets whether an interrupt breaks off work (initially true). If there is no work, an interrupt ends the program normally,
/// with exit code 0.
pub fn at_work(at_work: bool) {
    AT_WORK.store(at_work, Ordering::Relaxed);
}

/// Returns true if an interrupt arrived.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// Makes interrupts set the returned flag, and soon after end the process. No file is left incomplete: the finished files
/// are moved into place together.
pub fn watch() -> Result<&'static AtomicBool, Error> {
    ctrlc::set_handler(|| {
        ASKED.store(true, Ordering::Relaxed);
        if !AT_WORK.load(Ordering::Relaxed) {
            std::process::exit(0);
        }
        std::thread::sleep(PATIENCE);
        let _guard = abandon();
        tell(&format!("brdfc: {INTERRUPTED}"));
        std::process::exit(i32::from(ErrorKind::Cancelled.exit_code()));
    })
    .map_err(|error| Error::internal(format!("cannot watch for interrupts: {error}")))?;
    Ok(&ASKED)
}
