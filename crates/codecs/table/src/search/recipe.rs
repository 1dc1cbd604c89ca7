//! The recipe of a search: a budget that sizes of tables are tried against.

use crate::encode::MAX_TEXELS;
use crate::recipe::{Aim, TableRecipe};
use brdfc_codec::{Budget, HIGHLIGHT};
use serde::{Deserialize, Serialize};

/// Bytes on a GPU of the largest table that a search tries.
pub const LARGEST: u64 = 4 * MAX_TEXELS;

/// What a search is to meet, and among which tables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SearchRecipe {
    /// What a table has to meet.
    pub budget: Budget,
    /// Whether somebody asked for its limits of error: what is black is held against none.
    pub is_asked: bool,
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

impl Default for SearchRecipe {
    fn default() -> Self {
        Self { budget: Budget::default(), is_asked: false, table: TableRecipe::default(), tables: Tables::Both }
    }
}

impl SearchRecipe {
    /// The search for a budget, with a ΔE of [`Budget::default`] where nothing says how good or how large a pack is to be.
    pub fn of_budget(budget: Budget) -> Self {
        let is_open = !budget.limits_error() && budget.bytes.is_none();
        let delta_e = if is_open { Budget::default().delta_e } else { budget.delta_e };
        // Where ratios alone are limited, they are what tables are made for.
        let aim = if budget.error.is_some() && budget.delta_e.is_none() { Aim::Ratios } else { Aim::Renderings };
        let table = TableRecipe { aim, ..TableRecipe::default() };
        let is_asked = budget.limits_error() || budget.limits_highlight();
        let highlight = budget.highlight.or(delta_e.map(|_| HIGHLIGHT)).filter(|least| *least > 0.0);
        Self { budget: Budget { delta_e, highlight, ..budget }, is_asked, table, tables: Tables::Both }
    }
}
