//! How a user asks for a pack: the flags of the command line and the keys of a manifest, which are the same.

use super::byte_count::bytes_from_manifest;
#[cfg(feature = "clap")]
use super::byte_count::bytes_from_text;
use super::encoders::table::levels::MOST_LEVELS;
use super::encoders::table::recipe::{Size, TableRecipe};
use super::encoders::wavelet::recipe::{Ranking, Recipe, Target};
use super::recipe::{AutoRecipe, Budget, Tables};
use super::{OptionError, PackRecipe};
#[cfg(feature = "clap")]
use crate::whole_number::{any_whole_number, whole_number};
use brdfc_core::words::format_number;
use brdfc_formats::wavelet::MAX_LEVELS;
use brdfc_metrics::fraction::Fraction;

/// Options of an encoding; what is absent is left open. Each field is a flag (`--max-error`) and a key (`max_error`), and
/// its comment is the help of the flag; `docs/scene.md` describes the keys.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct EncodeOptions {
    /// Which codec: auto (default: the smallest table that meets the budget, plain or factored),
    /// table (of 16 KiB unless there is a budget), factored (a table and a curve for narrow highlights, one fetch more),
    /// or wavelet (the paper's, its slices ranked by what is seen).
    #[cfg_attr(feature = "clap", arg(long, value_name = "CODEC"))]
    pub codec: Option<String>,
    /// Largest mean ΔE of pictures of the pack and its source, 1e-6 to 100, with 95 % below four times that (default 0.5).
    /// Sizes are tried in steps of two: the pack that is kept may be almost twice as large as the smallest that would do.
    #[cfg_attr(
        feature = "clap",
        arg(id = "pack_delta_e", long = "max-delta-e", value_name = "E", conflicts_with = "ratio")
    )]
    pub max_delta_e: Option<f64>,
    /// Largest mean relative error ε_r: a fraction or a percentage, 0.02 or 2%. Of wavelet packs on their grid. Sizes are
    /// tried as for --max-delta-e.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E", conflicts_with = "ratio"))]
    pub max_error: Option<Fraction>,
    /// Most bytes on a GPU, before any compression of the file: a number, or one with KiB, MiB or GiB, such as 16KiB. Alone it
    /// asks for the pack with the smallest mean ΔE that fits; tables have up to 512 KiB.
    #[cfg_attr(feature = "clap", arg(long, value_name = "B", value_parser = bytes_from_text, conflicts_with = "ratio"))]
    #[serde(default, deserialize_with = "bytes_from_manifest")]
    pub max_bytes: Option<u64>,
    /// Most texture fetches of a look-up: 1 is a table of an isotropic material, 2 of any, one more is a factored pack,
    /// 84 a wavelet pack.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=u64::MAX), conflicts_with = "ratio")
    )]
    pub max_fetches: Option<u32>,
    /// Values that do not change when light and viewer do, as path tracers need them: the mean of both ways. Of table
    /// packs.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub reciprocal: Option<bool>,
    /// Table packs: levels of detail besides the finest, 0 (default) to 6, for surfaces whose bumps are seen from afar. They
    /// keep the energy, and make a pack a factored one.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = whole_number::<u32>(0..=MOST_LEVELS.into())))]
    pub levels: Option<u32>,
    /// Wavelet: keep one slice in R, 1 to 4096 (default 4).
    #[cfg_attr(feature = "clap", arg(long, value_name = "R"))]
    pub ratio: Option<f64>,
    /// Wavelet: cells per axis and hemisphere, 2, 4, 8, 16, 32 or 64 (default 32).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<usize>(GRIDS)))]
    pub grid: Option<usize>,
    /// Wavelet: what the two hemispheres are: tangent-pole, incoming and outgoing.
    #[cfg_attr(feature = "clap", arg(long, value_name = "P"))]
    pub parameterisation: Option<String>,
    /// Wavelet: bits per component, 8 (default), or 10 to 16 in a texture of 16 bits.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<u32>(BITS)))]
    pub bits: Option<u32>,
    /// Bias ε of the logarithm ln(f/μ + ε), 1e-6 to 1 (default 0.01 of wavelet packs, 0.0001 of tables): values far below
    /// ε times the mean are lost. Without a codec it asks for a wavelet pack.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub bias: Option<f64>,
    /// Wavelet: which slices are kept, energy (smallest error of the table; default unless the codec is named) or visible
    /// (smallest error of pictures: what grazing angles and darkness hide counts less; goes with --bias 0.0003).
    #[cfg_attr(feature = "clap", arg(long, value_name = "BY"))]
    pub ranking: Option<String>,
    /// Wavelet: keep the light. Coarser levels of detail and slices that are left out do not darken what is seen; means are
    /// those of reflectances, not of logarithms.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub lift: Option<bool>,
    /// Wavelet: smooth the table by moving least squares first, for noisy dense data. Scans are smoothed anyway.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub smooth: Option<bool>,
}

