//! What decides the bytes of a pack: the recipe, resolved before any work.

use super::log_encode::DEFAULT_BIAS;
use super::table::Grid;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::Parameterisation;

/// `ε` that goes with [`Ranking::Visible`]: renderings show values far below the mean of the table, which grazing angles raise.
const VISIBLE_BIAS: f64 = 3e-4;

/// How many slices are kept.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// `cells / ratio`, the scaling slice included; at least 1.
    Ratio(f64),
    /// The fewest whose `ε_r` on the grid, after quantisation, is at most this fraction.
    MaxError(f64),
    /// As many as fit into this many bytes on a GPU, of what is left where directions are cropped.
    MaxBytes(u64),
}

/// Which slices are the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Ranking {
    /// By energy, all cells alike (section 4.3): smallest error of the table.
    #[default]
    Energy,
    /// By energy weighted with what is seen, see [`super::visible`]: smallest error of renderings.
    Visible,
}

impl Ranking {
    /// The names that scripts use.
    pub const NAMES: [(&'static str, Self); 2] = [("energy", Self::Energy), ("visible", Self::Visible)];
}

/// Everything that decides the bytes of a pack, besides the source.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Recipe {
    /// What the two hemispheres of the table are.
    pub parameterisation: Parameterisation,
    /// `N`, 1 to 6.
    pub levels: u32,
    /// Finest level of detail that is needed, 0 to `levels`; finer slices are not stored.
    pub stored_levels: u32,
    /// 8, or 10 to 16.
    pub bits: u32,
    /// `ε` of the log encoding.
    pub bias: f64,
    /// Whether the table is smoothed.
    pub smooth: bool,
    /// Whether levels of detail and dropped slices keep the light that is sent out; tangent-pole only.
    pub lift: bool,
    /// How many slices are kept.
    pub target: Target,
    /// Which slices are kept.
    pub ranking: Ranking,
    /// Directions that are needed: what no look-up within them touches is cropped, and errors off the grid are those within.
    pub directions: DirectionRange,
    /// Whether the error off the grid is measured, too. Without, what the pack says of it is 0.
    pub measure_off_grid: bool,
    /// Whether texels are compressed in the file.
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
            smooth: false,
            lift: false,
            target: Target::Ratio(4.0),
            ranking: Ranking::Energy,
            directions: DirectionRange::ALL,
            measure_off_grid: true,
            supercompress: true,
        }
    }
}

impl Recipe {
    /// Slices ranked by what is seen, with the bias that goes with it: the same bytes look better.
    pub fn visible() -> Self {
        Self { ranking: Ranking::Visible, bias: VISIBLE_BIAS, ..Self::default() }
    }

    /// The grid of the table.
    pub fn grid(&self) -> Grid {
        Grid { parameterisation: self.parameterisation, levels: self.levels }
    }
}
