//! What decides the bytes of a pack: a codec with its recipe, or a budget that codecs and sizes are tried against.

use brdfc_formats::crop::DirectionRange;
use brdfc_table::recipe::TableRecipe;
use brdfc_wavelet::recipe::{Recipe, Target};
use serde::{Deserialize, Serialize};

/// How a material becomes a pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum PackRecipe {
    /// The smallest table, plain or factored, that meets a budget.
    Auto(AutoRecipe),
    /// A table of one size, plain or factored.
    Table(TableRecipe),
    /// A wavelet pack.
    Wavelet(Recipe),
}

/// What a search is to meet, and among which packs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AutoRecipe {
    /// What a pack has to meet.
    pub budget: Budget,
    /// What all tables that are tried have in common; its size is not looked at, nor whether it is factored.
    pub table: TableRecipe,
    /// Which tables are tried.
    pub tables: Tables,
}

/// Which tables a search tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tables {
    /// Tables alone.
    Plain,
    /// Tables with a curve.
    Factored,
    /// Tables alone, and those with a curve where they may be smaller or closer.
    Both,
}

/// Limits of a pack. Those that are absent are none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Budget {
    /// Largest mean ΔE*ab of pictures, and four times that for its 95th percentile.
    pub delta_e: Option<f64>,
    /// Largest `ε_r` off the grid, a fraction.
    pub error: Option<f64>,
    /// Most bytes on a GPU.
    pub bytes: Option<u64>,
    /// Most texture fetches of a look-up.
    pub fetches: Option<u32>,
}

/// The 95th percentile of ΔE may be so many times the mean that is allowed.
pub const TAIL: f64 = 4.0;

impl Default for Budget {
    /// A mean ΔE of 0.5 with 95 % below 2: differences that are hardly seen side by side.
    fn default() -> Self {
        Self { delta_e: Some(0.5), error: None, bytes: None, fetches: None }
    }
}

impl Budget {
    /// No limit yet: what is added makes it one. Where nothing says how good or how large a pack is to be, the ΔE of the default
    /// decides.
    pub const NONE: Self = Self { delta_e: None, error: None, bytes: None, fetches: None };

    /// With a largest mean ΔE*ab of pictures, 1e-6 to 100, and four times that for the 95th percentile.
    #[must_use]
    pub fn delta_e(self, largest: f64) -> Self {
        Self { delta_e: Some(largest), ..self }
    }

    /// With a largest `ε_r`, a fraction.
    #[must_use]
    pub fn error(self, largest: f64) -> Self {
        Self { error: Some(largest), ..self }
    }

    /// With a number of bytes on a GPU that is the most.
    #[must_use]
    pub fn bytes(self, most: u64) -> Self {
        Self { bytes: Some(most), ..self }
    }

    /// With a number of texture fetches that is the most.
    #[must_use]
    pub fn fetches(self, most: u32) -> Self {
        Self { fetches: Some(most), ..self }
    }

    /// Whether it says how good a pack has to be.
    pub fn limits_error(&self) -> bool {
        self.delta_e.is_some() || self.error.is_some()
    }
}

impl Default for AutoRecipe {
    fn default() -> Self {
        Self { budget: Budget::default(), table: TableRecipe::default(), tables: Tables::Both }
    }
}

impl Default for PackRecipe {
    fn default() -> Self {
        Self::Auto(AutoRecipe::default())
    }
}

impl PackRecipe {
    /// Whether texels are compressed in the file.
    pub fn set_supercompress(&mut self, supercompress: bool) {
        match self {
            Self::Auto(recipe) => recipe.table.supercompress = supercompress,
            Self::Table(recipe) => recipe.supercompress = supercompress,
            Self::Wavelet(recipe) => recipe.supercompress = supercompress,
        }
    }

    /// Whether a limit of error decides how large the pack becomes.
    pub fn limits_error(&self) -> bool {
        match self {
            Self::Auto(recipe) => recipe.budget.limits_error(),
            Self::Table(_) => false,
            Self::Wavelet(recipe) => matches!(recipe.target, Target::MaxError(_)),
        }
    }

    /// Leaves the error off the grid alone where nothing is chosen by it.
    #[must_use]
    pub fn without_measuring(mut self) -> Self {
        match &mut self {
            Self::Auto(_) => {}
            Self::Table(recipe) => recipe.measure = false,
            Self::Wavelet(recipe) => recipe.measure_off_grid = false,
        }
        self
    }

    /// Packs hold what look-ups within a range of directions touch.
    pub fn limit_directions(&mut self, directions: DirectionRange) {
        match self {
            Self::Auto(recipe) => recipe.table.directions = directions,
            Self::Table(recipe) => recipe.directions = directions,
            Self::Wavelet(recipe) => recipe.directions = directions,
        }
    }

    /// Directions that packs are for.
    pub fn directions(&self) -> DirectionRange {
        match self {
            Self::Auto(recipe) => recipe.table.directions,
            Self::Table(recipe) => recipe.directions,
            Self::Wavelet(recipe) => recipe.directions,
        }
    }

    /// Table packs have no coarser levels of detail than this many.
    pub fn limit_coarser_levels(&mut self, most: u32) {
        let table = match self {
            Self::Auto(recipe) => &mut recipe.table,
            Self::Table(recipe) => recipe,
            Self::Wavelet(_) => return,
        };
        table.levels = table.levels.min(most);
    }

    /// Wavelet packs store no finer levels of detail than this gives for the number of levels.
    pub fn limit_levels(&mut self, stored: impl Fn(u32) -> u32) {
        if let Self::Wavelet(recipe) = self {
            recipe.stored_levels = stored(recipe.levels);
        }
    }
}