/// Grids that there may be.
const GRIDS: &str = "2, 4, 8, 16, 32 or 64";
/// Bits per component that there may be.
const BITS: &str = "8, or 10 to 16";

impl TryFrom<EncodeOptions> for PackRecipe {
    type Error = OptionError;

    fn try_from(options: EncodeOptions) -> Result<Self, OptionError> {
        options.resolve(&EncodeOptions::default())
    }
}

/// Which values an option may have, in words; empty where its kind says all.
pub(crate) fn range_of(field: &str) -> &'static str {
    match field {
        "codec" => "auto, table, factored or wavelet",
        "max_delta_e" => Budget::DELTA_E,
        "max_fetches" => Budget::FETCHES,
        "levels" => "0 to 6",
        "ratio" => "1 to 4096",
        "grid" => GRIDS,
        "bits" => BITS,
        "parameterisation" => TANGENT_POLE,
        "ranking" => "energy or visible",
        "bias" => "1e-6 to 1",
        _ => "",
    }
}

/// The parameterisation of wavelet packs that are made; those over half-difference angles are read only.
const TANGENT_POLE: &str = "tangent-pole";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Codec {
    Auto,
    Table,
    Factored,
    Wavelet,
}

const CODECS: [(&str, Codec); 4] =
    [("auto", Codec::Auto), ("table", Codec::Table), ("factored", Codec::Factored), ("wavelet", Codec::Wavelet)];

impl EncodeOptions {
    /// The recipe of these options; what they leave open comes from `defaults`, then from [`PackRecipe::default`].
    ///
    /// Limits are taken from one of both, all together. Defaults that do not go with the codec that these options name, or ask
    /// for by what one codec alone has, are left out.
    ///
    /// # Errors
    /// Values out of range; options that do not go together.
    pub fn resolve(&self, defaults: &Self) -> Result<PackRecipe, OptionError> {
        // Named here, or asked for by what stands here.
        let asked = match self.codec.as_deref().map(codec).transpose()? {
            None if self.of_wavelet().is_some() => Some(Codec::Wavelet),
            None if self.max_delta_e.is_some()
                || self.max_fetches.is_some()
                || self.reciprocal == Some(true)
                || self.levels.is_some_and(|levels| levels > 0) =>
            {
                Some(Codec::Auto)
            }
            named => named,
        };
        let defaults = match asked {
            Some(Codec::Table) => Self { levels: None, ..defaults.without_wavelet() },
            Some(Codec::Auto | Codec::Factored) => {
                let mut defaults = defaults.without_wavelet();
                // A table with levels is a factored one.
                if self.levels.is_some_and(|levels| levels > 0) && defaults.named() == Some(Codec::Table) {
                    defaults.codec = Some("factored".to_owned());
                }
                defaults
            }
            Some(Codec::Wavelet) => defaults.without_search(),
            None => defaults.clone(),
        };
        let all = self.over(&defaults);
        all.check()?;
        match all.codec.as_deref().map(codec).transpose()? {
            Some(Codec::Wavelet) => Ok(PackRecipe::Wavelet(all.wavelet(Recipe::visible())?)),
            // Without a codec, options of wavelet packs ask for one.
            None if all.of_wavelet().is_some() || all.bias.is_some() => {
                Ok(PackRecipe::Wavelet(all.wavelet(Recipe::default())?))
            }
            Some(Codec::Table) => all.tables(Some(Tables::Plain)),
            Some(Codec::Factored) => all.tables(Some(Tables::Factored)),
            Some(Codec::Auto) | None => all.tables(None),
        }
    }

    /// The codec that is named, if it is one.
    fn named(&self) -> Option<Codec> {
        codec(self.codec.as_deref()?).ok()
    }

