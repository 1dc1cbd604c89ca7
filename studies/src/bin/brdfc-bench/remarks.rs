//! Progress of a study on stderr.

use brdfc_terminal::Common;
use brdfc_terminal::output::remark;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Minimum time between messages.
const BETWEEN: Duration = Duration::from_secs(5);

/// Counts the steps of a study, and prints their share with the time left.
pub(super) struct Remarks {
    common: Common,
    steps: usize,
    started: Instant,
    /// Steps so far, and the time of the last message.
    state: Mutex<(usize, Instant)>,
}

impl Remarks {
    pub(super) fn new(common: Common, steps: usize) -> Self {
        let started = Instant::now();
        Self { common, steps, started, state: Mutex::new((0, started)) }
    }

    /// Completes steps.
    pub(super) fn done(&self, steps: usize) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.0 += steps;
        if state.1.elapsed() >= BETWEEN {
            let (elapsed, share) = (self.started.elapsed().as_secs_f64(), state.0 as f64 / self.steps as f64);
            let left = elapsed / share * (1.0 - share);
            remark(self.common, &format!("{:.0} %, {elapsed:.0} s, about {left:.0} s left", 100.0 * share));
            state.1 = Instant::now();
        }
    }
}
