//! Settings of a pack.

use crate::lifting::Wavelet;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightCoordinates, MAX_DEGREE};

/// Name of a domain, without its parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DomainName {
    /// Linear values.
    Linear,
    /// sRGB-encoded values.
    Display,
    /// Cube roots.
    CubeRoot,
    /// Logarithms of values plus `ε`.
    Log,
}

impl DomainName {
    /// All domains.
    pub const ALL: [Self; 4] = [Self::Linear, Self::Display, Self::CubeRoot, Self::Log];

    /// Name in scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Display => "display",
            Self::CubeRoot => "cube-root",
            Self::Log => "log",
        }
    }
}

/// Target of a pack. The encoder builds the smallest pack that meets it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// Maximum loss against the PSNR at held-out lights before truncation, dB.
    Loss(f64),
    /// PSNR of sRGB-encoded values, dB.
    Quality(f64),
    /// Mean ΔE (CIE76).
    DeltaE(f64),
    /// Share of the squared error that terms and details remove, 0 to 1.
    Energy(f64),
    /// Maximum bytes on a GPU, mipmaps included.
    Bytes(u64),
}

/// Settings of a pack. Settings that are `None` are chosen by measurement.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct PwtRecipe {
    /// Coordinates of the polynomials, or learned terms.
    pub coordinates: Option<LightCoordinates>,
    /// Highest degree of the polynomials, or the number of learned terms.
    pub degree: Option<u32>,
    /// `λ` of the penalty on roughness.
    pub ridge: Option<f64>,
    /// Domain of the fitted values.
    pub domain: Option<DomainName>,
    /// Wavelet of the tree.
    pub wavelet: Wavelet,
    /// Levels of the tree; `None` for 5, or as many as the sides allow.
    pub depth: Option<u32>,
    /// Number of further splits of details.
    pub packets: u32,
    /// Maximum number of texture fetches of a look-up; `None` for any.
    pub max_fetches: Option<u32>,
    /// Target of the pack, such as a PSNR or a number of bytes.
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
            max_fetches: None,
            target: Target::Loss(0.3),
        }
    }
}

impl PwtRecipe {
    /// Maximum levels of a tree.
    pub const MAX_DEPTH: u32 = 8;
    /// Maximum number of further splits.
    pub const MAX_PACKETS: u32 = 4;
    /// Maximum number of fetches.
    pub const MAX_FETCHES: u32 = brdfc_formats::pwt::MAX_COMPONENTS as u32 / 4;

    /// Maximum number of learned terms, without the mean.
    pub(crate) fn most_learned(&self) -> usize {
        let of_fetches = 4 * self.max_fetches.unwrap_or(Self::MAX_FETCHES);
        self.degree.unwrap_or(of_fetches).min(LightCoordinates::Learned.max_degree()) as usize
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// Returns an error that names the setting that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let (least, most) = match self.coordinates {
            Some(LightCoordinates::Learned) => (1, LightCoordinates::Learned.max_degree()),
            _ => (0, MAX_DEGREE),
        };
        FormatError::check_range("degree", self.degree.unwrap_or(least), least..=most)?;
        FormatError::check_range("max-fetches", self.max_fetches.unwrap_or(1), 1..=Self::MAX_FETCHES)?;
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
