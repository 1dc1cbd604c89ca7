//! The layers of a relief: the heights at which a vertical line enters and leaves the surface, and the parameters of
//! the surface there.

use super::layout::{check_image, half_pair_bytes, half_pairs, rounded_pairs, word};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::Cursor;
use crate::tap::{footprint, periodic_tap, wrap};

/// Key that identifies the layers of a flat BTF.
pub(crate) const LAYERS: &str = "brdfc.flat-btf.layers";
const VERSION: u32 = 2;
const BYTES: usize = 24;
/// Maximum absolute height, in tiles.
pub const MAX_HEIGHT: f32 = 64.0;
/// Step of a byte.
const UNIT: f32 = 1.0 / 255.0;

/// Sheets of the surface in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Sheet {
    /// The lowest sheet, with solid below it everywhere.
    Base = 0,
    /// Upper side of a part that hangs over the base.
    Top = 1,
    /// Lower side of a part that hangs over the base.
    Underside = 2,
}

/// Header of the layers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerHeader {
    /// `M`, texels of the reference plane per side, 1 to 8192.
    pub size: u32,
    /// Number of sheets: 1, the base, or 3.
    pub sheets: u32,
    /// Number of mipmap levels.
    pub levels: u32,
    /// Heights of bytes 0 and 255, in tiles.
    pub heights: [f32; 2],
}

/// Heights of a column in units of the header's range, 0 to 1: base, top, underside. The last two are 0 with one sheet.
pub type Column = [f32; 3];

/// The layers of a relief.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerMap {
    header: LayerHeader,
    /// All levels, with the channels of [`LayerHeader::height_format`].
    heights: Vec<u8>,
    /// All levels, in each sheet by sheet: parameters less the position of the texel, in tiles. Exactly halves.
    displacements: Vec<[f32; 2]>,
}

impl LayerHeader {
    /// Format of the heights: one channel with one sheet, otherwise four, the last of them 0.
    pub fn height_format(&self) -> TexelFormat {
        if self.sheets == 1 { TexelFormat::R8Unorm } else { TexelFormat::Rgba8Unorm }
    }

    /// Range of heights, in tiles.
    pub fn range(&self) -> f32 {
        self.heights[1] - self.heights[0]
    }

    /// Texels per side of a level.
    pub(super) fn side(&self, level: u32) -> u32 {
        (self.size >> level).max(1)
    }

    /// Extent of the heights.
    pub fn height_extent(&self) -> Extent {
        Extent::D2([self.size; 2])
    }

    /// Extent of the displacements, a layer for each sheet. They have half as many texels per side, like level 1 of the
    /// heights: parameters are smoother than outlines.
    pub fn displacement_extent(&self) -> Extent {
        Extent::D2Array([self.side(1), self.side(1), self.sheets])
    }

    /// Number of mipmap levels of the displacements. Level k has as many texels as level k + 1 of the heights.
    pub fn displacement_levels(&self) -> u32 {
        (self.levels - 1).max(1)
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let checked = |field, found, range| FormatError::check_range(format!("{LAYERS} {field}"), found, range);
        checked("size", self.size, 1..=MAX_EXTENT_2D)?;
        if ![1, 3].contains(&self.sheets) {
            return Err(FormatError::whole(format!("{LAYERS} sheets"), self.sheets.to_string(), "1 or 3"));
        }
        checked("levels", self.levels, 1..=self.height_extent().most_levels())?;
        let [low, high] = self.heights;
        if !(low < high && low >= -MAX_HEIGHT && high <= MAX_HEIGHT) {
            let allowed = format!("two ascending heights of -{MAX_HEIGHT} to {MAX_HEIGHT} tiles");
            return Err(FormatError::whole(format!("{LAYERS} heights"), format!("{low} and {high}"), allowed));
        }
        Ok(())
    }
}

impl LayerMap {
    /// Creates a map from all levels of heights, with the channels of [`LayerHeader::height_format`], and all levels of
    /// displacements, in each level sheet by sheet, row by row. Displacements are rounded to halves.
    ///
    /// # Errors
    /// Returns an error if the header is out of range, lengths do not match it, or a displacement is out of range or
    /// NaN.
    pub fn new(header: LayerHeader, heights: Vec<u8>, displacements: Vec<[f32; 2]>) -> Result<Self, FormatError> {
        header.check()?;
        let of_heights =
            header.height_extent().texels_of_levels(header.levels) * header.height_format().texel_bytes() as u64;
        let of_displacements = header.displacement_extent().texels_of_levels(header.displacement_levels());
        for (what, found, expected) in [
            ("bytes of heights", heights.len(), of_heights),
            ("displacements of layers", displacements.len(), of_displacements),
        ] {
            if found as u64 != expected {
                return Err(FormatError::whole(what, found.to_string(), format!("{expected}, as the header says")));
            }
        }
        let displacements = rounded_pairs(displacements, |at| format!("displacement {at} of layers"))?;
        Ok(Self { header, heights, displacements })
    }

