//! `brdfc pwt`: one pack from photographs under known lights, for relighting.

mod images;

use super::output::{json_or, note, output_parser, print, print_report, refuse_flags, refuse_unfit_output, write_file};
use super::reading::PhotographOptions;
use super::{Common, Error};
use crate::table;
use brdfc::relight::{
    HoldOut, LevelReport, LightInput, MapModel, PTM, Ptm, PwtOptions, PwtReport, PwtTextureFacts, StackErrors,
    ViewChoice, any_above_white, make, make_map, recipe_of_map,
};
use brdfc::{ErrorKind, Input};
use brdfc_terminal::values::{any_whole_number, one_of};
use brdfc_terminal::words::counted;
use clap::Args;
use images::{ImageOutputs, ImageReports};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Encode photographs of one view, or all views of a BTF, under known lights as a pack that can be relit from any
/// direction, a polynomial wavelet tree.
///
/// INPUT is a folder of photographs with a list of lights (.lp), the list itself, a BTF (a folder of images or a .btf
/// file) or a flat BTF, or a file of an RTI viewer (.ptm, .rti). --view selects a view of a BTF; --view all stores every
/// view with the same terms of the light, and shaders blend the three views around the direction to the viewer. By default, cross-validation at held-out
/// lights selects the terms of the light, which are polynomials or learned from the photographs, their number, smoothness
/// and scale, and each term gets the resolution that it needs. If the output is a .ptm, the program fits a polynomial
/// texture map instead, for viewers that do not read packs. --normals, --albedo and --web write images for other programs,
/// with a pack or without.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc pwt icon -o icon.ktx2
  brdfc pwt icon -o icon.ktx2 --max-bytes 256KiB
  brdfc pwt icon/dirs.lp -o icon.ktx2 --quality 28 --hold-out 8
  brdfc pwt icon -o icon.ktx2 --terms learned --max-fetches 6
  brdfc pwt icon -o icon.ptm --model lrgb
  brdfc pwt old.rti -o old.ktx2
  brdfc pwt icon --normals normals.png --albedo albedo.png
  brdfc pwt icon -o icon.ktx2 --web icon-web
  brdfc pwt button -o button-view.ktx2 --view 12
  brdfc pwt button -o button.ktx2 --view all --max-bytes 4MiB --hold-out-views 4")]
pub struct Arguments {
    /// Photographs and lights, a BTF, a .ptm, a .rti or a pack.
    input: Input,
    /// The pack (.ktx2) or polynomial texture map (.ptm) to write, or - for a pack on stdout; optional with --normals,
    /// --albedo or --web.
    #[arg(
        long,
        short,
        value_name = "PACK.ktx2|MAP.ptm",
        value_parser = output_parser(),
        required_unless_present_any = ["normals", "albedo", "web"],
    )]
    output: Option<PathBuf>,
    #[command(flatten)]
    images: ImageOutputs,
    /// View of a BTF, 0 to the number of views - 1, or all (default: 0).
    #[arg(long, alias = "views", value_name = "V|all", value_parser = view_choice, allow_hyphen_values = true)]
    view: Option<ViewChoice>,
    #[command(flatten)]
    reading: PhotographOptions,
    /// Treat the images as tiles that repeat, like the images of BTFs.
    #[arg(long)]
    tile: bool,
    #[command(flatten)]
    options: PwtOptions,
    /// Number of lights to hold out of the fit, 0 to the number of lights - 1 (default: 0). The report includes the
    /// errors at held-out lights.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = any_whole_number::<usize>("0 to the number of lights - 1"),
    )]
    hold_out: usize,
    /// Number of views to hold out of a pack of all views, 0 to the number of views - 2 (default: 0). The report includes
    /// the errors at held-out views, which are blended from the others, at fitted and at held-out lights.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = any_whole_number::<usize>("0 to the number of views - 2"),
    )]
    hold_out_views: usize,
    /// Seed of the permutations that select the held-out lights and views, 0 or more (default: 0).
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Layout of a .ptm (default: rgb).
    #[arg(long, value_parser = one_of(&MODELS))]
    model: Option<MapModel>,
    /// Store texels uncompressed, without Zstandard.
    #[arg(long)]
    no_supercompression: bool,
}

const MODELS: [(&str, MapModel, &str); 2] = [
    ("rgb", MapModel::Rgb, "One polynomial per channel"),
    ("lrgb", MapModel::Lrgb, "One polynomial, multiplied by a colour"),
];

