//! User options of polynomial wavelet trees: flags of `brdfc pwt` and, under the same names, keys of `[captures]` and `[btfs]` in a
//! manifest.

use crate::encode::{Message, OptionError};
use brdfc_core::byte_count::bytes_from_manifest;
#[cfg(feature = "clap")]
use brdfc_core::byte_count::bytes_from_text;
#[cfg(feature = "clap")]
use brdfc_core::whole_number::any_whole_number;
use brdfc_formats::pwt::LightCoordinates;
use brdfc_metrics::fraction::Fraction;
use brdfc_pwt::{DomainName, PwtRecipe, Target, Wavelet};

/// Options of a polynomial wavelet tree; absent ones are chosen by measurement, or have the default of [`PwtRecipe`]. Each field is a
/// flag and a key, and its comment is the help of the flag.
#[derive(Debug, Clone, Default, PartialEq, serde::Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[serde(deny_unknown_fields)]
pub struct PwtOptions {
    /// Minimum PSNR of 8-bit sRGB levels, 0 to 200 dB.
    #[cfg_attr(feature = "clap", arg(long, value_name = "DB", group = "target"))]
    pub quality: Option<f64>,
    /// Maximum mean ΔE (CIE76), 0 to 1000.
    #[cfg_attr(feature = "clap", arg(long, value_name = "E", group = "target"))]
    pub max_delta_e: Option<f64>,
    /// Maximum bytes on a GPU, including mipmaps: a number, optionally with KiB or MiB.
    #[cfg_attr(feature = "clap", arg(long, value_name = "BYTES", group = "target", value_parser = bytes_from_text))]
    #[serde(default, deserialize_with = "bytes_from_manifest")]
    pub max_bytes: Option<u64>,
    /// Minimum fraction of the squared error that terms and details remove, 0 to 1.
    #[cfg_attr(feature = "clap", arg(long, value_name = "SHARE", group = "target"))]
    pub energy: Option<Fraction>,
    /// Maximum loss of PSNR at held-out lights from dropping terms and details, 0 to 100 dB (default: 0.3).
    #[cfg_attr(feature = "clap", arg(long, value_name = "DB", group = "target"))]
    pub loss: Option<f64>,
    /// Terms of the light: polynomials in the coordinates of the paraboloid or in x and y, harmonics of the hemisphere, or terms
    /// that are learned from the photographs (default: the best).
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", value_parser = names(&LightCoordinates::ALL, LightCoordinates::name))
    )]
    pub terms: Option<LightCoordinates>,
    /// Highest degree of polynomials, 0 to 5, or number of learned terms, 1 to 35 (default: the best). Without --terms it
    /// selects polynomials.
    #[cfg_attr(feature = "clap", arg(long, value_name = "D", value_parser = any_whole_number::<u32>("0 to 35")))]
    pub degree: Option<u32>,
    /// Maximum number of texture fetches per pixel, 1 to 32 (default: any).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<u32>("1 to 32")))]
    pub max_fetches: Option<u32>,
    /// Smoothness of polynomials between the lights: a ridge penalty, 0 to 1000000 (default: the best). Without --terms it
    /// selects polynomials.
    #[cfg_attr(feature = "clap", arg(long, value_name = "L"))]
    pub ridge: Option<f64>,
    /// Scale of the fitted values (default: the best).
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "NAME", value_parser = names(&DomainName::ALL, DomainName::name))
    )]
    pub domain: Option<DomainName>,
    /// Wavelet of the tree (default: haar).
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAME", value_parser = names(&Wavelet::ALL, Wavelet::name)))]
    pub wavelet: Option<Wavelet>,
    /// Levels of the tree, 0 to 8 (default: up to 5).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<u32>("0 to 8")))]
    pub levels: Option<u32>,
    /// Maximum number of further splits of details, each made only if it costs fewer bits, 0 to 4 (default: 1).
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", value_parser = any_whole_number::<u32>("0 to 4")))]
    pub packets: Option<u32>,
}

/// Parses one of several values by its name.
#[cfg(feature = "clap")]
fn names<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl clap::builder::TypedValueParser<Value = T> {
    use clap::builder::{PossibleValuesParser, TypedValueParser as _};
    let find = move |given: String| all.iter().copied().find(|one| name(*one) == given).expect("a name of one");
    PossibleValuesParser::new(all.iter().map(|one| name(*one)).collect::<Vec<_>>()).map(find)
}

