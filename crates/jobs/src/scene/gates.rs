//! Gates: limits that a finished pack has to meet, independently of its recipe. A gate with nothing to measure fails.

use super::lobes::{LOBES, LobesReport};
use crate::report::fit::{self, Found, Reliability};
use crate::report::gate::GateResult;
use crate::report::material::MaterialReport;
use brdfc_codec::{Budget, ErrorLimits, FitLimits, OptionError};
use brdfc_core::byte_count::bytes_from_manifest;
use brdfc_core::words::{counted, percent};
use brdfc_metrics::fraction::Fraction;
use serde::Deserialize;

/// The table `require` of a material or of the defaults.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Require {
    /// Largest mean ΔE of renderings; 95 % have to be below four times this.
    pub max_delta_e: Option<f64>,
    /// Smallest retained share of the highlight's light.
    pub min_highlight: Option<Fraction>,
    /// Largest mean relative error `ε_r` at independent test directions.
    pub max_error: Option<Fraction>,
    /// Largest size on a GPU, bytes.
    #[serde(default, deserialize_with = "bytes_from_manifest")]
    pub max_bytes: Option<u64>,
    /// Largest number of texture fetches per look-up.
    pub max_fetches: Option<u32>,
}

impl Require {
    /// Resolves the gates: values of `defaults` replace absent ones.
    ///
    /// # Errors
    /// Returns an error if a value is out of range.
    pub fn resolve(&self, defaults: &Self) -> Result<Budget, OptionError> {
        Budget::checked(
            self.max_delta_e.or(defaults.max_delta_e),
            self.min_highlight.or(defaults.min_highlight),
            self.max_error.or(defaults.max_error),
            self.max_bytes.or(defaults.max_bytes),
            self.max_fetches.or(defaults.max_fetches),
        )
    }
}

/// Limits of a finished pack and of the fit that it was made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gates {
    /// Limits of the pack, from the table `require`.
    pub required: Budget,
    /// Limits of the fit.
    pub fit: FitLimits,
    /// Error limits of the pack, from `require` or the recipe. They also apply to the error against the samples.
    pub errors: ErrorLimits,
    /// Error limit of the lobes that the manifest sets.
    pub lobes: ErrorLimits,
}

/// Checks a material and its lobes, if it has any, against its gates.
pub fn check(gates: &Gates, report: &MaterialReport, lobes: Option<&LobesReport>) -> Vec<GateResult> {
    let mut results = check_pack(&gates.required, report);
    let is_new = |result: &GateResult| results.iter().all(|other| other.gate != required(&result.gate) || other.passed);
    let of_source: Vec<GateResult> =
        fit::check_report(gates.fit, gates.errors, report.fit, &report.off_grid).into_iter().filter(is_new).collect();
    results.extend(of_source);
    if let Some(lobes) = lobes {
        let found = Found { delta_e: Some(lobes.facts.delta_e.mean), relative: None, all_lights: true };
        let limits = FitLimits { error: None, ..gates.fit };
        let of_lobes = fit::check(limits, gates.lobes, &Reliability::of(report.fit, &report.off_grid), found);
        results.extend(
            of_lobes.into_iter().map(|result| GateResult { gate: format!("{LOBES}.{}", result.gate), ..result }),
        );
    }
    results
}

/// Key of a gate of the table `require`.
fn required(gate: &str) -> String {
    format!("require.{gate}")
}

fn check_pack(gates: &Budget, report: &MaterialReport) -> Vec<GateResult> {
    let mut results = fit::check_output(gates.into(), &report.off_grid);
    results.iter_mut().for_each(|result| result.gate = required(&result.gate));
    let mut hold = |gate: &str, found: String, allowed: String, passed: bool| {
        results.push(GateResult::new(&required(gate), found, allowed, passed));
    };
    if let Some(least) = gates.highlight {
        // Materials without a highlight pass.
        let found = report.off_grid.highlight;
        let text = found.map_or("no highlight".to_owned(), |highlight| highlight.summary());
        let allowed = format!("at least {} of its light", percent(least));
        hold("min_highlight", text, allowed, found.is_none_or(|highlight| highlight.retained() >= least));
    }
    if let Some(limit) = gates.bytes {
        let allowed = format!("at most {}", counted(limit as usize, "byte"));
        hold("max_bytes", format!("{} bytes", report.bytes_on_gpu), allowed, report.bytes_on_gpu <= limit);
    }
    if let Some(limit) = gates.fetches {
        hold("max_fetches", report.fetches.to_string(), format!("at most {limit}"), report.fetches <= limit);
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::PackRecipe;
    use crate::encode::encode;
    use brdfc_source::open::open;

    fn report(address: &str) -> MaterialReport {
        let opened = open(address, None).unwrap();
        MaterialReport::new(&encode(opened.source.as_ref(), &PackRecipe::default(), &()).unwrap(), &opened, &())
            .unwrap()
    }

    fn passed(report: &MaterialReport, gates: Budget) -> Vec<bool> {
        check_pack(&gates, report).iter().map(|gate| gate.passed).collect()
    }

    #[test]
    fn each_gate_passes_and_fails() {
        let report = report("synth:ggx?alpha=0.4");
        let none = Budget::NONE;
        assert!(check_pack(&none, &report).is_empty());
        let (error, bytes) = (report.off_grid.norms.relative_mean, report.bytes_on_gpu);
        let loose = Budget::NONE.delta_e(5.0).highlight(0.5).error(2.0 * error).bytes(bytes).fetches(1);
        assert_eq!(passed(&report, loose), [true; 5]);
        let tight = Budget::NONE.delta_e(1e-6).highlight(0.999).error(0.5 * error).bytes(bytes - 1);
        assert_eq!(passed(&report, tight), [false; 4]);
    }

    #[test]
    fn gates_with_nothing_to_measure_fail() {
        let black = report("synth:lambert?kd=0");
        let gates = Budget::NONE.delta_e(100.0).error(1000.0);
        let results = check_pack(&gates, &black);
        assert!(results.iter().all(|gate| !gate.passed), "{results:?}");
        assert!(results[0].to_string().starts_with("require.max_delta_e: no light: the material is black"));
        assert!(results[1].to_string().starts_with("require.max_error: no sample above the floor"));
    }
}
