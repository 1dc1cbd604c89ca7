//! `brdfc shader`: prints the decoder of a kind of pack in an engine's language.

use super::output::{
    output_parser, print, print_json, print_report, refuse_missing_folder, refuse_overwriting, to_json, write_file,
};
use super::{Common, Error};
use crate::table;
use brdfc::Input;
use brdfc::inspect::Kind;
use brdfc::shader::{BrdfShader, EntryPoint, Interface, Language, PackKind, open_flat_btf, open_pack, shader};
use brdfc_terminal::words::{one_of, quoted};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use serde::Serialize;
use std::ffi::OsString;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// Write the shader that decodes a kind of pack, in the language of an engine.
///
/// The output is code to paste into your own shader: declarations and functions. Comments at its top list the functions
/// to call, the resources to bind, and the fields of the uniform block. SPIR-V cannot be pasted, so it is a compute
/// shader that decodes a list of queries. With --json and without a file, the program prints only the functions and
/// bindings. docs/engines has a page for each language.
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
    /// Language of the shader.
    #[arg(long, short, value_parser = PossibleValuesParser::new(Language::ALL.map(Language::name)).map(|name| language(&name)))]
    language: Language,
    /// The file to write, or - for stdout (default: stdout).
    #[arg(long, short, value_name = "FILE", value_parser = output_parser())]
    output: Option<PathBuf>,
}

/// Help for KIND.
fn kinds() -> String {
    format!("{}, or a pack", one_of(&PackKind::ALL.map(PackKind::name)))
}

/// Converts a name that clap has checked.
fn language(name: &str) -> Language {
    Language::from_name(name).expect("a name of one")
}

/// Report of `--json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// 'shader'.
    kind: &'static str,
    /// Kind of pack that it decodes.
    decoder: &'static str,
    /// The language.
    language: &'static str,
    /// Bytes of the file.
    bytes_on_disk: usize,
    /// Version of the decoder's bindings; packs of another version need another decoder.
    bindings_version: u32,
    /// Resources to bind and functions to call.
    #[serde(flatten)]
    interface: Interface,
    /// Evaluation of a BRDF in a shader; only for packs of BRDFs, in languages whose functions take no bindings.
    #[serde(skip_serializing_if = "Option::is_none")]
    brdf: Option<Brdf>,
    /// Compute shader; only for SPIR-V.
    #[serde(skip_serializing_if = "Option::is_none")]
    entry_point: Option<EntryPoint>,
}

/// Expressions that evaluate a pack of a BRDF, identical in WGSL, GLSL, GLSL ES 3.00 and HLSL.
#[derive(Debug, Serialize, schemars::JsonSchema)]
struct Brdf {
    /// `f_r` of `wi`, `wo` and `level`, interpolated by a sampler.
    filtered: &'static str,
    /// The same, interpolated by the shader.
    exact: &'static str,
    /// Level of detail at `distance` from the viewer.
    level_of_detail: &'static str,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output = arguments.output.as_deref();
    if let Some(output) = output {
        refuse_overwriting("--output", output, &[Path::new(&arguments.kind)])?;
        if output.extension().is_some_and(|extension| extension == "ktx2") {
            let found = output.display();
            return Err(Error::usage(format!(
                "--output: {found} has the extension of packs; choose another extension"
            )));
        }
        refuse_missing_folder(output)?;
    }
    let decoder = decoder(&arguments.kind)?;
    if output.is_none() && !common.json && arguments.language == Language::Spirv && std::io::stdout().is_terminal() {
        let text = "--output: SPIR-V is binary and is not printed on a terminal; choose a file or a pipe";
        return Err(Error::usage(text.to_owned()));
    }
    let shader = shader(decoder, arguments.language);
    // Functions in MSL take bound resources as parameters, and SPIR-V is a complete shader.
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

/// Returns the named decoder, or the decoder of a pack.
fn decoder(kind: &OsString) -> Result<PackKind, Error> {
    if let Some(decoder) = kind.to_str().and_then(PackKind::from_name) {
        return Ok(decoder);
    }
    let path = Path::new(kind);
    // The argument may be the path of a missing file.
    let is_word = path.extension().is_none() && path.components().count() == 1;
    if is_word && !path.exists() {
        return Err(Error::wrong_usage("KIND", quoted(&path.to_string_lossy()), kinds()));
    }
    let input = Input::from(path);
    match Kind::of(&input)? {
        kind if kind.is_flat_btf() => Ok(open_flat_btf(input)?.decoder.parts().reflectance.kind()),
        kind if kind.is_ktx2() => Ok(open_pack(input)?.kind()),
        kind => Err(kind.refused(&input, kinds()).into()),
    }
}

impl Report {
    fn text(&self) -> String {
        let functions: Vec<&str> = self.interface.functions.iter().map(|function| function.name.as_str()).collect();
        let size = table::bytes(self.bytes_on_disk as u64);
        format!("{} decoder in {}: {size}; call {}\n", self.decoder, self.language, functions.join(", "))
    }
}
