//! Times of stages.

use crate::report::material::StageTime;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Times the stages of what it passes on.
pub struct StageClock<'a> {
    listener: &'a dyn Progress,
    times: Mutex<Times>,
}

#[derive(Default)]
struct Times {
    ended: Vec<StageTime>,
    running: Option<(Stage, Instant)>,
}

impl Times {
    fn end(&mut self) {
        if let Some((stage, start)) = self.running.take() {
            self.ended.push(StageTime { stage: stage.name().to_owned(), seconds: start.elapsed().as_secs_f64() });
        }
    }
}

impl<'a> StageClock<'a> {
    /// A clock that passes everything on to `listener`.
    pub fn new(listener: &'a dyn Progress) -> Self {
        Self { listener, times: Mutex::default() }
    }

    /// Times of the stages that ended.
    pub fn so_far(&self) -> Vec<StageTime> {
        self.times.lock().unwrap_or_else(PoisonError::into_inner).ended.clone()
    }

    /// Ends the last stage and gives all times.
    pub fn finish(self) -> Vec<StageTime> {
        let mut times = self.times.into_inner().unwrap_or_else(PoisonError::into_inner);
        times.end();
        times.ended
    }
}

impl Progress for StageClock<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        self.listener.check()
    }

    fn stage(&self, stage: Stage, steps: usize) -> Result<(), Cancelled> {
        let mut times = self.times.lock().unwrap_or_else(PoisonError::into_inner);
        times.end();
        times.running = Some((stage, Instant::now()));
        drop(times);
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