/// Parses a view of a BTF.
fn view_choice(text: &str) -> Result<ViewChoice, String> {
    match text {
        "all" => Ok(ViewChoice::All),
        _ => text.parse().map(ViewChoice::One).map_err(|_| "expected 0 to the number of views - 1, or all".to_owned()),
    }
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    #[serde(flatten)]
    made: Made,
    #[serde(flatten)]
    images: ImageReports,
    /// Colour of the code values of photographs, and how they were converted; absent without photographs in files.
    #[serde(skip_serializing_if = "Option::is_none")]
    colour: Option<String>,
    /// Notes about the input, such as lights without an image, and photographs that are black everywhere.
    notes: Vec<String>,
    /// Seconds per stage.
    seconds: Seconds,
}

/// Notes about an input, which are printed at once and reported at the end.
struct Notes<'a> {
    common: Common,
    input: &'a Input,
    lines: Vec<String>,
}

impl Notes<'_> {
    fn add(&mut self, line: impl Into<String>) {
        let line = line.into();
        note(self.common, self.input, &line);
        self.lines.push(line);
    }
}

/// Result.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(clippy::large_enum_variant)]
enum Made {
    /// A pack.
    Pwt(PwtReport),
    /// A polynomial texture map.
    Ptm {
        /// Layout of the map.
        model: MapModel,
        /// Columns and rows.
        size: [u32; 2],
        /// Bytes of the file.
        bytes_on_disk: usize,
        /// Errors at the fitted lights.
        #[serde(flatten)]
        errors: StackErrors,
    },
    /// Only normals, albedo or images for web viewers.
    Images,
}

/// Seconds per stage.
#[derive(Debug, Clone, Copy, Serialize, schemars::JsonSchema)]
pub struct Seconds {
    /// Reading and decoding.
    read: f64,
    /// Fitting, selecting and measuring.
    encode: f64,
}

/// Rejects options that do not apply to outputs other than packs.
fn refuse_flags_of_packs(arguments: &Arguments, found: &str) -> Result<(), Error> {
    let web = arguments.images.web.is_some();
    let hold_out = arguments.hold_out != 0 && (arguments.output.is_some() || !web);
    refuse_flags(found, &[(hold_out, "--hold-out", "packs and images for web viewers")])?;
    let all = arguments.view == Some(ViewChoice::All);
    let given = [
        (all, "--view all"),
        (arguments.hold_out_views != 0, "--hold-out-views"),
        (arguments.tile, "--tile"),
        (arguments.no_supercompression, "--no-supercompression"),
    ];
    refuse_flags(found, &given.map(|(given, flag)| (given, flag, "packs")))?;
    let options: Vec<String> = arguments.options.given().map(flag_of).collect();
    refuse_flags(found, &options.iter().map(|flag| (true, flag.as_str(), "packs")).collect::<Vec<_>>())
}

