//! Flags that say how a pack is made.

use super::Error;
use brdfc::encode::OptionError;
use brdfc::{EncodeOptions, FitLimits, PackRecipe};
use clap::Args;

/// How a pack is made, and how it is stored.
#[derive(Debug, Args)]
pub struct PackOptions {
    #[command(flatten)]
    encode: EncodeOptions,
    /// Store texels as they are, without Zstandard.
    #[arg(long)]
    no_supercompression: bool,
}

impl PackOptions {
    /// Whether any is given.
    #[cfg(feature = "render")]
    pub fn any(&self) -> bool {
        self.encode != EncodeOptions::default() || self.no_supercompression
    }

    /// The recipe, and what is asked of the fit to a scan.
    pub fn request(&self) -> Result<(PackRecipe, FitLimits), Error> {
        let in_flags = |error: OptionError| {
            let (flag, OptionError { found, allowed, .. }) = (error.field.replace('_', "-"), error);
            Error::usage(format!("--{flag}: found {found}, expected {allowed}"))
        };
        let mut recipe = PackRecipe::from_options(&self.encode, &EncodeOptions::default()).map_err(in_flags)?;
        recipe.set_supercompress(!self.no_supercompression);
        Ok((recipe, self.encode.fit_limits().map_err(in_flags)?))
    }
}
