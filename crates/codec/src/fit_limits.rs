//! Limits for the fit of a source that is completed from samples.

use super::{Budget, EncodeOptions, OptionError};

/// Limits of a fit. They decide whether a measured error counts; the pack stays the same.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FitLimits {
    /// Maximum `ε_r` of held-out samples, and of held-out incidences.
    pub error: Option<f64>,
    /// True if limits of a pack's error count as met even where the fit has the larger error.
    pub trusted: bool,
}

/// Limits of a pack's error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ErrorLimits {
    /// Maximum mean ΔE of renderings; `None` for no limit.
    pub delta_e: Option<f64>,
    /// Maximum relative error `ε_r`, a fraction; `None` for no limit.
    pub relative: Option<f64>,
}

impl ErrorLimits {
    /// Takes the lower of the two limits of each error.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let least = |a: Option<f64>, b: Option<f64>| [a, b].into_iter().flatten().reduce(f64::min);
        Self { delta_e: least(self.delta_e, other.delta_e), relative: least(self.relative, other.relative) }
    }
}

impl From<&Budget> for ErrorLimits {
    fn from(budget: &Budget) -> Self {
        Self { delta_e: budget.delta_e, relative: budget.error }
    }
}

impl EncodeOptions {
    /// Limits of the fit.
    ///
    /// # Errors
    /// Returns an error for a value out of range.
    pub fn fit_limits(&self) -> Result<FitLimits, OptionError> {
        let share = |error: brdfc_metrics::fraction::Fraction| {
            error.checked().map_err(|allowed| OptionError::new("max_fit_error", error.to_string(), allowed))
        };
        Ok(FitLimits { error: self.max_fit_error.map(share).transpose()?, trusted: self.trust_fit == Some(true) })
    }
}
