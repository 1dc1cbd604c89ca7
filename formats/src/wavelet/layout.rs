//! Bytes of the `brdfc.*` entries of a wavelet pack, and the rules a pack must keep. Normative text: `formats/src/wavelet/spec.md`.

use crate::container::entries::{self, sized};
use crate::container::{Extent, Texture};
use crate::crop::Crop;
use crate::cursor::Cursor;
use crate::direction::Parameterisation;
use crate::wavelet::{Header, MAX_LEVELS, MAX_SLICES, SliceScale, WaveletPack};
use crate::{ErrorSummary, FormatError};
use std::collections::BTreeMap;

const VERSION: u32 = 1;
/// The entry that tells a wavelet pack.
pub(crate) const HEADER: &str = "brdfc.wavelet";
const INDEX: &str = "brdfc.wavelet.index";
const SCALES: &str = "brdfc.wavelet.scales";
const ERRORS: &str = "brdfc.wavelet.errors";

impl WaveletPack {
    /// The bytes of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        Texture {
            format: self.header.texel_format(),
            extent: Extent::D3(self.extent()),
            entries: entries_of(self),
            levels: 1,
            texels: self.texels.clone(),
        }
        .to_bytes(supercompress)
    }

    /// Reads and checks a KTX2 file.
    ///
    /// # Errors
    /// Whatever is not a pack that [`Self::to_bytes`] could have written: see `formats/src/wavelet/spec.md` for the rules.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_texture(Texture::from_bytes_within(bytes, Self::MAX_TEXEL_BYTES)?)
    }

    /// [`Self::from_bytes`] of a file whose container has been read.
    ///
    /// # Errors
    /// As [`Self::from_bytes`].
    pub fn from_texture(texture: Texture) -> Result<Self, FormatError> {
        from_texture(texture)
    }

    /// Texels of the largest pack: 64 x 64 x 2048 of 8 bytes.
    pub const MAX_TEXEL_BYTES: u64 = (8 << (2 * MAX_LEVELS)) * MAX_SLICES as u64;
}

fn entries_of(pack: &WaveletPack) -> BTreeMap<String, Vec<u8>> {
    let h = &pack.header;
    let mut header = Vec::with_capacity(40);
    for word in [
        VERSION,
        h.parameterisation.code(),
        h.levels,
        h.stored_levels,
        h.channels,
        h.bits,
        pack.slices() as u32,
        h.mean.to_bits(),
        h.bias.to_bits(),
        u32::from(h.lifted),
    ] {
        header.extend_from_slice(&word.to_le_bytes());
    }
    let index = pack.index.iter().flat_map(|i| i.to_le_bytes()).collect();
    let scales = pack.scales.iter().flat_map(|s| [s.scale.to_le_bytes(), s.offset.to_le_bytes()]).flatten().collect();
    let errors = [pack.on_grid, pack.off_grid].into_iter().flat_map(ErrorSummary::to_bytes).collect();
    let own = [(HEADER, header), (INDEX, index), (SCALES, scales), (ERRORS, errors)];
    let own = own.map(|(key, value)| (key.to_owned(), value));
    own.into_iter().chain(pack.crop.as_ref().map(Crop::entry)).collect()
}

fn from_texture(texture: Texture) -> Result<WaveletPack, FormatError> {
    texture.check_one_level()?;
    let (header, slices) = read_header(entry(&texture, HEADER)?)?;
    let grid = header.grid() as u32;
    let crop = Crop::of(&texture, [grid, grid], 1)?;
    let [columns, rows] = crop.map_or([grid, grid], |crop| crop.window.size);
    let extent = Extent::D3([columns, rows, slices as u32]);
    if texture.extent != extent || texture.format != header.texel_format() {
        return Err(FormatError::whole(
            "texture",
            format!("{} texels of {:?}", texture.extent, texture.format),
            format!("{extent} texels of {:?}, as {HEADER} says", header.texel_format()),
        ));
    }
    let index = read_index(entry(&texture, INDEX)?, &header, slices)?;
    let scales = read_scales(entry(&texture, SCALES)?, slices)?;
    let errors = sized(entry(&texture, ERRORS)?, ERRORS, 2 * ErrorSummary::BYTES)?;
    let (on_grid, off_grid) = errors.split_at(ErrorSummary::BYTES);
    let (on_grid, off_grid) = (ErrorSummary::from_bytes(on_grid, ERRORS)?, ErrorSummary::from_bytes(off_grid, ERRORS)?);
    let slice_bytes = (columns * rows) as usize * header.texel_format().texel_bytes();
    if texture.texels[..slice_bytes].iter().any(|byte| *byte != 0) {
        return Err(FormatError::whole("slice 0", "a texel that is not zero", "the zero slice"));
    }
    Ok(WaveletPack { header, index, scales, on_grid, off_grid, crop, texels: texture.texels })
}