impl Arguments {
    /// Rejects outputs of one view for all views, and a seed or held-out views without what they apply to.
    fn check_hold_out(&self) -> Result<(), Error> {
        let images = self.images.normals.is_some() || self.images.albedo.is_some() || self.images.web.is_some();
        if self.view == Some(ViewChoice::All) && images {
            return Err(Error::usage("--view all is not allowed together with --normals, --albedo or --web"));
        }
        if self.view != Some(ViewChoice::All) && self.hold_out_views > 0 {
            return Err(Error::usage("--hold-out-views needs --view all"));
        }
        if self.seed > 0 && self.hold_out == 0 && self.hold_out_views == 0 {
            return Err(Error::usage("--seed needs --hold-out or --hold-out-views"));
        }
        Ok(())
    }
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let recipe = arguments.options.recipe().map_err(|error| Error::from(error).name_options(flag_of))?;
    let output = arguments.output.as_deref();
    let is_map = output.and_then(Path::extension).is_some_and(|extension| extension.eq_ignore_ascii_case(PTM));
    if is_map {
        refuse_flags_of_packs(arguments, "an output .ptm")?;
    }
    let inputs = arguments.input.path();
    let inputs = inputs.as_slice();
    match output {
        Some(output) => refuse_unfit_output(output, &["ktx2", PTM], inputs)?,
        None if arguments.images.web.is_none() => refuse_flags_of_packs(arguments, "normals and albedo")?,
        None => refuse_flags_of_packs(arguments, "normals, albedo and images for web viewers")?,
    }
    arguments.check_hold_out()?;
    arguments.images.check(output, inputs)?;
    refuse_flags("a pack", &[(!is_map && arguments.model.is_some(), "--model", "an output .ptm")])?;
    let start = Instant::now();
    let input = LightInput::open_as(&arguments.input, arguments.view, arguments.reading.codes)?;
    let colour = input.colour().map(str::to_owned);
    let basis = input.basis();
    if matches!(input, LightInput::Pack(_)) && output.is_some() && !is_map {
        let text = format!("{}: already a pack; choose an --output that ends in .ptm", arguments.input);
        return Err(Error::usage(text));
    }
    let photographs = matches!(input, LightInput::Photographs(..));
    let count = if let LightInput::Photographs(samples, _) = &input { samples.lights.len() } else { 0 };
    let only_images = basis.is_some() && output.is_none();
    refuse_flags("a .ptm or .rti as input", &[(only_images && arguments.hold_out != 0, "--hold-out", "photographs")])?;
    let given = if let LightInput::Map(map) = &input { map.as_polynomials().cloned() } else { None };
    let mut notes = Notes { common, input: &arguments.input, lines: Vec::new() };
    input.notes().into_iter().for_each(|line| notes.add(line));
    let mut samples = input.into_samples();
    if samples.lights.len() < count {
        let lights = counted(samples.lights.len(), "light");
        notes.add(format!("{count} photographs of {lights}: photographs of one light are averaged"));
    }
    if photographs && any_above_white(&samples) {
        notes.add("the fit includes values above 1 (white); the PSNR treats them as 1");
    }
    samples.repeats |= arguments.tile;
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let model = arguments.model.unwrap_or(MapModel::Rgb);
    let made = is_map.then(|| make_map(&samples, model)).transpose();
    let made = made.map_err(|error| of_input(&arguments.input, error))?;
    let map = made.as_ref().map(|(map, _)| map).or(given.as_ref());
    let (images, why) = arguments
        .images
        .write((&samples, photographs), map, (arguments.hold_out, arguments.seed), inputs)
        .map_err(|error| of_input(&arguments.input, error))?;
    why.into_iter().for_each(|line| notes.add(line));
    let Some(output) = output else {
        let seconds = Seconds { read, encode: start.elapsed().as_secs_f64() };
        let text = images.summary() + &colour_line(colour.as_deref());
        let report = Report { version: 1, made: Made::Images, images, colour, notes: notes.lines, seconds };
        return print(&json_or(common, &report, text));
    };
    if let Some((map, errors)) = made {
        let seconds = Seconds { read, encode: start.elapsed().as_secs_f64() };
        return write_map(output, &map, (model, errors), (images, colour), notes, seconds);
    }
    let [width, height] = samples.view_size();
    if samples.repeats && recipe.depth.is_none() && (width % 2 == 1 || height % 2 == 1) {
        notes.add(format!("a tile of {width} x {height} pixels has no levels, because its sides are not both even"));
    }
    let recipe = basis.map_or(recipe, |basis| recipe_of_map(recipe, basis));
    let hold_out = HoldOut { lights: arguments.hold_out, views: arguments.hold_out_views, seed: arguments.seed };
    let made = make(&samples, &recipe, hold_out).map_err(|error| of_input(&arguments.input, error))?;
    if let Some(nothing) = made.encoded.errors.nothing_shown() {
        notes.add(format!("the errors mean nothing: {nothing}"));
    }
    let seconds = Seconds { read, encode: start.elapsed().as_secs_f64() };
    let bytes = made.encoded.pack.to_bytes(!arguments.no_supercompression);
    write_file(output, &bytes)?;
    let report = PwtReport::new(&made, recipe.target, bytes.len());
    let missed = made.missed(recipe.target);
    if !report.met {
        note(common, &arguments.input, "no pack meets the target; wrote the best pack");
    }
    let text = summary(&report, seconds) + &images.summary() + &colour_line(colour.as_deref());
    let report = Report { version: 1, made: Made::Pwt(report), images, colour, notes: notes.lines, seconds };
    print_report(common, output, &json_or(common, &report, text))?;
    missed.map_or(Ok(()), |message| Err(Error::check(message.named(flag_of))))
}

