//! Progress on stderr: a bar with the time left on a terminal, plain lines elsewhere.

use super::Common;
use super::output::tell;
use brdfc_jobs::scene::run::Watcher;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Stages in order, with their rough share of the time of a scattered scan, in per cent of a pack's.
const SHARES: [(&str, u64); 13] = [
    ("read", 2),
    ("resample", 70),
    ("log-encode", 1),
    ("smooth", 2),
    ("haar", 1),
    ("threshold", 10),
    ("quantise", 2),
    ("measure on the grid", 5),
    ("measure off the grid", 5),
    ("pack", 1),
    ("bandwidth map", 5),
    ("importance samples", 40),
    ("write", 1),
];
/// Those that only environment lighting needs.
const OF_MAPS: [&str; 2] = ["bandwidth map", "importance samples"];

/// Progress over a number of materials, the environment counted as one.
pub(super) struct Progress {
    bar: ProgressBar,
    lines: bool,
    shares: Vec<(&'static str, u64)>,
    /// Of one material.
    whole: u64,
    total: usize,
    finished: AtomicUsize,
    position: AtomicU64,
    started: Instant,
}

impl Progress {
    /// Of `total` materials, with maps or without.
    pub(super) fn new(total: usize, maps: bool, common: Common) -> Self {
        let shares: Vec<_> = SHARES.into_iter().filter(|(name, _)| maps || !OF_MAPS.contains(name)).collect();
        let whole = shares.iter().map(|(_, share)| share).sum();
        let terminal = std::io::stderr().is_terminal();
        let bar = if terminal && !common.quiet {
            let bar = ProgressBar::with_draw_target(Some(whole * total as u64), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {eta} left  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        } else {
            ProgressBar::hidden()
        };
        Self {
            bar,
            lines: !terminal && !common.quiet,
            shares,
            whole,
            total,
            finished: AtomicUsize::new(0),
            position: AtomicU64::new(0),
            started: Instant::now(),
        }
    }
}

/// Takes the bar away, after errors too.
impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Watcher for Progress {
    fn stage(&self, name: &str, stage: &'static str) {
        self.bar.set_message(format!("{name}: {stage}"));
        // The stage before this one is done.
        let before = self.shares.iter().position(|(name, _)| *name == stage).and_then(|at| at.checked_sub(1));
        let share = before.map_or(0, |at| self.shares[at].1);
        self.bar.set_position(share + self.position.fetch_add(share, Ordering::Relaxed));
    }

    fn finished(&self, name: &str, worked: bool) {
        let done = 1 + self.finished.fetch_add(1, Ordering::Relaxed);
        self.position.fetch_max(self.whole * done as u64, Ordering::Relaxed);
        self.bar.set_position(self.position.load(Ordering::Relaxed));
        if self.lines {
            let elapsed = self.started.elapsed().as_secs_f64();
            let left = elapsed / done as f64 * (self.total - done) as f64;
            let what = if worked { "done" } else { "failed" };
            let times = format!("{elapsed:.1} s, about {left:.0} s left");
            tell(&format!("{done} of {}: {name} {what} ({times})", self.total));
        }
    }
}
