//! Table pack: its texture and metadata. Byte layout: `spec.md`.

use super::curve::{CURVE, Curve};
use super::header::{TABLE_ENTRY, TableHeader, UNIFORM_BYTES};
use crate::bindings::PackFile;
use crate::container::entries::{check_texels, entry, sized};
use crate::container::{Extent, TexelFormat, half, rgb10a2};
use crate::crop::{Crop, DirectionRange, Window};
use crate::{ErrorSummary, FormatError, RenderingSummary};
use std::collections::BTreeMap;

const ERRORS: &str = "brdfc.table.errors";
/// Minimum columns and rows, needed for filtering.
const MIN_SIZE: u32 = 2;

/// A table pack in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct TablePack {
    header: TableHeader,
    texels: Vec<u8>,
    curve: Option<Curve>,
    crop: Option<Crop>,
    /// Error of the filtered pack against the source at independent test directions.
    pub off_grid: ErrorSummary,
    /// Colour differences between renderings of the pack and of the source.
    pub rendering: RenderingSummary,
}

impl TablePack {
    /// Creates a pack from values in `[0, 1]`, `[layer][slice][row][column]`, without the copied slice. Values are
    /// rounded to the texel format. Errors are 0 until they are measured.
    ///
    /// # Errors
    /// Returns an error if the header is out of range or the number of values is wrong.
    pub fn new(header: TableHeader, values: &[[f32; 3]]) -> Result<Self, FormatError> {
        header.check()?;
        let slice = (header.axes.half * header.axes.difference) as usize;
        let layer = slice * header.axes.azimuth as usize;
        if values.len() != layer * header.axes.layers as usize {
            let allowed = format!("{}, as the header says", layer * header.axes.layers as usize);
            return Err(FormatError::whole("table values", values.len().to_string(), allowed));
        }
        let repeated = if header.symmetry.mirror { 0 } else { slice };
        let all = values.chunks(layer).flat_map(|layer| layer.iter().chain(&layer[..repeated]));
        let texels = match header.texel_format() {
            TexelFormat::R16Float => {
                all.flat_map(|value| half::encode(value[0].clamp(0.0, 1.0)).to_le_bytes()).collect()
            }
            _ => all.flat_map(|value| rgb10a2::encode(*value).to_le_bytes()).collect(),
        };
        let (off_grid, rendering) = (ErrorSummary::default(), RenderingSummary::default());
        Ok(Self { header, texels, curve: None, crop: None, off_grid, rendering })
    }

    /// Adds a curve with the same number of channels, which makes a factored pack.
    ///
    /// # Errors
    /// Returns an error if the number of channels differs.
    pub fn with_curve(self, curve: Curve) -> Result<Self, FormatError> {
        curve.check_channels(self.header.channels)?;
        Ok(Self { curve: Some(curve), ..self })
    }

    /// Removes the texels outside a window.
    ///
    /// # Errors
    /// Returns an error if the window is not within the texture or has less than two columns or rows, or if the pack is
    /// already cropped.
    pub fn cropped(&self, crop: Crop) -> Result<Self, FormatError> {
        if self.crop.is_some() {
            return Err(FormatError::whole("table pack", "a cropped pack", "an uncropped pack"));
        }
        let [columns, rows, _] = self.header.extent();
        crop.check([columns, rows], MIN_SIZE)?;
        let texel_bytes = self.header.texel_format().texel_bytes();
        let slices = self.texels.chunks((columns * rows) as usize * texel_bytes);
        let texels = slices.flat_map(|slice| crop.window.cut(slice, columns, texel_bytes)).flatten().copied();
        Ok(Self { texels: texels.collect(), crop: Some(crop), ..self.clone() })
    }

    /// Covered directions and stored window; `None` for uncropped packs.
    pub fn crop(&self) -> Option<&Crop> {
        self.crop.as_ref()
    }

    /// Stored columns and rows, in terms of the header's node counts.
    pub fn window(&self) -> Window {
        let [columns, rows, _] = self.header.extent();
        self.crop.map_or(Window::whole([columns, rows]), |crop| crop.window)
    }

    /// Directions that the pack covers.
    pub fn directions(&self) -> DirectionRange {
        self.crop.map_or(DirectionRange::ALL, |crop| crop.directions)
    }

    /// Size of the texture.
    pub fn extent(&self) -> [u32; 3] {
        let [columns, rows] = self.window().size;
        [columns, rows, self.header.extent()[2]]
    }

    /// Sizes, symmetry and constants of the pack.
    pub fn header(&self) -> &TableHeader {
        &self.header
    }

