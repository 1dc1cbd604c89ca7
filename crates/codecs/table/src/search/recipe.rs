//! Recipe of a search: a budget and the tables that are tried.

use crate::encode::MAX_TEXELS;
use crate::recipe::{Aim, TableRecipe};
use brdfc_codec::{Budget, HIGHLIGHT};
use serde::{Deserialize, Serialize};

/// Bytes on a GPU of the largest table that a search tries.
pub const LARGEST: u64 = 4 * MAX_TEXELS;

/// Target of a search, and its candidates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchRecipe {
    /// Budget of the table.
    pub budget: Budget,
    /// True if the user set limits of error. Default limits do not apply to black materials.
    pub is_asked: bool,
    /// Common recipe of all tried tables; the search sets its size and `factored`.
    pub table: TableRecipe,
    /// Kinds of tables that are tried.
    pub tables: Tables,
}

/// Kinds of tables that a search tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tables {
    /// Plain tables only.
    Plain,
    /// Tables with a curve only.
    Factored,
    /// Plain tables, and tables with a curve if they may be smaller or closer.
    Both,
}

impl Default for SearchRecipe {
    fn default() -> Self {
        Self { budget: Budget::default(), is_asked: false, table: TableRecipe::default(), tables: Tables::Both }
    }
}

impl SearchRecipe {
    /// Creates the search for a budget, with the ΔE of [`Budget::default`] if neither error nor size is limited.
    pub fn of_budget(budget: Budget) -> Self {
        let is_open = !budget.limits_error() && budget.bytes.is_none();
        let delta_e = if is_open { Budget::default().delta_e } else { budget.delta_e };
        // If ratios alone are limited, tables minimise them.
        let aim = if budget.error.is_some() && budget.delta_e.is_none() { Aim::Ratios } else { Aim::Renderings };
        let table = TableRecipe { aim, ..TableRecipe::default() };
        let is_asked = budget.limits_error() || budget.limits_highlight();
        let highlight = budget.highlight.or(delta_e.map(|_| HIGHLIGHT)).filter(|least| *least > 0.0);
        Self { budget: Budget { delta_e, highlight, ..budget }, is_asked, table, tables: Tables::Both }
    }
}
