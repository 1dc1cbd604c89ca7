//! Selection of lobes: the candidate that removes most of the error is added, and all directions and sharpnesses move
//! to better ones, again and again.

use super::candidate::Candidate;
use super::system::{Column, System, Target, gain};
use super::views::Views;
use rayon::prelude::*;
use std::sync::Arc;

/// Candidates whose exact gain is computed.
const FINALISTS: usize = 12;
/// Smallest relative decrease of the error that is a gain.
const LEAST_GAIN: f64 = 1e-5;
/// Relative decrease of a round of moves below which they end.
const SETTLED: f64 = 2e-3;
/// Rounds of moves after a candidate is added, and at the end.
const ROUNDS: [usize; 2] = [2, 6];

/// A search for lobes that continues from one number of look-ups to the next.
pub struct Selection<'a> {
    views: &'a Views<'a>,
    target: Target,
    candidates: Vec<(Candidate, Arc<Column>)>,
    sharpest: u32,
    /// The lobes so far.
    pub system: System,
}

impl<'a> Selection<'a> {
    /// Starts with no lobes, for a choice of all candidates.
    pub fn new(views: &'a Views<'a>, all: Vec<Candidate>, sharpest: u32) -> Self {
        let target = Target::new(views);
        let candidates = all.into_par_iter().map(|one| (one, Arc::new(target.column(&one, views)))).collect();
        let system = System::new(&target);
        Self { views, target, candidates, sharpest, system }
    }

    /// Adds lobes up to a number of look-ups, and moves all of them.
    pub fn grow(&mut self, fetches: usize) {
        while let Some(better) = self.added(fetches) {
            self.system = better;
            self.refine(ROUNDS[0]);
            self.remove_unused();
        }
        self.refine(ROUNDS[1]);
    }

    /// The system with the best further candidate, if one decreases the error.
    fn added(&self, fetches: usize) -> Option<System> {
        let left = fetches.saturating_sub(self.system.fetches());
        let residual = self.system.residual(&self.target);
        let score = |(number, (candidate, column)): (usize, &(Candidate, Arc<Column>))| {
            (gain(column, &residual) / candidate.fetches() as f64, number)
        };
        let fits = |candidate: &Candidate| candidate.fetches() <= left;
        let mut scores: Vec<(f64, usize)> =
            self.candidates.par_iter().enumerate().filter(|(_, (one, _))| fits(one)).map(score).collect();
        scores.sort_by(|a, b| b.0.total_cmp(&a.0));
        scores.truncate(FINALISTS);
        let exact = |(_, number): &(f64, usize)| {
            let (candidate, column) = &self.candidates[*number];
            let system = self.system.with(None, *candidate, Arc::clone(column), &self.target);
            ((self.system.error - system.error) / candidate.fetches() as f64, system)
        };
        let systems: Vec<(f64, System)> = scores.par_iter().map(exact).collect();
        let best = systems.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best })?;
        (best.0 > LEAST_GAIN * self.system.error).then_some(best.1)
    }

    /// Moves each lobe to its best neighbour, for some rounds with smaller and smaller steps.
    fn refine(&mut self, rounds: usize) {
        for round in 0..rounds {
            let before = self.system.error;
            let share = 1.0 / (1.0 + 0.5 * round as f64);
            for at in 0..self.system.candidates.len() {
                let neighbours = self.system.candidates[at].neighbours(share, self.sharpest);
                let moved = |one: &Candidate| {
                    self.system.with(Some(at), *one, Arc::new(self.target.column(one, self.views)), &self.target)
                };
                let systems: Vec<System> = neighbours.par_iter().map(moved).collect();
                let best = systems.into_iter().reduce(|best, next| if next.error < best.error { next } else { best });
                if let Some(best) = best.filter(|best| best.error < self.system.error) {
                    self.system = best;
                }
            }
            if self.system.error > before * (1.0 - SETTLED) {
                break;
            }
        }
    }

    /// Removes lobes whose weights have become 0.
    fn remove_unused(&mut self) {
        let unused = |system: &System| {
            let is_unused = |at: &usize| system.weights(*at).flatten().all(|weight| weight <= 0.0);
            (0..system.candidates.len()).find(is_unused)
        };
        while let Some(at) = unused(&self.system) {
            self.system = self.system.without(at, &self.target);
        }
    }
}
