//! Flags of `brdfc flatten`.

use crate::reading::PhotographOptions;
use brdfc::Input;
use brdfc::flatten::{FillMethod, Reflectance, StackFormat, describe_structures};
use brdfc_terminal::values::{any_whole_number, bytes_from_text, one_of, views_of_map, whole_number};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Make a flat BTF: one file with the relief of a tile, in layers or in an indirection map, and the reflectance of its surface.
///
/// MESO is one tile of a repeating surface: synth:STRUCTURE, a mesh (.obj, .ply), or a height map (.png with 8 or 16
/// bits grey, .exr). It may also be an ordinary BTF (a folder of images or a .btf file), whose relief --geometry gives.
/// The program closes every mesh over the borders of the tile and reports repairs. A surface has at most 1048576
/// vertices, and a height map at most 1048576 pixels.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct Arguments {
    /// synth:STRUCTURE, a mesh, a height map, a folder of BTF images, a .btf file, or - for a mesh or a height map from
    /// stdin.
    pub(super) meso: Input,
    /// Output folder of NAME.ktx2, created if missing.
    #[arg(long, short, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Name of the file, without .ktx2 (default: the name of the folder).
    #[arg(long)]
    pub(super) name: Option<String>,
    /// Relief of a folder of BTF images or a .btf file: mesh, height map or structure (default: a plane).
    #[arg(long, value_name = "MESO")]
    pub(super) geometry: Option<Input>,
    /// Period of a mesh along x and y, in units of the mesh, above 0 (default: 1).
    #[arg(long, value_name = "SIZE")]
    pub(super) tile: Option<f64>,
    /// Tiles per unit of a height map, -10 to 10 (default: 0.1). White in a PNG is 1 unit.
    #[arg(long, value_name = "TILES")]
    pub(super) height_scale: Option<f64>,
    /// Height of a height map's 0 above the reference plane, in tiles, -10 to 10 (default: 0).
    #[arg(long, value_name = "TILES")]
    pub(super) height_offset: Option<f64>,
    /// Material: any INPUT of 'brdfc encode', or NAME=INPUT for the faces of that name in a mesh. May be given up to
    /// four times (default: a structure blends its own, other surfaces are 'synth:lambert?kd=0.5').
    #[arg(long, value_name = "[NAME=]INPUT")]
    pub(super) material: Vec<OsString>,
    #[command(flatten)]
    pub(super) reading: PhotographOptions,
    /// Image over the tile that multiplies the reflectance (PNG or JPEG), in the colour that the file states, or else sRGB.
    #[arg(long, value_name = "IMAGE")]
    pub(super) colour: Option<Input>,
    /// Image over the tile with the blend weights of the materials, in order, in its red, green, blue and alpha
    /// channels.
    #[arg(long, value_name = "IMAGE")]
    pub(super) weights: Option<Input>,
    /// Texels per side of the reference plane, which hold the relief of a tile, a power of two from 4 to 2048 (default: 256).
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = any_whole_number::<u32>(TEXELS))]
    pub(super) texels: u32,
    /// Texels per side of the flat BTF, which hold the reflectance, a power of two from 4 to 2048 (default: --texels).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>(TEXELS))]
    pub(super) flat_texels: Option<usize>,
    /// Form of the relief (default: layers).
    #[arg(long, value_parser = one_of(&RELIEFS), default_value = "layers")]
    pub(super) relief: Relief,
    /// Views of an indirection map: polar angles x rows of azimuths, of which the last repeats the first, 2 to 256 x 4 to
    /// 256 (default: 16x16). The product of each with --texels is at most 8192.
    #[arg(long, value_name = "ZxR", value_parser = views_of_map, allow_hyphen_values = true)]
    pub(super) indirection: Option<[u32; 2]>,
    /// Largest polar angle of these views, 1 to 90 degrees (default: 80). Steeper views look like this one.
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    pub(super) largest_angle: Option<f64>,
    /// Rays per texel and axis for each of these views, 1 to 16 (default: 2).
    #[arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=16))]
    pub(super) oversampling: Option<u32>,
    /// Store these views in two bytes each instead of eight, for at most 128 x 128 blocks of texels: a fifteenth of the bytes
    /// with 256 texels, at a larger error. Takes 5 fetches instead of 2.
    #[arg(long)]
    pub(super) compact: bool,
    /// Shadows with an indirection map (default: lights).
    #[arg(long, value_parser = one_of(&SHADOWS))]
    pub(super) shadows: Option<Shadows>,
    /// Form of the reflectance (default: auto).
    #[arg(long, value_parser = one_of(&REFLECTANCES), default_value = "auto")]
    pub(super) reflectance: Reflectance,
    /// Views of factors and trees: ubo2003 (81), ubo2014 (151), grid:ZxA@DEGREES, or a .csv file with index,theta_deg,phi_deg (default:
    /// ubo2003). A grid has Z polar angles from 0 to DEGREES: one direction at the zenith, and A azimuths at each other
    /// angle. For example, grid:2x6@50 has 1 + 6 = 7 directions.
    #[arg(long, value_name = "SET")]
    pub(super) views: Option<Input>,
    /// Lights of factors, of trees and of the shadows of an indirection map, in the same form (default: the set of --views).
    #[arg(long, value_name = "SET")]
    pub(super) lights: Option<Input>,
    /// Method that fills texels that a view does not see, for factors and trees (default: poisson).
    #[arg(long, value_parser = one_of(&FILLS))]
    pub(super) fill: Option<FillMethod>,
    /// Rays per texel for light of one bounce, 0 to 1024 (default: 0, direct light and cast shadows only).
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole_number::<usize>(0..=1024))]
    pub(super) bounces: usize,
    /// Maximum mean ΔE (CIE76) between the reflectance and the materials or images, over visible texels, above 0, up to
    /// 100 (default: 0.7). If none meets it, the program writes the best one, and exits with code 1 if the option was
    /// given.
    #[arg(long, value_name = "E")]
    pub(super) max_delta_e: Option<f64>,
    /// Scans as materials: count the error against the fit to a scan as the error against the material. Without this option
    /// --max-delta-e is met only if the errors of output and fit together are below it.
    #[arg(long)]
    pub(super) trust_fit: bool,
    /// Maximum bytes of the reflectance on a GPU, including mipmaps: a number, optionally with KiB or MiB. The program
    /// selects the form with the smallest error within this limit.
    #[arg(long, value_name = "BYTES", conflicts_with = "max_delta_e", value_parser = bytes_from_text)]
    pub(super) max_bytes: Option<u64>,
    /// Also write the ordinary BTF, computed from direct light, as images into a new or empty folder.
    #[arg(long, value_name = "DIR")]
    pub(super) write_images: Option<PathBuf>,
    /// Format of these images: png (8 bits, sRGB) or exr (16-bit floats, linear) (default: png).
    #[arg(long, value_parser = one_of(&IMAGE_FORMATS))]
    pub(super) image_format: Option<StackFormat>,
    /// Also write the raw flat BTF into a new or empty folder, as EXR files for other compressors: flat/ has the images of all
    /// --views and --lights with filled holes, masks/ the texels that each view sees, reference.exr the parameters that the
    /// view along the normal sees, and displacements/ those of each view less them.
    #[arg(long, value_name = "DIR")]
    pub(super) write_flat: Option<PathBuf>,
    /// Store texels uncompressed, without Zstandard.
    #[arg(long)]
    pub(super) no_supercompression: bool,
}

