//! `brdfc view`: writes a page that draws packs.

use super::output::{note, print_report, refuse_unfit_output, remark, to_json, write_file};
use super::reading::PhotographOptions;
use super::steps::Steps;
use super::{Common, Error};
use crate::inputs::refuse_stdin_twice;
use crate::table;
use brdfc::Input;
use brdfc::environment;
use brdfc::view::{ViewEnvironment, ViewItem, ViewOptions, open_items, view_page};
use brdfc_terminal::values::bytes_from_text;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Write a page that draws packs, for viewing them in a browser with any rotation, light and comparison.
///
/// The page is a single HTML file that needs no network and no server. It draws with WebGPU or WebGL 2, using the
/// decoders of engines, on a ball, a cloth, a teapot or a plane. With two materials it splits the screen and displays
/// their difference (ΔE) under the pointer and over the view. It draws materials that are not packs, such as the source of a pack, from a table of 128 KiB, and displays
/// the error of that table.
///
/// It draws packs of 'brdfc pwt' as a flat image, under up to three lights that the mouse moves. With the photographs (the
/// folder or the .lp of an RTI capture) next to the pack, it shows those that are nearest to the lights. It stores
/// photographs as JPEG files of at most 1024 pixels a side, smaller or fewer if they exceed --max-photographs.
///
/// An environment lights packs of lobes, and is visible behind them. Dragging with Shift or the right button turns it.
///
/// The address of the page may set options after a #, separated by &: scene=cloth, left=NAME, right=NAME, mode=split,
/// one or difference, coarser=1, light=90 (degrees by which lights and environment are turned), light=0.5,0.3 (x and
/// y of the unit vector to the light of an image; more lights after semicolons), api=webgl2 or webgpu,
/// embed (only the rendering).
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc view red.ktx2 -o red.html
  brdfc view red.ktx2 red-plastic.binary -o red.html   compared with its source
  brdfc view small.ktx2 large.ktx2 -o sizes.html
  brdfc view red.lobes.ktx2 --environment museum.exr -o red.html
  brdfc view packs -o all.html                         the packs of a build, with sources
  brdfc view button -o button.html                     a flat BTF
  brdfc view icon.ktx2 -o icon.html                    photographs under any light
  brdfc view icon.ktx2 icon --normals -o icon.html     next to the photographs, with normals")]
pub struct Arguments {
    /// Packs, lobes, flat BTFs (their file or folder), RTI captures (their folder or .lp), folders of builds, or
    /// materials: paths, - for stdin, or synth:MODEL?param=value&... The first one is on the left, the second one on the right.
    #[arg(required = true, value_name = "PACK")]
    inputs: Vec<Input>,
    /// The page to write (.html or .htm), or - for stdout.
    #[arg(long, short, value_name = "VIEW.html", value_parser = super::output::output_parser())]
    output: PathBuf,
    /// Environment that lights packs of lobes: a latitude-longitude image (.exr, .hdr), a cube map or a prefiltered
    /// environment (.ktx2) (default: the sky of the scenes).
    #[arg(long, value_name = "FILE")]
    environment: Option<Input>,
    /// For builds, draw only the packs, without their sources.
    #[arg(long)]
    no_sources: bool,
    /// Add the normals of the first RTI capture, or else of the first pack of 'brdfc pwt', as colours.
    #[arg(long)]
    normals: bool,
    #[command(flatten)]
    reading: PhotographOptions,
    /// Maximum bytes of the photographs of an RTI capture in the page: a number, optionally with KiB or MiB.
    #[arg(long, value_name = "BYTES", default_value = "8MiB", value_parser = bytes_from_text)]
    max_photographs: u64,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'view'.
    kind: &'static str,
    /// Bytes of the page.
    bytes_on_disk: usize,
    /// Bytes of the page without packs.
    bytes_alone: usize,
    /// Materials, the left one first.
    items: Vec<Item>,
    /// Environment, if there are packs of lobes.
    environment: Option<Environment>,
}

