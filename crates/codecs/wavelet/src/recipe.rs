//! Recipe of a wavelet pack, resolved before any work.

use super::log_encode::DEFAULT_BIAS;
use super::table::Grid;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::Header;

/// `ε` for [`Ranking::Visible`]: renderings show values far below the mean of the table, which grazing angles raise.
const VISIBLE_BIAS: f64 = 3e-4;

/// Target that decides the number of slices.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// `cells / ratio`, including the scaling slice; at least 1.
    Ratio(f64),
    /// The smallest number of slices whose `ε_r` on the grid, after quantisation, is at most this fraction.
    MaxError(f64),
    /// As many slices as fit into this many bytes on a GPU, after cropping.
    MaxBytes(u64),
}

/// Ranking of slices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ranking {
    /// By energy, with equal weights of cells (section 4.3): smallest error of the table.
    #[default]
    Energy,
    /// By perceptually weighted energy, see [`super::visible`]: smallest error of renderings.
    Visible,
}

impl Ranking {
    /// Names of the rankings in options.
    pub const NAMES: [(&'static str, Self); 2] = [("energy", Self::Energy), ("visible", Self::Visible)];
}

/// Everything besides the source that decides the bytes of a pack.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Recipe {
    /// Parameterisation of the two hemispheres of the table.
    pub parameterisation: Parameterisation,
    /// `N`, 1 to 6.
    pub levels: u32,
    /// Finest stored level of detail, 0 to `levels`.
    pub stored_levels: u32,
    /// 8, or 10 to 16.
    pub bits: u32,
    /// `ε` of the log encoding.
    pub bias: f64,
    /// True for a tree of each level of detail, which preserves energy; tangent-pole only. False for a single one, as in the
    /// paper.
    pub energy_preserving: bool,
    /// Target that decides the number of slices.
    pub target: Target,
    /// Ranking of slices.
    pub ranking: Ranking,
    /// Directions that the pack covers. Data that no look-up within this range reads are cropped, and errors against
    /// the source are measured within the range.
    pub directions: DirectionRange,
    /// True if the error at independent test directions is measured, too. Otherwise the pack stores an error of 0.
    pub measure_off_grid: bool,
    /// True if texels are compressed in the file.
    pub supercompress: bool,
}

impl Default for Recipe {
    /// 32 x 32 tangent-pole, 4:1, 8 bits.
    fn default() -> Self {
        Self {
            parameterisation: Parameterisation::TangentPole,
            levels: 5,
            stored_levels: 5,
            bits: 8,
            bias: DEFAULT_BIAS,
            energy_preserving: false,
            target: Target::Ratio(4.0),
            ranking: Ranking::Energy,
            directions: DirectionRange::ALL,
            measure_off_grid: true,
            supercompress: true,
        }
    }
}

impl Recipe {
    /// Slices ranked by visible error, with the matching bias: the same bytes look better.
    pub fn visible() -> Self {
        Self { ranking: Ranking::Visible, bias: VISIBLE_BIAS, ..Self::default() }
    }

    /// Header of a pack with this many channels, mean and bias.
    pub fn header(&self, channels: u32, mean: f32, bias: f32) -> Header {
        Header {
            parameterisation: self.parameterisation,
            levels: self.levels,
            stored_levels: self.stored_levels,
            channels,
            bits: self.bits,
            mean,
            bias,
            energy_preserving: self.energy_preserving,
        }
    }

    /// The grid of the table.
    pub fn grid(&self) -> Grid {
        Grid { parameterisation: self.parameterisation, levels: self.levels }
    }
}
