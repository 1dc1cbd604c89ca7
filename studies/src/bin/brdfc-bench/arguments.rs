//! Flags of `brdfc-bench`.

use brdfc_source::Input;
use brdfc_studies::Study;
use brdfc_terminal::inputs::refuse_stdin_twice;
use brdfc_terminal::values::{any_whole_number, views_of_map, whole_number};
use brdfc_terminal::{Error, Flags};
use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// Reproduce a study of the papers, and print the paper's own figures next to ours.
///
/// Timings of single stages are criterion benchmarks: 'cargo bench -p brdfc-benches'.
#[derive(Debug, Parser)]
#[command(
    name = "brdfc-bench",
    version,
    max_term_width = 110,
    after_help = "\
Examples:
  brdfc-bench
  brdfc-bench --json > table-1.json
  brdfc-bench --study flat-btf synth:knit --texels 64 --flat-texels 128
  brdfc-bench --study relief synth:button --out sheets
  brdfc-bench --study rays synth:folds
  brdfc-bench --study relighting icon --out figures
  brdfc-bench --study btf synth:knit --out figures
  brdfc-bench --study throughput
  brdfc-bench --study pareto paint.brdf metal.binary --out figures
  brdfc-bench --study codecs paint.brdf metal.binary --peers python3 --out figures
  brdfc-bench --study codecs paper_white_rgb.bsdf --peers python3 --networks rgl
  brdfc-bench --study stress
  brdfc-bench --study level-of-detail --out frames
  brdfc-bench --study images paint.brdf metal.bsdf synth:velvet --out figures
  brdfc-bench --study adaptive
  brdfc-bench --study adaptive red-plastic.binary paint.bsdf --environment museum.exr --pixels 192
  brdfc-bench --study pixel-bandwidth red-plastic.binary --environment museum.exr"
)]
pub struct Arguments {
    /// Materials of the studies that draw (default: synth:velvet, five models for adaptive, and a glossy metal for
    /// level-of-detail and for predicted bandwidth) and of pareto (default: three models), structures of flat-btf, relief, measured-btf and
    /// btf (default: all four) and of rays (default: synth:button), or the photographs of relighting.
    #[arg(value_name = "INPUT")]
    pub(super) inputs: Vec<Input>,
    /// Study to run (default: wavelet-brdf).
    #[arg(long, value_enum, default_value = "wavelet-brdf")]
    pub(super) study: Study,
    /// Write the frames of level-of-detail, the renderings of images, the figure of codecs, pareto, relighting or btf, the figures of flat-btf,
    /// contact sheets of relief or adaptive, the maps of pixel-bandwidth, or the mesh and the rays of rays into this folder.
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Texels of the reference plane per side, 8 or more, for flat-btf (default: 128) and rays (default: 64); for
    /// relief a power of two from 8 to 512 (default: 128); for btf the texels of both BTFs, a power of two from 8 to 256
    /// (default: 32); for measured-btf those of images and flat BTF, a power of two from 8 to 256 (default: 32).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>("a whole number, 8 or more"))]
    pub(super) texels: Option<usize>,
    /// Texels of flat BTFs per side for flat-btf, a power of two from 8 to 1024 (default: twice --texels, rounded up).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>("a power of two from 8 to 1024"))]
    pub(super) flat_texels: Option<usize>,
    /// Views and lights of flat-btf, measured-btf and btf, as for 'brdfc flatten --views' (default: ubo2003).
    #[arg(long, value_name = "SET")]
    pub(super) directions: Option<Input>,
    /// Polar angles x rows of azimuths of the indirection map of flat-btf, as for 'brdfc flatten' (default: 16x25).
    #[arg(long, value_name = "ZxR", value_parser = views_of_map, allow_hyphen_values = true)]
    pub(super) indirection: Option<[u32; 2]>,
    /// Largest polar angle of the indirection map of flat-btf, above 0, up to 89 degrees (default: 80).
    #[arg(long, value_name = "DEGREES")]
    pub(super) largest_angle: Option<f64>,
    /// Latitude-longitude image, .exr or .hdr, that lights the studies of adaptive shading and frame-time (default: a sky;
    /// for adaptive also a studio and a room).
    #[arg(long, value_name = "FILE")]
    pub(super) environment: Option<Input>,
    /// Pixels per side of the studies of adaptive shading, 32 to 2048, for pixel-bandwidth at least 64 (default: 512; for
    /// adaptive some cases at 192, 384 and 768; a number draws all cases);
    /// pixels per row of relief, 64 to 2048 (default: 640).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>("32 to 2048"))]
    pub(super) pixels: Option<usize>,
    /// Samples per pixel of their ground truth, 16 to 65536 (default: 256; for adaptive 1024 where 256 reach less than
    /// 40 dB).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(16..=65_536))]
    pub(super) truth: Option<usize>,
    /// Use the adapter whose name contains this (default: the fastest).
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Python with the packages of tests/peers/requirements.txt, with which codecs also measures zfp and SZ3.
    #[arg(long, value_name = "PYTHON")]
    pub(super) peers: Option<PathBuf>,
    /// Folder of Neural BRDFs (Sztrajman et al. 2021) that codecs also measures: the network of the material NAME is
    /// NAME.h5. Needs --peers.
    #[arg(long, value_name = "DIR")]
    pub(super) networks: Option<PathBuf>,
    /// Use few settings for pareto, few cases and small grids for stress, few pixels for level-of-detail and frame-time, or two small cases for adaptive, which takes seconds.
    #[arg(long)]
    pub(super) small: bool,
    /// Print the JSON schema of the report, and nothing else.
    #[arg(long)]
    pub(super) schema: bool,
    #[command(flatten)]
    pub(super) flags: Flags,
}