/// A material of the page.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct Item {
    /// Name on the page.
    name: String,
    /// Decoder, by its name in `brdfc shader`; 'photographs' for those and normals.
    decoder: &'static str,
    /// Bytes of its textures on a GPU.
    bytes_on_gpu: u64,
    /// Description on the page.
    facts: String,
    /// Photographs or normals in the page, if it is an RTI capture.
    #[serde(skip_serializing_if = "Option::is_none")]
    photographs: Option<PhotographsReport>,
}

/// Photographs in the page.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct PhotographsReport {
    /// Columns and rows.
    size: [usize; 2],
    /// Number in the page.
    count: usize,
    /// Number that was left out.
    left_out: usize,
    /// Bytes in the page, as Base64.
    bytes: u64,
}

/// The environment of the page.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct Environment {
    /// Name on the page.
    name: String,
    /// Bytes of its textures on a GPU.
    bytes_on_gpu: u64,
}

impl Environment {
    fn new(environment: &ViewEnvironment) -> Self {
        Self { name: environment.name.clone(), bytes_on_gpu: environment.pack.gpu_bytes() }
    }
}

impl Item {
    fn new(item: &ViewItem) -> Self {
        Self {
            name: item.name.clone(),
            decoder: item.decoder_name(),
            bytes_on_gpu: item.gpu_bytes(),
            facts: item.facts.clone(),
            photographs: item.photographs().map(|them| PhotographsReport {
                size: them.size,
                count: them.all.len(),
                left_out: them.total - them.all.len(),
                bytes: them.bytes(),
            }),
        }
    }
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output: &Path = &arguments.output;
    let packs = arguments.inputs.iter().map(|input| ("PACK", Some(input)));
    let inputs: Vec<(&str, Option<&Input>)> =
        packs.chain([("--environment", arguments.environment.as_ref())]).collect();
    refuse_stdin_twice(&inputs)?;
    let paths: Vec<&Path> = inputs.iter().filter_map(|(_, input)| input.and_then(Input::path)).collect();
    refuse_unfit_output(output, &["html", "htm"], &paths)?;
    // An interrupt ends the process at once: each file is either complete or absent.
    let cancelled = AtomicBool::new(false);
    let steps = Steps::new(common, &cancelled);
    let given = match &arguments.environment {
        Some(input) => Some(ViewEnvironment { name: input.short_name(), pack: environment::open(input, &steps)? }),
        None => None,
    };
    let options = ViewOptions {
        sources: !arguments.no_sources,
        normals: arguments.normals,
        codes: arguments.reading.codes,
        photograph_bytes: arguments.max_photographs,
    };
    let items = open_items(&arguments.inputs, options, &steps)?;
    for item in &items {
        let Some(them) = item.photographs() else { continue };
        for text in them.notes.iter().cloned().chain(them.left_out()) {
            note(common, &item.name, &text);
        }
    }
    if let [left, right, ..] = &items[..]
        && !left.is_comparable(right)
    {
        let why = match left.needs_environment() == right.needs_environment() {
            true => "they have no common surface",
            false => "an environment lights lobes, and point lights light other materials",
        };
        let line = format!("not drawn next to {}, only if selected on the page: {why}", left.name);
        note(common, &right.name, &line);
    }
    let environment = match (given, items.iter().any(ViewItem::needs_environment)) {
        (None, true) => Some(ViewEnvironment::sky(&())?),
        (Some(_), false) => {
            let text =
                "--environment: found no pack of lobes to light, expected one; 'brdfc encode --codec lobes' makes it";
            return Err(Error::usage(text));
        }
        (given, _) => given,
    };
    drop(steps);
    let page = view_page(&items, environment.as_ref())?;
    write_file(output, page.html.as_bytes())?;
    let report = Report {
        version: 1,
        kind: "view",
        bytes_on_disk: page.html.len(),
        bytes_alone: page.bytes_alone,
        items: items.iter().map(Item::new).collect(),
        environment: environment.as_ref().map(Environment::new),
    };
    if common.json {
        return print_report(common, output, &to_json(&report));
    }
    let size = |bytes: usize| table::bytes(bytes as u64);
    remark(
        common,
        &format!(
            "{}: {}, including {} for the page itself",
            output.display(),
            size(report.bytes_on_disk),
            size(report.bytes_alone)
        ),
    );
    Ok(())
}
