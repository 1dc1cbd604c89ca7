//! `brdfc shader`: the decoder of a kind of pack in an engine's language.

use super::output::{
    output_parser, print, print_json, print_report, refuse_missing_folder, refuse_overwriting, to_json, write_file,
};
use super::{Common, Error};
use crate::table;
use brdfc::Input;
use brdfc::shader::{BrdfShader, EntryPoint, Interface, Language, PackKind, open_flat_btf, open_pack, shader};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use serde::Serialize;
use std::ffi::OsString;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// Write the shader that decodes a kind of pack, in the language of an engine.
///
/// What comes out is a piece to be pasted into a shader of your own: declarations and functions. At its top stands what to
/// call, what to bind, and where the fields of the uniform block are. SPIR-V cannot be pasted: there it is a compute shader that
/// decodes a list of queries. With --json and no file, what to call and to bind is all that is printed. docs/engines has a page
/// for each language.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc shader table --language essl300 -o table.glsl
  brdfc shader red.ktx2 --language hlsl -o red.hlsl
  brdfc shader flat-btf --language wgsl > flat.wgsl
  brdfc shader wavelet --language spirv -o wavelet.spv
  brdfc shader table --language glsl --json")]
pub struct Arguments {
    #[arg(value_name = "KIND", help = kinds())]
    kind: OsString,
    /// The language.
    #[arg(long, short, value_parser = PossibleValuesParser::new(Language::ALL.map(Language::name)).map(|name| language(&name)))]
    language: Language,
    /// The file to write (default: standard output).
    #[arg(long, short, value_name = "FILE", value_parser = output_parser())]
    output: Option<PathBuf>,
}

/// Help for KIND.
fn kinds() -> String {
    let [others @ .., last] = PackKind::ALL.map(PackKind::name);
    format!("{} or {last}; or a pack", others.join(", "))
}

/// One of the names that clap lets through.
fn language(name: &str) -> Language {
    Language::from_name(name).expect("a name of one")
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'shader'.
    kind: &'static str,
    /// Which kind of pack it decodes.
    decoder: &'static str,
    /// The language.
    language: &'static str,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Version of the decoder's bindings: packs of another version are for another decoder.
    bindings_version: u32,
    /// What to bind, and what to call.
    #[serde(flatten)]
    interface: Interface,
    /// Of packs of BRDFs, how a shader evaluates one, in languages whose functions take no bindings.
    #[serde(skip_serializing_if = "Option::is_none")]
    brdf: Option<Brdf>,
    /// Of SPIR-V, what runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    entry_point: Option<EntryPoint>,
}

/// Expressions that evaluate a pack of a BRDF, the same in WGSL, GLSL, GLSL ES 3.00 and HLSL.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct Brdf {
    /// `f_r` of `wi`, `wo` and `level`, filtered by a sampler.
    filtered: &'static str,
    /// The same, filtered by the shader.
    exact: &'static str,
    /// The level of detail at `distance` from the viewer.
    level_of_detail: &'static str,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output = arguments.output.as_deref();
    if let Some(output) = output {
        refuse_overwriting("--output", output, &[Path::new(&arguments.kind)])?;
        if output.extension().is_some_and(|extension| extension == "ktx2") {
            let found = output.display();
            return Err(Error::usage(format!(
                "--output: found {found}, as packs are called, expected another extension"
            )));
        }
        refuse_missing_folder(output)?;
    }
    let decoder = decoder(&arguments.kind)?;
    if output.is_none() && !common.json && arguments.language == Language::Spirv && std::io::stdout().is_terminal() {
        let text = "--output: found none, and a terminal, expected a file or a pipe: SPIR-V is no text";
        return Err(Error::usage(text.to_owned()));
    }
    let shader = shader(decoder, arguments.language);
    // Functions in MSL take what is bound as parameters, and SPIR-V is a whole shader.
    let takes_no_bindings = !matches!(arguments.language, Language::Msl | Language::Spirv);
    let report = Report {
        version: 1,
        kind: "shader",
        decoder: decoder.name(),
        language: arguments.language.name(),
        bytes_on_disk: shader.bytes.len(),
        bindings_version: decoder.descriptor().version,
        interface: shader.interface,
        brdf: decoder.descriptor().brdf.filter(|_| takes_no_bindings).map(Brdf::from),
        entry_point: shader.entry_point,
    };
    match output {
        Some(output) => {
            write_file(output, &shader.bytes)?;
            print_report(common, output, &if common.json { to_json(&report) } else { report.text() })
        }
        None if common.json => print_json(&report),
        None => match std::str::from_utf8(&shader.bytes) {
            Ok(text) if arguments.language != Language::Spirv => print(text),
            _ => write_file(Path::new("/dev/stdout"), &shader.bytes),
        },
    }
}

impl From<BrdfShader> for Brdf {
    fn from(BrdfShader { filtered, exact, level_of_detail, .. }: BrdfShader) -> Self {
        Self { filtered, exact, level_of_detail }
    }
}

/// The decoder that is named, or that of a pack.
fn decoder(kind: &OsString) -> Result<PackKind, Error> {
    if let Some(decoder) = kind.to_str().and_then(PackKind::from_name) {
        return Ok(decoder);
    }
    let path = Path::new(kind);
    // What may be meant as a file is missing as one.
    let is_word = path.extension().is_none() && path.components().count() == 1;
    if is_word && !path.exists() {
        let names = PackKind::ALL.map(PackKind::name).join(", ");
        let found = path.display();
        return Err(Error::usage(format!("KIND: found {found}, expected {names}, or a pack")));
    }
    if path.is_dir() {
        open_flat_btf(path)?;
        return Ok(PackKind::FlatBtf);
    }
    Ok(open_pack(Input::File(path.to_owned()))?.kind())
}

impl Report {
    fn text(&self) -> String {
        let functions: Vec<&str> = self.interface.functions.iter().map(|function| function.name.as_str()).collect();
        let size = table::bytes(self.bytes_on_disk as u64);
        format!("{} decoder in {}: {size}; call {}\n", self.decoder, self.language, functions.join(", "))
    }
}
