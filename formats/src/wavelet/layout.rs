//! Key/value data of a wavelet pack and its validation. Normative text: `formats/src/wavelet/spec.md`.

use super::shader::{WaveletBrdfParameters, index_texels};
use crate::bindings::{Binding, Bindings, PackFile, Texels};
use crate::container::entries::{self, check_texels, sized};
use crate::container::{Extent, TexelFormat, Texture};
use crate::crop::Crop;
use crate::cursor::Cursor;
use crate::direction::Parameterisation;
use crate::wavelet::{Header, MAX_LEVELS, MAX_SLICES, SliceScale, WaveletPack};
use crate::{ErrorSummary, FormatError};
use std::collections::BTreeMap;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("wavelet", 2);

const VERSION: u32 = 2;
/// Key that identifies a wavelet pack.
const HEADER: &str = "brdfc.wavelet";
const INDEX: &str = "wavelet_brdf_index";
const ERRORS: &str = "brdfc.wavelet.errors";

impl WaveletPack {
    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        self.bindings().to_file(entries_of(self), supercompress)
    }

    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        const SAMPLER: &str = "wavelet_brdf_sampler";
        let index: Vec<u8> = index_texels(self).into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        let slices = Texels::new(self.header.texel_format(), Extent::D3(self.extent()), &self.texels[..]);
        let parameters = WaveletBrdfParameters::new(self).to_bytes().to_vec();
        Bindings::new(
            DECODER.0,
            DECODER.1,
            [
                Binding::frame(),
                Binding::uniform(5, "wavelet_brdf_parameters", parameters),
                Binding::texture(6, "wavelet_brdf_slices", slices.of_file().sampled(SAMPLER)),
                Binding::texture(
                    7,
                    INDEX,
                    Texels::new(TexelFormat::Rgba32Float, Extent::D2(self.header.index_extent()), index),
                ),
                Binding::sampler(8, SAMPLER, false),
            ],
        )
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/wavelet/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/wavelet/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        let (texture, index) = (file.take_own(), file.take_texture(INDEX));
        let pack = from_texture(texture, index)?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }
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
        u32::from(h.energy_preserving),
    ] {
        header.extend_from_slice(&word.to_le_bytes());
    }
    let errors = [pack.on_grid, pack.off_grid].into_iter().flat_map(ErrorSummary::to_bytes).collect();
    let own = [(HEADER, header), (ERRORS, errors)];
    let own = own.map(|(key, value)| (key.to_owned(), value));
    own.into_iter().chain(pack.crop.as_ref().map(Crop::entry)).collect()
}

fn from_texture(texture: Texture, index: Option<Texture>) -> Result<WaveletPack, FormatError> {
    texture.check_one_level()?;
    let (header, slices) = read_header(entry(&texture, HEADER)?)?;
    let grid = header.grid() as u32;
    let crop = Crop::of(&texture, [grid, grid], 1)?;
    let [columns, rows] = crop.map_or([grid, grid], |crop| crop.window.size);
    let extent = Extent::D3([columns, rows, slices as u32]);
    check_texels(&texture, "texture", extent, header.texel_format(), HEADER)?;
    let index = index.ok_or_else(|| FormatError::whole(INDEX, "no texels", "texels of an index map").problem())?;
    let (index, scales) = read_index(&index, &header, slices)?;
    let errors = sized(entry(&texture, ERRORS)?, ERRORS, 2 * ErrorSummary::BYTES)?;
    let (on_grid, off_grid) = errors.split_at(ErrorSummary::BYTES);
    let (on_grid, off_grid) = (ErrorSummary::from_bytes(on_grid, ERRORS)?, ErrorSummary::from_bytes(off_grid, ERRORS)?);
    let slice_bytes = (columns * rows) as usize * header.texel_format().texel_bytes();
    if texture.texels[..slice_bytes].iter().any(|byte| *byte != 0) {
        return Err(FormatError::whole("slice 0", "a non-zero texel", "zeros in all texels"));
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
    word("version", "2", &|v| v == VERSION)?;
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
    let energy_preserving = cursor.u32("energy-preserving")?;
    if energy_preserving > u32::from(parameterisation == Parameterisation::TangentPole) {
        let allowed = "0, or 1 with the tangent-pole parameterisation";
        return Err(FormatError::whole(format!("{HEADER} energy-preserving"), energy_preserving.to_string(), allowed));
    }
    let energy_preserving = energy_preserving == 1;
    Ok((Header { parameterisation, levels, stored_levels, channels, bits, mean, bias, energy_preserving }, slices))
}

/// Slices of all coefficients, and scales of all slices.
fn read_index(texture: &Texture, header: &Header, slices: usize) -> Result<(Vec<u16>, Vec<SliceScale>), FormatError> {
    check_texels(texture, INDEX, Extent::D2(header.index_extent()), TexelFormat::Rgba32Float, HEADER)?;
    // Stored coefficients use slices 1, 2, ... in order. Levels finer than the stored ones have no slices; the scaling
    // coefficient of each tree has one.
    let finest = 1usize << (2 * header.stored_levels);
    let (cells, coefficients) = (header.cells(), header.coefficients());
    let scalings: Vec<usize> = (0..header.trees()).map(|level| header.first_of_tree(level)).collect();
    let (mut index, mut scales) = (Vec::with_capacity(coefficients), vec![SliceScale::default()]);
    for (coefficient, texel) in texture.texels.as_chunks::<4>().0.as_chunks::<4>().0.iter().enumerate() {
        let [slice, scale, offset, zero] = texel.map(f32::from_le_bytes);
        let wrong = |field: &str, found: String, allowed: String| {
            Err(FormatError::whole(format!("{INDEX} coefficient {coefficient}, {field}"), found, allowed))
        };
        let (next, stored) = (scales.len(), slice.to_bits() != 0);
        let is_scaling = coefficient == 0 || scalings.contains(&coefficient);
        let may_be_stored = coefficient < finest || (cells..coefficients).contains(&coefficient);
        if stored && (slice != next as f32 || !may_be_stored) || is_scaling && !stored {
            let allowed = match coefficient {
                0 => "1, the scaling slice".to_owned(),
                _ if is_scaling => format!("{next}, the scaling slice of a tree"),
                _ if coefficient >= coefficients => "0, because there is no such coefficient".to_owned(),
                _ if !may_be_stored => "0, because this level is not stored".to_owned(),
                _ => format!("0 or {next}, the next slice"),
            };
            return wrong("slice", slice.to_string(), allowed);
        }
        if zero.to_bits() != 0 {
            return wrong("fourth component", zero.to_string(), "0".to_owned());
        }
        let fine = scale >= 0.0 && offset.is_finite() && (scale + offset).is_finite();
        if !fine || !stored && [scale, offset].map(f32::to_bits) != [0; 2] {
            let allowed =
                if stored { "numbers with a finite sum, non-negative scale" } else { "0 and 0 for the zero slice" };
            return wrong("scale and offset", format!("{scale} and {offset}"), allowed.to_owned());
        }
        if coefficient < coefficients {
            index.push(if stored { next as u16 } else { 0 });
        }
        if stored {
            scales.push(SliceScale { scale, offset });
        }
    }
    if scales.len() != slices {
        let allowed = format!("{}, as {HEADER} says", slices - 1);
        return Err(FormatError::whole(INDEX, format!("{} slices in use", scales.len() - 1), allowed));
    }
    Ok((index, scales))
}
