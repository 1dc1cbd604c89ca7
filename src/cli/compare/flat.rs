//! Comparison of two flat BTFs.

use crate::{Error, table};
use brdfc::Input;
use brdfc::compare::{ColourErrors, FlatComparison, flat_btfs};
use serde::Serialize;

/// Comparison of two flat BTFs of the same surface.
#[derive(Debug, Clone, Copy, Serialize, schemars::JsonSchema)]
pub(super) struct FlatReport {
    /// 'flat-btf'.
    kind: &'static str,
    /// Measured errors.
    #[serde(flatten)]
    comparison: FlatComparison,
}

impl FlatReport {
    /// Compares B with A.
    pub(super) fn new(a: &Input, b: &Input) -> Result<Self, Error> {
        Ok(Self { kind: "flat-btf", comparison: flat_btfs(a, b)? })
    }

    fn kinds(&self) -> [(&'static str, ColourErrors); 2] {
        let FlatComparison { at_samples, between_samples, .. } = self.comparison;
        [("at sampled directions", at_samples), ("between them", between_samples)]
    }

    pub(super) fn table(&self) -> String {
        let rows = self.kinds().map(|(kind, errors)| {
            let figures = [errors.mean, errors.p95, errors.max].map(|delta_e| format!("{delta_e:.2}"));
            [kind.to_owned(), errors.samples.to_string()].into_iter().chain(figures).collect::<Vec<_>>()
        });
        table::plain(&["ΔE", "look-ups", "mean", "95 %", "largest"], rows)
    }

    /// Compares both means with a limit.
    pub(super) fn check(&self, a: &Input, limit: f64) -> Result<(), Error> {
        if self.comparison.lit == 0 {
            return Err(Error::check(format!("{a}: all values are black, so there is no error to check")));
        }
        match self.kinds().into_iter().find(|(_, errors)| errors.mean > limit) {
            Some((kind, errors)) => {
                let found = table::apart(errors.mean, limit);
                Err(Error::check(format!("--max-delta-e: found {found} {kind}, expected at most {limit}")))
            }
            None => Ok(()),
        }
    }
}
