//! Flags that say how a pack is made.

use super::CliError;
use crate::brdf::encode::Recipe;
use crate::build::manifest::Options;
use clap::Args;

/// How a pack is made.
#[derive(Debug, Args)]
pub struct EncodeOptions {
    /// Keep one slice in R (default 4).
    #[arg(long, value_name = "R", conflicts_with_all = ["max_error", "max_bytes"])]
    ratio: Option<f64>,
    /// Keep the fewest slices whose mean relative error ε_r on the grid is at most E, a fraction: 0.02 is 2 %.
    #[arg(long, value_name = "E", conflicts_with = "max_bytes")]
    max_error: Option<f64>,
    /// Keep as many slices as fit into B bytes on a GPU: texture and index map, before any compression of the file.
    #[arg(long, value_name = "B")]
    max_bytes: Option<u64>,
    /// Cells per axis and hemisphere: 2, 4, 8, 16, 32 or 64 (default 32).
    #[arg(long, value_name = "N")]
    grid: Option<usize>,
    /// What the two hemispheres are: tangent-pole (default, incoming and outgoing) or half-difference.
    #[arg(long, value_name = "P")]
    parameterisation: Option<String>,
    /// Bits per component: 8 (default), or 10 to 16 in a texture of 16 bits.
    #[arg(long, value_name = "N")]
    bits: Option<u32>,
    /// Bias ε of the log encoding ln(f/μ + ε), 1e-6 to 1 (default 0.01): values far below ε times the mean are lost.
    /// Lower it for mirror-like materials, whose mean is far above most values.
    #[arg(long, value_name = "E")]
    bias: Option<f64>,
    /// Which slices are kept: energy (default: smallest error of the table) or visible (smallest error of pictures: what
    /// grazing angles and darkness hide counts less; goes with --bias 0.0003).
    #[arg(long, value_name = "BY")]
    ranking: Option<String>,
    /// Smooth the table by moving least squares first: for noisy dense data. Scans are smoothed anyway.
    #[arg(long)]
    smooth: bool,
    /// Store texels as they are, without Zstandard.
    #[arg(long)]
    no_supercompression: bool,
}

impl EncodeOptions {
    /// Whether any is given.
    #[cfg(feature = "render")]
    pub fn any(&self) -> bool {
        let numbers = self.ratio.is_some() || self.max_error.is_some() || self.bias.is_some();
        let sizes = self.max_bytes.is_some() || self.grid.is_some() || self.bits.is_some();
        numbers
            || sizes
            || self.parameterisation.is_some()
            || self.ranking.is_some()
            || self.smooth
            || self.no_supercompression
    }

    /// The recipe.
    pub fn recipe(&self) -> Result<Recipe, CliError> {
        let options = Options {
            grid: self.grid,
            bits: self.bits,
            parameterisation: self.parameterisation.clone(),
            ratio: self.ratio,
            max_error: self.max_error,
            max_bytes: self.max_bytes,
            smooth: self.smooth.then_some(true),
            bias: self.bias,
            ranking: self.ranking.clone(),
        };
        let recipe = options.resolve(&Options::default())?;
        Ok(Recipe { supercompress: !self.no_supercompression, ..recipe })
    }
}
