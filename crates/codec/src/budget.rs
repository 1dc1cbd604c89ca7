//! Limits of a pack, and checks of them.

use super::Message;
use brdfc_core::words::{bytes, format_number, percent};
use brdfc_metrics::fraction::Fraction;
use serde::{Deserialize, Serialize};

/// Error of an option that is out of range or conflicts with others.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", message(.field, .found, .allowed))]
pub struct OptionError {
    /// The key of the option in a manifest.
    pub field: &'static str,
    /// Value of the option; empty for a conflict.
    pub found: String,
    /// Valid values; for a conflict, the problem and its remedy.
    pub allowed: Message,
}

fn message(field: &str, found: &str, allowed: &Message) -> Message {
    let start = Message::default().with_key(field).with_text(": ");
    let start = if found.is_empty() { start } else { start.with_text(format!("found {found}, expected ")) };
    start.with_message(allowed)
}

impl OptionError {
    /// Creates an error from the value found and the valid values.
    pub fn new(field: &'static str, found: impl Into<String>, allowed: impl Into<Message>) -> Self {
        Self { field, found: found.into(), allowed: allowed.into() }
    }

    /// Creates an error of a conflict from the problem and its remedy.
    pub fn conflict(field: &'static str, problem: impl Into<Message>) -> Self {
        Self::new(field, "", problem)
    }

    /// The message with the positions of its keys.
    pub fn message(&self) -> Message {
        message(self.field, &self.found, &self.allowed)
    }
}

/// Limits of a pack. Absent limits do not apply.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Budget {
    /// Maximum mean ΔE of renderings; the maximum of its 95th percentile is four times as large.
    pub delta_e: Option<f64>,
    /// Minimum retained share of the highlight's light over all incoming directions, 0 to 1.
    pub highlight: Option<f64>,
    /// Maximum `ε_r` at independent test directions, a fraction.
    pub error: Option<f64>,
    /// Maximum number of bytes on a GPU.
    pub bytes: Option<u64>,
    /// Maximum number of texture fetches per look-up.
    pub fetches: Option<u32>,
}

/// Ratio of the limits of the 95th percentile and of the mean of ΔE.
pub const TAIL: f64 = 4.0;
/// Default of the minimum retained share of the highlight's light if ΔE is limited.
pub const HIGHLIGHT: f64 = 0.9;

impl Default for Budget {
    /// A mean ΔE of 0.5 with 95 % below 2: differences that are hardly visible side by side; and 90 % of the
    /// highlight's light, which renderings of a ball hide.
    fn default() -> Self {
        Self { delta_e: Some(0.5), highlight: Some(HIGHLIGHT), ..Self::NONE }
    }
}

impl Budget {
    /// No limits; a base for the builder methods. A search without a limit of ΔE, `ε_r` or bytes applies the
    /// default limit of ΔE.
    pub const NONE: Self = Self { delta_e: None, highlight: None, error: None, bytes: None, fetches: None };

    /// Sets the maximum mean ΔE of renderings, 1e-6 to 100, and the maximum 95th percentile, four times as large.
    #[must_use]
    pub fn delta_e(self, largest: f64) -> Self {
        Self { delta_e: Some(largest), ..self }
    }

    /// Sets the minimum retained share of the highlight's light, 0 (no limit) to 0.999.
    #[must_use]
    pub fn highlight(self, least: f64) -> Self {
        Self { highlight: Some(least), ..self }
    }

    /// Sets the maximum `ε_r`, a fraction.
    #[must_use]
    pub fn error(self, largest: f64) -> Self {
        Self { error: Some(largest), ..self }
    }

    /// Sets the maximum number of bytes on a GPU.
    #[must_use]
    pub fn bytes(self, most: u64) -> Self {
        Self { bytes: Some(most), ..self }
    }

    /// Sets the maximum number of texture fetches.
    #[must_use]
    pub fn fetches(self, most: u32) -> Self {
        Self { fetches: Some(most), ..self }
    }

    /// Returns true if an error limit is set.
    pub fn limits_error(&self) -> bool {
        self.delta_e.is_some() || self.error.is_some()
    }

    /// Returns true if the retained share of a highlight is limited.
    pub fn limits_highlight(&self) -> bool {
        self.highlight.is_some_and(|least| least > 0.0)
    }

    /// Summary of all limits: `ΔE at most 0.5, at most 1 fetch`.
    pub fn summary(&self) -> String {
        let Self { delta_e, highlight, error, bytes: most, fetches } = self;
        let limits = [
            delta_e.map(|limit| format!("ΔE at most {limit}")),
            highlight.filter(|least| *least > 0.0).map(|least| format!("{} of the highlight", percent(least))),
            error.map(|limit| format!("ε_r at most {}", percent(limit))),
            most.map(|limit| format!("at most {}", bytes(limit))),
            fetches.map(|limit| format!("at most {limit} {}", if limit == 1 { "fetch" } else { "fetches" })),
        ];
        limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// Valid limits of ΔE.
    pub const DELTA_E: &str = "1e-6 to 100";
    /// Valid limits of the highlight.
    pub const HIGHLIGHTS: &str = "0 to 0.999, such as 0.9 or 90%";
    /// Valid limits of fetches.
    pub const FETCHES: &str = "1 or more";

    /// Creates a budget from these limits.
    ///
    /// # Errors
    /// Returns an error for the first limit that is out of range, with the name of its key.
    pub fn checked(
        delta_e: Option<f64>,
        highlight: Option<Fraction>,
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
            let positive = "a positive fraction of 1e-9 or more, such as 0.02 for 2 %";
            if share < 1e-9 { Err(wrong(positive)) } else { Ok(share) }
        };
        let error = error.map(share).transpose()?;
        let least = |share: Fraction| match share.checked() {
            Ok(least) if least <= 0.999 => Ok(least),
            _ => Err(OptionError::new("min_highlight", share.to_string(), Self::HIGHLIGHTS)),
        };
        let highlight = highlight.map(least).transpose()?;
        if bytes == Some(0) {
            return Err(OptionError::new("max_bytes", "0", "1 or more"));
        }
        if fetches == Some(0) {
            return Err(OptionError::new("max_fetches", "0", Self::FETCHES));
        }
        Ok(Self { delta_e, highlight, error, bytes, fetches })
    }
}
