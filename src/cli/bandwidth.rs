//! `brdfc bandwidth`: bandwidth maps of materials, environments and textures.

use super::output::{
    json_or, note, note_coverage, note_repairs, output_parser, print, print_report, refuse_unfit_output, write_file,
};
use super::reading::{ReadingOptions, checked};
use super::{Common, Error};
use crate::table;
use brdfc::bandwidth::{
    self, BandwidthFacts, BandwidthMap, DEFAULT_EPSILON, EPSILON_RANGE, Placement, RESOLUTIONS, Resolution, Subject,
    holds_radiance,
};
use brdfc::scene::TEXTURE_METRES;
use brdfc::{Input, Tally};
use brdfc_terminal::words::{format_number, quoted};
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Precompute a map of how fast a material, an environment or a texture varies.
///
/// Renderers use such maps to decide where, and how finely, to shade; formats/src/bandwidth/spec.md describes the
/// layout. Prints the largest and the mean bandwidth.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc bandwidth red-plastic.binary -o red.bandwidth.ktx2
  brdfc bandwidth museum.exr -o museum.bandwidth.ktx2 --rendering museum.png
  brdfc bandwidth cloth.png -o cloth.bandwidth.ktx2 --size 0.3x0.2 --json")]
pub struct Arguments {
    /// A material (path, or synth:MODEL?param=value&...), an environment (.exr, .hdr; with --kind also
    /// .ktx2) or a texture (.png, .jpg); - for stdin.
    input: Input,
    /// The map to write, or - for stdout.
    #[arg(long, short, value_name = "MAP.ktx2", value_parser = output_parser())]
    output: PathBuf,
    /// Kind of the input, if its extension does not tell.
    #[arg(long, value_enum)]
    kind: Option<Kind>,
    /// Pixels per side at which each lobe of a material is transformed: a power of two from 32 to 1024 (default: 64).
    /// With auto, the program doubles it, up to 256, while highlights are narrower than the resolution shows. A note
    /// reports values that it limits.
    #[arg(long, value_name = "N|auto", allow_hyphen_values = true)]
    resolution: Option<String>,
    /// Threshold: ignore coefficients whose sum is below this fraction of the largest one, 0.0001 to 0.1 (default:
    /// 0.01).
    #[arg(long, value_name = "E", default_value_t = DEFAULT_EPSILON)]
    epsilon: f64,
    /// Width and height of a texture in metres, such as 0.3x0.2, each 1e-6 to 1e6. Required for textures.
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    size: Option<String>,
    /// Ignore everything beyond the border of a texture, which then does not repeat.
    #[arg(long)]
    no_tile: bool,
    #[command(flatten)]
    reading: ReadingOptions,
    /// Also write the map as an image, from dark (at most 1/256 of the largest value) to pale yellow.
    #[cfg(feature = "render")]
    #[arg(long, value_name = "MAP.png")]
    rendering: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A material.
    Brdf,
    /// A latitude-longitude image, or a cube map.
    Environment,
    /// An image on a surface.
    Texture,
}

/// Report of `--json`, and of 'brdfc info --json' for a map.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'bandwidth-map'.
    kind: &'static str,
    /// Metadata of the map, and its values.
    #[serde(flatten)]
    facts: BandwidthFacts,
    /// Repairs to a material's values; absent for images and for existing maps.
    #[serde(rename = "repaired")]
    repairs: Option<Tally>,
    /// Seconds spent on reading and computing; absent for existing maps.
    seconds: Option<Seconds>,
}

/// Seconds per stage.
#[derive(Debug, Clone, Copy, Serialize, schemars::JsonSchema)]
pub struct Seconds {
    /// Reading and decoding the input.
    read: f64,
    /// Transform, bandwidth, reduction.
    bandwidth: f64,
}

impl Report {
    fn new(map: &BandwidthMap, repairs: Option<Tally>, seconds: Option<Seconds>) -> Self {
        Self { version: 1, kind: "bandwidth-map", facts: BandwidthFacts::new(map), repairs, seconds }
    }

    fn text(&self) -> String {
        let facts = &self.facts;
        let mut lines = vec![
            ("kind", "bandwidth map".to_owned()),
            ("of", facts.of.clone()),
            ("texels", format!("{} x {}", facts.size[0], facts.size[1])),
            ("transformed at", format!("{} x {}", facts.transformed[0], facts.transformed[1])),
            ("threshold ε", facts.epsilon.to_string()),
            ("largest", format!("{:.4} {}", facts.largest, facts.unit)),
            ("mean", format!("{:.4} {}", facts.mean, facts.unit)),
            ("without variation", table::percent(facts.constant)),
            ("bytes on a GPU", table::bytes(facts.gpu_bytes)),
        ];
        if let Some(share) = facts.limited {
            lines.push(("limited by these", table::percent(share)));
        }
        if let (Some([width, height]), Some(tiles)) = (facts.metres, facts.tiles) {
            let border = if tiles { "repeats" } else { "does not repeat" };
            lines.push(("texture", format!("{width} m x {height} m, {border}")));
        }
        if let Some(seconds) = self.seconds {
            lines.push(("seconds", format!("{:.3} to read, {:.3} for the map", seconds.read, seconds.bandwidth)));
        }
        lines.iter().map(|(name, value)| format!("{name:17}  {value}\n")).collect()
    }
}

