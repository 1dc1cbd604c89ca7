//! Figures of packs as people read them.

use brdfc_core::words::percent;
use brdfc_formats::ErrorSummary;

/// The errors of a pack in one line.
pub fn errors_in_words(errors: &ErrorSummary) -> String {
    let ratio = |value: f32| percent(f64::from(value));
    format!(
        "ε_r {} (95 %: {}, 99 %: {}, largest: {}), ε {:.3e} 1/sr, reciprocity {}",
        ratio(errors.relative_mean),
        ratio(errors.relative_p95),
        ratio(errors.relative_p99),
        ratio(errors.relative_max),
        errors.rms,
        ratio(errors.reciprocity)
    )
}
