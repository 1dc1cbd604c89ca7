//! The flags of `brdfc flatten`.

use crate::directions::INDIRECTION;
use brdfc::Input;
use brdfc::flatten::{FillMethod, Form, StackFormat, describe_structures};
use brdfc_terminal::values::{any_whole_number, bytes_from_text, one_of, whole_number};
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Make a flat BTF: appearance on the surface itself, and maps of where each view sees it, in one file.
///
/// MESO is one tile of a surface that repeats: synth:STRUCTURE, a mesh (.obj, .ply), a height map (.png of 8 or 16 bits
/// grey, .exr), or an ordinary BTF, a folder of images or a .btf file, whose relief --geometry gives. Every mesh is closed over the
/// tile's borders first; what was repaired is reported. A surface has at most 1048576 vertices, and so many pixels a height
/// map: 1024 x 1024.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct Arguments {
    /// synth:STRUCTURE, a mesh, a height map, a folder of BTF images, a .btf file, or - for a mesh or a height map from stdin.
    pub(super) meso: Input,
    /// Folder of the file, NAME.ktx2; made if there is none.
    #[arg(long, short, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Name of the file, without .ktx2 (default: the folder's).
    #[arg(long)]
    pub(super) name: Option<String>,
    /// Relief of a folder of BTF images or a .btf file: mesh, height map or structure (default: the plane).
    #[arg(long, value_name = "MESO")]
    pub(super) geometry: Option<Input>,
    /// Period of a mesh along x and y, in its unit (default: 1).
    #[arg(long, value_name = "SIZE")]
    pub(super) tile: Option<f64>,
    /// Tiles per unit of a height map, white of a PNG is 1 (default: 0.1).
    #[arg(long, value_name = "TILES")]
    pub(super) height_scale: Option<f64>,
    /// Height of a height map's 0 above the reference plane, in tiles (default: 0).
    #[arg(long, value_name = "TILES")]
    pub(super) height_offset: Option<f64>,
    /// Material: any INPUT of 'brdfc encode', or NAME=INPUT for the faces of that name in a mesh. Up to four; a structure
    /// blends its own by default.
    #[arg(long, value_name = "[NAME=]INPUT")]
    pub(super) material: Vec<OsString>,
    /// Image over the tile that multiplies the reflectance (PNG or JPEG, sRGB).
    #[arg(long, value_name = "IMAGE")]
    pub(super) colour: Option<Input>,
    /// Image over the tile whose red, green, blue and alpha are the shares of the materials, in their order.
    #[arg(long, value_name = "IMAGE")]
    pub(super) weights: Option<Input>,
    /// Texels of the reference plane and its indirection map, per side.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = whole_number::<u32>(4..=2048))]
    pub(super) texels: u32,
    /// Texels of the flat BTF per side, a power of two (default: the one from --texels on).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<usize>(FLAT_TEXELS))]
    pub(super) flat_texels: Option<usize>,
    /// Views: ubo2003 (81), ubo2014 (151), grid:ZxA@DEGREES, or a .csv file with index,theta_deg,phi_deg (default: ubo2003).
    /// A grid has Z polar angles from the zenith, one direction, to DEGREES, with A azimuths at each of the others:
    /// grid:2x6@50 has 1 + 6 = 7 directions.
    #[arg(long, value_name = "SET")]
    pub(super) views: Option<Input>,
    /// Lights (default: as the views).
    #[arg(long, value_name = "SET")]
    pub(super) lights: Option<Input>,
    /// Polar angles x azimuths of the indirection map.
    #[arg(long, value_name = "ZxA", default_value = INDIRECTION, allow_hyphen_values = true)]
    pub(super) indirection: String,
    /// Largest polar angle of the indirection map, degrees; steeper views see what it sees.
    #[arg(long, value_name = "DEGREES", default_value_t = 80.0)]
    pub(super) largest_angle: f64,
    /// Rays per texel and axis for the indirection map.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole_number::<usize>(1..=16))]
    pub(super) oversampling: usize,
    /// What texels of the full form get that a view does not see (default: poisson).
    #[arg(long, value_parser = one_of(&FILLS))]
    pub(super) fill: Option<FillMethod>,
    /// Rays per texel that gather the light of one bounce; 0: direct light and cast shadows only.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole_number::<usize>(0..=1024))]
    pub(super) bounces: usize,
    /// Rounds of reweighting that spend texels where the surface is, as long as the stretch falls.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole_number::<usize>(0..=100))]
    pub(super) stretch_rounds: usize,
    /// full: every view and light, as factors; light: normal map and diffuse colours instead.
    #[arg(long, value_parser = one_of(&FORMS), default_value = "full")]
    pub(super) form: Form,
    /// Mean ΔE (CIE76) of factors from the views, where texels are seen, to stay below (default: 0.7). What nothing meets keeps the best, with exit
    /// code 1 where it was asked for.
    #[arg(long, value_name = "E")]
    pub(super) max_delta_e: Option<f64>,
    /// Most bytes of factors on a GPU, mipmaps included, of which those with the least error are kept: a number with or without KiB or
    /// MiB.
    #[arg(long, value_name = "BYTES", conflicts_with = "max_delta_e", value_parser = bytes_from_text)]
    pub(super) max_bytes: Option<u64>,
    /// Also write the ordinary BTF, computed directly from direct light, as images into a new or empty folder.
    #[arg(long, value_name = "DIR")]
    pub(super) write_images: Option<PathBuf>,
    /// Kind of these images: png (8 bits, sRGB) or exr (16-bit floats, linear) (default: png).
    #[arg(long, value_parser = one_of(&IMAGE_FORMATS))]
    pub(super) image_format: Option<StackFormat>,
    /// Store texels as they are, without Zstandard.
    #[arg(long)]
    pub(super) no_supercompression: bool,
}

/// What texels of a flat BTF may be, per side.
pub(super) const FLAT_TEXELS: &str =
    "a power of two from 4 to 2048, because holes are filled from images of half the size each";

const FILLS: [(&str, FillMethod, &str); 2] = [
    ("poisson", FillMethod::Poisson, "Gradients of the view that sees them most from above"),
    ("push-pull", FillMethod::PushPull, "Means of what is seen around them: faster, as in the paper"),
];
const FORMS: [(&str, Form, &str); 2] =
    [("full", Form::Full, "Equation 1"), ("light", Form::Light, "Normal map and diffuse colours")];
const IMAGE_FORMATS: [(&str, StackFormat, &str); 2] = [("png", StackFormat::Png, ""), ("exr", StackFormat::Exr, "")];

fn after_help() -> String {
    format!(
        "Structures:\n{}\nExamples:\n  brdfc flatten synth:button -o button\n  \
         brdfc flatten synth:button -o small --max-bytes 10MiB\n  \
         brdfc flatten 'synth:knit?count=6' -o wool --form light --texels 128\n  \
         brdfc flatten bricks.obj --tile 2 --material clay=clay.binary --material synth:lambert?kd=0.4 -o bricks\n  \
         brdfc flatten relief.png --height-scale 0.2 --colour relief-colour.png -o relief\n  \
         brdfc flatten corduroy/ --geometry corduroy-height.exr -o corduroy-flat",
        describe_structures()
    )
}
