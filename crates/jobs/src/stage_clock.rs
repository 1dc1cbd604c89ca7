//! Measures the times of stages.

use crate::report::material::StageTime;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Measures the times of stages and forwards progress to a listener.
pub struct StageClock<'a> {
    listener: &'a dyn Progress,
    /// Start of each stage.
    starts: Mutex<Vec<(Stage, Instant)>>,
}

impl<'a> StageClock<'a> {
    /// Creates a clock that forwards all progress to `listener`.
    pub fn new(listener: &'a dyn Progress) -> Self {
        Self { listener, starts: Mutex::default() }
    }

    /// Times of the finished stages.
    pub fn so_far(&self) -> Vec<StageTime> {
        times(&self.starts.lock().unwrap_or_else(PoisonError::into_inner), None)
    }

    /// Ends the last stage and returns all times.
    pub fn finish(self) -> Vec<StageTime> {
        times(&self.starts.into_inner().unwrap_or_else(PoisonError::into_inner), Some(Instant::now()))
    }
}

/// Times from each start to the next, and from the last start to `end`.
fn times(starts: &[(Stage, Instant)], end: Option<Instant>) -> Vec<StageTime> {
    let ends = starts.iter().skip(1).map(|(_, start)| *start).chain(end);
    let time = |((stage, start), end): (&(Stage, Instant), Instant)| StageTime {
        stage: stage.name().to_owned(),
        seconds: (end - *start).as_secs_f64(),
    };
    starts.iter().zip(ends).map(time).collect()
}

impl Progress for StageClock<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        self.listener.check()
    }

    fn stage(&self, stage: Stage, steps: usize) -> Result<(), Cancelled> {
        self.starts.lock().unwrap_or_else(PoisonError::into_inner).push((stage, Instant::now()));
        self.listener.stage(stage, steps)
    }

    fn step(&self) -> Result<(), Cancelled> {
        self.listener.step()
    }

    fn part<'b>(&'b self, name: &'b str) -> Box<dyn Progress + 'b> {
        self.listener.part(name)
    }

    fn finished(&self, succeeded: bool) {
        self.listener.finished(succeeded);
    }
}
