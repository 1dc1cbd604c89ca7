//! `brdfc render`: packs drawn by the shaders that engines use, and how wrong they look.

mod adaptive;
mod flat;
mod materials;
mod outputs;
mod scene;

use super::options::PackOptions;
use super::output::{print, print_json, remark};
use super::{CliError, Common, graphics_environment};
use crate::table;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_gpu::verify::{Material, Views, views};
use brdfc_gpu::{AdapterChoice, Decoding, Gpu, SliceFilter};
use brdfc_jobs::report::render::{PartMaterial, Verification};
use brdfc_render::scenes::Builtin;
use brdfc_source::Source;
use clap::{Args, ValueEnum};
use materials::Prepared;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Draw packs with the shaders that engines use, and say how wrong they look.
///
/// The scene is drawn by the graphics driver, a software driver if there is no other, without a display, and once more
/// on the CPU: from the packs, and from their sources where those are at hand. Differences are colour differences ΔE of
/// CIE L*a*b* per pixel that shows a surface; about 1 is just visible. Light comes from points and throws no shadows.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc render scene.toml -o scene.png
  brdfc render red.ktx2 -o red.png --scene cloth
  brdfc render red.ktx2 --source red-plastic.binary -o red.exr
  brdfc render red-plastic.binary --ratio 16 --sheet red.png          encodes it first
  brdfc render paint.brdf --scene cloth --max-delta-e 1.3 --json      exit code 1 when missed
  brdfc render button --scene vase -o vase.png                        a flat BTF of 'brdfc flatten'
  brdfc render button --scene plane --sheet plane.png                 beside the surface itself
  brdfc render red.ktx2 --adaptive --environment museum.exr --scene bumpy-ball --sheet red.png --maps maps.png

