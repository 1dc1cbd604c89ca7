//! Registration of table packs as a BRDF codec.

use super::encode::encode;
use super::levels::MAX_LEVELS;
use super::recipe::{Size, TableRecipe};
use super::report::{FACTORED, TABLE, TableReport};
use super::search::recipe::{LARGEST, SearchRecipe, Tables};
use super::search::within::search_within;
use brdfc_codec::{
    AveragingCost, BrdfRecipe, Encode, EncodeError, EncodeOptions, Encoded, ErrorLimits, GridCache, OptionError,
    Predicted, Variant,
};
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_core::words::bytes;
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use serde::{Deserialize, Serialize};

/// The variant that a search chooses.
const AUTO: &str = "auto";

/// Memory of an encoding without its source, bytes; measured with a scan.
const MEMORY: u64 = 40 << 20;
/// Memory of a search at its largest table, bytes; measured with a scan.
const MEMORY_OF_SEARCH: u64 = 128 << 20;

/// Everything besides the source that decides the bytes of a pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Recipe {
    /// A table of a given size.
    Table(TableRecipe),
    /// The smallest table that meets a budget.
    Search(SearchRecipe),
}

impl Default for Recipe {
    fn default() -> Self {
        Self::Search(SearchRecipe::default())
    }
}

impl From<TableRecipe> for Recipe {
    fn from(recipe: TableRecipe) -> Self {
        Self::Table(recipe)
    }
}

impl From<SearchRecipe> for Recipe {
    fn from(recipe: SearchRecipe) -> Self {
        Self::Search(recipe)
    }
}

impl Recipe {
    /// The table, or the common recipe of all tables of a search.
    fn table(&self) -> &TableRecipe {
        match self {
            Self::Table(table) | Self::Search(SearchRecipe { table, .. }) => table,
        }
    }

    /// The same recipe, mutable.
    fn table_mut(&mut self) -> &mut TableRecipe {
        match self {
            Self::Table(table) | Self::Search(SearchRecipe { table, .. }) => table,
        }
    }
}

impl BrdfRecipe for Recipe {
    fn variant(&self) -> &'static str {
        match self {
            Self::Search(SearchRecipe { tables: Tables::Both, .. }) => AUTO,
            Self::Search(SearchRecipe { tables: Tables::Factored, .. }) => FACTORED,
            Self::Search(SearchRecipe { tables: Tables::Plain, .. }) => TABLE,
            Self::Table(table) => {
                if table.has_curve() {
                    FACTORED
                } else {
                    TABLE
                }
            }
        }
    }

    fn target(&self) -> String {
        let most = |most| format!("at most {}", bytes(most));
        match self {
            Self::Search(search) => search.budget.summary(),
            Self::Table(TableRecipe { size: Size::Bytes(bytes), .. }) => most(*bytes),
            Self::Table(TableRecipe { size: Size::Nodes(axes), .. }) => {
                format!("{} x {} x {} x {}", axes.half, axes.difference, axes.azimuth, axes.layers)
            }
        }
    }

    fn directions(&self) -> DirectionRange {
        self.table().directions
    }

    fn limit_directions(&mut self, directions: DirectionRange) {
        self.table_mut().directions = directions;
    }

    fn has_fixed_size(&self) -> bool {
        matches!(self, Self::Table(TableRecipe { size: Size::Nodes(_), .. }))
    }

    fn is_search(&self) -> bool {
        matches!(self, Self::Search(_))
    }

    fn limits_error(&self) -> bool {
        matches!(self, Self::Search(search) if search.budget.limits_error())
    }

    fn asked_errors(&self) -> ErrorLimits {
        match self {
            Self::Search(search) if search.is_asked => ErrorLimits::from(&search.budget),
            _ => ErrorLimits::default(),
        }
    }

    /// A search needs the error.
    fn skip_measuring(&mut self) {
        if let Self::Table(table) = self {
            table.measure = false;
        }
    }

    fn set_supercompress(&mut self, supercompress: bool) {
        self.table_mut().supercompress = supercompress;
    }

    fn coarser_levels(&self) -> u32 {
        self.table().levels
    }

    fn limit_coarser_levels(&mut self, most: u32) {
        let table = self.table_mut();
        table.levels = table.levels.min(most);
    }

    fn memory(&self) -> u64 {
        match self {
            Self::Table(_) => MEMORY,
            Self::Search(_) => MEMORY_OF_SEARCH,
        }
    }

    fn predict(&self) -> Predicted {
        match self {
            Self::Search(search) => {
                Predicted { least: 0, most: search.budget.bytes.map_or(LARGEST, |bytes| bytes.min(LARGEST)) }
            }
            Self::Table(TableRecipe { size: Size::Bytes(most), .. }) => Predicted { least: 0, most: *most },
            Self::Table(TableRecipe { size: Size::Nodes(axes), .. }) => {
                // A table that does not wrap around has one slice less; grey texels have half the bytes.
                let texels = |azimuth: u32| u64::from(axes.half * axes.difference * azimuth * axes.layers);
                Predicted { least: 2 * texels(axes.azimuth), most: 4 * texels(axes.azimuth + 1) }
            }
        }
    }
}