    /// Sizes and range of heights.
    pub fn header(&self) -> &LayerHeader {
        &self.header
    }

    /// Texels of the heights in GPU layout.
    pub fn height_bytes(&self) -> &[u8] {
        &self.heights
    }

    /// Texels of the displacements in GPU layout.
    pub fn displacement_bytes(&self) -> Vec<u8> {
        half_pair_bytes(&self.displacements)
    }

    /// Filtered heights of the column at a point of the reference plane, in tiles. `detail` is the mipmap level, 0 the
    /// finest.
    pub fn column(&self, at: [f32; 2], detail: f32) -> Column {
        let (level, blend) = self.levels_of(detail);
        let fine = self.column_of_level(at, level);
        if blend > 0.0 {
            let coarse = self.column_of_level(at, level + 1);
            return [0, 1, 2].map(|k| fine[k] + blend * (coarse[k] - fine[k]));
        }
        fine
    }

    /// Parameters of the surface at a point of a sheet, not wrapped.
    pub fn parameters(&self, at: [f32; 2], sheet: Sheet, detail: f32) -> [f32; 2] {
        let (level, blend) = levels_around(detail - 1.0, self.header.displacement_levels());
        let mut moved = self.displacement_of_level(at, sheet, level);
        if blend > 0.0 {
            let coarse = self.displacement_of_level(at, sheet, level + 1);
            moved = [0, 1].map(|k| moved[k] + blend * (coarse[k] - moved[k]));
        }
        [at[0] + moved[0], at[1] + moved[1]]
    }

    /// The finer of two levels around a level of detail, and the weight of the coarser one.
    pub(super) fn levels_of(&self, detail: f32) -> (u32, f32) {
        levels_around(detail, self.header.levels)
    }

    fn column_of_level(&self, at: [f32; 2], level: u32) -> Column {
        let (side, channels) = (self.header.side(level), self.header.height_format().texel_bytes());
        let first = self.header.height_extent().texels_of_levels(level) as usize;
        let mut column = [0.0f32; 3];
        for ([i, j], weight) in footprint(periodic_tap(wrap(at[0]), side), periodic_tap(wrap(at[1]), side)) {
            let texel = &self.heights[(first + (j * side + i) as usize) * channels..][..channels];
            for (height, byte) in column.iter_mut().zip(texel) {
                *height += weight * (f32::from(*byte) * UNIT);
            }
        }
        column
    }

    fn displacement_of_level(&self, at: [f32; 2], sheet: Sheet, level: u32) -> [f32; 2] {
        let side = self.header.side(level + 1);
        let first = self.header.displacement_extent().texels_of_levels(level) as usize;
        let first = first + sheet as usize * (side * side) as usize;
        let mut sum = [0.0f32; 2];
        for ([i, j], weight) in footprint(periodic_tap(wrap(at[0]), side), periodic_tap(wrap(at[1]), side)) {
            let texel = self.displacements[first + (j * side + i) as usize];
            sum = [sum[0] + weight * texel[0], sum[1] + weight * texel[1]];
        }
        sum
    }

    /// Key and value of the header.
    pub(super) fn entry(&self) -> (String, Vec<u8>) {
        let LayerHeader { size, sheets, levels, heights } = self.header;
        let [low, high] = heights.map(f32::to_bits);
        let words = [VERSION, size, sheets, levels, low, high];
        (LAYERS.to_owned(), words.into_iter().flat_map(u32::to_le_bytes).collect())
    }

    /// Reads and validates the images of a file. The heights have the header.
    pub(super) fn from_textures(heights: Texture, displacements: &Texture) -> Result<Self, FormatError> {
        let bytes = sized(entry(&heights, LAYERS, "the layers of a flat BTF")?, LAYERS, BYTES)?;
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, LAYERS, "version", VERSION..=VERSION)?;
        let header = LayerHeader {
            size: cursor.u32("size")?,
            sheets: cursor.u32("sheets")?,
            levels: cursor.u32("levels")?,
            heights: [cursor.f32("low")?, cursor.f32("high")?],
        };
        header.check()?;
        check_image(&heights, "heights", (header.height_format(), header.height_extent(), header.levels), LAYERS)?;
        let of_displacements = (TexelFormat::Rg16Float, header.displacement_extent(), header.displacement_levels());
        check_image(displacements, "displacements", of_displacements, LAYERS)?;
        Self::new(header, heights.texels, half_pairs(&displacements.texels))
    }
}

/// The finer of two of `levels` levels around a level of detail, and the weight of the coarser one.
fn levels_around(detail: f32, levels: u32) -> (u32, f32) {
    let detail = detail.max(0.0).min((levels - 1) as f32);
    let finer = detail.floor();
    (finer as u32, detail - finer)
}
