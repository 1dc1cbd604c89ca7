//! Flags that determine how a pack is encoded and stored.

use super::Error;
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
    /// Returns true if any option is given.
    #[cfg(feature = "render")]
    pub fn any(&self) -> bool {
        self.encode != EncodeOptions::default() || self.no_supercompression
    }

    /// Resolves the recipe, and the limits of the fit to a scan.
    pub fn request(&self) -> Result<(PackRecipe, FitLimits), Error> {
        let mut recipe = PackRecipe::from_options(&self.encode, &EncodeOptions::default()).map_err(by_flags)?;
        recipe.set_supercompress(!self.no_supercompression);
        Ok((recipe, self.encode.fit_limits().map_err(by_flags)?))
    }
}

/// Names options by their flags, in an error that names them by the keys of a manifest.
pub fn by_flags(error: impl Into<Error>) -> Error {
    let error = error.into();
    let text = with_flags(error.message());
    error.with_message(text)
}

/// Names options by their flags, in a message that names them by the keys of a manifest.
pub fn with_flags(message: &str) -> String {
    let mut text = message.to_owned();
    let command = PackOptions::augment_args(Command::new(""));
    for flag in command.get_arguments().filter_map(|argument| argument.get_long()) {
        let key = flag.replace('-', "_");
        let named = format!("--{flag}");
        let parts = text.split(": ").map(|part| if part == key { &named } else { part });
        text = parts.collect::<Vec<_>>().join(": ");
        // Keys of one word are words of messages, too.
        if key.contains('_') {
            text = text.replace(&key, &named);
        }
    }
    text
}
