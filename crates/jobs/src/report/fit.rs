//! Checks of limits that apply to the output of any codec, by `encode`, `build`, `convert` and `flatten`: whether there is
//! anything to measure, and whether a scan determines the material.

use super::gate::GateResult;
use brdfc_codec::{ErrorLimits, FitLimits, TAIL};
use brdfc_core::Source;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_core::source::Repeats;
use brdfc_core::words::percent;
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::compare::{Comparison, is_black, mean_value};
use brdfc_metrics::fit_error::FitError;
use brdfc_metrics::sampling::PairSet;
use brdfc_metrics::values::values_at;
use serde::Serialize;

/// Reason why no error of a black material is measured.
const NO_LIGHT: &str = "no light: the material is black in all tested directions";

/// Properties of a source on which the meaning of an error against it depends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Reliability {
    /// Error of the fit to samples; absent for sources that are not fitted.
    pub fit: Option<FitError>,
    /// True for a material without any light at the test directions.
    pub black: bool,
}

/// Errors of an output against its source, as far as they are measured.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Found {
    /// Mean ΔE of renderings.
    pub delta_e: Option<f64>,
    /// Relative error `ε_r`, a fraction.
    pub relative: Option<f64>,
    /// True if the ΔE is under light from all directions, unlike that of the ball under three lights.
    pub all_lights: bool,
}

impl Found {
    /// The errors of a comparison.
    pub fn of(comparison: &Comparison) -> Self {
        Self {
            delta_e: Some(comparison.rendering.delta_e.mean),
            relative: Some(comparison.norms.relative_mean),
            all_lights: false,
        }
    }
}

impl Reliability {
    /// Measures a source within a range of directions.
    ///
    /// # Errors
    /// Returns an error if cancelled.
    pub fn measure(
        source: &dyn Source,
        directions: DirectionRange,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let set = PairSet::within(directions);
        let (values, _) = values_at(source, &set.pairs[..set.of_mean]);
        Ok(Self { fit: fit_error(source, directions, progress)?, black: is_black(mean_value(&values)) })
    }

    /// The reliability of a source that has been compared with an output.
    pub fn of(fit: Option<FitError>, off_grid: &Comparison) -> Self {
        Self { fit, black: off_grid.norms.samples > 0 && is_black(off_grid.mean) }
    }

    /// Notes on a source, for an output with this mean ΔE.
    pub fn remarks(&self, delta_e: f64) -> Vec<String> {
        if self.black {
            return vec!["the material is black at all test directions".to_owned()];
        }
        self.fit.as_ref().map_or(Vec::new(), |fit| fit_remarks(fit, delta_e))
    }
}

/// Error of the fit to samples within a range of directions; `None` for sources that are not fitted.
///
/// # Errors
/// Returns an error if cancelled.
pub fn fit_error(
    source: &dyn Source,
    directions: DirectionRange,
    progress: &dyn Progress,
) -> Result<Option<FitError>, Cancelled> {
    FitError::measure(source, directions, progress)
}