/// Studies of adaptive shading.
const ADAPTIVE: &[Study] = &[Study::Adaptive, Study::PixelBandwidth, Study::BandwidthDirections, Study::Antialiasing];

/// Studies that write files.
const WRITERS: &[Study] = &[
    Study::LevelOfDetail,
    Study::Images,
    Study::Codecs,
    Study::Pareto,
    Study::FlatBtf,
    Study::Rays,
    Study::Relief,
    Study::Relighting,
    Study::Btf,
    Study::Adaptive,
    Study::PixelBandwidth,
];

impl Arguments {
    /// Texels per side of studies that require a power of two.
    ///
    /// # Errors
    /// Returns an error unless it is one from 8 to `most`.
    pub(super) fn power_of_two_texels(&self, default: usize, most: usize) -> Result<usize, Error> {
        let texels = self.texels.unwrap_or(default);
        if !(8..=most).contains(&texels) || !texels.is_power_of_two() {
            return Err(Error::usage(format!("--texels: found {texels}, expected a power of two from 8 to {most}")));
        }
        Ok(texels)
    }

    /// Returns an error if a flag has no effect on the study.
    pub(super) fn check(&self) -> Result<(), Error> {
        let options = [("--directions", self.directions.as_ref()), ("--environment", self.environment.as_ref())];
        let inputs = self.inputs.iter().map(|input| ("INPUT", Some(input)));
        refuse_stdin_twice(&inputs.chain(options).collect::<Vec<_>>())?;
        if let (Study::WaveletBrdf | Study::Stress, Some(name)) = (self.study, self.study.to_possible_value())
            && !self.inputs.is_empty()
        {
            let allowed = "expected with the studies that draw (throughput, codecs, level-of-detail and images: \
                           materials), with pareto (materials), with btf, flat-btf, measured-btf, relief and rays (structures), and with \
                           relighting (photographs)";
            return Err(Error::usage(format!("INPUT: found with --study {}, {allowed}", name.get_name())));
        }
        for (given, option, studies) in [
            (self.out.is_some(), "out", WRITERS),
            (
                self.texels.is_some(),
                "texels",
                &[Study::FlatBtf, Study::Relief, Study::MeasuredBtf, Study::Rays, Study::Btf],
            ),
            (self.flat_texels.is_some(), "flat-texels", &[Study::FlatBtf]),
            (self.directions.is_some(), "directions", &[Study::FlatBtf, Study::MeasuredBtf, Study::Btf]),
            (self.indirection.is_some(), "indirection", &[Study::FlatBtf]),
            (self.largest_angle.is_some(), "largest-angle", &[Study::FlatBtf]),
            (self.environment.is_some(), "environment", &[ADAPTIVE, &[Study::FrameTime]].concat()),
            (self.pixels.is_some(), "pixels", &[ADAPTIVE, &[Study::Relief]].concat()),
            (self.truth.is_some(), "truth", ADAPTIVE),
            (
                self.adapter.is_some(),
                "adapter",
                &[Study::Throughput, Study::Codecs, Study::LevelOfDetail, Study::Images, Study::FrameTime],
            ),
            (self.peers.is_some(), "peers", &[Study::Codecs]),
            (self.networks.is_some(), "networks", &[Study::Codecs]),
            (
                self.small,
                "small",
                &[Study::Pareto, Study::Stress, Study::LevelOfDetail, Study::FrameTime, Study::Adaptive],
            ),
        ] {
            if given && !studies.contains(&self.study) {
                let names: Vec<String> =
                    studies.iter().filter_map(|s| Some(s.to_possible_value()?.get_name().to_owned())).collect();
                let allowed = names.join(", ");
                return Err(Error::usage(format!(
                    "--{option}: found with another study, expected with --study {allowed}"
                )));
            }
        }
        Ok(())
    }
}
