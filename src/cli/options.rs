//! Flags that determine how a pack is encoded and stored.

use super::Error;
use brdfc::encode::OptionError;
use brdfc::{EncodeOptions, FitLimits, PackRecipe};
use clap::Args;

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
        let by_flags = |error: OptionError| {
            let (flag, OptionError { found, allowed, .. }) = (error.field.replace('_', "-"), error);
            Error::usage(format!("--{flag}: found {found}, expected {allowed}"))
        };
        let mut recipe = PackRecipe::from_options(&self.encode, &EncodeOptions::default()).map_err(by_flags)?;
        recipe.set_supercompress(!self.no_supercompression);
        Ok((recipe, self.encode.fit_limits().map_err(by_flags)?))
    }
}