/// Checks the fit of the source against its limits, and the errors of fit and output together against the limits of errors.
/// If limits are set, a black material fails, and so does a scan that does not determine what the error is a mean of.
pub fn check(limits: FitLimits, errors: ErrorLimits, source: &Reliability, found: Found) -> Vec<GateResult> {
    if source.black {
        let set = [
            ("max_delta_e", errors.delta_e.map(|limit| limit.to_string())),
            ("max_error", errors.relative.map(percent)),
            ("max_fit_error", limits.error.map(percent)),
        ];
        let failed = |(gate, limit): (&str, Option<String>)| {
            limit.map(|limit| GateResult::new(gate, NO_LIGHT, at_most(&limit), false))
        };
        return set.into_iter().filter_map(failed).collect();
    }
    let mut results = Vec::new();
    let Some(fit) = &source.fit else { return results };
    let extrapolation = fit.extrapolation().filter(|_| !limits.trusted);
    let or_trusted = |allowed: &str| format!("{allowed}; trust_fit (--trust-fit) accepts the fit");
    if let Some(limit) = limits.error {
        let allowed = at_most(&percent(limit));
        let result = match (fit.error(), &extrapolation) {
            (Some(found), Some(problem)) if found <= limit => {
                Some((format!("{}, extrapolated: {problem}", percent(found)), or_trusted(&allowed), false))
            }
            (Some(found), _) => Some((percent(found), allowed, found <= limit)),
            (None, _) if fit.completed => {
                Some(("no samples can be held out: there are too few".to_owned(), allowed, false))
            }
            // A table is no fit, but its samples may not determine it.
            (None, _) => {
                let gaps = fit.gaps().or(fit.extrapolation()).filter(|_| !limits.trusted);
                gaps.map(|gaps| (gaps, or_trusted(&allowed), false))
            }
        };
        results.extend(result.map(|(found, allowed, passed)| GateResult::new("max_fit_error", found, allowed, passed)));
    }
    if limits.trusted || errors == ErrorLimits::default() {
        return results;
    }
    let mut fail = |found: String, allowed: &str| {
        results.push(GateResult::new("fit", found, or_trusted(allowed), false));
    };
    if let Some(gaps) = fit.gaps().or(extrapolation.filter(|_| errors.relative.is_some() || found.all_lights)) {
        fail(format!("no reliable fit: {gaps}"), "samples that determine the material");
    }
    // Both errors are independent. If the output alone misses the limit, its own check reports it. Limits of wavelet packs
    // apply on their grid.
    let together = |limit: Option<f64>, of_output: Option<f64>, of_fit: Option<f64>| {
        let (limit, of_output, of_fit) = (limit?, of_output?, of_fit?);
        let all = of_output.hypot(of_fit);
        (all > limit && (of_output <= limit || of_fit > limit)).then_some((limit, all, of_output, of_fit))
    };
    if let Some((limit, all, of_output, of_fit)) = together(errors.delta_e, found.delta_e, fit.delta_e) {
        let found = format!(
            "a ΔE of about {all:.2} against the material, {of_output:.2} from the pack and {of_fit:.2} from the fit"
        );
        fail(found, &at_most(&limit.to_string()));
    }
    if let Some((limit, all, of_output, of_fit)) = together(errors.relative, found.relative, fit.error()) {
        let [all, of_output, of_fit] = [all, of_output, of_fit].map(percent);
        let found =
            format!("ε_r of about {all} against the material, {of_output} from the pack and {of_fit} from the fit");
        fail(found, &at_most(&percent(limit)));
    }
    results
}

/// Checks the error of an output against its source. A limit with nothing to measure fails.
pub fn check_output(errors: ErrorLimits, comparison: &Comparison) -> Vec<GateResult> {
    let black = is_black(comparison.mean);
    let of_delta_e = errors.delta_e.map(|limit| {
        let rendering = &comparison.rendering.delta_e;
        let allowed = format!("a mean of at most {limit}, 95 % below {}", TAIL * limit);
        let found = format!("a mean of {:.3}, 95 % below {:.3}", rendering.mean, rendering.p95);
        // NaN fails.
        let passed = !black && rendering.mean <= limit && rendering.p95 <= TAIL * limit;
        GateResult::new("max_delta_e", if black { NO_LIGHT.to_owned() } else { found }, allowed, passed)
    });
    let of_relative = errors.relative.map(|limit| {
        let norms = &comparison.norms;
        let (found, passed) = match norms.counted() {
            0 => ("no sample above the floor".to_owned(), false),
            _ => (format!("{:.3} %", 100.0 * norms.relative_mean), norms.relative_mean <= limit),
        };
        GateResult::new("max_error", found, at_most(&percent(limit)), passed)
    });
    of_delta_e.into_iter().chain(of_relative).collect()
}

/// Checks of a pack, by the fit and the errors in its report.
pub fn check_report(
    limits: FitLimits,
    errors: ErrorLimits,
    fit: Option<FitError>,
    off_grid: &Comparison,
) -> Vec<GateResult> {
    check(limits, errors, &Reliability::of(fit, off_grid), Found::of(off_grid))
}

/// Spread of repeated samples above which it is reported.
const SPREAD: f64 = 0.05;

