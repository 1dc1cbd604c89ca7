//! `brdfc flatten`: flat BTFs of surfaces with relief, and of ordinary BTFs.

use super::output::{print, print_json, printable, remark};
use super::steps::Steps;
use super::{CliError, Common};
use crate::btf::fill::FillMethod;
use crate::btf::probes::ColourErrors;
use crate::btf::structures::describe_structures;
use crate::build::btf_stack::StackFormat;
use crate::build::flatten::{
    AssetFile, FlattenError, FlattenJob, FlattenRecipe, Form, MesoOptions, Values, material_list, open_appearance,
    open_geometry, run as flatten,
};
use crate::report::table::{bytes, percent};
use crate::source::btf_stack::BtfStack;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::pack::flat_btf::IndirectionHeader;
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Make the packs of a flat BTF: appearance on the surface itself, and maps of where each view sees it.
///
/// MESO is one tile of a surface that repeats: synth:STRUCTURE, a mesh (.obj, .ply), a height map (.png of 8 or 16 bits
/// grey, .exr), or a folder of images of an ordinary BTF, whose relief --geometry gives. Every mesh is closed over the
/// tile's borders first; what was mended is reported. A surface has at most 1048576 vertices, and so many pixels a height
/// map: 1024 x 1024.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct Arguments {
    /// synth:STRUCTURE, a mesh, a height map, or a folder of BTF images.
    meso: String,
    /// Folder of the packs; made if there is none.
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    /// Name of the asset's files (default: the folder's).
    #[arg(long)]
    name: Option<String>,
    /// Relief of a folder of BTF images: mesh, height map or structure (default: the plane).
    #[arg(long, value_name = "MESO")]
    geometry: Option<String>,
    /// Period of a mesh along x and y, in its unit.
    #[arg(long, value_name = "SIZE", default_value_t = 1.0)]
    tile: f64,
    /// Tiles per unit of a height map (white of a PNG is 1).
    #[arg(long, value_name = "TILES", default_value_t = 0.1, allow_negative_numbers = true)]
    height_scale: f64,
    /// Height of a height map's 0 above the reference plane, in tiles.
    #[arg(long, value_name = "TILES", default_value_t = 0.0, allow_negative_numbers = true)]
    height_offset: f64,
    /// Material: any INPUT of 'brdfc encode', or NAME=INPUT for the faces of that name in a mesh. Up to four; a structure
    /// blends its own by default.
    #[arg(long, value_name = "[NAME=]INPUT")]
    material: Vec<String>,
    /// Image over the tile that multiplies the reflectance (PNG or JPEG, sRGB).
    #[arg(long, value_name = "IMAGE")]
    colour: Option<String>,
    /// Image over the tile whose red, green, blue and alpha are the shares of the materials, in their order.
    #[arg(long, value_name = "IMAGE")]
    weights: Option<String>,
    /// Texels of the reference plane and its indirection map, per side.
    #[arg(long, value_name = "N", default_value_t = 256)]
    texels: u32,
    /// Texels of the flat BTF per side, a power of two (default: the one from --texels on).
    #[arg(long, value_name = "N")]
    flat_texels: Option<usize>,
    /// Views: ubo2003 (81), ubo2014 (151), grid:ZxA@DEGREES, or a CSV file with index,theta_deg,phi_deg.
    #[arg(long, value_name = "SET", default_value = "ubo2003")]
    views: String,
    /// Lights (default: as the views).
    #[arg(long, value_name = "SET")]
    lights: Option<String>,
    /// Polar angles x azimuths of the indirection map.
    #[arg(long, value_name = "ZxA", default_value = "16x16")]
    indirection: String,
    /// Largest polar angle of the indirection map, degrees; steeper views see what it sees.
    #[arg(long, value_name = "DEGREES", default_value_t = 80.0)]
    largest_angle: f64,
    /// Rays per texel and axis for the indirection map.
    #[arg(long, value_name = "N", default_value_t = 2)]
    oversampling: usize,
    /// What texels get that a view does not see.
    #[arg(long, value_enum, default_value = "poisson")]
    fill: Fill,
    /// Rays per texel that gather the light of one bounce; 0: direct light and cast shadows only.
    #[arg(long, value_name = "N", default_value_t = 0)]
    bounces: usize,
    /// Rounds of reweighting that spend texels where the surface is, as long as the stretch falls.
    #[arg(long, value_name = "N", default_value_t = 0)]
    stretch_rounds: usize,
    /// full: everything; light: normal map and diffuse colours instead of views x lights.
    #[arg(long, value_enum, default_value = "full")]
    form: FormArgument,
    /// Also write the ordinary BTF, computed directly, as a folder of images.
    #[arg(long, value_name = "DIR")]
    write_images: Option<PathBuf>,
    /// Kind of these images: png (8 bits, sRGB) or exr (16-bit floats, linear).
    #[arg(long, value_enum, default_value = "png")]
    image_format: ImageFormat,
    /// Store texels as they are, without Zstandard.
    #[arg(long)]
    no_supercompression: bool,
    /// Print the report as JSON (schema: 'brdfc schema flatten').
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Fill {
    /// Gradients of the view that sees them most from above.
    Poisson,
    /// Means of what is seen around them: faster, as in the paper.
    PushPull,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FormArgument {
    /// Equation 1.
    Full,
    /// Normal map and diffuse colours.
    Light,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ImageFormat {
    Png,
    Exr,
}

fn after_help() -> String {
    format!(
        "Structures:\n{}\nExamples:\n  brdfc flatten synth:button -o button\n  \
         brdfc flatten 'synth:knit?count=6' -o wool --form light --texels 128\n  \
         brdfc flatten bricks.obj --tile 2 --material clay=clay.binary --material synth:lambert?kd=0.4 -o bricks\n  \
         brdfc flatten relief.png --height-scale 0.2 --colour relief-colour.png -o relief\n  \
         brdfc flatten corduroy/ --geometry corduroy-height.exr -o corduroy-flat",
        describe_structures()
    )
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// The asset, as its own file has it.
    #[serde(flatten)]
    asset: AssetFile,
    /// Seconds from start to finish.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let started = Instant::now();
    let is_stack = Path::new(&arguments.meso).is_dir();
    let name = asset_name(arguments)?;
    let mut recipe = recipe(arguments)?;
    let options = meso_options(arguments, is_stack)?;
    let (geometry, materials, values) = if is_stack {
        let stack = BtfStack::open(Path::new(&arguments.meso))?;
        (recipe.views, recipe.lights) = (stack.views().clone(), stack.lights().clone());
        let mut geometry = open_geometry(&options)?;
        let folder = Path::new(&arguments.meso).canonicalize().ok();
        let folder = folder.as_deref().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
        geometry.name = format!("{} over {}", folder.unwrap_or_else(|| "images".to_owned()), geometry.name);
        (geometry, Vec::new(), Values::Measured(stack))
    } else {
        let geometry = open_geometry(&options)?;
        let materials = material_list(&options, &geometry)?;
        let appearance = open_appearance(&options, &materials, &mut ())?;
        let names = materials.iter().map(|material| without_folder(material)).collect();
        (geometry, names, Values::Computed(appearance))
    };
    std::fs::create_dir_all(&arguments.out).map_err(|error| CliError::write(&arguments.out, &error))?;
    let cancelled = watch_for_interrupts()?;
    let steps = Steps::new(common, &cancelled);
    let format = match arguments.image_format {
        ImageFormat::Png => StackFormat::Png,
        ImageFormat::Exr => StackFormat::Exr,
    };
    let images = arguments.write_images.as_deref().map(|folder| (folder, format));
    let job = FlattenJob { name: &name, folder: &arguments.out, recipe: &recipe, geometry, materials, values, images };
    let asset = flatten(job, &steps).map_err(|error| match error {
        FlattenError::Parameterise(error) => CliError::Input(format!("{}: {error}", options.geometry)),
        error => error.into(),
    })?;
    drop(steps);
    for line in remarks(&asset) {
        remark(common, &format!("note: {line}"));
    }
    let seconds = started.elapsed().as_secs_f64();
    if arguments.json {
        return print_json(&Report { asset, seconds });
    }
    print(&text(&asset, Some(seconds)))
}

/// A flag that is set by the first interrupt; the second ends the process at once.
fn watch_for_interrupts() -> Result<Arc<AtomicBool>, CliError> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .map_err(|error| CliError::Internal(format!("cannot watch for interrupts: {error}")))?;
    Ok(cancelled)
}

fn without_folder(material: &str) -> String {
    if crate::source::address::is_synth(material) {
        return material.to_owned();
    }
    Path::new(material).file_name().map_or_else(|| material.to_owned(), |name| name.to_string_lossy().into_owned())
}

fn asset_name(arguments: &Arguments) -> Result<String, CliError> {
    let folder = || {
        let whole = std::path::absolute(&arguments.out).ok()?;
        let path = whole.components().next_back()?;
        Some(path.as_os_str().to_string_lossy().into_owned())
    };
    let name = arguments.name.clone().or_else(folder).unwrap_or_default();
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    if name.is_empty() || name.starts_with('.') || !name.chars().all(allowed) {
        let text = format!("--name: found {name:?}; allowed letters, digits, spaces and -_. (give one with --name)");
        return Err(CliError::Usage(text));
    }
    Ok(name)
}

fn meso_options(arguments: &Arguments, is_stack: bool) -> Result<MesoOptions, CliError> {
    let for_stacks = [(arguments.geometry.is_some(), "--geometry")];
    let for_surfaces = [
        (!arguments.material.is_empty(), "--material"),
        (arguments.colour.is_some(), "--colour"),
        (arguments.weights.is_some(), "--weights"),
        (arguments.bounces > 0, "--bounces"),
        (arguments.write_images.is_some(), "--write-images"),
        (arguments.lights.is_some(), "--lights"),
    ];
    let wrong: &[(bool, &str)] = if is_stack { &for_surfaces } else { &for_stacks };
    if let Some((_, option)) = wrong.iter().find(|(given, _)| *given) {
        let (found, allowed) = if is_stack {
            ("a folder of images", "with a surface, whose appearance is computed")
        } else {
            ("a surface", "with a folder of images")
        };
        return Err(CliError::Usage(format!("{option}: found with {found}; allowed {allowed}")));
    }
    for (option, value) in [("height-scale", arguments.height_scale), ("height-offset", arguments.height_offset)] {
        if !(-10.0..=10.0).contains(&value) {
            return Err(CliError::Usage(format!("--{option}: found {value}; allowed -10 to 10 tiles")));
        }
    }
    let plane = || "synth:sponge?height=0&resolution=16".to_owned();
    let geometry = if is_stack { arguments.geometry.clone().unwrap_or_else(plane) } else { arguments.meso.clone() };
    let materials = arguments.material.iter().map(|text| named_material(text)).collect();
    Ok(MesoOptions {
        geometry,
        tile: arguments.tile,
        height_scale: arguments.height_scale,
        height_offset: arguments.height_offset,
        materials,
        colour: arguments.colour.clone(),
        weights: arguments.weights.clone(),
    })
}

/// `NAME=INPUT`, or an input alone; the `=` of an address is no name's.
fn named_material(text: &str) -> (Option<String>, String) {
    match text.split_once('=') {
        Some((name, source)) if !crate::source::address::is_synth(text) && !Path::new(text).exists() => {
            (Some(name.to_owned()), source.to_owned())
        }
        _ => (None, text.to_owned()),
    }
}

fn recipe(arguments: &Arguments) -> Result<FlattenRecipe, CliError> {
    let wrong = |option: &str, found: &dyn std::fmt::Display, allowed: &str| {
        CliError::Usage(format!("--{option}: found {found}; allowed {allowed}"))
    };
    if !(4..=2048).contains(&arguments.texels) {
        return Err(wrong("texels", &arguments.texels, "4 to 2048"));
    }
    let flat_texels = arguments.flat_texels.unwrap_or((arguments.texels as usize).next_power_of_two());
    if !(4..=2048).contains(&flat_texels) || !flat_texels.is_power_of_two() {
        return Err(wrong("flat-texels", &flat_texels, "a power of two from 4 to 2048"));
    }
    if !(arguments.largest_angle > 0.0 && arguments.largest_angle <= 89.0) {
        return Err(wrong("largest-angle", &arguments.largest_angle, "above 0, up to 89 degrees"));
    }
    for (option, value, range) in [
        ("oversampling", arguments.oversampling, 1..=16),
        ("bounces", arguments.bounces, 0..=1024),
        ("stretch-rounds", arguments.stretch_rounds, 0..=100),
    ] {
        if !range.contains(&value) {
            return Err(wrong(option, &value, &format!("{} to {}", range.start(), range.end())));
        }
    }
    let [zenith_samples, azimuth_samples] = pair(&arguments.indirection)
        .ok_or_else(|| wrong("indirection", &arguments.indirection, "polar angles x azimuths, such as 16x16"))?;
    let indirection = IndirectionHeader {
        size: arguments.texels,
        zenith_samples,
        azimuth_samples,
        largest_angle: arguments.largest_angle.to_radians() as f32,
    };
    indirection.check().map_err(|error| CliError::Usage(format!("--indirection, --texels: {error}")))?;
    let views = direction_set("views", &arguments.views)?;
    let lights = arguments.lights.as_ref().map_or(Ok(views.clone()), |lights| direction_set("lights", lights))?;
    Ok(FlattenRecipe {
        flat_texels,
        indirection,
        oversampling: arguments.oversampling,
        views,
        lights,
        fill: match arguments.fill {
            Fill::Poisson => FillMethod::Poisson,
            Fill::PushPull => FillMethod::PushPull,
        },
        bounces: arguments.bounces,
        rounds: arguments.stretch_rounds,
        form: match arguments.form {
            FormArgument::Full => Form::Full,
            FormArgument::Light => Form::Light,
        },
        supercompress: !arguments.no_supercompression,
    })
}

fn pair(text: &str) -> Option<[u32; 2]> {
    let (a, b) = text.split_once('x')?;
    Some([a.parse().ok()?, b.parse().ok()?])
}

/// A set of directions by its name, or from a file.
pub(super) fn direction_set(option: &str, text: &str) -> Result<DirectionSet, CliError> {
    match text {
        "ubo2003" => return Ok(DirectionSet::ubo2003()),
        "ubo2014" => return Ok(DirectionSet::ubo2014()),
        _ => {}
    }
    if let Some(grid) = text.strip_prefix("grid:") {
        let parsed = grid.split_once('@').and_then(|(size, angle)| Some((pair(size)?, angle.parse::<f64>().ok()?)));
        let Some(([zeniths, azimuths], angle)) = parsed else {
            let allowed = "grid:ZxA@DEGREES, such as grid:5x12@75";
            return Err(CliError::Usage(format!("--{option}: found {text}; allowed {allowed}")));
        };
        return DirectionSet::grid(zeniths as usize, azimuths as usize, angle)
            .map_err(|error| CliError::Usage(format!("--{option}: {error}")));
    }
    if !text.ends_with(".csv") {
        let allowed = "ubo2003, ubo2014, grid:ZxA@DEGREES, or a .csv file";
        return Err(CliError::Usage(format!("--{option}: found {text}; allowed {allowed}")));
    }
    let path = Path::new(text);
    let bytes = std::fs::read(path).map_err(|error| CliError::read(path, &error))?;
    DirectionSet::from_csv(&bytes).map_err(|error| CliError::Input(format!("{text}: {error}")))
}

/// What a user should know.
fn remarks(asset: &AssetFile) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(mended) = &asset.report.mended {
        for (count, what) in [
            (mended.unreferenced_vertices, "vertices that no triangle has were left out"),
            (mended.degenerate_triangles, "triangles with two equal corners were left out"),
            (mended.duplicate_triangles, "triangles that were there twice were left out"),
            (mended.turned_triangles, "triangles were turned over, so that outside is up"),
            (mended.exchanged_edges, "triangles without area were mended"),
        ] {
            if count > 0 {
                lines.push(format!("{count} {what}"));
            }
        }
    }
    if asset.report.never_seen > 0 {
        let share = asset.report.never_seen as f64 / (asset.settings.flat_texels as f64).powi(2);
        lines.push(format!("{} of the texels are seen by no view", percent(share)));
    }
    lines
}

