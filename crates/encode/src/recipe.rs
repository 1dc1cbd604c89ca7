//! The recipe of a search: a budget that sizes of tables are tried against.

use brdfc_codec::{BrdfRecipe, Budget, Predicted};
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
