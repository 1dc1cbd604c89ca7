//! Opens the inputs of a page.

use super::item::{Drawn, ViewItem};
use super::photographs::Photographs;
use crate::encode::EncodeError;
use crate::error::Error;
use crate::report::page::{Reports, source_name, source_of};
use crate::scene::build::notes;
use crate::write::build_folder;
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_core::words::bytes;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::{BrdfPack, FormatError, Pack, PackKind};
use brdfc_source::flat_btf::open_flat_btf;
use brdfc_source::open::open;
use brdfc_source::pack::open_pack;
use brdfc_source::photograph::CodeValues;
use brdfc_source::{Input, InputError, Kind};
use brdfc_table::encode::encode;
use brdfc_table::recipe::{Size, TableRecipe};
use std::path::Path;

/// Inputs that can be drawn.
const ALLOWED: &str = "a pack of a BRDF, lobes, a flat BTF, a pack of 'brdfc pwt', an RTI capture, the folder \
                       of a build, or a material; name several one by one";
/// Expected input next to an environment, which is no input of its own.
const LIGHTS_LOBES: &str = "a pack of lobes, which '--environment' lights with this file";

/// Bytes of the table pack as which a source is drawn, more than packs usually have. With four times as many, renderings of
/// measured materials are closer by at most 0.03 ΔE.
const TABLE_BYTES: u64 = 128 << 10;
/// Maximum bytes of textures of all materials, so that browsers can open the page.
const MAX_BYTES: u64 = 256 << 20;

/// Returns an error if the textures exceed the limit of a page.
pub(super) fn check_bytes(name: &str, size: u64) -> Result<(), Error> {
    if size <= MAX_BYTES {
        return Ok(());
    }
    let allowed = "at most 256 MiB in a page; use fewer or smaller materials";
    Err(refused(name, format!("{} of textures", bytes(size)), allowed))
}

/// Error about an input that cannot be drawn.
fn refused(name: &str, found: impl Into<String>, allowed: &'static str) -> Error {
    InputError::Format { name: name.to_owned(), error: FormatError::whole("input", found, allowed) }.into()
}

/// Options for reading the inputs of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ViewOptions {
    /// True to draw the sources of builds' packs, too, if they still exist.
    pub sources: bool,
    /// True to add the normals of the first RTI capture, or else of the first pack of `brdfc pwt`.
    pub normals: bool,
    /// Meaning of the code values of photographs in spite of what they state.
    pub codes: Option<CodeValues>,
    /// Maximum bytes of the photographs of each RTI capture in the page.
    pub photograph_bytes: u64,
}

impl Default for ViewOptions {
    fn default() -> Self {
        Self { sources: true, normals: false, codes: None, photograph_bytes: 8 << 20 }
    }
}

/// Reads inputs: packs, photographs, the packs of builds with their sources, and sources as table packs.
///
/// # Errors
/// Returns an error if an input cannot be read, is invalid or cannot be drawn, or if cancelled.
pub fn open_items(inputs: &[Input], options: ViewOptions, progress: &dyn Progress) -> Result<Vec<ViewItem>, Error> {
    let mut items: Vec<ViewItem> = Vec::new();
    let (mut capture, mut pack) = (None, None);
    for input in inputs {
        progress.check()?;
        let opened = match (Kind::of(input)?, input.path()) {
            (Kind::Build, Some(path)) => of_build(build_folder(path), options, progress)?,
            _ => vec![of_input(input, options, progress)?],
        };
        for mut item in opened {
            match item.drawn {
                Drawn::Photographs(_) => capture = capture.or(Some(input)),
                Drawn::Pwt(_) => pack = pack.or(Some(input)),
                _ => {}
            }
            item.name = unique_name(&items, item.name);
            items.push(item);
        }
    }
    if options.codes.is_some() && capture.is_none() {
        return Err(Error::usage("--photographs: found no RTI capture, expected one"));
    }
    if options.normals {
        let Some(input) = capture.or(pack) else {
            return Err(Error::usage("--normals: found no RTI capture and no pack of 'brdfc pwt', expected one"));
        };
        let name = unique_name(&items, format!("{}, normals", input.short_name()));
        items.push(of_photographs(name, Photographs::normals(input, options.codes)?));
    }
    Ok(items)
}

/// Makes a name unique among the items.
fn unique_name(items: &[ViewItem], name: String) -> String {
    let is_taken = |name: &str| items.iter().any(|item| item.name == name);
    if !is_taken(&name) {
        return name;
    }
    let numbered = (2..).map(|number| format!("{name} ({number})"));
    numbered.into_iter().find(|name| !is_taken(name)).expect("numbers do not end")
}

fn of_input(input: &Input, options: ViewOptions, progress: &dyn Progress) -> Result<ViewItem, Error> {
    let name = input.short_name();
    match (Kind::of(input)?, input.path()) {
        (Kind::RtiCapture, Some(path)) => {
            let them = Photographs::of_capture(path, options.codes, options.photograph_bytes, progress)?;
            Ok(of_photographs(name, them))
        }
        (kind, _) if kind.is_flat_btf() => of_flat_btf(name, input),
        (kind, _) if kind.is_ktx2() => of_pack(name, input),
        (kind, _) if kind.is_brdf() => {
            let opened = open(input, None)?;
            of_source(name, &input.to_string(), opened.source.as_ref(), progress)
        }
        (kind, _) => Err(kind.refused(input, ALLOWED).into()),
    }
}

