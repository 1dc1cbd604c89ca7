//! How many components: the fewest bytes that meet a target, or the least error within bytes.

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

/// What candidates are fitted to and tried on.
pub(super) struct Trials<'a> {
    pub(super) values: &'a Values,
    pub(super) held_out: &'a Sample,
    /// The base of what is held out.
    pub(super) base: &'a StoredBase,
    pub(super) directions: &'a FlatHeader,
    pub(super) chroma: ChromaRange,
    pub(super) progress: &'a dyn Progress,
}

/// How much of a target trials may take: the whole asset errs a little more than they do.
const MARGIN: f64 = 0.95;

/// What more bytes have to make of an error to be worth it.
const BETTER: f32 = 0.99;

/// The candidate with the least error where texels are seen; of those that are about as good the one that was tried first, which
/// has the fewest bytes.
#[derive(Default)]
struct Least {
    error: f32,
    candidate: Option<Candidate>,
}

impl Least {
    /// Looks at the candidate that was tried last.
    fn take(&mut self, candidate: Candidate, tried: &[FactoredTrial]) {
        let Some(trial) = tried.last() else { return };
        if self.candidate.is_none() || trial.errors.seen_mean < BETTER * self.error {
            *self = Self { error: trial.errors.seen_mean, candidate: Some(candidate) };
        }
    }
}

impl Trials<'_> {
    /// The candidate that a target asks for, and all that were tried.
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

    /// The fewest bytes with a mean error of at most so much where texels are seen; the least error where nothing has.
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
        for shape in shapes(true)? {
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

    /// The least error of what takes at most so many bytes.
    fn fit_into<E>(&self, most: u64, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let fitting = |shadowed: bool| -> Result<Vec<Shape>, FormatError> {
            let shapes = shapes(self.directions, shadowed)?;
            Ok(shapes.into_iter().filter(|shape| gpu_bytes(*shape, self.directions) <= most).collect())
        };
        let (plain, shadowed) = (fitting(false)?, fitting(true)?);
        // Without shadows one fit serves all numbers of components.
        let whole = plain.last().map(|shape| Candidate::new(self.values, *shape));
        let truncated = |shape: Shape| match &whole {
            Some(whole) if !shape.shadowed => whole.truncated(shape.groups),
            _ => Candidate::new(self.values, shape),
        };
        let mut least = Least::default();
        // More components are not always better where texels are seen: they go to what was filled in as well.
        for shape in plain.into_iter().chain(shadowed) {
            let candidate = self.attempt(truncated(shape), tried)?;
            least.take(candidate, tried);
        }
        least.candidate.ok_or_else(|| {
            FormatError::whole("bytes of factors", most.to_string(), "those of the smallest asset or more").into()
        })
    }
}
