//! How a user asks for a pack: the flags of the command line and the keys of a manifest, which are the same.

use super::recipe::{Ranking, Recipe, Target};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::MAX_LEVELS;
use brdfc_metrics::fraction::Fraction;

/// Options of an encoding; what is absent is left open. Each field is a flag (`--max-error`) and a key (`max_error`), and
/// its comment is the help of the flag; `docs/scene.md` describes the keys.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct EncodeOptions {
    /// Keep one slice in R (default 4).
    #[cfg_attr(feature = "clap", arg(long, value_name = "R", conflicts_with_all = ["max_error", "max_bytes"]))]
    pub ratio: Option<f64>,
    /// Keep the fewest slices whose mean relative error ε_r on the grid is at most E: a fraction or a percentage, 0.02 or 2%.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E", conflicts_with = "max_bytes"))]
    pub max_error: Option<Fraction>,
    /// Keep as many slices as fit into B bytes on a GPU: texture and index map, before any compression of the file.
    #[cfg_attr(feature = "clap", arg(long, value_name = "B"))]
    pub max_bytes: Option<u64>,
    /// Cells per axis and hemisphere: 2, 4, 8, 16, 32 or 64 (default 32).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub grid: Option<usize>,
    /// What the two hemispheres are: tangent-pole (default, incoming and outgoing) or half-difference.
    #[cfg_attr(feature = "clap", arg(long, value_name = "P"))]
    pub parameterisation: Option<String>,
    /// Bits per component: 8 (default), or 10 to 16 in a texture of 16 bits.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    pub bits: Option<u32>,
    /// Bias ε of the log encoding ln(f/μ + ε), 1e-6 to 1 (default 0.01): values far below ε times the mean are lost.
    /// Lower it for mirror-like materials, whose mean is far above most values.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub bias: Option<f64>,
    /// Which slices are kept: energy (default: smallest error of the table) or visible (smallest error of pictures: what
    /// grazing angles and darkness hide counts less; goes with --bias 0.0003).
    #[cfg_attr(feature = "clap", arg(long, value_name = "BY"))]
    pub ranking: Option<String>,
    /// Smooth the table by moving least squares first: for noisy dense data. Scans are smoothed anyway.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub smooth: Option<bool>,
}

/// An option out of range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: found {found}; allowed {allowed}")]
pub struct OptionError {
    /// Which.
    pub field: &'static str,
    /// What it is.
    pub found: String,
    /// What it may be.
    pub allowed: String,
}

impl EncodeOptions {
    /// The recipe of these options; what they leave open comes from `defaults`, then from [`Recipe::default`].
    ///
    /// # Errors
    /// Values out of range; more than one of ratio, error and byte budget.
    pub fn resolve(&self, defaults: &Self) -> Result<Recipe, OptionError> {
        let mut recipe = Recipe::default();
        if let Some(grid) = self.grid.or(defaults.grid) {
            if !grid.is_power_of_two() || !(2..=1 << MAX_LEVELS).contains(&grid) {
                return Err(problem("grid", grid.to_string(), "2, 4, 8, 16, 32 or 64"));
            }
            recipe.levels = grid.ilog2();
            recipe.stored_levels = recipe.levels;
        }
        if let Some(bits) = self.bits.or(defaults.bits) {
            if bits != 8 && !(10..=16).contains(&bits) {
                return Err(problem("bits", bits.to_string(), "8, or 10 to 16"));
            }
            recipe.bits = bits;
        }
        if let Some(name) = self.parameterisation.as_ref().or(defaults.parameterisation.as_ref()) {
            recipe.parameterisation = named("parameterisation", name, &Parameterisation::NAMES)?;
        }
        if let Some(smooth) = self.smooth.or(defaults.smooth) {
            recipe.smooth = smooth;
        }
        if let Some(bias) = self.bias.or(defaults.bias) {
            if !(1e-6..=1.0).contains(&bias) {
                return Err(problem("bias", bias.to_string(), "1e-6 to 1"));
            }
            recipe.bias = bias;
        }
        if let Some(name) = self.ranking.as_ref().or(defaults.ranking.as_ref()) {
            recipe.ranking = named("ranking", name, &Ranking::NAMES)?;
        }
        if let Some(target) = self.target()?.or(defaults.target()?) {
            recipe.target = target;
        }
        Ok(recipe)
    }

    fn target(&self) -> Result<Option<Target>, OptionError> {
        let given = [self.ratio.is_some(), self.max_error.is_some(), self.max_bytes.is_some()];
        if given.iter().filter(|g| **g).count() > 1 {
            return Err(problem(
                if self.ratio.is_some() { "ratio" } else { "max_error" },
                "more than one target".to_owned(),
                "one of ratio, max_error and max_bytes",
            ));
        }
        if let Some(ratio) = self.ratio {
            if !(1.0..=4096.0).contains(&ratio) {
                return Err(problem("ratio", ratio.to_string(), "1 to 4096"));
            }
            return Ok(Some(Target::Ratio(ratio)));
        }
        if let Some(error) = self.max_error {
            let wrong = |allowed: &str| problem("max_error", error.to_string(), allowed);
            let allowed = error.checked().map_err(|allowed| wrong(&allowed))?;
            if allowed == 0.0 {
                return Err(wrong("a positive fraction, such as 0.02 for 2 %"));
            }
            return Ok(Some(Target::MaxError(allowed)));
        }
        if self.max_bytes == Some(0) {
            return Err(problem("max_bytes", "0".to_owned(), "1 or more"));
        }
        Ok(self.max_bytes.map(Target::MaxBytes))
    }
}

fn problem(field: &'static str, found: impl Into<String>, allowed: &str) -> OptionError {
    OptionError { field, found: found.into(), allowed: allowed.to_owned() }
}

/// What `name` stands for among the names that are known.
fn named<T: Copy>(field: &'static str, name: &str, known: &[(&'static str, T)]) -> Result<T, OptionError> {
    known.iter().find(|(text, _)| *text == name).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(text, _)| *text).collect();
        problem(field, format!("\"{name}\""), &names.join(" or "))
    })
}