/// Form of the relief.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relief {
    Layers,
    Vdim,
}

/// Shadows of an indirection map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shadows {
    Lights,
    Omitted,
}

/// Allowed numbers of texels per side.
pub(super) const TEXELS: &str = "a power of two from 4 to 2048, because each mipmap level halves the size";

const RELIEFS: [(&str, Relief, &str); 2] = [
    ("layers", Relief::Layers, "Heights through which rays march: small and sharp, with outlines and exact shadows"),
    (
        "vdim",
        Relief::Vdim,
        "View-dependent indirection map of Hadim et al. 2009: at most 8 fetches for any relief, many times the bytes",
    ),
];
const SHADOWS: [(&str, Shadows, &str); 2] = [
    ("lights", Shadows::Lights, "Those of --lights, blended between three of them"),
    ("none", Shadows::Omitted, "Every light above a texel's normal reaches it"),
];
const FILLS: [(&str, FillMethod, &str); 2] = [
    ("poisson", FillMethod::Poisson, "Blend gradients of the view that is closest to the normal"),
    ("push-pull", FillMethod::PushPull, "Average visible neighbours: faster, as in Hadim et al. 2009"),
];
const REFLECTANCES: [(&str, Reflectance, &str); 4] = [
    ("auto", Reflectance::Auto, "The smaller form that meets --max-delta-e"),
    ("brdf", Reflectance::Brdf, "Normal, tint and share of two materials of each texel: for one or two materials"),
    (
        "factors",
        Reflectance::Factors,
        "Components of sampled views and lights in addition: for images and bounced light",
    ),
    (
        "pwt",
        Reflectance::Pwt,
        "Polynomial wavelet trees of all views, which are in memory at once: with the default views, for --flat-texels up to 128",
    ),
];
const IMAGE_FORMATS: [(&str, StackFormat, &str); 2] = [("png", StackFormat::Png, ""), ("exr", StackFormat::Exr, "")];

fn after_help() -> String {
    format!(
        "Structures:\n{}\nExamples:\n  brdfc flatten synth:button -o button\n  \
         brdfc flatten synth:button -o small --texels 64\n  \
         brdfc flatten 'synth:knit?count=6' -o wool --texels 128\n  \
         brdfc flatten synth:button -o fixed-cost --texels 128 --relief vdim --indirection 16x16\n  \
         brdfc flatten bricks.obj --material clay=clay.binary --material 'synth:lambert?kd=0.4' -o bricks\n  \
         brdfc flatten relief.png --height-scale 0.2 --colour relief-colour.png -o relief\n  \
         brdfc flatten corduroy/ --geometry corduroy-height.exr -o corduroy-flat",
        describe_structures()
    )
}
