//! User options of a pack: flags of the command line and, under the same names, keys of a manifest.

use super::budget::{Budget, OptionError};
use brdfc_core::byte_count::bytes_from_manifest;
#[cfg(feature = "clap")]
use brdfc_core::byte_count::bytes_from_text;
#[cfg(feature = "clap")]
use brdfc_core::whole_number::{any_whole_number, whole_number};
use brdfc_core::words::format_number;
use brdfc_metrics::fraction::Fraction;

/// Options of an encoding; absent ones are open. Each field is a flag (`--max-error`) and a key (`max_error`), and its
/// comment is the help of the flag; `docs/manifest.md` describes the keys.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct EncodeOptions {
    /// Codec (default: auto): auto (the smallest table that meets the limits, plain or factored), table (16 KiB unless
    /// there is a limit), factored (a table and a curve for narrow highlights, one more fetch), wavelet (after
    /// Claustres et al. 2007, ranked by visible error), or lobes (only for 'brdfc encode': look-ups in the light of an
    /// environment).
    #[cfg_attr(feature = "clap", arg(long, value_name = "CODEC"))]
    pub codec: Option<String>,
    /// Maximum mean ΔE of renderings of the pack and its source, 1e-6 to 100, with 95 % below four times this limit
    /// (default: 0.5). Sizes are tried in doublings: the pack may be almost twice as large as the smallest pack that
    /// meets the limit.
    #[cfg_attr(
        feature = "clap",
        arg(id = "pack_delta_e", long = "max-delta-e", value_name = "E", conflicts_with = "ratio")
    )]
    pub max_delta_e: Option<f64>,
    /// Minimum retained share of the highlight's light over all incoming directions: 0 to 0.999, 0.9 or 90%
    /// (default: 0.9 with a limit of ΔE or without limits; 0 sets no limit). Renderings of a ball hide the narrowest
    /// highlights.
    #[cfg_attr(feature = "clap", arg(long, value_name = "SHARE", conflicts_with = "ratio"))]
    pub min_highlight: Option<Fraction>,
    /// Maximum mean relative error ε_r: a fraction or a percentage, 0.02 or 2%. For wavelet packs, the error on their
    /// grid. Sizes are tried in doublings.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E", conflicts_with = "ratio"))]
    pub max_error: Option<Fraction>,
    /// Maximum number of bytes on a GPU, before any compression of the file: a number, also with KiB, MiB or GiB, such
    /// as 16KiB. Alone it selects the pack with the smallest mean ΔE that fits; tables have up to 512 KiB.
    #[cfg_attr(feature = "clap", arg(long, value_name = "B", value_parser = bytes_from_text, conflicts_with = "ratio"))]
    #[serde(default, deserialize_with = "bytes_from_manifest")]
    pub max_bytes: Option<u64>,
    /// Maximum number of texture fetches per look-up, 1 or more. A table of an isotropic material needs 1, any other
    /// table 2, a factored pack 1 more, and a wavelet pack of 32 x 32 cells 84.
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=u64::MAX), conflicts_with = "ratio")
    )]
    pub max_fetches: Option<u32>,
    /// Table packs: symmetrised values, the mean over both orders of light and viewer, as path tracers need them.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub reciprocal: Option<bool>,
    /// Table packs: levels of detail below the finest, 0 to 6 (default: 0), for distant surfaces with bumps. They are
    /// energy-preserving, and the pack becomes a factored pack.
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = whole_number::<u32>(0..=6)))]
    pub levels: Option<u32>,
    /// Wavelet: keep one slice in R, 1 to 4096 (default: 4).
    #[cfg_attr(feature = "clap", arg(long, value_name = "R"))]
    pub ratio: Option<f64>,
    /// Wavelet: cells per axis and hemisphere, 2, 4, 8, 16, 32 or 64 (default: 32).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<usize>(GRIDS)))]
    pub grid: Option<usize>,
    /// Wavelet: parameterisation: tangent-pole, the only value (hemispheres: incoming, outgoing).
    #[cfg_attr(feature = "clap", arg(long, value_name = "P"))]
    pub parameterisation: Option<String>,
    /// Wavelet: bits per component, 8, or 10 to 16 in a texture of 16 bits (default: 8).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<u32>(BITS)))]
    pub bits: Option<u32>,
    /// Bias ε of the logarithm ln(f/μ + ε), 1e-6 to 1: values far below ε times the mean are lost (default: 0.0001 for
    /// tables, 0.0003 for --codec wavelet, 0.01 for wavelet packs that are chosen by another option).
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub bias: Option<f64>,
    /// Wavelet: ranking of slices (default: visible with --codec wavelet, else energy): energy (smallest error of the
    /// table) or visible (smallest visible error: grazing angles and dark values count less; use with --bias 0.0003).
    #[cfg_attr(feature = "clap", arg(long, value_name = "BY"))]
    pub ranking: Option<String>,
    /// Wavelet: levels of detail as in the paper, with one set of coefficients for all. The pack is smaller by about a
    /// quarter, but its coarser levels darken renderings.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub plain_levels: Option<bool>,
    /// Scans: maximum ε_r of held-out rows, and of held-out incidences, against the fit to the other rows: a fraction
    /// or a percentage, 0.1 or 10%. Sources without a fit pass.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub max_fit_error: Option<Fraction>,
    /// Scans: report the error of the pack against the fit as the error against the material. Without this option a
    /// limit of error is met only if the errors of pack and fit together are below it; rows that are few, far apart or
    /// contradictory fail.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub trust_fit: Option<bool>,
}

