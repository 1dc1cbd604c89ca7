//! Gates: what a finished pack has to be, however it was asked for. A gate that saw nothing does not pass.

use crate::encode::byte_count::bytes_from_manifest;
use crate::encode::options::{OptionError, checked_limits};
use crate::encode::recipe::{Budget, TAIL};
use crate::report::material::MaterialReport;
use brdfc_metrics::fraction::Fraction;
use serde::{Deserialize, Serialize};

/// The table `require` of a material or of the defaults.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Require {
    /// Largest mean ΔE of pictures, with 95 % below four times that.
    pub max_delta_e: Option<f64>,
    /// Largest mean relative error `ε_r`, off any grid.
    pub max_error: Option<Fraction>,
    /// Most bytes on a GPU.
    #[serde(default, deserialize_with = "bytes_from_manifest")]
    pub max_bytes: Option<u64>,
    /// Most texture fetches of a look-up.
    pub max_fetches: Option<u32>,
}

impl Require {
    /// The gates, each from here or else from `defaults`.
    ///
    /// # Errors
    /// Values out of range.
    pub fn resolve(&self, defaults: &Self) -> Result<Budget, OptionError> {
        checked_limits(
            self.max_delta_e.or(defaults.max_delta_e),
            self.max_error.or(defaults.max_error),
            self.max_bytes.or(defaults.max_bytes),
            self.max_fetches.or(defaults.max_fetches),
        )
    }
}

/// What a gate saw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct GateResult {
    /// Which, by its key.
    pub gate: String,
    /// What was found: a number, or why there is none.
    pub found: String,
    /// What is allowed.
    pub allowed: String,
    /// Whether it is open.
    pub passed: bool,
}

impl std::fmt::Display for GateResult {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { gate, found, allowed, .. } = self;
        write!(f, "require.{gate}: found {found}; allowed {allowed}")
    }
}

/// Holds a material against its gates.
pub fn check(gates: &Budget, report: &MaterialReport) -> Vec<GateResult> {
    let of = |gate: &str, found: String, allowed: String, passed: bool| GateResult {
        gate: gate.to_owned(),
        found,
        allowed,
        passed,
    };
    let (norms, picture) = (&report.off_grid.norms, &report.off_grid.picture.delta_e);
    let black = report.off_grid.mean <= 0.0;
    let above_floor = norms.samples - norms.below_floor.min(norms.samples);
    let mut results = Vec::new();
    if let Some(limit) = gates.delta_e {
        let allowed = format!("{limit}, and 95 % below {}", TAIL * limit);
        results.push(if black {
            of("max_delta_e", "no light: the material is black wherever it was looked at".to_owned(), allowed, false)
        } else {
            let found = format!("{:.3}, and 95 % below {:.3}", picture.mean, picture.p95);
            // What is no number is not below either.
            of("max_delta_e", found, allowed, picture.mean <= limit && picture.p95 <= TAIL * limit)
        });
    }
    if let Some(limit) = gates.error {
        let allowed = format!("{} %", 100.0 * limit);
        results.push(if above_floor == 0 {
            of("max_error", "no sample above the floor".to_owned(), allowed, false)
        } else {
            let found = format!("{:.3} %", 100.0 * norms.relative_mean);
            of("max_error", found, allowed, norms.relative_mean <= limit)
        });
    }
    if let Some(limit) = gates.bytes {
        let passed = report.bytes_on_gpu <= limit;
        results.push(of("max_bytes", format!("{} bytes", report.bytes_on_gpu), format!("{limit} bytes"), passed));
    }
    if let Some(limit) = gates.fetches {
        results.push(of("max_fetches", report.fetches.to_string(), limit.to_string(), report.fetches <= limit));
    }
    results
}
