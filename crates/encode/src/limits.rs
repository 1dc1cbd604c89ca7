//! Checks of what users limit.

use super::PackRecipe;
use super::recipe::{AutoRecipe, Budget};
use brdfc_core::words::format_number;
use brdfc_metrics::fraction::Fraction;

/// An option out of range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: found {found}; allowed {allowed}")]
pub struct OptionError {
    /// The key of the option in a manifest.
    pub field: &'static str,
    /// Its value.
    pub found: String,
    /// Values that it may have.
    pub allowed: String,
}

impl OptionError {
    /// An option with the value that was found and the values that it may have.
    pub fn new(field: &'static str, found: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self { field, found: found.into(), allowed: allowed.into() }
    }
}

impl Budget {
    /// Values of ΔE that may be a limit.
    pub const DELTA_E: &str = "1e-6 to 100";
    /// Numbers of fetches that may be a limit.
    pub const FETCHES: &str = "1 or more";

    /// A budget of these limits.
    ///
    /// # Errors
    /// The first that is out of range, under the name of its key.
    pub fn checked(
        delta_e: Option<f64>,
        error: Option<Fraction>,
        bytes: Option<u64>,
        fetches: Option<u32>,
    ) -> Result<Self, OptionError> {
        if let Some(limit) = delta_e
            && !(1e-6..=100.0).contains(&limit)
        {
            return Err(OptionError::new("max_delta_e", format_number(limit), Self::DELTA_E));
        }
        let share = |error: Fraction| {
            let wrong = |allowed: &str| OptionError::new("max_error", error.to_string(), allowed);
            let share = error.checked().map_err(|allowed| wrong(&allowed))?;
            let positive = "a positive fraction, such as 0.02 for 2 %, of 1e-9 or more";
            if share < 1e-9 { Err(wrong(positive)) } else { Ok(share) }
        };
        let error = error.map(share).transpose()?;
        if bytes == Some(0) {
            return Err(OptionError::new("max_bytes", "0", "1 or more"));
        }
        if fetches == Some(0) {
            return Err(OptionError::new("max_fetches", "0", Self::FETCHES));
        }
        Ok(Self { delta_e, error, bytes, fetches })
    }
}

impl TryFrom<Budget> for PackRecipe {
    type Error = OptionError;

    fn try_from(Budget { delta_e, error, bytes, fetches }: Budget) -> Result<Self, OptionError> {
        let budget = Budget::checked(delta_e, error.map(Fraction::bare), bytes, fetches)?;
        Ok(Self::Auto(AutoRecipe::of_budget(budget)))
    }
}
