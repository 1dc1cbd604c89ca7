//! Checks of the fit that a pack of a scan was made from.

use super::gate::GateResult;
use super::material::MaterialReport;
use brdfc_codec::{ErrorLimits, FitLimits};
use brdfc_core::words::percent;
use brdfc_metrics::compare::is_black;

/// Holds the fit against its limits, and the error against the sampled material, the fit's included, against those of the pack.
/// Sources that are not completed from samples have no fit, and pass.
pub fn check(limits: FitLimits, errors: ErrorLimits, report: &MaterialReport) -> Vec<GateResult> {
    let mut results = Vec::new();
    let Some(fit) = &report.fit else { return results };
    let none = || "too few samples to leave any out".to_owned();
    if let Some(limit) = limits.error {
        let (found, passed) = match fit.error() {
            _ if is_black(report.off_grid.mean) => ("no light: the material is black".to_owned(), false),
            Some(found) => (percent(found), found <= limit),
            None => (none(), false),
        };
        results.push(GateResult::new("max_fit_error", found, percent(limit), passed));
    }
    if limits.trusted || errors == ErrorLimits::default() {
        return results;
    }
    let mut closed = |found: String, allowed: &str| {
        results.push(GateResult::new("fit", found, format!("{allowed}, or trust_fit"), false));
    };
    if let Some(gaps) = fit.gaps() {
        closed(gaps, "samples that say what the material is");
    }
    // As of independent errors.
    if let (Some(limit), Some(of_fit)) = (errors.delta_e, fit.delta_e) {
        let of_pack = report.off_grid.picture.delta_e.mean;
        let all = of_pack.hypot(of_fit);
        // What the pack misses by itself is reported of the pack.
        if all > limit && (of_pack <= limit || of_fit > limit) {
            let found = format!(
                "a ΔE of about {all:.2} against the material, {of_pack:.2} of the pack and {of_fit:.2} of the fit"
            );
            closed(found, &format!("{limit}"));
        }
    }
    if let (Some(limit), Some(of_fit)) = (errors.relative, fit.error()) {
        let of_pack = report.off_grid.norms.relative_mean;
        let all = of_pack.hypot(of_fit);
        // Likewise; limits of wavelet packs are on their grid.
        if all > limit && (of_pack <= limit || of_fit > limit) {
            let [all, of_pack, of_fit] = [all, of_pack, of_fit].map(percent);
            let found =
                format!("ε_r of about {all} against the material, {of_pack} of the pack and {of_fit} of the fit");
            closed(found, &percent(limit));
        }
    }
    results
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
        report.off_grid.picture.delta_e.mean = 0.4;
        report.off_grid.norms.relative_mean = 0.04;
        MaterialReport { fit, ..report }
    }

    fn closed(fit: FitError, limits: FitLimits, delta_e: Option<f64>, relative: Option<f64>) -> Vec<String> {
        let results = check(limits, ErrorLimits { delta_e, relative }, &report(Some(fit)));
        results.into_iter().filter(|gate| !gate.passed).map(|gate| gate.gate).collect()
    }

    #[test]
    fn limits_are_held_against_pack_and_fit_together() {
        let none = FitLimits::default();
        // 0.5 together, and 5 %.
        assert!(closed(GOOD, none, Some(0.51), Some(0.051)).is_empty());
        assert_eq!(closed(GOOD, none, Some(0.49), None), ["fit"]);
        assert_eq!(closed(GOOD, none, None, Some(0.049)), ["fit"]);
        // The pack misses it by itself.
        assert!(closed(GOOD, none, Some(0.35), None).is_empty());
        assert_eq!(closed(GOOD, none, Some(0.2), None), ["fit"]);
        // Nobody asked.
        assert!(closed(GOOD, none, None, None).is_empty());
        let trusted = FitLimits { trusted: true, ..none };
        assert!(closed(GOOD, trusted, Some(0.1), Some(0.01)).is_empty());
        assert!(check(none, ErrorLimits { delta_e: Some(0.1), relative: None }, &report(None)).is_empty());
    }

    #[test]
    fn gaps_and_contradictions_close_it_whatever_the_limit() {
        let rise = |ratio, peak| Some(Rise { incidence: 60.0, nearest: 4.0, next: 8.0, ratio, peak });
        let repeats = |share, spread| Some(Repeats { pairs: 9, share, spread, largest: spread });
        for (fit, closes) in [
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
            assert_eq!(!closed(fit, FitLimits::default(), Some(100.0), None).is_empty(), closes, "{fit:?}");
            let trusted = FitLimits { trusted: true, ..FitLimits::default() };
            assert!(closed(fit, trusted, Some(100.0), None).is_empty());
        }
    }

    #[test]
    fn the_error_of_a_fit_has_a_limit_of_its_own() {
        let limits = |error| FitLimits { error: Some(error), trusted: true };
        assert!(closed(GOOD, limits(0.03), None, None).is_empty());
        assert_eq!(closed(GOOD, limits(0.029), None, None), ["max_fit_error"]);
        let unknown = FitError { samples: None, incidences: None, ..GOOD };
        assert_eq!(closed(unknown, limits(100.0), None, None), ["max_fit_error"]);
    }
}