/// Prefixes errors of photographs with the name of the input.
fn of_input(input: &Input, error: Error) -> Error {
    if error.kind() == ErrorKind::Input { error.prefixed(input) } else { error }
}

/// The flag of an option's key.
fn flag_of(key: &str) -> String {
    format!("--{}", key.replace('_', "-"))
}

fn write_map(
    output: &Path,
    map: &Ptm,
    (model, errors): (MapModel, StackErrors),
    (images, colour): (ImageReports, Option<String>),
    Notes { common, lines: notes, .. }: Notes<'_>,
    seconds: Seconds,
) -> Result<(), Error> {
    let bytes = map.to_bytes();
    write_file(output, &bytes)?;
    let made = Made::Ptm { model, size: map.size(), bytes_on_disk: bytes.len(), errors };
    let [width, height] = map.size();
    let row = vec![
        format!("{width} x {height}"),
        map.model().name().to_owned(),
        table::bytes(bytes.len() as u64),
        format!("{:.2}", errors.psnr),
        format!("{:.2}", errors.delta_e),
    ];
    let text = table::plain(&["pixels", "layout", "bytes", "dB", "mean ΔE"], &[row])
        + &images.summary()
        + &colour_line(colour.as_deref());
    let report = Report { version: 1, made, images, colour, notes, seconds };
    print_report(common, output, &json_or(common, &report, text))
}

/// Line of the colour of photographs.
fn colour_line(colour: Option<&str>) -> String {
    colour.map_or(String::new(), |colour| format!("\ncolour  {colour}\n"))
}

fn summary(report: &PwtReport, seconds: Seconds) -> String {
    let decimals = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let tried = report.tried.iter().map(|c| {
        [
            c.domain.name().to_owned(),
            c.coordinates.name().to_owned(),
            c.degree.to_string(),
            if c.ridge == 0.0 { "-".to_owned() } else { format!("{:e}", c.ridge) },
            format!("{:.2}", c.psnr),
            decimals(c.held_out_psnr),
        ]
    });
    let mut text = table::plain(&["scale", "terms", "degree", "ridge", "dB", "dB held out"], tried);
    text.push('\n');
    let level = |level: &LevelReport| {
        let textures = report.textures.iter().find(|texture| texture.level == level.level);
        [
            level.level.to_string(),
            level.subbands.to_string(),
            table::percent(level.energy),
            level.degree.map_or("none".to_owned(), |degree| degree.to_string()),
            textures.map_or("-".to_owned(), |t| format!("{} x {}", t.size[0], t.size[1])),
            textures.map_or("-".to_owned(), |t| format!("{} x {}", t.layers, t.channels)),
        ]
    };
    if report.levels.is_empty() {
        let texture = |t: &PwtTextureFacts| {
            [t.level.to_string(), format!("{} x {}", t.size[0], t.size[1]), format!("{} x {}", t.layers, t.channels)]
        };
        text.push_str(&table::plain(&["level", "texels", "layers x channels"], report.textures.iter().map(texture)));
    } else {
        let header = ["level", "subbands", "energy", "degree", "texels", "layers x channels"];
        text.push_str(&table::plain(&header, report.levels.iter().map(level)));
    }
    text.push('\n');
    let held = report.held_out.as_ref();
    let row = vec![
        report.lights.to_string(),
        table::bytes(report.bytes_on_gpu),
        table::bytes(report.bytes_on_disk as u64),
        report.fetches.to_string(),
        format!("{:.2}", report.psnr),
        format!("{:.2}", report.delta_e),
        decimals(held.map(|held| held.psnr)),
        decimals(held.map(|held| held.delta_e)),
        format!("{:.2}", seconds.read + seconds.encode),
    ];
    let header = ["lights", "GPU", "file", "fetches", "dB", "ΔE", "dB held out", "ΔE held out", "seconds"];
    text.push_str(&table::plain(&header, &[row]));
    if let Some(held) = &report.held_out_views {
        let row = vec![
            held.views.len().to_string(),
            format!("{:.2}", held.psnr),
            format!("{:.2}", held.delta_e),
            decimals(held.psnr_at_held_out_lights),
            decimals(held.delta_e_at_held_out_lights),
        ];
        let header = ["views held out", "dB", "ΔE", "dB, lights held out too", "ΔE, lights held out too"];
        text.push('\n');
        text.push_str(&table::plain(&header, &[row]));
    }
    text
}
