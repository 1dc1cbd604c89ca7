//! Flags of `brdfc render`.

use super::adaptive_options::AdaptiveOptions;
use crate::options::PackOptions;
use brdfc::Input;
use brdfc::render::{Builtin, Filter, FlatForm};
use brdfc::scene::MAX_SAMPLES;
use brdfc_terminal::values::{one_of, whole_number};
use clap::Args;
use std::path::PathBuf;

/// Draw packs with the shaders that engines use, and say how wrong they look.
///
/// The scene is drawn by the graphics driver, a software driver if there is no other, without a display, and once more
/// on the CPU: from the packs, and from their sources where those are at hand. Differences are colour differences ΔE of
/// CIE L*a*b* per pixel that shows a surface; about 1 is just visible. Light comes from points and throws no shadows.
///
/// Schemas of --json: 'render', with --adaptive 'render-adaptive', with --contact 'render-contact'.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc render scene.toml -o scene.png
  brdfc render scene.toml --contact all.png --max-delta-e 2            every material, labelled
  brdfc render red.ktx2 -o red.png --scene cloth
  brdfc render red.ktx2 --source red-plastic.binary -o red.exr
  brdfc render red-plastic.binary --ratio 16 --sheet red.png          encodes it first
  brdfc render paint.brdf --scene cloth --max-delta-e 1.3 --json      exit code 1 when missed
  brdfc render button --scene vase -o vase.png                        a flat BTF of 'brdfc flatten'
  brdfc render button --scene plane --sheet plane.png                 beside the surface itself
  brdfc render coin.ktx2 --source coin --sheet coin.png                 a light stack's pack, beside its photographs
  brdfc render red.ktx2 --adaptive --environment museum.exr --scene bumpy-ball --sheet red.png --maps maps.png

A manifest says what is shown in its [render] table, see docs/scene.md. Without a Vulkan driver the exit code is 5.")]
pub struct Arguments {
    /// A scene manifest, a pack, a flat BTF or its folder, or anything that can be encoded: a path or
    /// synth:MODEL?param=value&..., or - for a material or a pack from stdin.
    #[arg(value_name = "SCENE.toml|INPUT")]
    pub(super) input: Input,
    /// The shader's image: .png (sRGB) or .exr (linear).
    #[arg(long, short, value_name = "IMAGE")]
    pub(super) output: Option<PathBuf>,
    /// The CPU's image, from the sources or else from the packs: .png or .exr. With --adaptive the ground truth.
    #[arg(long, value_name = "IMAGE")]
    pub(super) reference: Option<PathBuf>,
    /// ΔE per pixel of the shader's image against the reference, dark 0 to light yellow 10: .png.
    #[arg(long, value_name = "IMAGE.png")]
    pub(super) difference: Option<PathBuf>,
    /// The shader's image, the reference and their difference side by side: .png.
    #[arg(long, value_name = "IMAGE.png")]
    pub(super) sheet: Option<PathBuf>,
    /// A contact sheet: every material that the manifest's uses refer to (all where there are no uses), each alone on a
    /// sphere or --scene, with name, bytes, ΔE and the colour scale: .png. The manifest's table 'render' is not read. Limits
    /// hold for each material.
    #[arg(
        long,
        value_name = "IMAGE.png",
        conflicts_with_all = ["output", "reference", "difference", "sheet", "adaptive", "maps"]
    )]
    pub(super) contact: Option<PathBuf>,
    /// Which scene (default: the manifest's, or sphere; for a light stack's pack a plane, seen from above).
    #[arg(long, value_name = "SCENE", value_parser = one_of(&SCENES))]
    pub(super) scene: Option<Builtin>,
    /// Pixels, such as 800x600, each 1 to 8192 (default 512x512, with --contact 160x160).
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub(super) size: Option<String>,
    /// Samples per pixel and axis, 1 to 16: 2 is 4 per pixel (default 2).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(1..=MAX_SAMPLES as u64))]
    pub(super) samples: Option<usize>,
    /// Factor from radiance to the display's range, above 0 (default: the brightest 1 % of the surfaces clip).
    #[arg(long, value_name = "X")]
    pub(super) exposure: Option<f64>,
    /// How values between cells are found (default: bilinear).
    #[arg(long, value_parser = one_of(&FILTERS))]
    pub(super) filter: Option<Filter>,
    /// Filter slices, or the texels of a light stack's pack, in the shader with exact weights instead of the sampler.
    #[arg(long)]
    pub(super) exact: bool,
    /// A level of detail for all pixels, 0 to 6, coarse to fine (default: it follows the distance).
    #[arg(long, value_name = "L")]
    pub(super) lod: Option<f32>,
    /// What a pack was made from, to compare with; with --adaptive bandwidth and samples are those of its lobes. Of a light
    /// stack's pack the photograph that is nearest to each light is shown; without lights of a manifest, under its own light.
    #[arg(long, value_name = "INPUT")]
    pub(super) source: Option<Input>,
    /// Draw the packs that 'brdfc build' put into this folder (default: packs, if one was built there). What was made of
    /// something else than the manifest says now is made anew for the picture; a limit is then missed.
    #[arg(long, value_name = "DIR")]
    pub(super) packs: Option<PathBuf>,
    /// Compare whole tables too, all slices at 16 bits: what the grid alone loses.
    #[arg(long)]
    pub(super) table: bool,
    /// Fail with exit code 1 if the mean ΔE is above X: against the sources, or the CPU's decoder without them. A picture
    /// without a surface or without light fails, too, whichever limit is given.
    #[arg(long, value_name = "X")]
    pub(super) max_delta_e: Option<f64>,
    /// Fail if the 95th percentile of ΔE is above X.
    #[arg(long, value_name = "X")]
    pub(super) max_delta_e_p95: Option<f64>,
    /// Fail if the mean FLIP over surfaces is above X, 0 to 1.
    #[arg(long, value_name = "X")]
    pub(super) max_flip: Option<f64>,
    /// Use the adapter whose name contains this (default: the fastest).
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    /// Of a flat BTF: every view and light, or normal map and diffuse colours (default: full where the file has views).
    #[arg(long, value_parser = one_of(&FORMS))]
    pub(super) form: Option<FlatForm>,
    /// Of a flat BTF: tiles per unit of the scene's uv, 1 to 1024 (default: 4 on plane, bottle, vase and teapot, else 8); of a
    /// light stack's pack that is a tile, likewise (default: 1).
    #[arg(long, value_name = "N", value_parser = whole_number::<u32>(1..=1024))]
    pub(super) repeat: Option<u32>,
    #[command(flatten)]
    pub(super) adaptive: AdaptiveOptions,
    #[command(flatten, next_help_heading = "Encoding of what is no pack")]
    pub(super) options: PackOptions,
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
    ("ribbed-torus", Builtin::RibbedTorus, "A torus with a smooth and a ribbed half, likewise"),
];
const FORMS: [(&str, FlatForm, &str); 2] =
    [("full", FlatForm::Full, "Equation 1 of Hadim et al. 2009"), ("light", FlatForm::Light, "Their light form")];
const FILTERS: [(&str, Filter, &str); 3] = [
    ("nearest", Filter::Nearest, "The nearest cell"),
    ("slices", Filter::Slices, "Bilinear in slices, one reconstruction"),
    ("bilinear", Filter::Bilinear, "Bilinear, four reconstructions"),
];
