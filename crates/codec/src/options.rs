//! How a user asks for a pack: the flags of the command line and the keys of a manifest, which are the same.

use super::budget::{Budget, OptionError};
use brdfc_core::byte_count::bytes_from_manifest;
#[cfg(feature = "clap")]
use brdfc_core::byte_count::bytes_from_text;
#[cfg(feature = "clap")]
use brdfc_core::whole_number::{any_whole_number, whole_number};
use brdfc_core::words::format_number;
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
    /// Largest mean ΔE of renderings of the pack and its source, 1e-6 to 100, with 95 % below four times that (default 0.5).
    /// Sizes are tried in steps of two: the pack that is kept may be almost twice as large as the smallest that would do.
    #[cfg_attr(
        feature = "clap",
        arg(id = "pack_delta_e", long = "max-delta-e", value_name = "E", conflicts_with = "ratio")
    )]
    pub max_delta_e: Option<f64>,
    /// Least share of the light in the highlight that is kept, at the incoming direction where least is: 0 to 0.999, 0.9 or 90%
    /// (default 0.9 with --max-delta-e or without limits; 0 asks for none). Renderings of a ball do not show the narrowest highlights.
    #[cfg_attr(feature = "clap", arg(long, value_name = "S", conflicts_with = "ratio"))]
    pub min_highlight: Option<Fraction>,
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
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = whole_number::<u32>(0..=6)))]
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
    /// ε times the mean are lost.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub bias: Option<f64>,
    /// Wavelet: which slices are kept, energy (smallest error of the table; default unless the codec is named) or visible
    /// (smallest error of renderings: what grazing angles and darkness hide counts less; goes with --bias 0.0003).
    #[cfg_attr(feature = "clap", arg(long, value_name = "BY"))]
    pub ranking: Option<String>,
    /// Wavelet: keep the light. Coarser levels of detail and slices that are left out do not darken what is seen; means are
    /// those of reflectances, not of logarithms.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub lift: Option<bool>,
    /// Wavelet: smooth the table by moving least squares first, for noisy dense data. Scans are smoothed anyway.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub smooth: Option<bool>,
    /// Scans: largest ε_r of rows, or of whole incidences, that are left out of the fit to the others: a fraction or a percentage,
    /// 0.1 or 10%. Sources without a fit pass.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E"))]
    pub max_fit_error: Option<Fraction>,
    /// Scans: take the error of the pack against the fit for the error against the material. Without it a limit of the error
    /// that is asked for does not count as met where both together are above it: where rows are few, far apart or contradict each other.
    #[cfg_attr(feature = "clap", arg(long, num_args = 0, default_missing_value = "true"))]
    pub trust_fit: Option<bool>,
}

/// What users may ask a codec for, by a name that `--codec` takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// The name.
    pub name: &'static str,
    /// Keys of the options that it has, besides `codec`.
    pub options: &'static [&'static str],
}

/// Levels of detail that there may be.
const LEVELS: &str = "0 to 6";
/// Grids that there may be.
const GRIDS: &str = "2, 4, 8, 16, 32 or 64";
/// Bits per component that there may be.
const BITS: &str = "8, or 10 to 16";

/// Values that an option may have, in words; empty where its kind says all, and of the codec, whose names `brdfc_encode` lists.
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
    /// The error of an option that is out of range.
    pub fn out_of_range(field: &'static str, found: impl Into<String>) -> OptionError {
        OptionError::new(field, found, range_of(field))
    }

    /// The options that ask something of a pack besides its codec: keys and values, those of one codec alone first.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, String)> + use<> {
        // By name, so that no field is left out.
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
            lift,
            smooth,
            max_fit_error: _,
            trust_fit: _,
        } = self;
        let on = |flag: &Option<bool>| flag.filter(|on| *on).map(|on| on.to_string());
        let quoted = |text: &Option<String>| text.as_ref().map(|text| format!("\"{text}\""));
        [
            ("ratio", ratio.map(format_number)),
            ("grid", grid.map(|cells| cells.to_string())),
            ("bits", bits.map(|bits| bits.to_string())),
            ("parameterisation", quoted(parameterisation)),
            ("ranking", quoted(ranking)),
            ("lift", on(lift)),
            ("smooth", on(smooth)),
            ("max_delta_e", max_delta_e.map(format_number)),
            ("min_highlight", min_highlight.map(|share| share.to_string())),
            ("max_fetches", max_fetches.map(|fetches| fetches.to_string())),
            ("reciprocal", on(reciprocal)),
            ("levels", levels.filter(|levels| *levels > 0).map(|levels| levels.to_string())),
            ("max_error", max_error.map(|error| error.to_string())),
            ("max_bytes", max_bytes.map(|bytes| bytes.to_string())),
            ("bias", bias.map(format_number)),
        ]
        .into_iter()
        .filter_map(|(key, value)| Some((key, value?)))
    }

    /// Keeps the options whose keys `has` accepts, the codec, and what is asked of the fit.
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
        only!(max_delta_e min_highlight max_error max_bytes max_fetches reciprocal levels ratio grid parameterisation bits bias ranking lift smooth)
    }

    /// These options, and where they leave something open `defaults`. Limits come from one of both, all together.
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
            codec min_highlight reciprocal levels grid parameterisation bits bias ranking lift smooth max_fit_error trust_fit;
            ratio max_delta_e max_error max_bytes max_fetches
        )
    }

    /// Whether a limit of the pack's size or error is given.
    pub fn has_limits(&self) -> bool {
        self.given().any(|(key, _)| is_limit(key))
    }

    /// These options without their limits.
    #[must_use]
    pub fn without_limits(&self) -> Self {
        self.only(|key| !is_limit(key))
    }

    /// The limits of error, bytes and fetches.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn budget(&self) -> Result<Budget, OptionError> {
        Budget::checked(self.max_delta_e, self.min_highlight, self.max_error, self.max_bytes, self.max_fetches)
    }

    /// The bias, if it is given.
    ///
    /// # Errors
    /// One that is out of range.
    pub fn bias(&self) -> Result<Option<f64>, OptionError> {
        match self.bias {
            Some(bias) if !(1e-6..=1.0).contains(&bias) => Err(Self::out_of_range("bias", format_number(bias))),
            bias => Ok(bias),
        }
    }
}
