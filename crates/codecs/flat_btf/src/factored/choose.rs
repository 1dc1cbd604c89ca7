//! Chooses the number of components: the fewest bytes that meet a target, or the least error within a number of bytes.

use super::assemble::Shape;
use super::base::StoredBase;
use super::candidate::Candidate;
use super::recipe::{FactoredTarget, gpu_bytes, shapes};
use super::report::{FactorError, FactoredTrial};
use super::sample::{Sample, Values};
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::{ChromaRange, GROUP};

/// Data that candidates are fitted to and tested on.
pub(super) struct Trials<'a> {
    pub(super) values: &'a Values,
    pub(super) held_out: &'a Sample,
    /// Base of the held-out texels.
    pub(super) base: &'a StoredBase,
    pub(super) directions: &'a FlatHeader,
    pub(super) chroma: ChromaRange,
    /// True to try a factor of its own for each texel and light.
    pub(super) shadowed: bool,
    pub(super) progress: &'a dyn Progress,
}

/// Share of the target error that trials may have: the error of the whole asset is slightly larger.
const MARGIN: f64 = 0.95;

/// Factor below which an error must fall to justify more bytes.
const BETTER: f32 = 0.99;

/// The candidate with the least error where texels are seen. Among similar ones it is the first, which has the fewest
/// bytes.
#[derive(Default)]
struct Least {
    error: f32,
    candidate: Option<Candidate>,
}

impl Least {
    /// Considers the candidate of the last trial.
    fn take(&mut self, candidate: Candidate, tried: &[FactoredTrial]) {
        let Some(trial) = tried.last() else { return };
        if self.candidate.is_none() || trial.errors.seen_mean < BETTER * self.error {
            *self = Self { error: trial.errors.seen_mean, candidate: Some(candidate) };
        }
    }
}

impl Trials<'_> {
    /// Returns the candidate for a target, and all trials.
    pub(super) fn choose<E>(&self, target: FactoredTarget) -> Result<(Candidate, Vec<FactoredTrial>), FactorError<E>> {
        let mut tried = Vec::new();
        self.progress.stage(Stage::Try, 0)?;
        let chosen = match target {
            FactoredTarget::Components { components, shadowed } => {
                let groups = components.div_ceil(GROUP as u32);
                self.attempt(Candidate::new(self.values, Shape { groups, shadowed }), &mut tried)?
            }
            FactoredTarget::Error(most) => self.meet(most, &mut tried)?,
            FactoredTarget::Bytes(most) => self.fit_into(most, &mut tried)?,
        };
        Ok((chosen, tried))
    }

    /// Measures a candidate.
    fn attempt<E>(&self, candidate: Candidate, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let errors = candidate.errors(self.held_out, self.directions, self.base, self.chroma)?;
        let Shape { groups, shadowed } = candidate.shape;
        let (components, gpu_bytes) = (groups * GROUP as u32, gpu_bytes(candidate.shape, self.directions));
        tried.push(FactoredTrial { components, shadowed, gpu_bytes, errors });
        self.progress.step()?;
        Ok(candidate)
    }

    /// Finds the fewest bytes with a mean error of at most `most` where texels are seen, or else the least error.
    fn meet<E>(&self, most: f64, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let most = MARGIN * most;
        let met = |tried: &[FactoredTrial]| tried.last().is_some_and(|trial| f64::from(trial.errors.seen_mean) <= most);
        // Without shadows one fit serves all numbers of components.
        let shapes = |shadowed| shapes(self.directions, shadowed);
        let plain_shapes = shapes(false)?;
        let plain = Candidate::new(self.values, plain_shapes[plain_shapes.len() - 1]);
        let mut best: Option<(u64, Candidate)> = None;
        let mut least = Least::default();
        for shape in &plain_shapes {
            let candidate = self.attempt(plain.truncated(shape.groups), tried)?;
            if met(tried) {
                best = Some((gpu_bytes(candidate.shape, self.directions), candidate));
                break;
            }
            least.take(candidate, tried);
        }
        for shape in if self.shadowed { shapes(true)? } else { Vec::new() } {
            if best.as_ref().is_some_and(|(bytes, _)| gpu_bytes(shape, self.directions) >= *bytes) {
                break;
            }
            let candidate = self.attempt(Candidate::new(self.values, shape), tried)?;
            if met(tried) {
                return Ok(candidate);
            }
            least.take(candidate, tried);
        }
        Ok(best.map(|(_, candidate)| candidate).or(least.candidate).unwrap_or(plain))
    }

    /// Finds the least error with at most `most` bytes.
    fn fit_into<E>(&self, most: u64, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let fitting = |shadowed: bool| -> Result<Vec<Shape>, FormatError> {
            let shapes = shapes(self.directions, shadowed)?;
            Ok(shapes.into_iter().filter(|shape| gpu_bytes(*shape, self.directions) <= most).collect())
        };
        let (plain, shadowed) = (fitting(false)?, if self.shadowed { fitting(true)? } else { Vec::new() });
        // Without shadows one fit serves all numbers of components.
        let whole = plain.last().map(|shape| Candidate::new(self.values, *shape));
        let truncated = |shape: Shape| match &whole {
            Some(whole) if !shape.shadowed => whole.truncated(shape.groups),
            _ => Candidate::new(self.values, shape),
        };
        let mut least = Least::default();
        // More components do not always reduce the error where texels are seen, because they also fit filled texels.
        for shape in plain.into_iter().chain(shadowed) {
            let candidate = self.attempt(truncated(shape), tried)?;
            least.take(candidate, tried);
        }
        least.candidate.ok_or_else(|| {
            FormatError::whole("bytes of factors", most.to_string(), "at least the bytes of the smallest asset").into()
        })
    }
}
