//! Flags of `brdfc render --adaptive`.

use brdfc_terminal::values::{any_whole_number, whole_number};
use clap::Args;
use std::path::PathBuf;

/// Most samples of forward shading, and mean samples that may be asked for: the lists of samples begin again after as many.
pub(super) const MOST: u32 = 1024;
/// Points per pixel that there may be.
pub(super) const ANTIALIAS: &str = "1, 4 or 16";

/// Flags of `--adaptive`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Adaptive shading")]
pub(super) struct AdaptiveOptions {
    /// Light by the environment alone, and shade only where, and as much as, predicted bandwidth asks for: beside forward
    /// shading and a ground truth. Point lights, mirrors and shadows are not drawn.
    #[arg(long)]
    pub(super) adaptive: bool,
    /// Latitude-longitude image, .exr or .hdr, that lights the scene (default: the manifest's, or the scene's sky).
    #[arg(long, value_name = "FILE")]
    pub(super) environment: Option<PathBuf>,
    /// Mean samples per pixel if all pixels were shaded, 0.01 to 1024 (default 64);
    /// a shaded pixel gets 1 to 1024, more where more shows.
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) budget: Option<f32>,
    /// Factor on predicted bandwidths before levels are chosen, 0.001 to 1000: less is faster, more is sharper
    /// (default 0.5).
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) caution: Option<f32>,
    /// Incident directions that bandwidth is averaged over, 1 to 4096, rounded up to a multiple of 4 (default 16).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = whole_number::<u32>(1..=4096))]
    pub(super) bandwidth_directions: Option<u32>,
    /// Points per pixel: 1 (default), 4 or 16.
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = any_whole_number::<u32>(ANTIALIAS))]
    pub(super) antialias: Option<u32>,
    /// Samples per point of forward shading, 1 to 1024 (default 32).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = whole_number::<u32>(1..=MOST.into()))]
    pub(super) forward: Option<u32>,
    /// Samples per point of the ground truth, 16 to 65536, on the CPU (default: 256 per pixel, and twice those of forward shading).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = whole_number::<usize>(16..=65_536))]
    pub(super) truth: Option<usize>,
    /// Bandwidth, levels and variance as it shows side by side, from dark to pale yellow: .png. Bandwidth over 8 octaves and
    /// variance over 16, up to the largest of the rendering; levels from the coarsest to the finest.
    #[arg(long, value_name = "IMAGE.png", requires = "adaptive")]
    pub(super) maps: Option<PathBuf>,
    /// Fail with exit code 1 if the PSNR is below X dB.
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) min_psnr: Option<f64>,
}

impl AdaptiveOptions {
    /// Points per pixel and axis.
    pub(super) fn points_per_axis(&self) -> usize {
        1 << (self.antialias.unwrap_or(1).max(1).ilog2() / 2)
    }
}
