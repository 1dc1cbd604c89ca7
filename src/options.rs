//! Flags that say how a pack is made.

use super::CliError;
use brdfc_wavelet::options::EncodeOptions;
use brdfc_wavelet::recipe::Recipe;
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

    /// The recipe.
    pub fn recipe(&self) -> Result<Recipe, CliError> {
        let recipe = self.encode.resolve(&EncodeOptions::default())?;
        Ok(Recipe { supercompress: !self.no_supercompression, ..recipe })
    }
}
