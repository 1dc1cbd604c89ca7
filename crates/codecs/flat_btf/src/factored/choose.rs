//! How many components: the fewest bytes that meet a target, or the least error within bytes.

use super::assemble::Shape;
use super::base::StoredBase;
use super::candidate::Candidate;
use super::recipe::{FactoredTarget, gpu_bytes, shapes};
use super::report::{FactorError, FactoredTrial};
use super::sample::{Sample, Values};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::GROUP;
use brdfc_source::progress::{Progress, Stage};

/// What candidates are fitted to and tried on.
pub(super) struct Trials<'a> {
    pub(super) values: &'a Values,
    pub(super) held_out: &'a Sample,
    /// The base of what is held out.
    pub(super) base: &'a StoredBase,
    pub(super) directions: &'a FlatHeader,
    pub(super) progress: &'a dyn Progress,
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
        let errors = candidate.errors(self.held_out, self.directions, self.base)?;
        let Shape { groups, shadowed } = candidate.shape;
        let (components, gpu_bytes) = (groups * GROUP as u32, gpu_bytes(candidate.shape, self.directions));
        tried.push(FactoredTrial { components, shadowed, gpu_bytes, errors });
        self.progress.step()?;
        Ok(candidate)
    }

    /// The fewest bytes with a mean error of at most so much where texels are seen; the least error where nothing has.
    fn meet<E>(&self, most: f64, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let met = |tried: &[FactoredTrial]| tried.last().is_some_and(|trial| f64::from(trial.errors.seen_mean) <= most);
        // Without shadows one fit serves all numbers of components.
        let shapes = |shadowed| shapes(self.directions, shadowed);
        let plain_shapes = shapes(false)?;
        let plain = Candidate::new(self.values, plain_shapes[plain_shapes.len() - 1]);
        let mut best: Option<(u64, Candidate)> = None;
        for shape in &plain_shapes {
            let candidate = self.attempt(plain.truncated(shape.groups), tried)?;
            if met(tried) {
                best = Some((gpu_bytes(candidate.shape, self.directions), candidate));
                break;
            }
        }
        let mut least: Option<(f32, Candidate)> = None;
        for shape in shapes(true)? {
            if best.as_ref().is_some_and(|(bytes, _)| gpu_bytes(shape, self.directions) >= *bytes) {
                break;
            }
            let candidate = self.attempt(Candidate::new(self.values, shape), tried)?;
            if met(tried) {
                return Ok(candidate);
            }
            let error = tried[tried.len() - 1].errors.seen_mean;
            if least.as_ref().is_none_or(|(found, _)| error < *found) {
                least = Some((error, candidate));
            }
        }
        let plain_error = tried[..plain_shapes.len().min(tried.len())].iter().map(|trial| trial.errors.seen_mean);
        Ok(match (best, least) {
            (Some((_, candidate)), _) => candidate,
            (None, Some((error, candidate))) if plain_error.fold(f32::MAX, f32::min) >= error => candidate,
            _ => plain,
        })
    }

    /// The least error of what takes at most so many bytes.
    fn fit_into<E>(&self, most: u64, tried: &mut Vec<FactoredTrial>) -> Result<Candidate, FactorError<E>> {
        let largest = |shadowed: bool| -> Result<Option<Shape>, FormatError> {
            let shapes = shapes(self.directions, shadowed)?;
            Ok(shapes.into_iter().rev().find(|shape| gpu_bytes(*shape, self.directions) <= most))
        };
        let mut best: Option<(f32, Candidate)> = None;
        for shape in [largest(false)?, largest(true)?].into_iter().flatten() {
            let candidate = self.attempt(Candidate::new(self.values, shape), tried)?;
            let error = tried[tried.len() - 1].errors.seen_mean;
            if best.as_ref().is_none_or(|(found, _)| error < *found) {
                best = Some((error, candidate));
            }
        }
        best.map(|(_, candidate)| candidate).ok_or_else(|| {
            FormatError::whole("bytes of factors", most.to_string(), "those of the smallest asset or more").into()
        })
    }
}
