//! Progress of one long job on stderr: a bar with the time left on a terminal, plain lines elsewhere.

use super::Common;
use super::output::tell;
use brdfc_jobs::flatten::FlattenWatcher;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Plain lines come at least this far apart.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Steps of stages, one after the other.
pub(super) struct Steps<'a> {
    bar: ProgressBar,
    lines: bool,
    cancelled: &'a AtomicBool,
    stage: Mutex<Stage>,
}

struct Stage {
    name: &'static str,
    steps: usize,
    done: usize,
    started: Instant,
    told: Instant,
}

impl<'a> Steps<'a> {
    pub(super) fn new(common: Common, cancelled: &'a AtomicBool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let bar = if terminal && !common.quiet {
            let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{msg:14} {bar:30} {percent:>3} %  {eta} left");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        } else {
            ProgressBar::hidden()
        };
        let now = Instant::now();
        let stage = Mutex::new(Stage { name: "", steps: 1, done: 0, started: now, told: now });
        Self { bar, lines: !terminal && !common.quiet, cancelled, stage }
    }

    fn goes_on(&self) -> bool {
        !self.cancelled.load(Ordering::Relaxed)
    }
}

/// Takes the bar away, after errors too.
impl Drop for Steps<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl FlattenWatcher for Steps<'_> {
    fn stage(&self, name: &'static str, steps: usize) -> bool {
        let now = Instant::now();
        if let Ok(mut stage) = self.stage.lock() {
            *stage = Stage { name, steps, done: 0, started: now, told: now };
        }
        self.bar.set_message(name);
        self.bar.reset();
        self.bar.set_length(steps as u64);
        if self.lines && steps > 1 {
            tell(&format!("{name}: {steps} steps"));
        }
        self.goes_on()
    }

    fn step(&self) -> bool {
        self.bar.inc(1);
        if let Ok(mut stage) = self.stage.lock() {
            stage.done += 1;
            if self.lines && stage.told.elapsed() >= BETWEEN_LINES && stage.done < stage.steps {
                let elapsed = stage.started.elapsed().as_secs_f64();
                let left = elapsed / stage.done as f64 * (stage.steps - stage.done) as f64;
                tell(&format!(
                    "{}: {} of {} ({elapsed:.0} s, about {left:.0} s left)",
                    stage.name, stage.done, stage.steps
                ));
                stage.told = Instant::now();
            }
        }
        self.goes_on()
    }
}
