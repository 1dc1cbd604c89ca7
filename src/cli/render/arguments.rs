//! Flags of `brdfc render`.

use super::adaptive_options::AdaptiveOptions;
use crate::options::PackOptions;
use crate::reading::{PhotographOptions, ReadingOptions};
use brdfc::Input;
use brdfc::render::{Builtin, Filter};
use brdfc::scene::MAX_SAMPLES;
use brdfc_terminal::values::{one_of, whole_number};
use clap::Args;
use std::path::PathBuf;

/// Draw packs with the shaders that engines use, and measure the error of the rendering.
///
/// The graphics driver draws the scene without a display; a software driver is used if there is no other. The CPU draws
/// it again, from the packs and, if available, from their sources. The report lists colour differences ΔE (CIE L*a*b*)
/// over pixels that show a surface; a ΔE of about 1 is just visible. Lights throw no shadows: points, and the
/// environment of a scene, which lobes look up.
///
/// Schemas of --json: 'render'; 'render-adaptive' with --adaptive; 'render-contact' with --contact.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc render scene.toml -o scene.png
  brdfc render scene.toml --contact all.png --max-delta-e 2       every material, labelled
  brdfc render scene.toml --environment museum.exr -o scene.png   point lights and a room
  brdfc render red.ktx2 -o red.png --scene cloth
  brdfc render red.ktx2 --source red-plastic.binary -o red.exr
  brdfc render red-plastic.binary --ratio 16 --sheet red.png      encodes the material first
  brdfc render noisy.binary --smooth --sheet noisy.png
  brdfc render paint.brdf --scene cloth --max-delta-e 1.3 --json  exit code 1 if missed
  brdfc render button --scene vase -o vase.png                    a flat BTF
  brdfc render button --scene plane --sheet plane.png             compared with the surface
  brdfc render coin.ktx2 --source coin --sheet coin.png           compared with photographs
  brdfc render red.lobes.ktx2 --environment museum.exr -o red.png
  brdfc render red-plastic.binary --environment museum.exr --sheet red.png
  brdfc render red.ktx2 --adaptive --environment museum.exr --sheet red.png --maps maps.png

