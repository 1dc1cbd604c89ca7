//! Packs as sources: what an engine would see.

use super::error::InputError;
use super::format::{Facts, Format, Opened};
use super::input::{Input, InputFile};
use super::pair_list::PairBlock;
use super::{Source, Symmetry, Tally};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::{TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_formats::{BrdfPack, FormatError, Pack, PackKind};
use std::path::Path;

/// How packs are opened as sources.
pub(crate) const FORMAT: Format = Format { extension: "ktx2", name: "pack", open };

fn open(input: InputFile<'_>) -> Result<Opened, InputError> {
    let (name, level) = (file_name(input.path), input.level);
    input.parse(|bytes| Ok(opened(&brdf_pack(Pack::from_bytes(bytes, name)?)?, level)))
}

/// A pack as an input, decoded at a level of detail if it has any; `None` is the finest.
pub fn opened(pack: &BrdfPack, level: Option<f32>) -> Opened {
    match pack {
        BrdfPack::Wavelet(pack) => opened_wavelet(pack, level),
        BrdfPack::Table(pack) => opened_table(pack, level),
    }
}

fn opened_wavelet(pack: &WaveletPack, level: Option<f32>) -> Opened {
    let header = &pack.header;
    let facts = Facts::WaveletPack {
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
    };
    Opened { source: Box::new(PackSource::new(pack, level)), facts }
}

fn opened_table(pack: &TablePack, level: Option<f32>) -> Opened {
    let header = pack.header();
    let facts = Facts::TablePack {
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
    };
    Opened { source: Box::new(TableSource::at(pack, level)), facts }
}

/// Reads a pack of any kind.
///
/// # Errors
/// Files that cannot be read; packs of no known kind, or that break the rules of their layout.
pub fn open_pack(input: impl Into<Input>) -> Result<Pack, InputError> {
    let input = input.into();
    InputFile::of(&input, &mut ())?.parse(|bytes| Pack::from_bytes(bytes, file_name(input.named_path())))
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
        PackKind::FlatBtf(_) => "a table or wavelet pack; of a flat BTF, its folder or the NAME.json beside its parts",
        _ => "a table or wavelet pack",
    };
    Err(FormatError::whole("pack", kind.name(), allowed))
}

fn file_name(path: &Path) -> Option<&str> {
    path.file_name().and_then(|name| name.to_str())
}

/// A wavelet pack, decoded at a level of detail with bilinear filtering on both hemispheres.
#[derive(Debug)]
pub struct PackSource {
    decoder: WaveletDecoder,
    directions: DirectionRange,
    level: f32,
}

impl PackSource {
    /// `level` is the level of detail, `0.0..=N`; `None` is the finest.
    pub fn new(pack: &WaveletPack, level: Option<f32>) -> Self {
        let level = level.unwrap_or(pack.header.levels as f32);
        Self { decoder: WaveletDecoder::new(pack), directions: pack.directions(), level }
    }

    /// The decoder.
    pub fn decoder(&self) -> &WaveletDecoder {
        &self.decoder
    }
}

impl Source for PackSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        self.decoder.eval(pair, self.level, Filter::Bilinear).map(f64::from)
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    fn is_grey(&self) -> bool {
        self.decoder.header().channels == 1
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }
}

/// A table pack, filtered exactly.
#[derive(Debug)]
pub struct TableSource {
    decoder: TableDecoder,
    directions: DirectionRange,
    level: f32,
}

impl TableSource {
    /// Unpacks a pack, to be evaluated at its finest level of detail.
    pub fn new(pack: &TablePack) -> Self {
        Self::at(pack, None)
    }

    /// `level` is the level of detail, from 0 to the pack's number of levels; `None` is the finest.
    pub fn at(pack: &TablePack, level: Option<f32>) -> Self {
        let level = level.unwrap_or(pack.levels() as f32);
        Self { decoder: TableDecoder::new(pack), directions: pack.directions(), level }
    }
}

impl Source for TableSource {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        self.decoder.eval_at(pair, self.level).map(f64::from)
    }

    fn eval_block(&self, block: PairBlock<'_>, tally: &mut Tally, values: &mut [[f64; 3]]) {
        tally.evaluations += values.len() as u64;
        for ((value, pair), angles) in values.iter_mut().zip(block.pairs()).zip(block.of_tables()) {
            let found = if pair.is_above_horizon() { self.decoder.eval_angles(*angles, self.level) } else { [0.0; 3] };
            *value = found.map(f64::from);
        }
    }

    fn symmetry(&self) -> Symmetry {
        let header = self.decoder.header();
        let folds = header.symmetry;
        let mirror = if header.isotropic() { folds.mirror } else { folds.half_turn && folds.reflected };
        Symmetry { isotropic: header.isotropic(), mirror, reciprocal: folds.reciprocal }
    }

    fn is_grey(&self) -> bool {
        self.decoder.header().channels == 1
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }
}