impl PwtOptions {
    /// Keys of the given options, in the order of the fields.
    pub fn given(&self) -> impl Iterator<Item = &'static str> + use<> {
        // Destructures, so that no field is missing.
        let Self {
            quality,
            max_delta_e,
            max_bytes,
            energy,
            loss,
            terms,
            degree,
            max_fetches,
            ridge,
            domain,
            wavelet,
            levels,
            packets,
        } = self;
        [
            ("quality", quality.is_some()),
            ("max_delta_e", max_delta_e.is_some()),
            ("max_bytes", max_bytes.is_some()),
            ("energy", energy.is_some()),
            ("loss", loss.is_some()),
            ("terms", terms.is_some()),
            ("degree", degree.is_some()),
            ("max_fetches", max_fetches.is_some()),
            ("ridge", ridge.is_some()),
            ("domain", domain.is_some()),
            ("wavelet", wavelet.is_some()),
            ("levels", levels.is_some()),
            ("packets", packets.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, is_given)| is_given.then_some(key))
    }

    /// Resolves the options.
    ///
    /// # Errors
    /// Returns an error for a value that is out of range, for several targets, and for options of polynomials with learned terms.
    pub fn recipe(&self) -> Result<PwtRecipe, OptionError> {
        let default = PwtRecipe::default();
        if self.terms == Some(LightCoordinates::Learned) {
            let of_polynomials = [("ridge", self.ridge.is_some()), ("packets", self.packets.is_some())];
            if let Some((key, _)) = of_polynomials.into_iter().find(|(_, is_given)| *is_given) {
                let problem = Message::from("does not apply to ").with_key("terms");
                return Err(OptionError::conflict(key, problem.with_text(" learned, only to polynomials")));
            }
        }
        let targets = [
            ("quality", self.quality.map(Target::Quality)),
            ("max_delta_e", self.max_delta_e.map(Target::DeltaE)),
            ("max_bytes", self.max_bytes.map(Target::Bytes)),
            ("energy", self.energy.map(|share| Target::Energy(share.value()))),
            ("loss", self.loss.map(Target::Loss)),
        ];
        let mut targets = targets.into_iter().filter_map(|(key, target)| Some((key, target?)));
        let target = targets.next();
        if let (Some((first, _)), Some((second, _))) = (target, targets.next()) {
            let problem = Message::from("not allowed together with ").with_key(first);
            return Err(OptionError::conflict(second, problem.with_text(": a pack has one target")));
        }
        let recipe = PwtRecipe {
            coordinates: self.terms,
            degree: self.degree,
            ridge: self.ridge,
            domain: self.domain,
            wavelet: self.wavelet.unwrap_or(default.wavelet),
            depth: self.levels,
            packets: self.packets.unwrap_or(default.packets),
            max_fetches: self.max_fetches,
            target: target.map_or(default.target, |(_, target)| target),
        };
        recipe.check().map_err(|error| {
            let key = match error.field.as_ref() {
                "bytes" => "max_bytes",
                "delta E" => "max_delta_e",
                "max-fetches" => "max_fetches",
                "degree" => "degree",
                "ridge" => "ridge",
                "levels" => "levels",
                "packets" => "packets",
                "loss" => "loss",
                "quality" => "quality",
                _ => "energy",
            };
            let learned = LightCoordinates::Learned.max_degree();
            let mut allowed = Message::from(&*error.allowed);
            if key == "degree" && self.terms.is_none() {
                allowed =
                    allowed.with_text(format!(", or up to {learned} with ")).with_key("terms").with_text(" learned");
            }
            OptionError::new(key, error.found, allowed)
        })?;
        Ok(recipe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_out_of_range_and_conflicts_are_named() {
        let error = |options: PwtOptions| options.recipe().unwrap_err().to_string();
        let degree = PwtOptions { degree: Some(6), ..PwtOptions::default() };
        assert_eq!(error(degree), "degree: found 6, expected 0 to 5, or up to 35 with terms learned");
        let two = PwtOptions { max_bytes: Some(1), loss: Some(1.0), ..PwtOptions::default() };
        assert_eq!(error(two), "loss: not allowed together with max_bytes: a pack has one target");
        let learned = PwtOptions { terms: Some(LightCoordinates::Learned), ridge: Some(0.1), ..PwtOptions::default() };
        assert_eq!(learned.given().collect::<Vec<_>>(), ["terms", "ridge"]);
        assert!(error(learned).starts_with("ridge: does not apply to terms learned"));
        assert_eq!(PwtOptions::default().recipe().unwrap(), PwtRecipe::default());
    }
}
