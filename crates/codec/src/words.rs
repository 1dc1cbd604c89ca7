//! Formatted figures of packs.

use brdfc_core::words::percent;
use brdfc_formats::ErrorSummary;

/// Formats the errors of a pack in one line.
pub fn format_errors(errors: &ErrorSummary) -> String {
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