/// Options of plain tables.
const OPTIONS: [&str; 7] =
    ["max_delta_e", "min_highlight", "max_error", "max_bytes", "max_fetches", "reciprocal", "bias"];
/// Options of factored packs, and of a search among both kinds.
const FACTORED_OPTIONS: [&str; 8] =
    ["max_delta_e", "min_highlight", "max_error", "max_bytes", "max_fetches", "reciprocal", "bias", "levels"];

impl Encode for Recipe {
    type Report = TableReport;

    const VARIANTS: &'static [Variant] = &[
        Variant { name: AUTO, options: &FACTORED_OPTIONS },
        Variant { name: TABLE, options: &OPTIONS },
        Variant { name: FACTORED, options: &FACTORED_OPTIONS },
    ];

    /// The recipe of a table, or a search if it is `auto` or if error or fetches are limited.
    fn from_options(variant: &str, options: &EncodeOptions) -> Result<Self, OptionError> {
        let default = TableRecipe::default();
        let levels = options.levels.unwrap_or(0);
        if levels > MAX_LEVELS {
            return Err(EncodeOptions::out_of_range("levels", levels.to_string()));
        }
        let table = TableRecipe {
            size: options.max_bytes.map_or(default.size, Size::Bytes),
            factored: variant == FACTORED,
            levels,
            reciprocal: options.reciprocal == Some(true),
            bias: options.bias()?.unwrap_or(default.bias),
            ..default
        };
        let budget = options.budget()?;
        if variant != AUTO && !budget.limits_error() && !budget.limits_highlight() && budget.fetches.is_none() {
            return Ok(Self::Table(table));
        }
        let tables = match variant {
            AUTO if levels == 0 => Tables::Both,
            // A pack with levels has a curve.
            _ if table.has_curve() => Tables::Factored,
            _ => Tables::Plain,
        };
        let search = SearchRecipe::of_budget(budget);
        let table = TableRecipe { size: search.table.size, aim: search.table.aim, ..table };
        Ok(Self::Search(SearchRecipe { table, tables, ..search }))
    }

    fn encode(
        &self,
        source: &dyn Source,
        _: &dyn GridCache,
        progress: &dyn Progress,
    ) -> Result<Encoded<TableReport>, EncodeError> {
        let recipe = match self {
            Self::Table(recipe) => recipe,
            Self::Search(recipe) => return search_within(source, recipe, progress),
        };
        let mut made: Encoded<TableReport> = encode(source, recipe, progress)?.into();
        if recipe.reciprocal && recipe.measure {
            let reference = Reference::new(source, PairSet::within(recipe.directions));
            made.averaging = Some(AveragingCost::of(source, &reference));
        }
        Ok(made)
    }
}
