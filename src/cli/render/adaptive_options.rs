//! Flags of `brdfc render --adaptive`.

use brdfc::Input;
use brdfc_terminal::values::{any_whole_number, whole_number};
use clap::Args;
use std::path::PathBuf;

/// Maximum samples of forward shading, and maximum mean samples: lists of samples repeat after this many.
pub(super) const MAX_SAMPLES: u32 = 1024;
/// Allowed points per pixel.
pub(super) const ANTIALIAS: &str = "1, 4 or 16";
/// Allowed sides of tiles of rates.
pub(super) const RATE_TILE: &str = "8, 16 or 32";

/// Flags of `--adaptive`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Adaptive shading")]
pub(super) struct AdaptiveOptions {
    /// Light the scene by the environment alone, and shade only where, and as finely as, predicted bandwidth requires.
    /// The program compares the result with forward shading and a ground truth. It draws no point lights, mirrors or
    /// shadows.
    #[arg(long)]
    pub(super) adaptive: bool,
    /// Latitude-longitude image (.exr, .hdr), cube map or prefiltered environment (.ktx2) that lights the scene, or - for
    /// stdin. Without --adaptive, lobes look it up; the reference is the integral over all directions. It adds to the
    /// point lights of a manifest's scene, and lights a single material alone. (Default: the environment of the
    /// manifest; for lobes and with --adaptive, otherwise the scene's sky.)
    #[arg(long, value_name = "FILE")]
    pub(super) environment: Option<Input>,
    /// Texture that multiplies the materials of all parts, instead of the textures of a manifest's uses: .png or .jpg. It
    /// repeats, at whole numbers per unit of the parts' uv.
    #[arg(long, value_name = "IMAGE", requires = "adaptive")]
    pub(super) texture: Option<Input>,
    /// Width and height of the texture in metres, such as 0.3x0.2, each 1e-6 to 1e6. One unit of the scene is a metre.
    #[arg(long, value_name = "WxH", requires = "texture", allow_hyphen_values = true)]
    pub(super) texture_size: Option<String>,
    /// Mean samples per pixel if all pixels were shaded, 0.01 to 1024 (default: 64). A shaded pixel gets 1 to 1024,
    /// more where bandwidth is higher.
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) budget: Option<f32>,
    /// Factor on predicted bandwidths before levels are selected, 0.001 to 1000: smaller is faster, larger is sharper
    /// (default: 0.5).
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) caution: Option<f32>,
    /// Incident directions over which bandwidth is averaged, 1 to 4096, rounded up to a multiple of 4 (default: 16).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = whole_number::<u32>(1..=4096))]
    pub(super) bandwidth_directions: Option<u32>,
    /// Points per pixel: 1, 4 or 16 (default: 1).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = any_whole_number::<u32>(ANTIALIAS))]
    pub(super) antialias: Option<u32>,
    /// Samples per point of forward shading, 1 to 1024 (default: 32).
    #[arg(long, value_name = "N", requires = "adaptive", value_parser = whole_number::<u32>(1..=MAX_SAMPLES.into()))]
    pub(super) forward: Option<u32>,
    /// Directions per pixel of the reference on the CPU, 16 to 65536 (default: 256, or up to 4096
    /// where noise would be more than a fifth of the ΔE); with --adaptive samples per point
    /// of the ground truth (default: 256 per pixel, at least twice the samples of --forward).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(16..=65_536))]
    pub(super) truth: Option<usize>,
    /// Write bandwidth, levels and variance side by side, from dark to pale yellow: .png. Bandwidth covers 8 octaves
    /// and variance 16, up to the maximum of the rendering; levels run from the coarsest to the finest.
    #[arg(long, value_name = "IMAGE.png", requires = "adaptive")]
    pub(super) maps: Option<PathBuf>,
    /// Write shading rates for variable rate shading, one grey pixel per tile: .png. Values are those of
    /// D3D12_SHADING_RATE: 0, 5 or 10 for 1 x 1, 2 x 2 or 4 x 4 pixels.
    #[arg(long, value_name = "IMAGE.png", requires = "adaptive")]
    pub(super) rates: Option<PathBuf>,
    /// Pixels per side of a tile of --rates, as the graphics hardware requires: 8, 16 or 32 (default: 16).
    #[arg(long, value_name = "N", requires = "rates", value_parser = any_whole_number::<u32>(RATE_TILE))]
    pub(super) rate_tile: Option<u32>,
    /// Fail with exit code 1 if the PSNR is below X dB, any finite number.
    #[arg(long, value_name = "X", requires = "adaptive")]
    pub(super) min_psnr: Option<f64>,
}

impl AdaptiveOptions {
    /// Points per pixel and axis.
    pub(super) fn points_per_axis(&self) -> usize {
        1 << (self.antialias.unwrap_or(1).max(1).ilog2() / 2)
    }
}
