//! Recipe of lobes.

use brdfc_formats::FormatError;
use brdfc_formats::lobes::MAX_LOBES;
use serde::{Deserialize, Serialize};

/// Maximum mean ΔE without other limits: about the smallest visible difference.
pub const DEFAULT_DELTA_E: f64 = 1.0;
/// Maximum number of look-ups without other limits.
pub const DEFAULT_FETCHES: usize = 16;
/// Numbers of look-ups to try.
const COUNTS: [usize; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32];

/// Limits of the lobes of a material.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LobesRecipe {
    /// Maximum number of look-ups, 1 to 32.
    pub max_fetches: usize,
    /// Maximum mean ΔE in environments that the fit did not use. The smallest number of look-ups that meets it is
    /// selected; without it, the number with the smallest error.
    pub max_delta_e: Option<f64>,
}

impl Default for LobesRecipe {
    fn default() -> Self {
        Self { max_fetches: DEFAULT_FETCHES, max_delta_e: Some(DEFAULT_DELTA_E) }
    }
}

impl LobesRecipe {
    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the number that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        FormatError::check_range("look-ups of lobes", self.max_fetches, 1..=MAX_LOBES)?;
        match self.max_delta_e {
            Some(most) if !(most > 0.0 && most.is_finite()) => {
                Err(FormatError::whole("maximum ΔE", most.to_string(), "a positive number"))
            }
            _ => Ok(()),
        }
    }

    /// Numbers of look-ups to try, from few to many.
    pub(crate) fn counts(&self) -> Vec<usize> {
        let below = COUNTS.into_iter().filter(|count| *count < self.max_fetches);
        below.chain([self.max_fetches]).collect()
    }
}
