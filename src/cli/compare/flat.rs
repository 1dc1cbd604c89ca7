//! Comparison of two flat BTFs.

use crate::{Error, table};
use brdfc::Input;
use brdfc::compare::{ColourErrors, flat_btfs};
use serde::Serialize;

/// Comparison of two flat BTFs of the same surface.
#[derive(Debug, Clone, Copy, Serialize, schemars::JsonSchema)]
pub(super) struct FlatReport {
    /// 'flat-btf'.
    kind: &'static str,
    /// Measured errors.
    errors: ColourErrors,
}

impl FlatReport {
    /// Compares B with A.
    pub(super) fn new(a: &Input, b: &Input) -> Result<Self, Error> {
        Ok(Self { kind: "flat-btf", errors: flat_btfs(a, b)? })
    }

    pub(super) fn table(&self) -> String {
        let ColourErrors { samples, mean, p95, max, .. } = self.errors;
        let figures = [mean, p95, max].map(|delta_e| format!("{delta_e:.2}"));
        let row = [samples.to_string()].into_iter().chain(figures).collect::<Vec<_>>();
        table::plain(&["look-ups", "mean ΔE", "95 %", "largest"], [row])
    }

    /// Compares the mean with a limit.
    pub(super) fn check(&self, a: &Input, limit: f64) -> Result<(), Error> {
        if self.errors.show_nothing() {
            return Err(Error::check(format!("{a}: all values are black or white, so there is no error to check")));
        }
        let found = self.errors.mean;
        if found <= limit {
            return Ok(());
        }
        let found = table::apart(found, limit);
        Err(Error::check(format!("--max-delta-e: found {found}, expected at most {limit}")))
    }
}