    /// Bytes of the texture, as in the file.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }

    /// Values in `[0, 1]` of all texels, `[layer][slice][row][column]`; grey values are repeated three times.
    pub fn values(&self) -> Vec<[f32; 3]> {
        match self.header.texel_format() {
            TexelFormat::R16Float => {
                let value = |bytes: &[u8; 2]| [half::decode(u16::from_le_bytes(*bytes)); 3];
                self.texels.as_chunks::<2>().0.iter().map(value).collect()
            }
            _ => {
                self.texels.as_chunks::<4>().0.iter().map(|bytes| rgb10a2::decode(u32::from_le_bytes(*bytes))).collect()
            }
        }
    }

    /// Curve of a factored pack.
    pub fn curve(&self) -> Option<&Curve> {
        self.curve.as_ref()
    }

    /// Number of coarser levels of detail.
    pub fn levels(&self) -> u32 {
        self.curve.as_ref().map_or(0, Curve::levels)
    }

    /// Filtered fetches of one look-up.
    pub fn fetches(&self) -> u32 {
        self.header.fetches() + u32::from(self.curve.is_some())
    }

    /// GPU memory saved by cropping, bytes.
    pub fn cropped_bytes(&self) -> u64 {
        (self.header.texels() * self.header.texel_format().texel_bytes() - self.texels.len()) as u64
    }

    /// GPU memory of textures and uniform block, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        (self.texels.len() + self.curve.as_ref().map_or(0, |curve| curve.texels().len()) + UNIFORM_BYTES) as u64
    }

    /// Contents of the KTX2 file.
    pub fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        let errors = [&self.off_grid.to_bytes()[..], &self.rendering.to_bytes()[..]].concat();
        let mut entries =
            BTreeMap::from([(TABLE_ENTRY.to_owned(), self.header.to_bytes()), (ERRORS.to_owned(), errors)]);
        entries.extend(self.crop.as_ref().map(Crop::entry));
        self.bindings().to_file(entries, supercompress)
    }

    /// Reads and validates a KTX2 file.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/table/spec.md`.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_file(PackFile::from_bytes(bytes)?)
    }

    /// Same as [`Self::from_bytes`] for a file whose bindings have been read.
    ///
    /// # Errors
    /// Returns an error if the file violates `formats/src/table/spec.md`.
    pub fn from_file(mut file: PackFile) -> Result<Self, FormatError> {
        const WHAT: &str = "a table pack";
        let (texture, curve) = (file.take_own(), file.take_texture(CURVE));
        texture.check_one_level()?;
        let header = TableHeader::from_bytes(entry(&texture, TABLE_ENTRY, WHAT)?)?;
        let [columns, rows, slices] = header.extent();
        let crop = Crop::of(&texture, [columns, rows], MIN_SIZE)?;
        let [width, height] = crop.map_or([columns, rows], |crop| crop.window.size);
        let extent = Extent::D3([width, height, slices]);
        check_texels(&texture, "texture", extent, header.texel_format(), TABLE_ENTRY)?;
        let errors = sized(entry(&texture, ERRORS, WHAT)?, ERRORS, ErrorSummary::BYTES + RenderingSummary::BYTES)?;
        let (off_grid, rendering) = errors.split_at(ErrorSummary::BYTES);
        let off_grid = ErrorSummary::from_bytes(off_grid, ERRORS)?;
        let rendering = RenderingSummary::from_bytes(rendering, ERRORS)?;
        let curve = curve.map(|texture| Curve::from_texture(texture, header.channels)).transpose()?;
        let pack = Self { header, texels: texture.texels, curve, crop, off_grid, rendering };
        pack.check_texels()?;
        file.check_same(&pack.bindings())?;
        Ok(pack)
    }

    fn check_texels(&self) -> Result<(), FormatError> {
        if self.header.channels == 1
            && let Some([value, ..]) = self.values().iter().find(|value| !(0.0..=1.0).contains(&value[0]))
        {
            return Err(FormatError::whole("table texel", value.to_string(), "0 to 1"));
        }
        if self.header.symmetry.mirror {
            return Ok(());
        }
        let [columns, rows, _] = self.extent();
        let slice = (columns * rows) as usize * self.header.texel_format().texel_bytes();
        for layer in self.texels.chunks(slice * self.header.slices() as usize) {
            if layer[..slice] != layer[layer.len() - slice..] {
                let found = "the last slice differs from the first";
                let allowed = "a copy of the first slice, because φ_d is periodic";
                return Err(FormatError::whole("table layer", found, allowed).problem());
            }
        }
        Ok(())
    }
}