A manifest says what is shown in its [render] table, see docs/scene.md. Without a Vulkan driver the exit code is 5.")]
pub struct Arguments {
    /// A scene manifest, a pack, the folder or the .json of a flat BTF, or anything that can be encoded: a path or
    /// synth:MODEL?param=value&...
    #[arg(value_name = "SCENE.toml|INPUT")]
    input: String,
    /// The shader's image: .png (sRGB) or .exr (linear).
    #[arg(long, short, value_name = "IMAGE")]
    output: Option<PathBuf>,
    /// The CPU's image, from the sources or else from the packs: .png or .exr. With --adaptive the ground truth.
    #[arg(long, value_name = "IMAGE")]
    reference: Option<PathBuf>,
    /// ΔE per pixel of the shader's image against the reference, dark 0 to light yellow 10: .png.
    #[arg(long, value_name = "IMAGE.png")]
    difference: Option<PathBuf>,
    /// The shader's image, the reference and their difference side by side: .png.
    #[arg(long, value_name = "IMAGE.png")]
    sheet: Option<PathBuf>,
    /// Which scene (default: the manifest's, or sphere).
    #[arg(long, value_enum, value_name = "SCENE")]
    scene: Option<SceneName>,
    /// Pixels, such as 800x600 (default 512x512).
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Samples per pixel and axis: 2 is 4 per pixel (default 2).
    #[arg(long, value_name = "N")]
    samples: Option<usize>,
    /// Factor from radiance to the display's range (default: the brightest 1 % of the surfaces clip).
    #[arg(long, value_name = "X")]
    exposure: Option<f64>,
    /// How values between cells are found (default: bilinear).
    #[arg(long, value_enum)]
    filter: Option<FilterName>,
    /// Filter slices in the shader with exact weights instead of the sampler.
    #[arg(long)]
    exact: bool,
    /// A level of detail for all pixels (default: it follows the distance).
    #[arg(long, value_name = "L")]
    lod: Option<f32>,
    /// What a pack was made from, to compare with; with --adaptive bandwidth and samples are those of its lobes.
    #[arg(long, value_name = "INPUT")]
    source: Option<String>,
    /// Take the packs of a manifest from this folder, where 'brdfc build' put them, instead of encoding.
    #[arg(long, value_name = "DIR")]
    packs: Option<PathBuf>,
    /// Compare whole tables too, all slices at 16 bits: what the grid alone loses.
    #[arg(long)]
    table: bool,
    /// Fail with exit code 1 if the mean ΔE is above X: against the sources, or the CPU's decoder without them.
    #[arg(long, value_name = "X")]
    max_delta_e: Option<f64>,
    /// Use the adapter whose name contains this (default: the fastest).
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Of a flat BTF: every view and light, or normal map and diffuse colours (default: full where the folder has views).
    #[arg(long, value_enum)]
    form: Option<FormName>,
    /// Of a flat BTF: tiles per unit of the scene's uv (default: 4 on plane, bottle, vase and teapot, else 8).
    #[arg(long, value_name = "N")]
    repeat: Option<u32>,
    #[command(flatten)]
    adaptive: adaptive::Options,
    #[command(flatten)]
    options: PackOptions,
    /// Print JSON (schema: 'brdfc schema render', with --adaptive 'brdfc schema render-adaptive').
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SceneName {
    /// A ball.
    Sphere,
    /// A draped cloth: its tangents follow the weave.
    Cloth,
    /// A still life of four materials, one bumped, one mirroring its environment.
    Table,
    /// A landscape at a grazing angle, for levels of detail.
    Terrain,
    /// A square on the ground, seen obliquely.
    Plane,
    /// A bottle: a surface of revolution.
    Bottle,
    /// A vase: a surface of revolution.
    Vase,
    /// A teapot with lid, spout and handle.
    Teapot,
    /// A ball with a smooth and a bumpy half, without point lights: for environments.
    BumpyBall,
    /// A torus with a smooth and a ribbed half, likewise.
    RibbedTorus,
}

impl From<SceneName> for Builtin {
    fn from(name: SceneName) -> Self {
        match name {
            SceneName::Sphere => Self::Sphere,
            SceneName::Cloth => Self::Cloth,
            SceneName::Table => Self::Table,
            SceneName::Terrain => Self::Terrain,
            SceneName::Plane => Self::Plane,
            SceneName::Bottle => Self::Bottle,
            SceneName::Vase => Self::Vase,
            SceneName::Teapot => Self::Teapot,
            SceneName::BumpyBall => Self::BumpyBall,
            SceneName::RibbedTorus => Self::RibbedTorus,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormName {
    /// Equation 1 of Hadim et al. 2009.
    Full,
    /// Their light form.
    Light,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum FilterName {
    /// The nearest cell.
    Nearest,
    /// Bilinear in slices, one reconstruction.
    Slices,
    /// Bilinear, four reconstructions.
    Bilinear,
}

impl From<FilterName> for Filter {
    fn from(name: FilterName) -> Self {
        match name {
            FilterName::Nearest => Self::Nearest,
            FilterName::Slices => Self::Slices,
            FilterName::Bilinear => Self::Bilinear,
        }
    }
}

pub use adaptive::Report as AdaptiveReport;

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// What was drawn and measured.
    #[serde(flatten)]
    verification: Verification,
    /// Seconds from the start to the last image, encoding included.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    graphics_environment::prepare();
    let started = Instant::now();
    outputs::check(arguments)?;
    if let Some(limit) = arguments.max_delta_e
        && !(limit >= 0.0 && limit.is_finite())
    {
        return Err(CliError::Usage(format!("--max-delta-e: found {limit}; allowed a number, 0 or more")));
    }
    if let Some(level) = arguments.lod
        && !(0.0..=6.0).contains(&level)
    {
        return Err(CliError::Usage(format!("--lod: found {level}; allowed 0 to 6")));
    }
    if adaptive::is_adaptive(arguments) {
        return adaptive::run(arguments, common);
    }
    let (verification, views) = if flat::is_flat(&arguments.input) {
        flat::verification(arguments, common)?
    } else {
        of_brdfs(arguments, common)?
    };
    if verification.checked().pixels == 0 {
        remark(common, "note: no pixel shows a surface; look at render.camera");
    } else if views.reference().pixels.iter().all(|pixel| *pixel == [0.0; 3]) {
        remark(common, "note: all surfaces are black: no light reaches what is seen, or the materials reflect none");
    }
    drop(views);
    let seconds = started.elapsed().as_secs_f64();
    let checked = arguments.max_delta_e.map(|limit| check(&verification, limit));
    if arguments.json {
        print_json(&Report { version: 1, verification, seconds })?;
    } else {
        print(&outputs::text(&verification))?;
        remark(common, &format!("{seconds:.1} s"));
    }
    checked.unwrap_or(Ok(()))
}

/// Draws packs of BRDFs.
fn of_brdfs(arguments: &Arguments, common: Common) -> Result<(Verification, Views), CliError> {
    if let Some(flag) = flat::flag_of_flat(arguments) {
        let text = format!("{flag}: found with {}; allowed with the folder of a flat BTF", arguments.input);
        return Err(CliError::Usage(text));
    }
    let subject = materials::subject(arguments)?;
    let setup = scene::setup(arguments, &subject)?;
    // Before the work: without an adapter there is nothing to wait for.
    let choice = arguments.adapter.clone().map_or(AdapterChoice::Best, AdapterChoice::Named);
    let gpu = Gpu::open(&choice)?;
    let prepared = materials::prepare(arguments, &subject, &setup.names, common)?;

    let of_part = |name: &String| prepared.iter().find(|p| p.name == *name).expect("every name was prepared");
    let parts: Vec<&Prepared> = setup.names.iter().map(of_part).collect();
    let materials: Vec<Material<'_>> = parts
        .iter()
        .map(|part| Material {
            pack: &part.pack,
            source: part.source.as_deref().map(|source| source as &dyn Source),
            table: part.table.as_ref(),
        })
        .collect();
    let decoding = Decoding {
        filter: arguments.filter.unwrap_or(FilterName::Bilinear).into(),
        slices: if arguments.exact { SliceFilter::Exact } else { SliceFilter::Hardware },
        level: arguments.lod,
        distance_scale: subject.distance_scale().unwrap_or(DEFAULT_DISTANCE_SCALE),
    };
    let views = views(&gpu, &setup.scene, setup.frame, &materials, decoding)?;
    let listed = setup.scene.parts.iter().zip(&parts).map(|(part, material)| PartMaterial {
        part: part.name.to_owned(),
        material: material.name.clone(),
        bytes_on_gpu: material.pack.gpu_bytes(),
    });
    let verification = Verification::new(
        setup.builtin.name(),
        setup.frame,
        &views,
        setup.exposure,
        gpu.description(),
        listed.collect(),
    );
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// A check that rests on nothing fails too.
fn check(verification: &Verification, limit: f64) -> Result<(), CliError> {
    let difference = verification.checked();
    let found = if difference.pixels == 0 {
        "no pixel that shows a surface".to_owned()
    } else if difference.invalid_pixels > 0 {
        format!("{} pixels that hold no number", difference.invalid_pixels)
    } else if difference.delta_e.mean > limit {
        table::significant(difference.delta_e.mean)
    } else {
        return Ok(());
    };
    Err(CliError::Check(format!("mean ΔE: found {found}; allowed {limit}")))
}
