//! Times of stages.

use crate::report::material::StageTime;
use brdfc_wavelet::encode::Observer;
use std::time::Instant;

/// Times stages for a caller that may show or cancel them.
pub struct StageClock<F> {
    on_stage: F,
    times: Vec<StageTime>,
    started: Option<(&'static str, Instant)>,
}

impl<F: FnMut(&'static str) -> bool> StageClock<F> {
    /// `on_stage` hears each start and says whether to go on.
    pub fn new(on_stage: F) -> Self {
        Self { on_stage, times: Vec::new(), started: None }
    }

    /// Ends the last stage and gives all times.
    pub fn finish(mut self) -> Vec<StageTime> {
        self.end();
        self.times
    }

    fn end(&mut self) {
        if let Some((stage, start)) = self.started.take() {
            self.times.push(StageTime { stage: stage.to_owned(), seconds: start.elapsed().as_secs_f64() });
        }
    }
}

impl<F: FnMut(&'static str) -> bool> Observer for StageClock<F> {
    fn stage(&mut self, name: &'static str) -> bool {
        self.end();
        self.started = Some((name, Instant::now()));
        (self.on_stage)(name)
    }
}
