//! The recipe of a search: a budget that sizes of tables are tried against.

use brdfc_codec::{BrdfRecipe, Predicted};
use brdfc_core::words::{bytes, percent};
use brdfc_formats::crop::DirectionRange;
use brdfc_table::encode::MOST_TEXELS;
use brdfc_table::recipe::{Aim, TableRecipe};
use serde::{Deserialize, Serialize};

/// Bytes on a GPU of the largest table that a search tries.
pub(super) const LARGEST: u64 = 4 * MOST_TEXELS;
/// Memory of a search at its largest table, without its source, bytes; measured with a scan.
const MEMORY: u64 = 128 << 20;

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

impl AutoRecipe {
    /// The search for a budget, with a ΔE of [`Budget::default`] where nothing says how good or how large a pack is to be.
    pub fn of_budget(budget: Budget) -> Self {
        let is_open = !budget.limits_error() && budget.bytes.is_none();
        let delta_e = if is_open { Budget::default().delta_e } else { budget.delta_e };
        // Where ratios alone are limited, they are what tables are made for.
        let aim = if budget.error.is_some() && budget.delta_e.is_none() { Aim::Ratios } else { Aim::Pictures };
        let table = TableRecipe { aim, ..TableRecipe::default() };
        Self { budget: Budget { delta_e, ..budget }, table, tables: Tables::Both }
    }
}

impl BrdfRecipe for AutoRecipe {
    fn codec(&self) -> &'static str {
        "auto"
    }

    fn target(&self) -> String {
        let Budget { delta_e, error, bytes: most, fetches } = self.budget;
        let limits = [
            delta_e.map(|limit| format!("ΔE at most {limit}")),
            error.map(|limit| format!("ε_r at most {}", percent(limit))),
            most.map(|limit| format!("at most {}", bytes(limit))),
            fetches.map(|limit| format!("at most {limit} {}", if limit == 1 { "fetch" } else { "fetches" })),
        ];
        limits.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    fn directions(&self) -> DirectionRange {
        self.table.directions
    }

    fn limit_directions(&mut self, directions: DirectionRange) {
        self.table.directions = directions;
    }

    fn has_fixed_size(&self) -> bool {
        false
    }

    fn limits_error(&self) -> bool {
        self.budget.limits_error()
    }

    /// The search decides by the error.
    fn skip_measuring(&mut self) {}

    fn set_supercompress(&mut self, supercompress: bool) {
        self.table.supercompress = supercompress;
    }

    fn coarser_levels(&self) -> u32 {
        self.table.levels
    }

    fn limit_coarser_levels(&mut self, most: u32) {
        self.table.limit_coarser_levels(most);
    }

    fn memory(&self) -> u64 {
        MEMORY
    }

    fn predict(&self) -> Predicted {
        Predicted { least: 0, most: self.budget.bytes.map_or(LARGEST, |bytes| bytes.min(LARGEST)) }
    }
}
