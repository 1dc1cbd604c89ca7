//! At how many pixels lobes are transformed.

use serde::{Deserialize, Serialize};

/// Smallest and largest number of pixels per side that may be asked for.
pub const RESOLUTIONS: [usize; 2] = [32, 1024];
/// The same where nothing is asked for.
pub const AUTOMATIC: [usize; 2] = [64, 256];

/// Pixels per side of a lobe's image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Resolution {
    /// Doubled from the first of [`AUTOMATIC`] until no lobe is [too narrow], up to the last.
    ///
    /// [too narrow]: super::lobe::LobeBandwidth::narrow
    #[default]
    Automatic,
    /// A power of two within [`RESOLUTIONS`].
    Fixed(usize),
}

impl Resolution {
    /// What is tried one after the other.
    pub fn steps(self) -> impl Iterator<Item = usize> {
        let [first, last] = match self {
            Self::Automatic => AUTOMATIC,
            Self::Fixed(side) => [side; 2],
        };
        std::iter::successors(Some(first), |side| Some(2 * side)).take_while(move |side| *side <= last)
    }
}
