//! Checks of the fit from which a pack of a scan was made.

use super::gate::GateResult;
use super::material::MaterialReport;
use brdfc_codec::{ErrorLimits, FitLimits};
use brdfc_core::words::percent;
use brdfc_metrics::compare::is_black;

/// Checks the error of the fit against its limits, and the error of pack and fit together against the limits of the pack.
/// Sources that are not fitted to samples pass.
pub fn check(limits: FitLimits, errors: ErrorLimits, report: &MaterialReport) -> Vec<GateResult> {
    let mut results = Vec::new();
    let Some(fit) = &report.fit else { return results };
    let unknown = || "no held-out samples: there are too few".to_owned();
    if let Some(limit) = limits.error {
        let (found, passed) = match fit.error() {
            _ if is_black(report.off_grid.mean) => ("no light: the material is black".to_owned(), false),
            Some(found) => (percent(found), found <= limit),
            None => (unknown(), false),
        };
        results.push(GateResult::new("max_fit_error", found, at_most(&percent(limit)), passed));
    }
    if limits.trusted || errors == ErrorLimits::default() {
        return results;
    }
    let mut fail = |found: String, allowed: &str| {
        let allowed = format!("{allowed}; trust_fit (--trust-fit) accepts the fit");
        results.push(GateResult::new("fit", found, allowed, false));
    };
    if let Some(gaps) = fit.gaps() {
        fail(format!("no reliable fit: {gaps}"), "samples that determine the material");
    }
    // Both errors are independent.
    if let (Some(limit), Some(of_fit)) = (errors.delta_e, fit.delta_e) {
        let of_pack = report.off_grid.rendering.delta_e.mean;
        let all = of_pack.hypot(of_fit);
        // If the pack alone misses the limit, the pack's own check reports it.
        if all > limit && (of_pack <= limit || of_fit > limit) {
            let found = format!(
                "a ΔE of about {all:.2} against the material, {of_pack:.2} from the pack and {of_fit:.2} from the fit"
            );
            fail(found, &at_most(&limit.to_string()));
        }
    }
    if let (Some(limit), Some(of_fit)) = (errors.relative, fit.error()) {
        let of_pack = report.off_grid.norms.relative_mean;
        let all = of_pack.hypot(of_fit);
        // Likewise. Limits of wavelet packs apply on their grid.
        if all > limit && (of_pack <= limit || of_fit > limit) {
            let [all, of_pack, of_fit] = [all, of_pack, of_fit].map(percent);
            let found =
                format!("ε_r of about {all} against the material, {of_pack} from the pack and {of_fit} from the fit");
            fail(found, &at_most(&percent(limit)));
        }
    }
    results
}

fn at_most(limit: &str) -> String {
    format!("at most {limit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{PackRecipe, encode};
    use brdfc_core::source::{Repeats, Rise};
    use brdfc_metrics::fit_error::FitError;
    use brdfc_source::open::open;

    const GOOD: FitError = FitError {
        rise: None,
        samples: Some(0.02),
        incidences: Some(0.03),
        delta_e: Some(0.3),
        farthest: 8.0,
        uncovered: 0.0,
        repeats: None,
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
        let results = check(limits, ErrorLimits { delta_e, relative }, &report(Some(fit)));
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
        assert!(check(none, ErrorLimits { delta_e: Some(0.1), relative: None }, &report(None)).is_empty());
    }

    #[test]
    fn gaps_and_contradictions_fail_at_any_limit() {
        let rise = |ratio, peak| Some(Rise { incidence: 60.0, nearest: 4.0, next: 8.0, ratio, peak });
        let repeats = |share, spread| Some(Repeats { pairs: 9, share, spread, largest: spread });
        for (fit, fails) in [
            (FitError { uncovered: 0.2, ..GOOD }, true),
            (FitError { uncovered: 0.05, ..GOOD }, false),
            (FitError { repeats: repeats(0.5, 0.9), ..GOOD }, true),
            (FitError { repeats: repeats(0.01, 0.9), ..GOOD }, false),
            (FitError { repeats: repeats(0.5, 0.1), ..GOOD }, false),
            (FitError { rise: rise(4.0, 5.0), ..GOOD }, true),
            (FitError { rise: rise(99.0, 1.2), ..GOOD }, true),
            (FitError { rise: rise(4.0, 1.2), ..GOOD }, false),
            (FitError { samples: None, incidences: None, delta_e: None, ..GOOD }, true),
        ] {
            assert_eq!(!failed(fit, FitLimits::default(), Some(100.0), None).is_empty(), fails, "{fit:?}");
            let trusted = FitLimits { trusted: true, ..FitLimits::default() };
            assert!(failed(fit, trusted, Some(100.0), None).is_empty());
        }
    }

    #[test]
    fn the_error_of_a_fit_has_a_limit_of_its_own() {
        let limits = |error| FitLimits { error: Some(error), trusted: true };
        assert!(failed(GOOD, limits(0.03), None, None).is_empty());
        assert_eq!(failed(GOOD, limits(0.029), None, None), ["max_fit_error"]);
        let unknown = FitError { samples: None, incidences: None, ..GOOD };
        assert_eq!(failed(unknown, limits(100.0), None, None), ["max_fit_error"]);
    }
}
