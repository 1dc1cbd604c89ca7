//! Conversion of options to recipes.

use super::PackRecipe;
use super::codecs::CodecEntry;
use brdfc_codec::{Budget, EncodeOptions, Message, OptionError, Variant};
use brdfc_core::words::{one_of, quoted};
use brdfc_metrics::fraction::Fraction;
use brdfc_table::search::recipe::SearchRecipe;
use std::sync::LazyLock;

/// A variant of a codec, chosen by its name or by its options.
#[derive(Clone, Copy, PartialEq)]
struct Choice {
    codec: usize,
    variant: &'static Variant,
}

impl Choice {
    /// All variants, the default first.
    fn all() -> impl Iterator<Item = Self> {
        let codecs = PackRecipe::CODECS.iter().enumerate();
        codecs.flat_map(|(codec, CodecEntry { variants, .. })| {
            variants.iter().map(move |variant| Self { codec, variant })
        })
    }

    /// Finds the variant of a name.
    fn named(name: &str) -> Result<Self, OptionError> {
        let unknown = || OptionError::new("codec", quoted(name), codec_names());
        Self::all().find(|asked| asked.variant.name == name).ok_or_else(unknown)
    }

    fn has(&self, option: &str) -> bool {
        self.variant.options.contains(&option)
    }

    fn has_all_of(&self, options: &EncodeOptions) -> bool {
        options.given().all(|option| self.has(option))
    }

    /// The variant that options without a codec select: `preferred` if it has all of them, then the last variant of its
    /// codec that has all, then the first of any codec. If no variant has all options, the first variant that has the
    /// first option.
    fn by_options(options: &EncodeOptions, preferred: Option<Self>) -> Self {
        let all: Vec<Self> = Self::all().collect();
        let of_codec = |asked: &&Self| preferred.is_some_and(|preferred| preferred.codec == asked.codec);
        let in_order = preferred.iter().chain(all.iter().rev().filter(of_codec)).chain(&all);
        let first = options.given().next().unwrap_or_default();
        let fits = in_order.copied().find(|asked| asked.has_all_of(options));
        fits.or_else(|| all.iter().copied().find(|asked| asked.has(first))).unwrap_or(all[0])
    }

    /// Error of an option that the variant does not have.
    fn refuses(&self, option: &'static str, options: &EncodeOptions) -> OptionError {
        let asks = options.given().find(|other| self.has(other));
        let (codec, having) = (self.variant.name, join(Self::all().filter(|asked| asked.has(option))));
        let problem = match asks {
            Some(other) if options.codec.is_none() => {
                let problem = Message::from("conflicts with ").with_key(other);
                let remedy = format!(", an option of the codec {codec}; use the codec {having} without ");
                problem.with_text(remedy).with_key(other)
            }
            _ => format!("does not apply to the codec {codec}; use the codec {having}").into(),
        };
        OptionError::conflict(option, problem)
    }
}

/// Joins names: `auto, table or factored`.
fn join(asked: impl Iterator<Item = Choice>) -> String {
    one_of(&asked.map(|asked| asked.variant.name).collect::<Vec<_>>())
}

/// The names that `--codec` takes.
pub fn codecs() -> impl Iterator<Item = &'static str> {
    Choice::all().map(|choice| choice.variant.name)
}

/// The same, as a list for people.
pub fn codec_names() -> &'static str {
    static NAMES: LazyLock<String> = LazyLock::new(|| join(Choice::all()));
    &NAMES
}

impl PackRecipe {
    /// Creates the recipe of options. `defaults` fill open ones, then [`PackRecipe::default`].
    ///
    /// All limits come from `options`, or all from `defaults`. Defaults that conflict with the codec of the options are
    /// dropped.
    ///
    /// # Errors
    /// Returns an error for values out of range and for conflicting options.
    pub fn from_options(options: &EncodeOptions, defaults: &EncodeOptions) -> Result<Self, OptionError> {
        let (asked, all) = merged(options, defaults)?;
        if let Some(option) = all.given().find(|option| !asked.has(option)) {
            return Err(asked.refuses(option, &all));
        }
        // Reports limits out of range before options of a single codec.
        all.budget()?;
        all.fit_limits()?;
        (Self::CODECS[asked.codec].recipe)(asked.variant.name, &all)
    }
}

/// Merges options over defaults, such as flags of the command line over keys of a manifest. Defaults that conflict
/// with the codec of the options are dropped. Invalid options pass; [`PackRecipe::from_options`] reports them.
pub fn options_over(options: &EncodeOptions, defaults: &EncodeOptions) -> EncodeOptions {
    merged(options, defaults).map_or_else(|_| options.over(defaults), |(_, all)| all)
}

/// The variant that options select, and the options merged over the defaults that go with it.
fn merged(options: &EncodeOptions, defaults: &EncodeOptions) -> Result<(Choice, EncodeOptions), OptionError> {
    let of = |options: &EncodeOptions| options.codec.as_deref().map(Choice::named).transpose();
    // Limits that are replaced select nothing.
    let defaults = &if options.has_limits() { defaults.without_limits() } else { defaults.clone() };
    let by_default = of(defaults)?.unwrap_or_else(|| Choice::by_options(defaults, None));
    let asked = of(options)?.unwrap_or_else(|| Choice::by_options(options, Some(by_default)));
    if asked == by_default {
        return Ok((asked, options.over(defaults)));
    }
    // A bias belongs to the codec that its neighbours select, if any.
    let is_neutral = defaults.codec.is_none() && asked.has_all_of(defaults);
    let keeps_bias = asked.codec == by_default.codec || is_neutral;
    let fitting = defaults.only(|option| asked.has(option) && (keeps_bias || option != "bias"));
    Ok((asked, options.over(&EncodeOptions { codec: None, ..fitting })))
}

impl TryFrom<EncodeOptions> for PackRecipe {
    type Error = OptionError;

    fn try_from(options: EncodeOptions) -> Result<Self, OptionError> {
        Self::from_options(&options, &EncodeOptions::default())
    }
}

impl TryFrom<Budget> for PackRecipe {
    type Error = OptionError;

    fn try_from(Budget { delta_e, highlight, error, bytes, fetches }: Budget) -> Result<Self, OptionError> {
        let [highlight, error] = [highlight, error].map(|share| share.map(Fraction::bare));
        let budget = Budget::checked(delta_e, highlight, error, bytes, fetches)?;
        Ok(SearchRecipe::of_budget(budget).into())
    }
}

#[cfg(test)]
mod tests;
