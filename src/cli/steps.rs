//! Progress of one long job on stderr: a bar with the remaining time on a terminal, plain lines elsewhere.

use super::Common;
use super::output::tell;
use super::progress::bar;
use brdfc::{Cancelled, Progress, Stage};
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Minimum time between plain lines.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Steps of consecutive stages.
pub(super) struct Steps<'a> {
    bar: ProgressBar,
    lines: bool,
    cancelled: &'a AtomicBool,
    running: Mutex<Running>,
}

struct Running {
    stage: &'static str,
    steps: usize,
    done: usize,
    started: Instant,
    reported: Instant,
}

impl<'a> Steps<'a> {
    pub(super) fn new(common: Common, cancelled: &'a AtomicBool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = bar(1, "{msg:14} {bar:30} {percent:>3} %  {eta} left", terminal && !common.quiet);
        let now = Instant::now();
        let running = Mutex::new(Running { stage: "", steps: 1, done: 0, started: now, reported: now });
        Self { bar, lines: !terminal && !common.quiet, cancelled, running }
    }
}

impl Progress for Steps<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }

    fn stage(&self, stage: Stage, steps: usize) -> Result<(), Cancelled> {
        let (now, name) = (Instant::now(), stage.name());
        if let Ok(mut running) = self.running.lock() {
            *running = Running { stage: name, steps, done: 0, started: now, reported: now };
        }
        self.bar.set_message(name);
        self.bar.reset();
        self.bar.set_length(steps as u64);
        self.check()
    }

    fn step(&self) -> Result<(), Cancelled> {
        self.bar.inc(1);
        if let Ok(mut running) = self.running.lock() {
            running.done += 1;
            if self.lines && running.reported.elapsed() >= BETWEEN_LINES && running.done < running.steps {
                let elapsed = running.started.elapsed().as_secs_f64();
                let left = elapsed / running.done as f64 * (running.steps - running.done) as f64;
                tell(&format!(
                    "{}: {} of {} ({elapsed:.0} s, about {left:.0} s left)",
                    running.stage, running.done, running.steps
                ));
                running.reported = Instant::now();
            }
        }
        self.check()
    }

    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(())
    }
}
