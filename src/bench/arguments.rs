//! Flags of `brdfc bench`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Repeat a study of the papers, with the paper's own figures beside ours.
///
/// Timings of single stages are criterion benchmarks: 'cargo bench'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc bench
  brdfc bench --json > table-1.json
  brdfc bench --study flat-btf synth:knit --texels 64 --flat-texels 128
  brdfc bench --study rays synth:folds
  brdfc bench --study throughput
  brdfc bench --study level-of-detail --out frames
  brdfc bench --study images paint.brdf metal.bsdf synth:velvet
  brdfc bench --study adaptive red-plastic.binary paint.bsdf --environment museum.exr
  brdfc bench --study pixel-bandwidth red-plastic.binary --environment museum.exr")]
pub struct Arguments {
    /// Materials of the studies that draw (default: synth:velvet, and a glossy metal for level-of-detail and those of
    /// adaptive shading), or structures of flat-btf (default: all four) and of rays (default: synth:button).
    #[arg(value_name = "INPUT")]
    pub(super) inputs: Vec<String>,
    /// Which study.
    #[arg(long, value_enum, default_value = "wavelet-brdf")]
    pub(super) study: Study,
    /// Write the frames of level-of-detail into this folder, or the mesh and the rays of rays.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Texels of the reference plane per side, for flat-btf (default 128) and rays (default 64).
    #[arg(long, value_name = "N")]
    pub(super) texels: Option<usize>,
    /// Texels of flat BTFs per side for flat-btf, a power of two (default: twice those of the plane).
    #[arg(long, value_name = "N")]
    pub(super) flat_texels: Option<usize>,
    /// Views and lights of flat-btf, as for 'brdfc flatten --views' (default: ubo2003).
    #[arg(long, value_name = "SET")]
    pub(super) directions: Option<String>,
    /// Latitude-longitude image, .exr or .hdr, that lights the studies of adaptive shading (default: a sky).
    #[arg(long, value_name = "FILE")]
    pub(super) environment: Option<String>,
    /// Pixels per side of the studies of adaptive shading, 32 to 2048, for pixel-bandwidth 64 and more (default 512).
    #[arg(long, value_name = "N")]
    pub(super) pixels: Option<usize>,
    /// Samples per pixel of their ground truth, 16 to 65536 (default 256).
    #[arg(long, value_name = "N")]
    pub(super) truth: Option<usize>,
    /// Use the adapter whose name contains this (default: the fastest).
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Print JSON (schema: 'brdfc schema bench').
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Study {
    /// Table 1 of Claustres et al. 2007: errors of Lewis, Ward and Poulin-Fournier at 4:1, 16:1 and 32:1.
    WaveletBrdf,
    /// Section 4 of Hadim et al. 2009: reconstruction, coherency, sizes and interpolation of flat BTFs. Takes minutes for
    /// each of synth:button, folds, knit and sponge, which are the default.
    FlatBtf,
    /// Rays per second against a repeated structure. With --out: mesh.ply and rays.bin for other programs.
    Rays,
    /// Section 6.3: evaluations per second, shader and CPU decoder.
    Throughput,
    /// Section 6.3, figure 10: a terrain with and without levels of detail, time per level, flicker.
    LevelOfDetail,
    /// Section 6.3, figure 9: colour differences on a cloth, shader against source, 4:1 and 8 bits.
    Images,
    /// Section 5 of Bagher et al. 2012: samples that adaptive and forward shading need for the same error, of every
    /// material on two shapes, on the CPU. Minutes for each material.
    Adaptive,
    /// Figure 12 of Bagher et al. 2012: predicted pixel bandwidth against windowed Fourier transforms, on a sphere.
    PixelBandwidth,
    /// Figure 13 of Bagher et al. 2012: error with bandwidth averaged over 16 to 1024 directions.
    BandwidthDirections,
    /// Figure 10 of Bagher et al. 2012: cost of adaptive shading with 1, 4 and 16 points per pixel.
    Antialiasing,
}