fn entry<'a>(texture: &'a Texture, key: &'static str) -> Result<&'a [u8], FormatError> {
    entries::entry(texture, key, "a wavelet pack")
}

fn read_header(bytes: &[u8]) -> Result<(Header, usize), FormatError> {
    let mut cursor = Cursor::new(sized(bytes, HEADER, 40)?);
    let mut word = |field: &'static str, allowed: &str, check: &dyn Fn(u32) -> bool| {
        let value = cursor.u32(field)?;
        if check(value) {
            return Ok(value);
        }
        Err(FormatError::whole(format!("{HEADER} {field}"), value.to_string(), allowed))
    };
    word("version", "1", &|v| v == VERSION)?;
    let code = word("parameterisation", "0 (tangent-pole) or 1 (half-difference)", &|v| {
        Parameterisation::from_code(v).is_some()
    })?;
    let levels = word("levels", "1 to 6", &|v| (1..=MAX_LEVELS).contains(&v))?;
    let stored_levels = word("stored levels", "0 to the number of levels", &|v| v <= levels)?;
    let channels = word("channels", "1 or 3", &|v| v == 1 || v == 3)?;
    let bits = word("bits", "8, or 10 to 16", &|v| v == 8 || (10..=16).contains(&v))?;
    let slices = word("slices", "2 to 2048", &|v| (2..=MAX_SLICES as u32).contains(&v))? as usize;
    let mean = cursor.f32("mean")?;
    let bias = cursor.f32("bias")?;
    for (value, field) in [(mean, "mean"), (bias, "bias")] {
        if !value.is_normal() || value < 0.0 {
            return Err(FormatError::whole(format!("{HEADER} {field}"), value.to_string(), "a positive number"));
        }
    }
    let parameterisation = Parameterisation::from_code(code).expect("checked above");
    let lifted = cursor.u32("lifted")?;
    if lifted > u32::from(parameterisation == Parameterisation::TangentPole) {
        let allowed = "0, or 1 where the parameterisation is tangent-pole";
        return Err(FormatError::whole(format!("{HEADER} lifted"), lifted.to_string(), allowed));
    }
    let lifted = lifted == 1;
    Ok((Header { parameterisation, levels, stored_levels, channels, bits, mean, bias, lifted }, slices))
}

fn read_index(bytes: &[u8], header: &Header, slices: usize) -> Result<Vec<u16>, FormatError> {
    let bytes = sized(bytes, INDEX, 2 * header.cells())?;
    let index: Vec<u16> = bytes.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect();
    // Kept coefficients take slices 1, 2, ... in order; finer levels than the stored ones are all dropped.
    let finest = 1usize << (2 * header.stored_levels);
    let mut next = 1;
    for (coefficient, slice) in index.iter().enumerate() {
        let slice = usize::from(*slice);
        let kept = slice != 0;
        if kept && (slice != next || coefficient >= finest) || coefficient == 0 && !kept {
            return Err(FormatError::whole(
                format!("{INDEX} entry {coefficient}"),
                slice.to_string(),
                if coefficient == 0 {
                    "1, the scaling slice".to_owned()
                } else if coefficient >= finest {
                    "0, as this level is not stored".to_owned()
                } else {
                    format!("0 or {next}, the next slice")
                },
            ));
        }
        next += usize::from(kept);
    }
    if next != slices {
        return Err(FormatError::whole(INDEX, format!("{} slices in use", next - 1), format!("{}", slices - 1)));
    }
    Ok(index)
}

fn read_scales(bytes: &[u8], slices: usize) -> Result<Vec<SliceScale>, FormatError> {
    let mut cursor = Cursor::new(sized(bytes, SCALES, 8 * slices)?);
    let mut scales = Vec::with_capacity(slices);
    for slice in 0..slices {
        let (scale, offset) = (cursor.f32("scale")?, cursor.f32("offset")?);
        let fine = scale >= 0.0 && offset.is_finite() && (scale + offset).is_finite();
        if !fine || slice == 0 && (scale != 0.0 || offset != 0.0) {
            return Err(FormatError::whole(
                format!("{SCALES} slice {slice}"),
                format!("scale {scale}, offset {offset}"),
                if slice == 0 { "0 and 0, the zero slice" } else { "numbers with a finite sum, scale not negative" },
            ));
        }
        scales.push(SliceScale { scale, offset });
    }
    Ok(scales)
}