    /// Without what wavelet packs alone have, and a bias that was meant for them.
    fn without_wavelet(&self) -> Self {
        let (ratio, grid, bits, lift, smooth) = (None, None, None, None, None);
        let named = self.named();
        let bias = self.bias.filter(|_| matches!(named, Some(Codec::Auto | Codec::Table | Codec::Factored)));
        let codec = self.codec.clone().filter(|_| matches!(named, Some(Codec::Table | Codec::Factored)));
        Self { ratio, grid, bits, lift, smooth, bias, parameterisation: None, ranking: None, codec, ..self.clone() }
    }

    /// Without what wavelet packs do not have.
    fn without_search(&self) -> Self {
        let bias = self.bias.filter(|_| matches!(self.named(), Some(Codec::Wavelet)) || self.codec.is_none());
        Self { max_delta_e: None, max_fetches: None, reciprocal: None, levels: None, bias, codec: None, ..self.clone() }
    }

    /// These options, and where they leave something open `defaults`. Limits come from one of both, all together.
    #[must_use]
    pub fn over(&self, defaults: &Self) -> Self {
        let limits = |options: &Self| {
            options.ratio.is_some()
                || options.max_delta_e.is_some()
                || options.max_error.is_some()
                || options.max_bytes.is_some()
                || options.max_fetches.is_some()
        };
        let limited = if limits(self) { self } else { defaults };
        Self {
            codec: self.codec.clone().or_else(|| defaults.codec.clone()),
            max_delta_e: limited.max_delta_e,
            max_error: limited.max_error,
            max_bytes: limited.max_bytes,
            max_fetches: limited.max_fetches,
            ratio: limited.ratio,
            reciprocal: self.reciprocal.or(defaults.reciprocal),
            levels: self.levels.or(defaults.levels),
            grid: self.grid.or(defaults.grid),
            parameterisation: self.parameterisation.clone().or_else(|| defaults.parameterisation.clone()),
            bits: self.bits.or(defaults.bits),
            bias: self.bias.or(defaults.bias),
            ranking: self.ranking.clone().or_else(|| defaults.ranking.clone()),
            lift: self.lift.or(defaults.lift),
            smooth: self.smooth.or(defaults.smooth),
        }
    }

    /// The first option that wavelet packs alone have.
    fn of_wavelet(&self) -> Option<(&'static str, String)> {
        let text = |value: &String| format!("\"{value}\"");
        [
            ("ratio", self.ratio.map(format_number)),
            ("grid", self.grid.map(|v| v.to_string())),
            ("bits", self.bits.map(|v| v.to_string())),
            ("parameterisation", self.parameterisation.as_ref().map(text)),
            ("ranking", self.ranking.as_ref().map(text)),
            ("lift", self.lift.filter(|on| *on).map(|v| v.to_string())),
            ("smooth", self.smooth.filter(|on| *on).map(|v| v.to_string())),
        ]
        .into_iter()
        .find_map(|(field, found)| Some((field, found?)))
    }

    /// Checks limits and what all codecs have.
    fn check(&self) -> Result<(), OptionError> {
        self.budget()?;
        if let Some(levels) = self.levels
            && levels > MOST_LEVELS
        {
            return Err(problem("levels", levels.to_string(), range_of("levels")));
        }
        if let Some(bias) = self.bias
            && !(1e-6..=1.0).contains(&bias)
        {
            return Err(problem("bias", format_number(bias), range_of("bias")));
        }
        Ok(())
    }

    fn budget(&self) -> Result<Budget, OptionError> {
        Budget::checked(self.max_delta_e, self.max_error, self.max_bytes, self.max_fetches)
    }

