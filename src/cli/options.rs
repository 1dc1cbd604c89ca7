//! Flags that determine how a pack is encoded and stored.

use super::Error;
use brdfc::encode::{GateResult, OptionError};
use brdfc::lobes::CODEC;
use brdfc::{EncodeOptions, FitLimits, PackRecipe};
use clap::{Args, Command};

/// Encoding and storage options of a pack.
#[derive(Debug, Args)]
pub struct PackOptions {
    #[command(flatten)]
    encode: EncodeOptions,
    /// Store texels uncompressed, without Zstandard.
    #[arg(long)]
    no_supercompression: bool,
}

impl PackOptions {
    /// Key of the first option that is given.
    #[cfg(feature = "render")]
    pub fn first(&self) -> Option<&'static str> {
        first_key(&self.encode).or(self.no_supercompression.then_some("no_supercompression"))
    }

    /// Options of lobes, if they are requested.
    pub fn of_lobes(&self) -> Option<&EncodeOptions> {
        (self.encode.codec.as_deref() == Some(CODEC)).then_some(&self.encode)
    }

    /// Returns true if texels are compressed in the file.
    pub fn supercompress(&self) -> bool {
        !self.no_supercompression
    }

    /// Resolves the recipe, and the limits of the fit to a scan.
    pub fn request(&self) -> Result<(PackRecipe, FitLimits), OptionError> {
        let mut recipe = PackRecipe::from_options(&self.encode, &EncodeOptions::default())?;
        recipe.set_supercompress(self.supercompress());
        Ok((recipe, self.encode.fit_limits()?))
    }
}

/// Key of the first encoding option that is given.
pub fn first_key(options: &EncodeOptions) -> Option<&'static str> {
    let codec = options.codec.is_some().then_some("codec");
    let others = [
        ("levels", options.levels.is_some()),
        ("max_fit_error", options.max_fit_error.is_some()),
        ("trust_fit", options.trust_fit.is_some()),
    ];
    let of_others = others.into_iter().filter_map(|(key, is_given)| is_given.then_some(key));
    codec.into_iter().chain(options.given()).chain(of_others).next()
}

/// Names options by their flags.
pub fn by_flags(error: impl Into<Error>) -> Error {
    error.into().name_options(flag_of)
}

/// Messages of failed checks, with flags for keys.
pub fn failed(gates: &[GateResult]) -> Option<String> {
    let closed = gates.iter().filter(|gate| !gate.passed).map(GateResult::message);
    let all = closed.reduce(|all, next| all.with_text("; ").with_message(&next))?;
    Some(by_flags(brdfc::Error::with_keys(brdfc::ErrorKind::Check, all)).to_string())
}

/// The flag of an option's key; keys without a flag, such as `require.max_bytes`, stay as they are.
pub fn flag_of(key: &str) -> String {
    if has_flag(key) { format!("--{}", key.replace('_', "-")) } else { key.to_owned() }
}

/// The key of an option and its flag, for builds with a manifest and with flags.
pub fn key_and_flag_of(key: &str) -> String {
    if has_flag(key) { format!("{key} ({})", flag_of(key)) } else { key.to_owned() }
}

fn has_flag(key: &str) -> bool {
    let command = PackOptions::augment_args(Command::new(""));
    command.get_arguments().filter_map(|argument| argument.get_long()).any(|flag| flag.replace('-', "_") == key)
}
