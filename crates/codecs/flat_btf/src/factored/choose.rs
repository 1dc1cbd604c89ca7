//! Chooses the numbers of components and of cells of the residual: the fewest bytes that meet a target, or the least error
//! within a number of bytes.

use super::assemble::Shape;
use super::base::{Rays, StoredBase};
use super::candidate::Candidate;
use super::recipe::{FactoredTarget, gpu_bytes, shapes};
use super::report::{FactorError, FactoredTrial};
use super::residual::{Arrival, Shares};
use super::sample::Sample;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::{ChromaRange, GROUP};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Data that candidates are fitted to and tested on.
pub(super) struct Trials<'a> {
    pub(super) fitted: &'a Sample,
    /// Number of texels of the fits.
    pub(super) texels: usize,
    pub(super) held_out: &'a Sample,
    /// Bases of the texels of fits, and of held-out ones.
    pub(super) bases: [&'a StoredBase; 2],
    pub(super) directions: &'a FlatHeader,
    pub(super) chroma: ChromaRange,
    pub(super) arrival: &'a Arrival,
    pub(super) progress: &'a dyn Progress,
}

/// Share of the target error that trials may have: the error of the whole asset is slightly larger.
const MARGIN: f64 = 0.95;

/// Factor below which an error must fall to justify more bytes, and another one for every doubling of the bytes where
/// there is no limit of bytes.
const BETTER: f64 = 0.99;
const BETTER_OF_TWICE: f64 = 0.9;

/// The candidate with the least error where texels are seen, as far as its bytes pay.
#[derive(Default)]
struct Least {
    error: f64,
    bytes: u64,
    candidate: Option<Candidate>,
}

impl Least {
    /// Considers the candidate of a trial of no fewer bytes. Twice the bytes must reduce the error to `of_twice`.
    fn take(&mut self, candidate: Candidate, trial: &FactoredTrial, of_twice: f64) {
        let (error, bytes) = (f64::from(trial.errors.seen_mean), trial.gpu_bytes);
        let doublings = (bytes as f64 / self.bytes.max(1) as f64).log2();
        if self.candidate.is_none() || error < BETTER * of_twice.powf(doublings) * self.error {
            *self = Self { error, bytes, candidate: Some(candidate) };
        }
    }
}

/// A residual with the candidate of most components, from which the others follow.
struct Fitted {
    largest: Candidate,
    /// Shares of the held-out texels.
    held_out: Shares,
}

impl Trials<'_> {
    /// Returns the candidate for a target, and all trials.
    pub(super) fn choose<E>(&self, target: FactoredTarget) -> Result<(Candidate, Vec<FactoredTrial>), FactorError<E>> {
        let (directions, residuals) = (self.directions, self.arrival.sizes());
        let (shapes, most) = match target {
            FactoredTarget::Components { components, residual } => {
                // Values before shadows have no residual.
                let residual = if residuals == [0] { 0 } else { residual };
                (vec![Shape { groups: components.div_ceil(GROUP as u32), residual }], None)
            }
            // The error of the whole asset is slightly larger.
            FactoredTarget::Error(most) => (shapes(directions, &residuals)?, Some(MARGIN * most)),
            FactoredTarget::Bytes(most) => {
                let mut fitting = shapes(directions, &residuals)?;
                fitting.retain(|shape| gpu_bytes(*shape, directions) <= most);
                (fitting, None)
            }
        };
        let mut tried = Vec::new();
        let mut fitted = BTreeMap::new();
        let mut least = Least::default();
        self.progress.stage(Stage::Try, 0)?;
        // More bytes do not always reduce the error where texels are seen, because they also fit filled texels.
        for shape in &shapes {
            let of_residual = match fitted.entry(shape.residual) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(vacant) => vacant.insert(self.fit(shape.residual, &shapes)?),
            };
            let candidate = of_residual.largest.truncated(shape.groups);
            let base = (self.bases[1], &of_residual.held_out);
            let errors = candidate.errors(self.held_out, directions, base, self.chroma)?;
            let (components, gpu_bytes) = (shape.groups * GROUP as u32, gpu_bytes(*shape, directions));
            let trial = FactoredTrial { components, residual: shape.residual, gpu_bytes, errors };
            tried.push(trial);
            self.progress.step()?;
            if most.is_some_and(|most| f64::from(errors.seen_mean) <= most) {
                return Ok((candidate, tried));
            }
            least.take(candidate, &trial, if most.is_some() { BETTER_OF_TWICE } else { 1.0 });
        }
        // The target was checked: there is a shape.
        let none = || FormatError::whole("shapes of factors", "none", "at least one that fits").problem();
        Ok((least.candidate.ok_or_else(none)?, tried))
    }

    /// Fits the largest of the shapes with a residual.
    fn fit(&self, residual: u32, shapes: &[Shape]) -> Result<Fitted, FormatError> {
        let groups = shapes.iter().filter(|shape| shape.residual == residual).map(|shape| shape.groups).max();
        let map = self.arrival.residual(residual)?;
        let shape = Shape { groups: groups.unwrap_or(1), residual };
        let Shares { fit_roots, shaded, .. } = self.arrival.shares(map.as_ref(), &self.fitted.texels[..self.texels]);
        let values = self.fitted.values(self.texels, self.bases[0], &shaded, &Rays::new(self.directions));
        let largest = Candidate::new(&values, &fit_roots, shape);
        Ok(Fitted { largest, held_out: self.arrival.shares(map.as_ref(), &self.held_out.texels) })
    }
}