/// Notes on fits that are less accurate than the pack, and on samples that contradict each other.
fn fit_remarks(fit: &FitError, delta_e: f64) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(weakness) = fit.weakness(delta_e) {
        let to = match fit.completed {
            true => "a fit to samples, which is less accurate than the pack",
            false => "a table whose samples do not determine the material",
        };
        lines.push(format!("errors are relative to {to}: {weakness}"));
    }
    if let Some(Repeats { pairs, spread, largest, .. }) = fit.repeats.filter(|repeats| repeats.spread > SPREAD) {
        let (spread, largest) = (percent(spread), percent(largest));
        lines.push(format!(
            "{} measured more than once: values differ by {spread} of the larger overall, {largest} at most",
            if pairs == 1 { "1 direction pair was".to_owned() } else { format!("{pairs} direction pairs were") }
        ));
    }
    lines
}

fn at_most(limit: &str) -> String {
    format!("at most {limit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{PackRecipe, encode};
    use crate::report::material::MaterialReport;
    use brdfc_core::source::{PeakAt, Rise, Rounding, Saturation};
    use brdfc_metrics::fit_error::Gaps;
    use brdfc_source::open::open;

    const GOOD: FitError = FitError {
        exchanged: None,
        rise: None,
        samples: Some(0.02),
        incidences: Some(0.03),
        delta_e: Some(0.3),
        ball: Gaps { farthest: 8.0, uncovered: 0.0 },
        test_directions: Gaps { farthest: 9.0, uncovered: 0.02 },
        repeats: None,
        saturation: None,
        rounding: None,
        completed: true,
        too_few: false,
    };

    /// The report of a pack with a ΔE of 0.4 and ε_r of 4 %, of a scan with this fit.
    fn report(fit: Option<FitError>) -> MaterialReport {
        let opened = open("synth:ggx?alpha=0.4", None).expect("a model");
        let made = encode(opened.source.as_ref(), &PackRecipe::default(), &()).expect("a pack");
        let mut report = MaterialReport::new(&made, &opened, &()).expect("it is not cancelled");
        report.off_grid.rendering.delta_e.mean = 0.4;
        report.off_grid.norms.relative_mean = 0.04;
        MaterialReport { fit, ..report }
    }

    fn failed(fit: FitError, limits: FitLimits, delta_e: Option<f64>, relative: Option<f64>) -> Vec<String> {
        let results = check_report(limits, ErrorLimits { delta_e, relative }, Some(fit), &report(Some(fit)).off_grid);
        results.into_iter().filter(|gate| !gate.passed).map(|gate| gate.gate).collect()
    }

    #[test]
    fn limits_apply_to_pack_and_fit_together() {
        let none = FitLimits::default();
        // 0.5 together, and 5 %.
        assert!(failed(GOOD, none, Some(0.51), Some(0.051)).is_empty());
        assert_eq!(failed(GOOD, none, Some(0.49), None), ["fit"]);
        assert_eq!(failed(GOOD, none, None, Some(0.049)), ["fit"]);
        // The pack alone misses the limit.
        assert!(failed(GOOD, none, Some(0.35), None).is_empty());
        assert_eq!(failed(GOOD, none, Some(0.2), None), ["fit"]);
        // No limit is set.
        assert!(failed(GOOD, none, None, None).is_empty());
        let trusted = FitLimits { trusted: true, ..none };
        assert!(failed(GOOD, trusted, Some(0.1), Some(0.01)).is_empty());
        assert!(
            check_report(none, ErrorLimits { delta_e: Some(0.1), relative: None }, None, &report(None).off_grid)
                .is_empty()
        );
    }

    #[test]
    fn gaps_and_contradictions_fail_at_any_limit() {
        let rise =
            |ratio, peak| Some(Rise { peak_at: PeakAt::Mirror, incidence: 60.0, nearest: 4.0, next: 8.0, ratio, peak });
        let gaps = |uncovered| Gaps { farthest: 40.0, uncovered };
        let repeats = |share, spread| Some(Repeats { pairs: 9, share, spread, largest: spread });
        for (fit, fails) in [
            (FitError { ball: gaps(0.2), ..GOOD }, true),
            (FitError { ball: gaps(0.05), ..GOOD }, false),
            (FitError { repeats: repeats(0.5, 0.9), ..GOOD }, true),
            (FitError { repeats: repeats(0.01, 0.9), ..GOOD }, false),
            (FitError { repeats: repeats(0.5, 0.1), ..GOOD }, false),
            (FitError { exchanged: Some(0.06), ..GOOD }, true),
            (FitError { exchanged: Some(0.04), ..GOOD }, false),
            (FitError { rise: rise(4.0, 5.0), ..GOOD }, true),
            (FitError { rise: rise(99.0, 1.2), ..GOOD }, true),
            (FitError { rise: rise(4.0, 1.2), ..GOOD }, false),
            (FitError { saturation: Some(Saturation { samples: 9, farthest: 5.0 }), ..GOOD }, true),
            (FitError { rounding: Some(Rounding { step: 0.01, error: 0.03 }), ..GOOD }, true),
            (FitError { rounding: Some(Rounding { step: 0.01, error: 0.01 }), ..GOOD }, false),
            (FitError { samples: None, incidences: None, delta_e: None, too_few: true, ..GOOD }, true),
        ] {
            assert_eq!(!failed(fit, FitLimits::default(), Some(100.0), None).is_empty(), fails, "{fit:?}");
            let trusted = FitLimits { trusted: true, ..FitLimits::default() };
            assert!(failed(fit, trusted, Some(100.0), None).is_empty());
        }
    }

    #[test]
    fn black_materials_fail_at_any_limit() {
        let limits = FitLimits { error: Some(0.1), trusted: true };
        let errors = ErrorLimits { delta_e: Some(1.0), relative: Some(0.1) };
        for black in [true, false] {
            let results = check(limits, errors, &Reliability { fit: None, black }, Found::default());
            let keys: Vec<&str> = results.iter().map(|result| result.gate.as_str()).collect();
            assert_eq!(keys, if black { &["max_delta_e", "max_error", "max_fit_error"][..] } else { &[] });
        }
        let beyond = FitError { test_directions: Gaps { farthest: 40.0, uncovered: 0.3 }, ..GOOD };
        let beyond = Reliability { fit: Some(beyond), black: false };
        let limit = ErrorLimits { delta_e: Some(5.0), relative: None };
        for all_lights in [true, false] {
            let found = Found { delta_e: Some(0.1), all_lights, ..Found::default() };
            assert_eq!(check(FitLimits::default(), limit, &beyond, found).is_empty(), !all_lights);
        }
        let none = check(
            FitLimits::default(),
            ErrorLimits::default(),
            &Reliability { fit: None, black: true },
            Found::default(),
        );
        assert_eq!(none, []);
    }

    /// A lobe too narrow for most test directions is black by both definitions or by none.
    #[test]
    fn sources_and_comparisons_are_black_alike() {
        for (address, black) in [
            ("synth:ward?kd=0&ks=0.1&ax=0.001&ay=0.001", false),
            ("synth:lambert?kd=0", true),
            ("synth:lambert?kd=0.01", false),
        ] {
            let opened = open(address, None).expect("a model");
            let source = opened.source.as_ref();
            let measured = Reliability::measure(source, DirectionRange::ALL, &()).expect("it is not cancelled");
            let made = encode(source, &PackRecipe::default(), &()).expect("a pack");
            assert_eq!((measured.black, Reliability::of(None, &made.off_grid).black), (black, black), "{address}");
        }
    }

    #[test]
    fn the_error_of_a_fit_has_a_limit_of_its_own() {
        let limits = |error| FitLimits { error: Some(error), trusted: true };
        assert!(failed(GOOD, limits(0.03), None, None).is_empty());
        assert_eq!(failed(GOOD, limits(0.029), None, None), ["max_fit_error"]);
        // Gaps beyond the ball make ε_r an extrapolation. A ΔE does not depend on them.
        let beyond = FitError { test_directions: Gaps { farthest: 40.0, uncovered: 0.3 }, ..GOOD };
        let error = |trusted| FitLimits { error: Some(0.05), trusted };
        assert!(failed(GOOD, error(false), Some(5.0), Some(0.1)).is_empty());
        assert_eq!(failed(beyond, error(false), None, None), ["max_fit_error"]);
        assert_eq!(failed(beyond, FitLimits::default(), None, Some(0.1)), ["fit"]);
        assert!(failed(beyond, FitLimits::default(), Some(5.0), None).is_empty());
        assert!(failed(beyond, error(true), None, Some(0.1)).is_empty());
        let unknown = FitError { samples: None, incidences: None, ..GOOD };
        assert_eq!(failed(unknown, limits(100.0), None, None), ["max_fit_error"]);
    }
}
