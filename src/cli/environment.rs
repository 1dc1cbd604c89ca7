//! `brdfc environment`: prefiltered environments.

use super::info::lines_of;
use super::output::{json_or, output_parser, print_report, refuse_unfit_output, write_file};
use super::progress::{Materials, label};
use super::{Common, Error};
use crate::table;
use brdfc::encode::StageClock;
use brdfc::environment::{EnvironmentFacts, EnvironmentHeader, open_surroundings_with_conversions};
use brdfc::{Input, Progress as _, Stage};
use brdfc_terminal::values::any_whole_number;
use clap::Args;
use serde::Serialize;
use std::path::PathBuf;

/// Prefilter an environment, so that a shader needs a few look-ups instead of a sum over all directions.
///
/// The result is a cube map with mipmaps: level 0 is the environment, each further level is blurred twice as far. A second
/// cube map contains the irradiance. 'brdfc encode --codec lobes' makes the materials that use it;
/// formats/src/environment/spec.md describes the layout.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc environment museum.exr -o museum.env.ktx2
  brdfc environment sky.hdr -o sky.env.ktx2 --side 1024
  brdfc environment engine-cube.ktx2 -o sky.env.ktx2
  brdfc encode red-plastic.binary --codec lobes -o red.lobes.ktx2
  brdfc render red.lobes.ktx2 --environment museum.env.ktx2 -o red.png")]
pub struct Arguments {
    /// A latitude-longitude image (.exr, .hdr), a cube map of an engine, or a prefiltered environment, whose finest level
    /// counts (.ktx2); - for stdin.
    input: Input,
    /// The pack to write, or - for stdout.
    #[arg(long, short, value_name = "ENVIRONMENT.ktx2", value_parser = output_parser())]
    output: PathBuf,
    /// Texels along each side of a face: a power of two, 8 to 2048 (default: half the width of the image, or the
    /// side of the cube map, as a power of two from 64 to 512).
    #[arg(long, value_name = "N", value_parser = any_whole_number::<u32>(SIDES))]
    side: Option<u32>,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'environment'.
    kind: &'static str,
    /// Contents of the pack.
    #[serde(flatten)]
    facts: EnvironmentFacts,
    /// Width and height of the image, or of each face of the cube map, pixels.
    image: [usize; 2],
    /// Number of images: 6 faces of a cube map, or 1.
    faces: usize,
    /// Colour and other statements of the image, such as its exposure, and what was done; empty for cube maps.
    conversions: Vec<String>,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Seconds from reading to writing.
    seconds: f64,
}

/// Allowed sides.
const SIDES: &str = "a power of two, 8 to 2048";

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    if let Some(side) = arguments.side.filter(|side| !EnvironmentHeader::is_side(*side)) {
        return Err(Error::wrong_usage("--side", side, SIDES));
    }
    refuse_unfit_output(&arguments.output, &["ktx2"], arguments.input.path().as_slice())?;
    let progress = Materials::new(1, false, common);
    let name = label(&arguments.output);
    let part = progress.part(&name);
    let clock = StageClock::new(part.as_ref());
    clock.stage(Stage::Read, 1)?;
    let (surroundings, conversions) = open_surroundings_with_conversions(&arguments.input)?;
    let pack = surroundings.prefilter(arguments.side, &clock).map_err(|error| error.prefixed(&arguments.input))?;
    clock.stage(Stage::Write, 1)?;
    let bytes = pack.to_bytes(true);
    write_file(&arguments.output, &bytes)?;
    let seconds = clock.finish().iter().map(|stage| stage.seconds).sum();
    drop(part);
    drop(progress);
    let [width, height, faces] = surroundings.size();
    let report = Report {
        version: 1,
        kind: "environment",
        facts: EnvironmentFacts::new(&pack),
        image: [width, height],
        faces,
        conversions,
        bytes_on_disk: bytes.len(),
        seconds,
    };
    print_report(common, &arguments.output, &json_or(common, &report, report.text()))
}

/// Lines of `brdfc info`.
pub(super) fn lines(facts: &EnvironmentFacts) -> Vec<(&'static str, String)> {
    let EnvironmentFacts { side, levels, largest, gpu_bytes, scale: _ } = facts;
    vec![
        ("kind", "prefiltered environment".to_owned()),
        ("texels", format!("6 faces of {side} x {side}, {levels} levels")),
        ("largest", format!("{largest} W/(m² sr)")),
        ("bytes on a GPU", table::bytes(*gpu_bytes)),
    ]
}

impl Report {
    fn text(&self) -> String {
        let mut lines = lines(&self.facts);
        let [width, height] = self.image;
        let faces = if self.faces == 1 { String::new() } else { format!("{} faces of ", self.faces) };
        lines.push(("image", format!("{faces}{width} x {height} pixels")));
        if !self.conversions.is_empty() {
            lines.push(("colour", self.conversions.join("; ")));
        }
        lines.push(("bytes on disk", table::bytes(self.bytes_on_disk as u64)));
        lines.push(("seconds", format!("{:.2}", self.seconds)));
        lines_of(&lines)
    }
}