    /// The recipe of tables of the kind that is named, or a search among both.
    fn tables(&self, named: Option<Tables>) -> Result<PackRecipe, OptionError> {
        if let Some((field, found)) = self.of_wavelet() {
            let name = self.codec.as_deref().unwrap_or("auto");
            return Err(problem(field, found, &format!("the codec wavelet, not {name}")));
        }
        if let (Some(Tables::Plain), Some(levels @ 1..)) = (named, self.levels) {
            let allowed = "0 with the codec table; levels are rows of a curve, which factored packs have";
            return Err(problem("levels", levels.to_string(), allowed));
        }
        let (levels, reciprocal) = (self.levels.unwrap_or(0), self.reciprocal == Some(true));
        let budget = self.budget().expect("checked before");
        let mut recipe = AutoRecipe::of_budget(budget);
        let table = TableRecipe { factored: named == Some(Tables::Factored), levels, reciprocal, ..recipe.table };
        recipe.table = TableRecipe { bias: self.bias.unwrap_or(table.bias), ..table };
        if named.is_some() && !budget.limits_error() && budget.fetches.is_none() {
            let size = budget.bytes.map_or(recipe.table.size, Size::Bytes);
            return Ok(PackRecipe::Table(TableRecipe { size, ..recipe.table }));
        }
        // A pack with levels has a curve.
        recipe.tables = named.unwrap_or(if levels > 0 { Tables::Factored } else { Tables::Both });
        Ok(PackRecipe::Auto(recipe))
    }

    fn wavelet(&self, mut recipe: Recipe) -> Result<Recipe, OptionError> {
        for (field, found) in [
            ("max_delta_e", self.max_delta_e.map(format_number)),
            ("max_fetches", self.max_fetches.map(|v| v.to_string())),
            ("reciprocal", self.reciprocal.filter(|on| *on).map(|v| v.to_string())),
            ("levels", self.levels.filter(|levels| *levels > 0).map(|v| v.to_string())),
        ] {
            if let Some(found) = found {
                let with = match self.of_wavelet() {
                    Some((other, _)) => other,
                    None if self.codec.is_none() => "bias alone, which asks for a wavelet pack",
                    None => "the codec wavelet",
                };
                return Err(problem(
                    field,
                    format!("{found} with {with}"),
                    "it with the codec auto, table or factored",
                ));
            }
        }
        if let Some(grid) = self.grid {
            if !grid.is_power_of_two() || !(2..=1 << MAX_LEVELS).contains(&grid) {
                return Err(problem("grid", grid.to_string(), GRIDS));
            }
            recipe.levels = grid.ilog2();
            recipe.stored_levels = recipe.levels;
        }
        if let Some(bits) = self.bits {
            if bits != 8 && !(10..=16).contains(&bits) {
                return Err(problem("bits", bits.to_string(), BITS));
            }
            recipe.bits = bits;
        }
        if let Some(name) = &self.parameterisation
            && name != TANGENT_POLE
        {
            let allowed = format!("{TANGENT_POLE}; half-difference angles are those of the codec table");
            return Err(problem("parameterisation", format!("\"{name}\""), &allowed));
        }
        if let Some(name) = &self.ranking {
            recipe.ranking = named("ranking", name, &Ranking::NAMES)?;
        }
        recipe.lift = self.lift.unwrap_or(recipe.lift);
        recipe.smooth = self.smooth.unwrap_or(recipe.smooth);
        recipe.bias = self.bias.unwrap_or(recipe.bias);
        if let Some(target) = self.target()? {
            recipe.target = target;
        }
        Ok(recipe)
    }

    fn target(&self) -> Result<Option<Target>, OptionError> {
        let given = [self.ratio.is_some(), self.max_error.is_some(), self.max_bytes.is_some()];
        if given.iter().filter(|g| **g).count() > 1 {
            return Err(problem(
                if self.ratio.is_some() { "ratio" } else { "max_error" },
                "more than one target",
                "one of ratio, max_error and max_bytes",
            ));
        }
        if let Some(ratio) = self.ratio {
            if !(1.0..=4096.0).contains(&ratio) {
                return Err(problem("ratio", format_number(ratio), range_of("ratio")));
            }
            return Ok(Some(Target::Ratio(ratio)));
        }
        let error = self.max_error.map(|error| Target::MaxError(error.checked().expect("checked before")));
        Ok(error.or(self.max_bytes.map(Target::MaxBytes)))
    }
}

fn codec(name: &str) -> Result<Codec, OptionError> {
    named("codec", name, &CODECS)
}

fn problem(field: &'static str, found: impl Into<String>, allowed: &str) -> OptionError {
    OptionError::new(field, found, allowed)
}

/// What `name` stands for among the names that are known.
fn named<T: Copy>(field: &'static str, name: &str, known: &[(&'static str, T)]) -> Result<T, OptionError> {
    known.iter().find(|(text, _)| *text == name).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(text, _)| *text).collect();
        problem(field, format!("\"{name}\""), &names.join(" or "))
    })
}

#[cfg(test)]
mod tests;
