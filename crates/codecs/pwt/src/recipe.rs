//! What decides a pack besides its renderings.

use crate::lifting::Wavelet;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightCoordinates, MAX_DEGREE};

/// The name of a domain, without what is found for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainName {
    /// Linear values.
    Linear,
    /// Codes of sRGB.
    Display,
    /// Cube roots.
    CubeRoot,
    /// Logarithms of what is a little larger.
    Log,
}

impl DomainName {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Display, Self::CubeRoot, Self::Log];

    /// The name that scripts use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Display => "display",
            Self::CubeRoot => "cube-root",
            Self::Log => "log",
        }
    }
}

/// What a pack is to meet. The smallest one that does is made.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// At most so many dB below what is reached at unseen lights before anything is left out.
    Loss(f64),
    /// Signal-to-noise ratio of sRGB codes, dB.
    Quality(f64),
    /// Mean ΔE (CIE76).
    DeltaE(f64),
    /// Share of the squared error that terms and details take away, 0 to 1.
    Energy(f64),
    /// Most bytes on a GPU, mipmaps included.
    Bytes(u64),
}

/// Everything that decides a pack besides its renderings. What is `None` is chosen by measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtRecipe {
    /// In what the terms are polynomials.
    pub coordinates: Option<LightCoordinates>,
    /// Highest degree.
    pub degree: Option<u32>,
    /// `λ` of the penalty on roughness.
    pub ridge: Option<f64>,
    /// The scale of values that are fitted.
    pub domain: Option<DomainName>,
    /// The wavelet.
    pub wavelet: Wavelet,
    /// Levels of the tree; `None` for as many as 5 and the sides allow.
    pub depth: Option<u32>,
    /// How often details are split further.
    pub packets: u32,
    /// What to meet.
    pub target: Target,
}

impl Default for PwtRecipe {
    fn default() -> Self {
        Self {
            coordinates: None,
            degree: None,
            ridge: None,
            domain: None,
            wavelet: Wavelet::Haar,
            depth: None,
            packets: 1,
            target: Target::Loss(0.3),
        }
    }
}

impl PwtRecipe {
    /// Deepest tree.
    pub const MAX_DEPTH: u32 = 8;
    /// Most further splits.
    pub const MAX_PACKETS: u32 = 4;

    /// Whether everything is in range.
    ///
    /// # Errors
    /// Names what is not.
    pub fn check(&self) -> Result<(), FormatError> {
        FormatError::check_range("degree", self.degree.unwrap_or_default(), 0..=MAX_DEGREE)?;
        FormatError::check_range("ridge", self.ridge.unwrap_or_default(), 0.0..=1e6)?;
        FormatError::check_range("levels", self.depth.unwrap_or_default(), 0..=Self::MAX_DEPTH)?;
        FormatError::check_range("packets", self.packets, 0..=Self::MAX_PACKETS)?;
        let (field, number, range) = match self.target {
            Target::Loss(loss) => ("loss", loss, 0.0..=100.0),
            Target::Quality(decibels) => ("quality", decibels, 0.0..=200.0),
            Target::DeltaE(delta_e) => ("delta E", delta_e, 0.0..=1000.0),
            Target::Energy(share) => ("energy", share, 0.0..=1.0),
            Target::Bytes(bytes) => ("bytes", bytes as f64, 1.0..=1e12),
        };
        FormatError::check_range(field, number, range)
    }
}
