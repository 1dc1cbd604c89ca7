//! Packs as inputs.

use super::error::InputError;
use super::format::{Format, Opened};
use super::input::{Input, InputFile};
use super::read::{extension_of, start_of};
use brdfc_core::PackSource;
use brdfc_encode::PackFacts;
use brdfc_formats::bindings::PackFile;
use brdfc_formats::{BrdfPack, FormatError, Pack, PackKind};
use brdfc_readers::recognise::KTX2;
use std::path::Path;

/// BRDF packs of any codec as inputs.
pub(crate) const fn format<F: From<PackFacts>>() -> Format<F> {
    Format { name: "pack", kind: &KTX2, open }
}

fn open<F: From<PackFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let level = input.reading.level;
    input.parse(|bytes| Ok(opened(&brdf_pack(Pack::from_bytes(bytes)?)?, level)))
}

/// Wraps a pack as an input, decoded at a level of detail; `None` is the finest.
pub(crate) fn opened<F: From<PackFacts>>(pack: &BrdfPack, level: Option<f32>) -> Opened<F> {
    Opened { source: Box::new(PackSource::new(&**pack, level)), facts: PackFacts::from(pack).into() }
}

/// Kind of the pack that a file starts with; `None` for other files.
pub(crate) fn kind_of_file(file: &Path) -> Option<PackKind> {
    let is_texture = KTX2.extensions.contains(&extension_of(file).as_str());
    let start = is_texture.then(|| start_of(file, PackFile::HEAD_BYTES)).flatten()?;
    kind_in(&start)
}

/// Kind of the pack that starts with these bytes.
pub(crate) fn kind_in(start: &[u8]) -> Option<PackKind> {
    PackKind::from_name(PackFile::decoder_in(&start[..start.len().min(PackFile::HEAD_BYTES)])?)
}

/// Reads a pack of any kind.
///
/// # Errors
/// Returns an error for files that cannot be read, and for packs of unknown kinds or that violate their layout.
pub fn open_pack(input: impl Into<Input>) -> Result<Pack, InputError> {
    let input = input.into();
    InputFile::of(&input, &mut ())?.parse(Pack::from_bytes)
}

/// Reads a BRDF pack of any codec.
///
/// # Errors
/// Same as [`open_pack`]. Other kinds of packs are an error that names the kind.
pub fn open_brdf_pack(input: impl Into<Input>) -> Result<BrdfPack, InputError> {
    let input = input.into();
    brdf_pack(open_pack(&input)?).map_err(|error| InputError::format(input.named_path(), error))
}

fn brdf_pack(pack: Pack) -> Result<BrdfPack, FormatError> {
    BrdfPack::try_from(pack).map_err(|kind| {
        let allowed = match kind {
            PackKind::FlatBtf | PackKind::FlatBtfTrees => "a pack of a BRDF; a flat BTF has no single BRDF",
            _ => "a pack of a BRDF",
        };
        FormatError::whole("pack", kind.summary(), allowed)
    })
}
