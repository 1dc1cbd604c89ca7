//! `brdfc bandwidth`: how fast a material, an environment or a texture varies, as a map.

use super::output::{print, print_json, refuse_overwriting, remark, to_json, write_file};
use super::{CliError, Common};
use crate::bandwidth::environment::environment_bandwidth;
use crate::bandwidth::lobe::{DEFAULT_RESOLUTION, RESOLUTIONS, SIDE, lobe_bandwidth};
use crate::bandwidth::texture::{BandwidthImage, Placement, texture_bandwidth};
use crate::bandwidth::{DEFAULT_EPSILON, EPSILON_RANGE};
use crate::build::write::is_standard_output;
use crate::source::open::open;
use crate::source::radiance_image::open_radiance_image;
use crate::source::tile_image::open_tile_image;
use brdfc_formats::pack::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use clap::{Args, ValueEnum};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Precompute how fast a material, an environment or a texture varies.
///
/// Renderers shade only where, and as finely as, such maps ask for: see formats/spec/bandwidth.md. Prints the largest and the
/// mean bandwidth.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc bandwidth red-plastic.binary -o red.bandwidth.ktx2
  brdfc bandwidth museum.exr -o museum.bandwidth.ktx2 --picture museum.png
  brdfc bandwidth cloth.png -o cloth.bandwidth.ktx2 --size 0.3x0.2 --json")]
pub struct Arguments {
    /// A material (path, or synth:MODEL?param=value&...), an environment (.exr, .hdr) or a texture (.png, .jpg).
    input: String,
    /// The map to write.
    #[arg(long, short, value_name = "MAP.ktx2")]
    output: PathBuf,
    /// What the input is, where its extension does not say.
    #[arg(long, value_enum)]
    kind: Option<Kind>,
    /// Pixels per side at which each lobe of a material is transformed: 32, 64 (default), 128 or 256.
    #[arg(long, value_name = "N")]
    resolution: Option<usize>,
    /// Coefficients whose sum is below this share of the largest one do not count, 0.0001 to 0.1.
    #[arg(long, value_name = "E", default_value_t = DEFAULT_EPSILON)]
    epsilon: f64,
    /// Width and height of a texture in metres.
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// The texture does not repeat: what lies beyond its border does not count.
    #[arg(long)]
    no_tile: bool,
    /// Write the map as a picture, too: from dark (calm, 1/256 of the largest value and less) to pale yellow.
    #[cfg(feature = "render")]
    #[arg(long, value_name = "MAP.png")]
    picture: Option<PathBuf>,
    /// Print the report as JSON (schema: 'brdfc schema bandwidth').
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A material.
    Brdf,
    /// A latitude-longitude image.
    Environment,
    /// An image on a surface.
    Texture,
}