The [render] table of a manifest selects what to draw, see docs/manifest.md. Without a Vulkan driver the exit code is 5.")]
pub struct Arguments {
    /// A scene manifest, a pack, a flat BTF or its folder, or any input of 'brdfc encode': a path or
    /// synth:MODEL?param=value&..., or - for a material or a pack from stdin.
    #[arg(value_name = "SCENE.toml|INPUT")]
    pub(super) input: Input,
    /// Rendering of the shader: .png (sRGB) or .exr (linear).
    #[arg(long, short, value_name = "IMAGE")]
    pub(super) output: Option<PathBuf>,
    /// Rendering of the CPU, from the sources or else from the packs: .png or .exr. With --adaptive, the ground truth.
    #[arg(long, value_name = "IMAGE")]
    pub(super) reference: Option<PathBuf>,
    /// ΔE per pixel between the shader's rendering and the reference, from dark (0) to light yellow (10): .png.
    #[arg(long, value_name = "IMAGE.png")]
    pub(super) difference: Option<PathBuf>,
    /// The shader's rendering, the reference and their difference side by side: .png.
    #[arg(long, value_name = "IMAGE.png")]
    pub(super) sheet: Option<PathBuf>,
    /// A contact sheet of all materials that the manifest's uses refer to (all materials if there are no uses): .png.
    /// Each is drawn alone on a sphere or on --scene, with name, bytes, ΔE and the colour scale. The manifest's table
    /// render is ignored. Limits apply to each material.
    #[arg(
        long,
        value_name = "IMAGE.png",
        conflicts_with_all = ["output", "reference", "difference", "sheet", "adaptive", "maps", "rates"]
    )]
    pub(super) contact: Option<PathBuf>,
    /// Scene (default: the scene of the manifest, or sphere; for the pack of an RTI capture a plane, seen from above).
    #[arg(long, value_name = "SCENE", value_parser = one_of(&SCENES))]
    pub(super) scene: Option<Builtin>,
    /// Width and height in pixels, such as 800x600, each 1 to 8192 (default: 512x512, with --contact 160x160).
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub(super) size: Option<String>,
    /// Samples per pixel and axis, 1 to 16; 2 is 4 per pixel (default: 2).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(1..=MAX_SAMPLES as u64))]
    pub(super) samples: Option<usize>,
    /// Factor from radiance to the range of the display, above 0 (default: the brightest 1 % of the surfaces clip).
    #[arg(long, value_name = "X")]
    pub(super) exposure: Option<f64>,
    /// Interpolation of values between cells (default: bilinear).
    #[arg(long, value_parser = one_of(&FILTERS))]
    pub(super) filter: Option<Filter>,
    /// Interpolate slices, or the texels of an RTI capture's pack, in the shader with exact weights instead of in the
    /// sampler.
    #[arg(long)]
    pub(super) exact: bool,
    /// Level of detail for all pixels, 0 (coarsest) to 6; packs with fewer levels are drawn at their finest level
    /// (default: depends on the distance).
    #[arg(long, value_name = "L")]
    pub(super) lod: Option<f32>,
    /// Source of a pack, to compare with. With --adaptive, bandwidth and samples come from its lobes. For the pack of
    /// an RTI capture, the program shows the photograph that is nearest to each light; without lights in a manifest, it
    /// uses the photograph's own light.
    #[arg(long, value_name = "INPUT")]
    pub(super) source: Option<Input>,
    /// Draw the packs that 'brdfc build' put into this folder (default: packs, if a build filled it). Packs whose
    /// source or options differ from the manifest are encoded again for the rendering. With this option, such packs
    /// fail any limit.
    #[arg(long, value_name = "DIR")]
    pub(super) packs: Option<PathBuf>,
    /// Also compare whole tables, all slices at 16 bits, which shows the error of the grid alone.
    #[arg(long)]
    pub(super) table: bool,
    /// Fail with exit code 1 if the mean ΔE of the rendering is above X, a number of 0 or more. The reference is drawn
    /// from the sources, or without sources by the CPU's decoder. With any limit, a rendering without a surface or
    /// without light fails. --pack-delta-e limits the encoding of materials instead, as --max-delta-e of 'brdfc encode'
    /// does.
    #[arg(long, value_name = "X")]
    pub(super) max_delta_e: Option<f64>,
    /// Fail with exit code 1 if the 95th percentile of ΔE is above X, a number of 0 or more.
    #[arg(long, value_name = "X")]
    pub(super) max_delta_e_p95: Option<f64>,
    /// Fail with exit code 1 if the mean FLIP over surfaces is above X, 0 to 1.
    #[arg(long, value_name = "X")]
    pub(super) max_flip: Option<f64>,
    /// Use the adapter whose name contains this text (default: the fastest).
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Tiles of a flat BTF per unit of the scene's uv, 1 to 1024 (default: 4 on plane, bottle, vase and teapot, else
    /// 8). Also applies to the pack of an RTI capture that is a tile (default: 1).
    #[arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=1024))]
    pub(super) repeat: Option<u32>,
    #[command(flatten)]
    pub(super) adaptive: AdaptiveOptions,
    #[command(flatten, next_help_heading = "Encoding of materials")]
    pub(super) options: PackOptions,
    #[command(flatten, next_help_heading = "Reading of materials")]
    pub(super) reading: ReadingOptions,
    #[command(flatten, next_help_heading = "Reading of photographs")]
    pub(super) images: PhotographOptions,
}

const SCENES: [(&str, Builtin, &str); 10] = [
    ("sphere", Builtin::Sphere, "A ball"),
    ("cloth", Builtin::Cloth, "A draped cloth: its tangents follow the weave"),
    ("table", Builtin::Table, "A still life of four materials, one bumped, one mirroring its environment"),
    ("terrain", Builtin::Terrain, "A landscape at a grazing angle, for levels of detail"),
    ("plane", Builtin::Plane, "A square on the ground, seen obliquely"),
    ("bottle", Builtin::Bottle, "A bottle: a surface of revolution"),
    ("vase", Builtin::Vase, "A vase: a surface of revolution"),
    ("teapot", Builtin::Teapot, "A teapot with lid, spout and handle"),
    ("bumpy-ball", Builtin::BumpyBall, "A ball with a smooth and a bumpy half, without point lights: for environments"),
    ("ribbed-torus", Builtin::RibbedTorus, "A torus with a smooth and a ribbed half, lit like bumpy-ball"),
];
const FILTERS: [(&str, Filter, &str); 3] = [
    ("nearest", Filter::Nearest, "The nearest cell"),
    ("slices", Filter::Slices, "Bilinear over the light, nearest over the viewer"),
    ("bilinear", Filter::Bilinear, "Bilinear, four reconstructions"),
];

impl Arguments {
    /// Returns true if the environment of the command line lights materials by their lobes.
    pub(super) fn by_lobes(&self) -> bool {
        self.adaptive.environment.is_some() && !self.adaptive.adaptive
    }
}