/// What people read of an asset.
pub(super) fn text(asset: &AssetFile, seconds: Option<f64>) -> String {
    let (report, settings) = (&asset.report, &asset.settings);
    let stretch = &report.parameterisation.after;
    let mut rows = vec![
        ("source", asset.source.clone()),
        ("texels", format!("{0} x {0} flat, {1} x {1} on the plane", settings.flat_texels, settings.texels)),
        ("views x lights", format!("{} x {}", settings.views.1, settings.lights.1)),
        ("heights", format!("{:.4} to {:.4} tiles", report.heights[0], report.heights[1])),
        ("stretch", format!("{:.3} (1 is even), largest {:.2}", stretch.l2, stretch.largest)),
        ("texels that a view sees", percent(report.seen)),
        ("files", format!("{} in {}, {} on a GPU", bytes(asset.bytes()), asset.parts.len(), bytes(asset.gpu_bytes()))),
    ];
    for (name, error) in [
        ("ΔE at sampled directions", report.errors.at_samples),
        ("ΔE between them", report.errors.between_samples),
        ("ΔE of the light form", report.errors.light_form),
    ] {
        if let Some(ColourErrors { mean, p95, max, .. }) = error {
            rows.push((name, format!("{mean:.2} (95 %: {p95:.1}, largest: {max:.1})")));
        }
    }
    rows.extend(seconds.map(|seconds| ("time", format!("{seconds:.1} s"))));
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let lines = rows.iter().map(|(name, value)| format!("{name:width$}  {}\n", printable(value)));
    format!("{}\n", asset.name) + &lines.collect::<String>()
}