/// What `--json` prints, and 'brdfc info --json' of a map.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'bandwidth-map'.
    kind: &'static str,
    /// 'brdf', 'environment' or 'texture'.
    of: &'static str,
    /// Unit of the bandwidths.
    unit: &'static str,
    /// Texels per row and rows.
    size: [u32; 2],
    /// Width and height of the image that was transformed; of materials, of each lobe.
    transformed: [u32; 2],
    /// Share of the largest coefficient that does not count.
    epsilon: f32,
    /// Width and height of a texture in metres.
    metres: Option<[f32; 2]>,
    /// Whether a texture repeats.
    tiles: Option<bool>,
    /// Largest bandwidth.
    largest: f32,
    /// Mean of all texels.
    mean: f64,
    /// Share of texels without any variation, 0 to 1.
    constant: f64,
    /// Seconds that reading and finding the bandwidth took; not of a map that was there.
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
    fn new(map: &BandwidthMap, seconds: Option<Seconds>) -> Self {
        let (header, values) = (map.header(), map.values());
        let (metres, tiles) = match header.kind {
            BandwidthKind::Texture { metres, tiles } => (Some(metres), Some(tiles)),
            _ => (None, None),
        };
        let count = values.len() as f64;
        Self {
            version: 1,
            kind: "bandwidth-map",
            of: header.kind.name(),
            unit: header.kind.unit(),
            size: map.size(),
            transformed: header.transformed,
            epsilon: header.epsilon,
            metres,
            tiles,
            largest: values.iter().copied().fold(0.0, f32::max),
            mean: values.iter().map(|value| f64::from(*value)).sum::<f64>() / count,
            constant: values.iter().filter(|value| **value == 0.0).count() as f64 / count,
            seconds,
        }
    }

    fn text(&self) -> String {
        let mut lines = vec![
            ("kind", "bandwidth map".to_owned()),
            ("of", self.of.to_owned()),
            ("texels", format!("{} x {}", self.size[0], self.size[1])),
            ("transformed at", format!("{} x {}", self.transformed[0], self.transformed[1])),
            ("threshold ε", self.epsilon.to_string()),
            ("largest", format!("{:.4} {}", self.largest, self.unit)),
            ("mean", format!("{:.4} {}", self.mean, self.unit)),
            ("without variation", crate::report::table::percent(self.constant)),
        ];
        if let (Some([width, height]), Some(tiles)) = (self.metres, self.tiles) {
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
pub(super) fn info(map: &BandwidthMap, json: bool) -> Result<(), CliError> {
    let report = Report::new(map, None);
    if json { print_json(&report) } else { print(&report.text()) }
}

/// What is to be done, from the flags.
enum Recipe {
    Brdf { resolution: usize },
    Environment,
    Texture(Placement),
}

/// Of what an image file is by its extension, if it is one: whether of radiance.
fn radiance(input: &str) -> Option<bool> {
    let extension = Path::new(input).extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "exr" | "hdr" => Some(true),
        "png" | "jpg" | "jpeg" => Some(false),
        _ => None,
    }
}

fn recipe(arguments: &Arguments) -> Result<Recipe, CliError> {
    let usage = |text: String| Err(CliError::Usage(text));
    let [least, most] = EPSILON_RANGE;
    if !(least..=most).contains(&arguments.epsilon) {
        return usage(format!("--epsilon: found {}; allowed {least} to {most}", arguments.epsilon));
    }
    let radiance = radiance(&arguments.input);
    let kind = arguments.kind.unwrap_or(match radiance {
        None => Kind::Brdf,
        Some(true) => Kind::Environment,
        Some(false) => Kind::Texture,
    });
    if (kind == Kind::Brdf) != radiance.is_none() {
        let found = if radiance.is_none() { "no image" } else { "an image" };
        let allowed = "brdf for materials; environment or texture for .exr, .hdr, .png and .jpg";
        return usage(format!("--kind: found {} of {found}; allowed {allowed}", format!("{kind:?}").to_lowercase()));
    }
    if kind != Kind::Brdf && arguments.resolution.is_some() {
        return usage("--resolution: found an image; allowed for materials".to_owned());
    }
    if kind != Kind::Texture && (arguments.size.is_some() || arguments.no_tile) {
        return usage("--size, --no-tile: found no texture; allowed for textures".to_owned());
    }
    Ok(match kind {
        Kind::Brdf => {
            let resolution = arguments.resolution.unwrap_or(DEFAULT_RESOLUTION);
            let [least, most] = RESOLUTIONS;
            if !(resolution.is_power_of_two() && (least..=most).contains(&resolution)) {
                return usage(format!("--resolution: found {resolution}; allowed 32, 64, 128 or 256"));
            }
            Recipe::Brdf { resolution }
        }
        Kind::Environment => Recipe::Environment,
        Kind::Texture => Recipe::Texture(Placement { metres: metres(arguments)?, tiles: !arguments.no_tile }),
    })
}

/// Width and height of a texture.
fn metres(arguments: &Arguments) -> Result<[f64; 2], CliError> {
    let side = |part: &str| part.parse::<f64>().ok().filter(|side| (1e-6..=1e6).contains(side));
    let found = arguments.size.as_deref().unwrap_or("none");
    found.split_once(['x', 'X']).and_then(|(width, height)| Some([side(width)?, side(height)?])).ok_or_else(|| {
        CliError::Usage(format!("--size: found {found}; allowed WIDTHxHEIGHT of the texture in metres, 1e-6 to 1e6"))
    })
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), CliError> {
    let recipe = recipe(arguments)?;
    refuse_overwriting(&arguments.output, &[Path::new(&arguments.input)])?;
    let (map, seconds) = match recipe {
        Recipe::Brdf { resolution } => material(arguments, resolution)?,
        Recipe::Environment => image(arguments, BandwidthKind::Environment, |pixels, width| {
            environment_bandwidth(pixels, width, arguments.epsilon)
        })?,
        Recipe::Texture(placement) => {
            let metres = placement.metres.map(|side| side as f32);
            image(arguments, BandwidthKind::Texture { metres, tiles: placement.tiles }, |pixels, width| {
                texture_bandwidth(pixels, width, placement, arguments.epsilon)
            })?
        }
    };
    write_file(&arguments.output, &map.to_bytes(true))?;
    #[cfg(feature = "render")]
    if let Some(path) = &arguments.picture {
        write_file(path, &picture(&map))?;
    }
    let report = Report::new(&map, Some(seconds));
    let text = if arguments.json { to_json(&report) } else { report.text() };
    if is_standard_output(&arguments.output) {
        // Behind a map the report would be taken for a part of it.
        remark(common, text.trim_end());
        return Ok(());
    }
    print(&text)
}

fn packed(header: BandwidthHeader, size: [usize; 2], values: &[f32]) -> Result<BandwidthMap, CliError> {
    BandwidthMap::new(header, size.map(|side| side as u32), values)
        .map_err(|error| CliError::Internal(format!("a map that its own layout refuses: {error}")))
}

fn material(arguments: &Arguments, resolution: usize) -> Result<(BandwidthMap, Seconds), CliError> {
    let start = Instant::now();
    let opened = open(&arguments.input, None)?;
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let found = lobe_bandwidth(opened.source.as_ref(), resolution, arguments.epsilon);
    let seconds = Seconds { read, bandwidth: start.elapsed().as_secs_f64() };
    let transformed = [resolution as u32; 2];
    let header = BandwidthHeader { kind: BandwidthKind::Brdf, epsilon: arguments.epsilon as f32, transformed };
    Ok((packed(header, [SIDE; 2], &found.values)?, seconds))
}

/// Reads an image and finds its map.
fn image(
    arguments: &Arguments,
    kind: BandwidthKind,
    map: impl Fn(&[[f32; 3]], usize) -> BandwidthImage,
) -> Result<(BandwidthMap, Seconds), CliError> {
    let start = Instant::now();
    let path = Path::new(&arguments.input);
    let (pixels, width) = if radiance(&arguments.input) == Some(true) {
        let image = open_radiance_image(path)?;
        (image.pixels, image.width)
    } else {
        let image = open_tile_image(path)?;
        (image.colours(), image.width)
    };
    let read = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let found = map(&pixels, width);
    let seconds = Seconds { read, bandwidth: start.elapsed().as_secs_f64() };
    let transformed = found.transformed.map(|side| side as u32);
    let header = BandwidthHeader { kind, epsilon: arguments.epsilon as f32, transformed };
    Ok((packed(header, [found.width, found.height], &found.values)?, seconds))
}

/// Eight octaves below the largest value, as a PNG.
#[cfg(feature = "render")]
fn picture(map: &BandwidthMap) -> Vec<u8> {
    use crate::render::picture::{heat_map, rgb_png};
    let values = map.values();
    let largest = values.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let shares: Vec<f32> = values.iter().map(|value| 1.0 + (value / largest).log2() / 8.0).collect();
    let [width, height] = map.size().map(|side| side as usize);
    rgb_png(&heat_map(&shares, width, height, 1.0))
}
