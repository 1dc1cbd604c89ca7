//! Interrupts that stop long work between two steps, and end the process where the next step is far.

use crate::Error;
use crate::output::tell;
use brdfc::ErrorKind;
use brdfc::scene::abandon;
use brdfc_terminal::INTERRUPTED;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time for a step to end by itself; people wait half a second at most.
const PATIENCE: Duration = Duration::from_millis(250);

static AT_WORK: AtomicBool = AtomicBool::new(true);
static ASKED: AtomicBool = AtomicBool::new(false);

/// Whether there is work that an interrupt breaks off, as there is at first. Where there is none it ends the program as it was
/// meant to end, with exit code 0.
pub fn at_work(at_work: bool) {
    AT_WORK.store(at_work, Ordering::Relaxed);
}

/// Whether an interrupt came.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}

/// From now on an interrupt sets the flag that this returns, and soon after ends the process. Nothing is half written: finished
/// files are put in place all together.
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
