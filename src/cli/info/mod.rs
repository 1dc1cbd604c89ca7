//! `brdfc info`: describes an input.

mod files;

pub use files::FilesReport;

use super::output::{json_or, note_gaps, print, print_json, printable};
use super::reading::{ReadingOptions, checked};
use super::{Common, Error, bandwidth, encode_lobes, environment, flatten};
use crate::table::bytes;
use brdfc::environment::EnvironmentFacts;
use brdfc::inspect::{
    AnyPack as Pack, DeviceNeeds, ImportanceFacts, Kind, Opened, PtmFacts, PwtFacts, RtiCapture, RtiCaptureFacts,
    RtiFacts, STRUCTURES, SYNTH_PREFIX, SurfaceFacts, Symmetry, describe_surface, known_files, open, open_asset,
    open_pack, open_ptm, open_rti, opened, split_query, surface,
};
use brdfc::lobes::LobesFacts;
use brdfc::{BrdfPack, Facts, FormatError, Input, InputError};
use clap::Args;
use serde::Serialize;

/// Describe an input: layout, sizes, symmetries, measured errors of a pack.
///
/// For a mesh, the report states whether it closes over the tile, and which repairs it needs; for a folder of images, which
/// ones are missing; for an RTI capture, a polynomial texture map or a polynomial wavelet tree, its lights and sizes.
///
/// Schemas of --json: 'info'; 'files' with --files; 'flat-btf' for a flat BTF; 'info-surface' for a structure, a mesh, a height
/// map or images; 'bandwidth' for a bandwidth map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc info paint.brdf
  brdfc info red.ktx2 --json
  brdfc info bricks.obj
  brdfc info button
  brdfc info red.ktx2 --files --json")]
pub struct Arguments {
    /// A path, synth:MODEL?param=value&... or synth:STRUCTURE?...; a flat BTF or its folder; a mesh, a height map, a folder of
    /// images or a .btf file for 'brdfc flatten'; an RTI capture, as its .lp or its folder; a .ptm or .rti; or - for stdin.
    input: Input,
    /// For a pack: list texels, sizes and metadata keys of the KTX2 file and its images. With --json, also print the metadata in
    /// Base64 and the required features of a device. Loaders of ordinary KTX2 files drop this metadata.
    #[arg(long)]
    files: bool,
    #[command(flatten)]
    reading: ReadingOptions,
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Description of the input.
    #[serde(flatten)]
    contents: Contents,
    /// Required features of a device; packs only.
    #[serde(skip_serializing_if = "Option::is_none")]
    devices: Option<DeviceNeeds>,
}

/// Contents of an input.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
enum Contents {
    Reflectance {
        /// Kind and facts.
        #[serde(flatten)]
        facts: Facts,
        /// Exact symmetries, which save work.
        symmetry: Symmetry,
        /// True if one channel is sufficient.
        grey: bool,
    },
    Other(Other),
}

/// Inputs without reflectance of their own, or with reflectance for a single view.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Other {
    /// An importance-sample pack.
    ImportancePack(ImportanceFacts),
    /// A prefiltered environment.
    Environment(EnvironmentFacts),
    /// Lobes of a BRDF.
    Lobes(LobesFacts),
    /// Photographs of one view under known lights.
    RtiCapture(RtiCaptureFacts),
    /// A polynomial texture map.
    Ptm(PtmFacts),
    /// An RTI file of hemispherical harmonics.
    Rti(RtiFacts),
    /// A polynomial wavelet tree.
    PwtPack(PwtFacts),
}

/// Report of `--json` for inputs of 'brdfc flatten'.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct SurfaceReport {
    /// Layout of this report.
    version: u32,
    /// Description of the surface.
    #[serde(flatten)]
    facts: SurfaceFacts,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let input = &arguments.input;
    let reading = checked(arguments.reading, &[input])?;
    if arguments.files {
        return files::run(input, common);
    }
    let kind = Kind::of(input)?;
    let contents = match (kind, input.path()) {
        (Kind::Mesh | Kind::Image | Kind::Btf, _) => return surface(input, common),
        (Kind::Structure, _) if is_structure(input) => return surface(input, common),
        (Kind::RtiCapture, Some(path)) => Contents::Other(Other::RtiCapture(RtiCapture::open(path)?.facts())),
        (Kind::RtiCapture, None) => {
            let path = "the path of the list, because the images are in its folder";
            let error = FormatError::whole("input", "the lights of an RTI capture", path);
            return Err(InputError::Format { name: input.to_string(), error }.into());
        }
        (Kind::Ptm, _) => Contents::Other(Other::Ptm(PtmFacts::new(&open_ptm(input)?))),
        (Kind::Rti, _) => Contents::Other(Other::Rti(RtiFacts::new(&open_rti(input)?))),
        (kind, _) if kind.is_flat_btf() => {
            let (_, asset) = open_asset(input)?;
            if common.json {
                return print_json(&asset);
            }
            let needs = files::device_needs(input)?;
            return print(&(flatten::text(&asset, &[], None) + &lines_of(&[("devices", needs.summary())])));
        }
        (kind, _) if kind.is_ktx2() => match open_pack(input)? {
            Pack::Bandwidth(map) => return bandwidth::info(&map, common),
            Pack::Importance(pack) => Contents::Other(Other::ImportancePack(ImportanceFacts::new(&pack))),
            Pack::Environment(pack) => Contents::Other(Other::Environment(EnvironmentFacts::new(&pack))),
            Pack::Lobes(pack) => Contents::Other(Other::Lobes(LobesFacts::new(&pack))),
            Pack::Pwt(pack) => Contents::Other(Other::PwtPack(PwtFacts::new(&pack))),
            pack => match BrdfPack::try_from(pack) {
                Ok(pack) => reflectance(opened(&pack, None)),
                Err(kind) => return Err(Kind::Pack(kind).refused(input, allowed()).into()),
            },
        },
        (Kind::Model | Kind::Structure | Kind::Table | Kind::Scan, _) => {
            let opened = open(input, reading).map_err(with_structures)?;
            note_gaps(common, input, opened.source.as_ref());
            reflectance(opened)
        }
        _ => return Err(kind.refused(input, allowed()).into()),
    };
    let devices = if kind.is_ktx2() { Some(files::device_needs(input)?) } else { None };
    let mut lines = contents_lines(&contents);
    lines.extend(devices.as_ref().map(|needs| ("devices", needs.summary())));
    print(&json_or(common, &Report { version: 1, contents, devices }, lines_of(&lines)))
}

