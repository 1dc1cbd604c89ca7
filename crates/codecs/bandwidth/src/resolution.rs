//! Resolution at which lobes are transformed.

use serde::{Deserialize, Serialize};

/// Smallest and largest number of pixels per side that callers may choose.
pub const RESOLUTIONS: [usize; 2] = [32, 1024];
/// Smallest and largest number of pixels per side of [`Resolution::Automatic`].
pub const AUTOMATIC: [usize; 2] = [64, 256];

/// Pixels per side of a lobe's image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Resolution {
    /// Doubled from the first of [`AUTOMATIC`] until no lobe is [too narrow], up to the last.
    ///
    /// [too narrow]: super::lobe::LobeBandwidth::narrow
    Automatic,
    /// A power of two within [`RESOLUTIONS`].
    Fixed(usize),
}

impl Default for Resolution {
    /// 64 pixels: sufficient for all but mirrors and narrow highlights, and sixteen times faster than 256.
    fn default() -> Self {
        Self::Fixed(AUTOMATIC[0])
    }
}

impl Resolution {
    /// Parses a number of pixels, or `auto`.
    pub fn parse(text: &str) -> Option<Self> {
        let [least, most] = RESOLUTIONS;
        let allowed = |side: &usize| side.is_power_of_two() && (least..=most).contains(side);
        if text == "auto" { Some(Self::Automatic) } else { text.parse().ok().filter(allowed).map(Self::Fixed) }
    }

    /// Resolutions to try, in order.
    pub fn steps(self) -> impl Iterator<Item = usize> {
        let [first, last] = match self {
            Self::Automatic => AUTOMATIC,
            Self::Fixed(side) => [side; 2],
        };
        std::iter::successors(Some(first), |side| Some(2 * side)).take_while(move |side| *side <= last)
    }
}