/// Variant of a codec: a name that `--codec` takes, and its options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Value of `--codec` and of the manifest's key `codec`.
    pub name: &'static str,
    /// Keys of its options, except `codec`.
    pub options: &'static [&'static str],
}

/// Valid levels of detail.
const LEVELS: &str = "0 to 6";
/// Valid grids.
const GRIDS: &str = "2, 4, 8, 16, 32 or 64";
/// Valid bits per component.
const BITS: &str = "8, or 10 to 16";

/// Valid values of an option. Empty if its type says all, and for the codec, whose names `brdfc_encode` lists.
pub fn range_of(field: &str) -> &'static str {
    match field {
        "max_delta_e" => Budget::DELTA_E,
        "min_highlight" => Budget::HIGHLIGHTS,
        "max_fetches" => Budget::FETCHES,
        "levels" => LEVELS,
        "ratio" => "1 to 4096",
        "grid" => GRIDS,
        "bits" => BITS,
        "parameterisation" => "tangent-pole",
        "ranking" => "energy or visible",
        "bias" => "1e-6 to 1",
        _ => "",
    }
}

fn is_limit(key: &str) -> bool {
    key == "ratio" || key.starts_with("max_")
}

impl EncodeOptions {
    /// Error of an option that is out of range.
    pub fn out_of_range(field: &'static str, found: impl Into<String>) -> OptionError {
        OptionError::new(field, found, range_of(field))
    }

    /// Keys of the set options of a pack except the codec, with the options of a single codec first.
    pub fn given(&self) -> impl Iterator<Item = &'static str> + use<> {
        // Destructures, so that no field is missing.
        let Self {
            codec: _,
            max_delta_e,
            min_highlight,
            max_error,
            max_bytes,
            max_fetches,
            reciprocal,
            levels,
            ratio,
            grid,
            parameterisation,
            bits,
            bias,
            ranking,
            plain_levels,
            max_fit_error: _,
            trust_fit: _,
        } = self;
        [
            ("ratio", ratio.is_some()),
            ("grid", grid.is_some()),
            ("bits", bits.is_some()),
            ("parameterisation", parameterisation.is_some()),
            ("ranking", ranking.is_some()),
            ("plain_levels", *plain_levels == Some(true)),
            ("max_delta_e", max_delta_e.is_some()),
            ("min_highlight", min_highlight.is_some()),
            ("max_fetches", max_fetches.is_some()),
            ("reciprocal", *reciprocal == Some(true)),
            ("levels", levels.is_some_and(|levels| levels > 0)),
            ("max_error", max_error.is_some()),
            ("max_bytes", max_bytes.is_some()),
            ("bias", bias.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, is_set)| is_set.then_some(key))
    }

    /// Keeps the codec, the limits of the fit and the options whose keys `has` accepts.
    #[must_use]
    pub fn only(&self, has: impl Fn(&str) -> bool) -> Self {
        macro_rules! only {
            ($($key:ident)*) => {
                Self {
                    codec: self.codec.clone(),
                    max_fit_error: self.max_fit_error,
                    trust_fit: self.trust_fit,
                    $($key: self.$key.clone().filter(|_| has(stringify!($key))),)*
                }
            };
        }
        only!(max_delta_e min_highlight max_error max_bytes max_fetches reciprocal levels ratio grid parameterisation bits bias ranking plain_levels)
    }

    /// Fills open options from `defaults`. All limits come from `self`, or all from `defaults`.
    #[must_use]
    pub fn over(&self, defaults: &Self) -> Self {
        let limited = if self.has_limits() { self } else { defaults };
        macro_rules! over {
            ($($key:ident)*; $($limit:ident)*) => {
                Self {
                    $($key: self.$key.clone().or_else(|| defaults.$key.clone()),)*
                    $($limit: limited.$limit,)*
                }
            };
        }
        over!(
            codec min_highlight reciprocal levels grid parameterisation bits bias ranking plain_levels max_fit_error trust_fit;
            ratio max_delta_e max_error max_bytes max_fetches
        )
    }

    /// Returns true if the pack's size or error is limited.
    pub fn has_limits(&self) -> bool {
        self.given().any(is_limit)
    }

    /// These options without limits.
    #[must_use]
    pub fn without_limits(&self) -> Self {
        self.only(|key| !is_limit(key))
    }

    /// Limits of error, bytes and fetches.
    ///
    /// # Errors
    /// Returns an error for the first limit that is out of range.
    pub fn budget(&self) -> Result<Budget, OptionError> {
        Budget::checked(self.max_delta_e, self.min_highlight, self.max_error, self.max_bytes, self.max_fetches)
    }

    /// The bias, if set.
    ///
    /// # Errors
    /// Returns an error if it is out of range.
    pub fn bias(&self) -> Result<Option<f64>, OptionError> {
        match self.bias {
            Some(bias) if !(1e-6..=1.0).contains(&bias) => Err(Self::out_of_range("bias", format_number(bias))),
            bias => Ok(bias),
        }
    }
}