fn of_pack(name: String, input: &Input) -> Result<ViewItem, Error> {
    match open_pack(input)? {
        Pack::Pwt(pack) => Ok(of_tree(name, pack)),
        Pack::Lobes(pack) => {
            let look_ups = match pack.fetches() {
                1 => "one look-up".to_owned(),
                many => format!("{many} look-ups"),
            };
            let facts = format!("lobes, {look_ups} in the environment, {} on a GPU", bytes(pack.gpu_bytes()));
            Ok(ViewItem { name, facts, drawn: Drawn::Lobes(pack) })
        }
        Pack::Environment(_) => Err(refused(&input.to_string(), PackKind::Environment.summary(), LIGHTS_LOBES)),
        pack => match BrdfPack::try_from(pack) {
            Ok(pack) => Ok(of_brdf(name, pack)),
            Err(kind) => Err(refused(&input.to_string(), kind.summary(), ALLOWED)),
        },
    }
}

fn of_tree(name: String, pack: PwtPack) -> ViewItem {
    let [width, height] = pack.header().size;
    let facts = format!("{width} x {height} pixels under any light, {} on a GPU", bytes(pack.gpu_bytes()));
    ViewItem { name, facts, drawn: Drawn::Pwt(Box::new(pack)) }
}

fn of_photographs(name: String, photographs: Photographs) -> ViewItem {
    ViewItem { name, facts: photographs.facts(), drawn: Drawn::Photographs(photographs) }
}

fn of_brdf(name: String, pack: BrdfPack) -> ViewItem {
    let fetches = match pack.fetches() {
        1 => "one fetch".to_owned(),
        many => format!("{many} fetches"),
    };
    let mut facts = format!("{}, {} on a GPU, {fetches}", pack.variant(), bytes(pack.gpu_bytes()));
    match (pack.rendering(), pack.off_grid().relative_mean) {
        (Some(rendering), _) if rendering.max > 0.0 => {
            facts += &format!(", ΔE {:.2} of a ball against its source", rendering.mean);
        }
        (None, error) if error > 0.0 => {
            facts += &format!(", ε_r {} against its source", brdfc_core::words::percent(error.into()));
        }
        _ => {}
    }
    if !pack.directions().is_all() {
        facts += &format!(", only for {}", pack.directions());
    }
    ViewItem { name, facts, drawn: Drawn::Brdf(pack) }
}

fn of_source(name: String, input: &str, source: &dyn Source, progress: &dyn Progress) -> Result<ViewItem, Error> {
    let recipe = TableRecipe { size: Size::Bytes(TABLE_BYTES), ..TableRecipe::default() };
    let encoded = encode(source, &recipe, progress).map_err(|error| match error {
        EncodeError::Cancelled(cancelled) => cancelled.into(),
        error => Error::input(error).prefixed(input),
    })?;
    let table = encoded.pack;
    let error = table.rendering.mean;
    let size = bytes(table.gpu_bytes());
    let facts = format!("the source as a table of {size}: ΔE {error:.2} of a ball against the source itself");
    Ok(ViewItem { name, facts, drawn: Drawn::Brdf(BrdfPack::Table(table)) })
}

fn of_flat_btf(name: String, input: &Input) -> Result<ViewItem, Error> {
    let file = open_flat_btf(input)?;
    let size = file.gpu_bytes();
    // Checked before it is compressed.
    check_bytes(&input.to_string(), size)?;
    let FlatBtfFile { decoder, directions, .. } = file;
    let form = decoder.parts().reflectance.name();
    let facts = format!("flat BTF, {form}, {} on a GPU", bytes(size));
    Ok(ViewItem { name, facts, drawn: Drawn::FlatBtf(Box::new(decoder), directions) })
}

/// The packs of a build, those of materials each followed by its source. Environments are no items of their own.
fn of_build(folder: &Path, options: ViewOptions, progress: &dyn Progress) -> Result<Vec<ViewItem>, Error> {
    let notes = notes(folder);
    let mut items = Vec::new();
    let reports = Reports::open(folder, None)?;
    for (material, pack) in reports.brdf_packs()? {
        progress.check()?;
        let mut item = of_brdf(material.clone(), pack);
        let note = notes.get(&material).cloned().unwrap_or_default();
        let source = options.sources.then(|| source_of(&note));
        if let Some(Err(reason)) = &source {
            item.facts += &format!("; shown without its source: {reason}");
        }
        items.push(item);
        if let Some(Ok(source)) = source {
            items.push(of_source(source_name(&material), &material, source.as_ref(), progress)?);
        }
    }
    items.extend(reports.tree_packs()?.into_iter().map(|(name, pack)| of_tree(name, pack)));
    if items.is_empty() {
        return Err(refused(&folder.display().to_string(), "a build without packs", ALLOWED));
    }
    Ok(items)
}
