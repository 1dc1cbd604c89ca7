//! Assets that cover a whole scene: a flat BTF or the pack of an RTI capture, given directly or by a manifest.

use super::arguments::Arguments;
use super::lobes;
use super::materials::{Subject, pack_flag};
use crate::reading::first_flag;
use crate::{Error, output};
use brdfc::Input;
use brdfc::inspect::{AnyPack as Pack, Kind, open_pack};
use brdfc::lobes::LobesPack;
use brdfc::render::PwtPack;
use brdfc::scene::read_manifest;
use std::path::Path;

/// An asset, and where its path is from.
pub(super) struct Asset {
    /// Path of the asset.
    pub(super) input: Input,
    /// The scene of the command line: the manifest, or the asset itself.
    pub(super) subject: Subject,
    pub(super) kind: AssetKind,
}

pub(super) enum AssetKind {
    /// A flat BTF.
    Flat,
    /// A polynomial wavelet tree.
    Pwt(Box<PwtPack>),
    /// A BRDF that an environment lights: lobes, or a material without a pack of them.
    Lobes(Option<Box<LobesPack>>),
}

/// Opens the asset; `None` if the input is a BRDF under point lights.
pub(super) fn asset(arguments: &Arguments) -> Result<Option<Asset>, Error> {
    let (input, subject) = match Kind::of(&arguments.input)? {
        Kind::Manifest => match of_manifest(arguments)? {
            Some(found) => found,
            None => return Ok(None),
        },
        _ => (arguments.input.clone(), Subject::Pack),
    };
    let named_by_manifest = subject.manifest().is_some();
    let kind = match Kind::of(&input)? {
        Kind::RtiCapture => return Err(not_packed(&input)),
        kind if kind.is_flat_btf() => AssetKind::Flat,
        kind if kind.is_ktx2() => match open_pack(&input) {
            Ok(Pack::Pwt(pack)) => AssetKind::Pwt(Box::new(pack)),
            Ok(Pack::Lobes(pack)) if !named_by_manifest => AssetKind::Lobes(Some(Box::new(pack))),
            Ok(other) if named_by_manifest => {
                return Err(no_asset(&input, &format!("found {}, ", other.kind().summary())));
            }
            Err(error) if named_by_manifest => return Err(error.into()),
            // Packs of BRDFs are opened later, after their flags are checked, and report the error.
            _ if !arguments.by_lobes() => return Ok(None),
            _ => AssetKind::Lobes(None),
        },
        _ if named_by_manifest => return Err(no_asset(&input, "")),
        _ if arguments.by_lobes() => AssetKind::Lobes(None),
        _ => return Ok(None),
    };
    Ok(Some(Asset { input, subject, kind }))
}

/// Name of an input for reports: the file without its extension.
pub(super) fn name_of(input: &Input) -> String {
    let stem = input.path().and_then(Path::file_stem);
    stem.map_or_else(|| input.to_string(), |name| name.to_string_lossy().into_owned())
}

/// Reads a manifest, and returns its asset and itself.
fn of_manifest(arguments: &Arguments) -> Result<Option<(Input, Subject)>, Error> {
    let Some(path) = arguments.input.path().map(Path::to_owned) else { return Ok(None) };
    let (text, manifest) = read_manifest(&path)?;
    let Some(asset) = &manifest.render.asset else { return Ok(None) };
    let file = path.parent().unwrap_or(Path::new("")).join(asset);
    let manifest = Box::new(manifest);
    let subject = Subject::Scene { path, text, manifest, jobs: Vec::new(), environment: None, packs: None };
    Ok(Some((Input::from(&file), subject)))
}

fn no_asset(input: &Input, found: &str) -> Error {
    let allowed = "a flat BTF, or the pack of an RTI capture";
    Error::input(format!("{input}: render.asset: {found}expected {allowed}"))
}

fn not_packed(input: &Input) -> Error {
    let text = "RTI captures are not drawn; draw a pack that 'brdfc pwt' makes, with the RTI capture as --source";
    Error::input(format!("{input}: {text}"))
}

/// Rejects an environment for an input that no lobes are drawn of.
pub(super) fn refuse_environment(arguments: &Arguments, input: &Input) -> Result<(), Error> {
    if arguments.by_lobes() {
        let text = "--environment applies to materials and their scenes, not to flat BTFs and packs of RTI captures";
        return Err(Error::usage(format!("{input}: {text}")));
    }
    Ok(())
}

/// Rejects flags that do not apply to this kind of asset.
pub(super) fn refuse_flags(arguments: &Arguments, asset: &Asset) -> Result<(), Error> {
    if matches!(asset.kind, AssetKind::Lobes(_)) {
        return lobes::refuse_flags(arguments, &asset.input);
    }
    refuse_environment(arguments, &asset.input)?;
    let is_flat = matches!(asset.kind, AssetKind::Flat);
    let (of_brdfs, of_both) = ("BRDFs", "BRDFs and packs of RTI captures");
    let option = arguments.options.first().map(pack_flag);
    let read = first_flag(arguments.reading);
    let flags = [
        (arguments.packs.is_some(), "--packs", of_brdfs),
        (arguments.table, "--table", of_brdfs),
        (arguments.lod.is_some(), "--lod", of_brdfs),
        (arguments.filter.is_some(), "--filter", of_brdfs),
        (option.is_some(), option.as_deref().unwrap_or_default(), of_brdfs),
        (read.is_some(), read.unwrap_or_default(), of_brdfs),
        (arguments.contact.is_some(), "--contact", of_brdfs),
        (arguments.adaptive.adaptive, "--adaptive", of_brdfs),
        (is_flat && arguments.source.is_some(), "--source", of_both),
        (is_flat && arguments.exact, "--exact", of_both),
    ];
    let what = if is_flat { "a flat BTF" } else { "a pack of an RTI capture" };
    output::refuse_flags(format!("{}, {what}", asset.input), &flags)
}