/// `brdfc info` of a map.
pub(super) fn info(map: &BandwidthMap, common: Common) -> Result<(), Error> {
    let report = Report::new(map, None, None);
    print(&json_or(common, &report, report.text()))
}

/// Resolves the kind of map from the flags.
fn recipe(arguments: &Arguments) -> Result<bandwidth::Kind, Error> {
    let usage = |text: String| Err(Error::usage(text));
    let [least, most] = EPSILON_RANGE;
    if !(least..=most).contains(&arguments.epsilon) {
        return usage(format!("--epsilon: found {}, expected {least} to {most}", format_number(arguments.epsilon)));
    }
    let radiance = holds_radiance(&arguments.input)?;
    let kind = arguments.kind.unwrap_or(match radiance {
        None => Kind::Brdf,
        Some(true) => Kind::Environment,
        Some(false) => Kind::Texture,
    });
    let fits = match radiance {
        // Packs of materials, cube maps and prefiltered environments have one extension.
        None => kind == Kind::Brdf || (kind == Kind::Environment && arguments.input.extension()? == "ktx2"),
        Some(_) => kind != Kind::Brdf,
    };
    if !fits {
        let found = if radiance.is_none() { "a material" } else { "an image" };
        let allowed = "brdf for materials, environment for .ktx2, environment or texture for .exr, .hdr, .png and .jpg";
        return usage(format!("--kind: found {} for {found}, expected {allowed}", format!("{kind:?}").to_lowercase()));
    }
    if kind != Kind::Brdf && arguments.resolution.is_some() {
        return usage("--resolution does not apply to images, only to materials".to_owned());
    }
    if kind != Kind::Texture && (arguments.size.is_some() || arguments.no_tile) {
        return usage("--size and --no-tile apply only to textures".to_owned());
    }
    let reading = checked(arguments.reading, &[&arguments.input])?;
    Ok(match kind {
        Kind::Brdf => {
            let asked = arguments.resolution.as_deref();
            let Some(resolution) = asked.map_or(Some(Resolution::default()), Resolution::parse) else {
                let (found, [least, most]) = (asked.unwrap_or_default(), RESOLUTIONS);
                return usage(format!(
                    "--resolution: found {found}, expected a power of two from {least} to {most}, or auto"
                ));
            };
            bandwidth::Kind::Material(resolution, reading)
        }
        Kind::Environment => bandwidth::Kind::Environment,
        Kind::Texture => bandwidth::Kind::Texture(Placement {
            metres: texture_size("--size", arguments.size.as_deref())?,
            tiles: !arguments.no_tile,
        }),
    })
}

/// Parses the flag for the width and height of a texture in metres, such as `--size`.
pub(super) fn texture_size(flag: &str, found: Option<&str>) -> Result<[f64; 2], Error> {
    let side = |part: &str| part.parse::<f64>().ok().filter(|side| TEXTURE_METRES.contains(side));
    let allowed = "WIDTHxHEIGHT of the texture in metres, 1e-6 to 1e6";
    let Some(found) = found else {
        return Err(Error::usage(format!("{flag}: required for textures; expected {allowed}")));
    };
    let sides = found.split_once(['x', 'X']).and_then(|(width, height)| Some([side(width)?, side(height)?]));
    sides.ok_or_else(|| Error::wrong_usage(flag, quoted(found), allowed))
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    refuse_unfit_output(&arguments.output, &["ktx2"], arguments.input.path().as_slice())?;
    let recipe = recipe(arguments)?;
    #[cfg(feature = "render")]
    check_rendering(arguments)?;
    let start = Instant::now();
    let subject = Subject::open(&arguments.input, recipe)?;
    if let Subject::Material(material, _) = &subject {
        note_coverage(common, &arguments.input, material.source());
    }
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let (map, repairs) = subject.map(arguments.epsilon)?;
    let seconds = Seconds { read, bandwidth: start.elapsed().as_secs_f64() };
    write_file(&arguments.output, &map.to_bytes(true))?;
    #[cfg(feature = "render")]
    if let Some(path) = &arguments.rendering {
        write_file(path, &brdfc::bandwidth::rendering(&map))?;
    }
    repairs.iter().for_each(|repairs| note_repairs(common, &arguments.input, repairs));
    let report = Report::new(&map, repairs, Some(seconds));
    if let Some(line) = report.facts.remark() {
        note(common, &arguments.input, &line);
    }
    print_report(common, &arguments.output, &json_or(common, &report, report.text()))
}

/// Checks that `--rendering` is a PNG and differs from the input and the map.
#[cfg(feature = "render")]
fn check_rendering(arguments: &Arguments) -> Result<(), Error> {
    use super::output::{refuse_other_extension, refuse_overwriting, refuse_same_outputs};
    let Some(path) = &arguments.rendering else { return Ok(()) };
    refuse_other_extension("--rendering", path, &["png"])?;
    refuse_overwriting("--rendering", path, arguments.input.path().as_slice())?;
    refuse_same_outputs(&[("--output", Some(&arguments.output)), ("--rendering", Some(path))])
}
