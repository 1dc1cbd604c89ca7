//! Progress on stderr: a bar with the remaining time on a terminal, plain lines elsewhere.

use super::Common;
use super::interrupt;
use super::output::tell;
use brdfc::{Cancelled, Plan, Progress, Stage};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Name of the file at a path, for progress lines.
pub fn label(path: &Path) -> String {
    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// Stages in order, with their approximate share of a pack's time for a scattered scan, in per cent.
const SHARES: [(Stage, u64); 14] = [
    (Stage::Read, 2),
    (Stage::Resample, 70),
    (Stage::LogEncode, 1),
    (Stage::Haar, 1),
    (Stage::Threshold, 10),
    (Stage::Quantise, 2),
    (Stage::MeasureOnGrid, 5),
    (Stage::MeasureOffGrid, 5),
    (Stage::Pack, 1),
    (Stage::Prefilter, 5),
    (Stage::Lobes, 40),
    (Stage::BandwidthMap, 5),
    (Stage::ImportanceSamples, 40),
    (Stage::Write, 1),
];
/// Stages that only environment lighting needs.
const MAP_STAGES: [Stage; 4] = [Stage::Prefilter, Stage::Lobes, Stage::BandwidthMap, Stage::ImportanceSamples];

/// Progress over several materials; the environment counts as one.
pub(super) struct Materials<'a> {
    /// Set when the result is no longer needed. An interrupt has the same effect.
    cancelled: Option<&'a AtomicBool>,
    bar: ProgressBar,
    lines: bool,
    shares: Vec<(Stage, u64)>,
    /// Length of the bar for one material.
    whole: u64,
    total: usize,
    finished: AtomicUsize,
    position: AtomicU64,
    /// Start of the first material, after any wait for another build.
    started: OnceLock<Instant>,
    quiet: bool,
}

impl<'a> Materials<'a> {
    /// Progress of all materials of a plan.
    pub(super) fn of(plan: &Plan, common: Common) -> Self {
        let maps = plan.environment.is_some();
        Self::new(plan.jobs.len() + plan.assets.len() + usize::from(maps), maps, common)
    }

    /// Stops when `cancelled` is set, and prints no plain lines.
    pub(super) fn without_lines_until(self, cancelled: &'a AtomicBool) -> Self {
        Self { cancelled: Some(cancelled), lines: false, ..self }
    }

    /// Progress of `total` materials, with or without maps.
    pub(super) fn new(total: usize, maps: bool, common: Common) -> Self {
        let shares: Vec<_> = SHARES.into_iter().filter(|(stage, _)| maps || !MAP_STAGES.contains(stage)).collect();
        let whole = shares.iter().map(|(_, share)| share).sum();
        let terminal = std::io::stderr().is_terminal();
        let bar = bar(whole * total as u64, "{bar:30} {percent:>3} %  {eta} left  {msg}", terminal && !common.quiet);
        Self {
            cancelled: None,
            bar,
            lines: !terminal && !common.quiet,
            shares,
            whole,
            total,
            finished: AtomicUsize::new(0),
            position: AtomicU64::new(0),
            started: OnceLock::new(),
            quiet: common.quiet,
        }
    }
}

/// Makes a bar on stderr, which disappears when dropped; hidden unless `visible`.
pub(super) fn bar(length: u64, template: &str, visible: bool) -> ProgressBar {
    if !visible {
        return ProgressBar::hidden();
    }
    let bar =
        ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr()).with_finish(ProgressFinish::AndClear);
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

impl Progress for Materials<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        let is_over = self.cancelled.is_some_and(|flag| flag.load(Ordering::Relaxed)) || interrupt::is_asked();
        if is_over { Err(Cancelled) } else { Ok(()) }
    }

    fn part<'a>(&'a self, name: &'a str) -> Box<dyn Progress + 'a> {
        self.started.get_or_init(Instant::now);
        Box::new(Material { all: self, name })
    }

    fn waits(&self, for_what: &str) {
        if !self.quiet {
            self.bar.suspend(|| tell(&format!("note: waiting for {for_what}")));
        }
    }
}

/// Progress of one material.
struct Material<'a> {
    all: &'a Materials<'a>,
    name: &'a str,
}

impl Progress for Material<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        self.all.check()
    }

    fn stage(&self, stage: Stage, _: usize) -> Result<(), Cancelled> {
        let all = self.all;
        all.bar.set_message(format!("{}: {}", self.name, stage.name()));
        // The previous stage is complete.
        let before = all.shares.iter().position(|(known, _)| *known == stage).and_then(|at| at.checked_sub(1));
        let share = before.map_or(0, |at| all.shares[at].1);
        all.bar.set_position(share + all.position.fetch_add(share, Ordering::Relaxed));
        self.check()
    }

    fn part<'a>(&'a self, name: &'a str) -> Box<dyn Progress + 'a> {
        self.all.part(name)
    }

    fn finished(&self, succeeded: bool) {
        let all = self.all;
        let done = 1 + all.finished.fetch_add(1, Ordering::Relaxed);
        all.position.fetch_max(all.whole * done as u64, Ordering::Relaxed);
        all.bar.set_position(all.position.load(Ordering::Relaxed));
        if all.lines {
            let elapsed = all.started.get_or_init(Instant::now).elapsed().as_secs_f64();
            let left = elapsed / done as f64 * (all.total - done) as f64;
            let what = if succeeded { "done" } else { "failed" };
            let times = format!("{elapsed:.1} s, about {left:.0} s left");
            tell(&format!("{done} of {}: {} {what} ({times})", all.total, self.name));
        }
    }
}