/// Inputs that are described, for messages.
fn allowed() -> String {
    let others = ".lp (RTI capture), .ptm or .rti (RTI viewer), .btf (BTF), .obj or .ply (mesh), .png or .exr (height map), the folder \
                  of an RTI capture or a BTF, or synth:NAME";
    format!("{}, {others}", known_files())
}

/// Describes an input of 'brdfc flatten'.
fn surface(input: &Input, common: Common) -> Result<(), Error> {
    let facts = describe_surface(input)?;
    let text = lines_of(&surface::summary(&facts));
    print(&json_or(common, &SurfaceReport { version: 1, facts }, text))
}

/// Returns true for the address of a structure that exists.
fn is_structure(input: &Input) -> bool {
    let name =
        input.address().map_or("", |address| split_query(address.strip_prefix(SYNTH_PREFIX).unwrap_or(address)).0);
    STRUCTURES.iter().any(|info| info.name == name)
}

/// Formats names and values as lines with aligned values.
pub(super) fn lines_of(lines: &[(&'static str, String)]) -> String {
    let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    lines.iter().map(|(name, value)| format!("{name:width$}  {}\n", printable(value))).collect()
}

fn reflectance(opened: Opened) -> Contents {
    let (symmetry, grey) = (opened.source.symmetry(), opened.source.is_grey());
    Contents::Reflectance { facts: opened.facts, symmetry, grey }
}

/// Adds structures to the error for an unknown model, and surfaces to the error for an unknown extension.
fn with_structures(error: InputError) -> Error {
    let more = match &error {
        InputError::Address { error, .. } if error.part == "model" => {
            let names: Vec<&str> = STRUCTURES.iter().map(|info| info.name).collect();
            format!("; structures: {}", names.join(", "))
        }
        _ => String::new(),
    };
    let error = Error::from(error);
    let text = format!("{error}{more}");
    error.with_message(text)
}

fn symmetry_text(s: Symmetry) -> String {
    let named = [(s.isotropic, "isotropic"), (s.mirror, "mirror symmetric"), (s.reciprocal, "reciprocal")];
    let held: Vec<&str> = named.into_iter().filter(|(holds, _)| *holds).map(|(_, name)| name).collect();
    if held.is_empty() { "none exact".to_owned() } else { held.join(", ") }
}

fn contents_lines(contents: &Contents) -> Vec<(&'static str, String)> {
    match contents {
        Contents::Reflectance { facts, symmetry, grey } => {
            let mut lines = facts.summary();
            if facts.levels().is_none() {
                lines.push(("symmetry", symmetry_text(*symmetry)));
                lines.push(("colour", if *grey { "grey (one channel)" } else { "RGB" }.to_owned()));
            }
            lines
        }
        Contents::Other(Other::ImportancePack(facts)) => importance_lines(facts),
        Contents::Other(Other::Environment(facts)) => environment::lines(facts),
        Contents::Other(Other::Lobes(facts)) => encode_lobes::lines(facts),
        Contents::Other(Other::RtiCapture(facts)) => facts.summary(),
        Contents::Other(Other::Ptm(facts)) => facts.summary(),
        Contents::Other(Other::Rti(facts)) => facts.summary(),
        Contents::Other(Other::PwtPack(facts)) => pwt_lines(facts),
    }
}

/// Formats facts about a polynomial wavelet tree.
pub(super) fn pwt_lines(facts: &PwtFacts) -> Vec<(&'static str, String)> {
    let mut lines = facts.summary();
    for (_, text) in lines.iter_mut().filter(|(name, _)| *name == "held out") {
        text.push_str(", estimated by cross-validation before pruning and rounding");
    }
    lines.push(("bytes on a GPU", bytes(facts.gpu_bytes)));
    lines
}

/// Formats facts about importance samples.
pub(super) fn importance_lines(facts: &ImportanceFacts) -> Vec<(&'static str, String)> {
    let ImportanceFacts { polar, azimuths, samples, gpu_bytes } = facts;
    let azimuths = if *azimuths == 1 { ", isotropic".to_owned() } else { format!(" x {azimuths} azimuths") };
    vec![
        ("kind", "importance-sample pack".to_owned()),
        ("outgoing directions", format!("{polar} polar angles{azimuths}")),
        ("samples of each", samples.to_string()),
        ("bytes on a GPU", bytes(*gpu_bytes)),
    ]
}
