//! Packs as sources: what an engine would see.

use super::error::InputError;
use super::format::{Facts, Format, InputFile, Opened};
use super::read::{MAX_FILE_BYTES, read_file};
use super::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_formats::{FormatError, Pack, PackKind};
use std::path::Path;

/// How packs are opened as sources.
pub(crate) const FORMAT: Format = Format { extension: "ktx2", name: "pack", open };

fn open(input: InputFile<'_>) -> Result<Opened, InputError> {
    let (name, level) = (file_name(input.path), input.level);
    input.parse(|bytes| Ok(opened(&wavelet_pack(Pack::from_bytes(bytes, name)?)?, level)))
}

/// A wavelet pack as an input, decoded at a level of detail; `None` is the finest.
pub fn opened(pack: &WaveletPack, level: Option<f32>) -> Opened {
    let header = &pack.header;
    let facts = Facts::WaveletPack {
        parameterisation: header.parameterisation,
        grid: header.grid(),
        levels: header.levels,
        stored_levels: header.stored_levels,
        channels: header.channels,
        bits: header.bits,
        slices_kept: pack.slices() - 1,
        mean: header.mean,
        bias: header.bias,
        gpu_bytes: pack.gpu_bytes(),
        on_grid: pack.on_grid,
        off_grid: pack.off_grid,
    };
    Opened { source: Box::new(PackSource::new(pack, level)), facts }
}

/// Reads a pack of any kind.
///
/// # Errors
/// Files that cannot be read; packs of no known kind, or that break the rules of their layout.
pub fn open_pack(path: &Path) -> Result<Pack, InputError> {
    let bytes = read_file(path, MAX_FILE_BYTES)?;
    Pack::from_bytes(&bytes, file_name(path)).map_err(|error| InputError::format(path, error))
}

/// Reads a wavelet pack.
///
/// # Errors
/// As [`open_pack`]; a pack of another kind, which is named.
pub fn open_wavelet_pack(path: &Path) -> Result<WaveletPack, InputError> {
    wavelet_pack(open_pack(path)?).map_err(|error| InputError::format(path, error))
}

fn wavelet_pack(pack: Pack) -> Result<WaveletPack, FormatError> {
    let kind = match pack {
        Pack::Wavelet(pack) => return Ok(pack),
        other => other.kind(),
    };
    let allowed = match kind {
        PackKind::FlatBtf(_) => "a wavelet pack; of a flat BTF, its folder or the NAME.json beside its parts",
        _ => "a wavelet pack",
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
    level: f32,
}

impl PackSource {
    /// `level` is the level of detail, `0.0..=N`; `None` is the finest.
    pub fn new(pack: &WaveletPack, level: Option<f32>) -> Self {
        Self { decoder: WaveletDecoder::new(pack), level: level.unwrap_or(pack.header.levels as f32) }
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
}
