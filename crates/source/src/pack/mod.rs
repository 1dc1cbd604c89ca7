//! Packs as inputs.

mod facts;

pub use facts::{TablePackFacts, WaveletPackFacts};

use super::error::InputError;
use super::format::{Format, Opened};
use super::input::{Input, InputFile};
use brdfc_core::decoded;
use brdfc_formats::table::TablePack;
use brdfc_formats::wavelet::WaveletPack;
use brdfc_formats::{BrdfPack, FormatError, Pack, PackKind};
use brdfc_readers::recognise::KTX2;

/// Packs of reflectances as inputs, of whichever codec.
pub(crate) const fn format<F: From<WaveletPackFacts> + From<TablePackFacts>>() -> Format<F> {
    Format { name: "pack", kind: &KTX2, open }
}

fn open<F: From<WaveletPackFacts> + From<TablePackFacts>>(input: InputFile<'_>) -> Result<Opened<F>, InputError> {
    let level = input.level;
    input.parse(|bytes| Ok(opened(&brdf_pack(Pack::from_bytes(bytes)?)?, level)))
}

/// A pack as an input, decoded at a level of detail; `None` is the finest.
pub(crate) fn opened<F: From<WaveletPackFacts> + From<TablePackFacts>>(
    pack: &BrdfPack,
    level: Option<f32>,
) -> Opened<F> {
    let facts = match pack {
        BrdfPack::Wavelet(pack) => wavelet_facts(pack).into(),
        BrdfPack::Table(pack) => table_facts(pack).into(),
    };
    Opened { source: decoded(pack, level), facts }
}

fn wavelet_facts(pack: &WaveletPack) -> WaveletPackFacts {
    let header = &pack.header;
    WaveletPackFacts {
        parameterisation: header.parameterisation,
        grid: header.grid(),
        levels: header.levels,
        stored_levels: header.stored_levels,
        lifted: header.lifted,
        channels: header.channels,
        bits: header.bits,
        slices_kept: pack.slices() - 1,
        mean: header.mean,
        bias: header.bias,
        directions: pack.directions(),
        gpu_bytes: pack.gpu_bytes(),
        on_grid: pack.on_grid,
        off_grid: pack.off_grid,
    }
}

fn table_facts(pack: &TablePack) -> TablePackFacts {
    let header = pack.header();
    TablePackFacts {
        axes: header.axes,
        folded: header.symmetry,
        channels: header.channels,
        mean: header.mean,
        bias: header.bias,
        curve_nodes: pack.curve().map_or(0, |curve| curve.nodes()),
        levels: pack.levels(),
        fetches: pack.fetches(),
        directions: pack.directions(),
        gpu_bytes: pack.gpu_bytes(),
        off_grid: pack.off_grid,
        picture: pack.picture,
    }
}

/// Reads a pack of any kind.
///
/// # Errors
/// Files that cannot be read; packs of no known kind, or that break the rules of their layout.
pub fn open_pack(input: impl Into<Input>) -> Result<Pack, InputError> {
    let input = input.into();
    InputFile::of(&input, &mut ())?.parse(Pack::from_bytes)
}

/// Reads a pack of reflectances, of whichever codec.
///
/// # Errors
/// As [`open_pack`]; a pack of another kind, which is named.
pub fn open_brdf_pack(input: impl Into<Input>) -> Result<BrdfPack, InputError> {
    let input = input.into();
    brdf_pack(open_pack(&input)?).map_err(|error| InputError::format(input.named_path(), error))
}

fn brdf_pack(pack: Pack) -> Result<BrdfPack, FormatError> {
    let kind = match pack {
        Pack::Wavelet(pack) => return Ok(BrdfPack::Wavelet(pack)),
        Pack::Table(pack) => return Ok(BrdfPack::Table(pack)),
        other => other.kind(),
    };
    let allowed = match kind {
        PackKind::FlatBtf => "a table or wavelet pack: a flat BTF has no one BRDF",
        _ => "a table or wavelet pack",
    };
    Err(FormatError::whole("pack", kind.in_words(), allowed))
}
