//! Request to smooth measured values.

use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Smoothing of measured values before they are used: `true`, `false` or a radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Smooth {
    /// True for a strength that left-out values choose.
    Chosen(bool),
    /// Number of cells of a dense table on each side of a fit.
    Radius(usize),
}

impl Smooth {
    /// Valid radii. A quadratic through fewer cells follows their noise.
    pub const RADII: RangeInclusive<usize> = 2..=16;
    /// Description of valid values, for messages.
    pub const ALLOWED: &str = "true, false, or a radius of 2 to 16 cells";

    /// The radius, if any, of smoothing that is requested.
    pub fn strength(self) -> Option<Option<usize>> {
        match self {
            Self::Chosen(is_requested) => is_requested.then_some(None),
            Self::Radius(radius) => Some(Some(radius)),
        }
    }
}

impl FromStr for Smooth {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let radius = || text.parse().ok().filter(|radius| Self::RADII.contains(radius)).map(Self::Radius);
        let parsed = text.parse().map(Self::Chosen).ok().or_else(radius);
        parsed.ok_or_else(|| format!("expected {}", Self::ALLOWED))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switches_and_radii() {
        for (text, smooth) in
            [("true", Smooth::Chosen(true)), ("false", Smooth::Chosen(false)), ("3", Smooth::Radius(3))]
        {
            assert_eq!(text.parse(), Ok(smooth));
        }
        for text in ["", "yes", "1", "17", "-2", "2.5"] {
            assert_eq!(text.parse::<Smooth>(), Err(format!("expected {}", Smooth::ALLOWED)), "{text}");
        }
    }
}
