//! Compact samples of indirection maps: two bytes for each view of a block of texels, in the frame of the view and between
//! bounds of the block.

use super::MAX_HEIGHT;
use super::factored::Place;
use super::layout::{check_image, half_pair_bytes, half_pairs, rounded_pairs, word};
use super::vdim_header::{COMPACT, VDIM_PART, VdimHeader};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{TexelFormat, Texture};
use crate::cursor::Cursor;

const VERSION: u32 = 1;
const BYTES: usize = 16;
/// Names of the parts in errors.
const RANGES_PART: &str = "ranges";
const HEIGHTS_PART: &str = "heights";
/// Step of a byte.
const UNIT: f32 = 1.0 / 255.0;

/// Compact samples of a map of blocks, on all its levels.
#[derive(Debug, Clone, PartialEq)]
pub struct CompactSamples {
    /// Heights of byte 0 and of byte 255, in tiles.
    pub range: [f32; 2],
    /// For each level the minima of all blocks, row by row, then their extents: displacements divided by
    /// [`VdimHeader::growth`], along the azimuth of the view and across it, to its left. Rounded to halves by [`Vdim::new`].
    ///
    /// [`Vdim::new`]: super::Vdim::new
    pub ranges: Vec<[f32; 2]>,
    /// Places between these bounds, row by row of the packed map.
    pub packed: Vec<[u8; 2]>,
    /// Heights of the surface over its parameters, row by row, with as many texels as the reference.
    pub heights: Vec<u8>,
}

impl CompactSamples {
    /// Checks lengths, ranges and seams, and rounds the bounds to halves.
    pub(super) fn check(self, header: &VdimHeader) -> Result<Self, FormatError> {
        let [low, high] = self.range;
        if !(low.abs() <= MAX_HEIGHT && high.abs() <= MAX_HEIGHT && low < high) {
            let allowed = format!("-{MAX_HEIGHT} to {MAX_HEIGHT}, the lower one first");
            return Err(FormatError::whole(format!("{COMPACT} heights"), format!("{:?}", self.range), allowed));
        }
        for (part, found, extent) in [
            (RANGES_PART, self.ranges.len(), header.ranges_extent()),
            (VDIM_PART, self.packed.len(), header.packed_extent()),
            (HEIGHTS_PART, self.heights.len(), header.reference_extent()),
        ] {
            header.check_length(part, found, extent)?;
        }
        let ranges = rounded_pairs(self.ranges, |at| format!("texel {at} of the part {RANGES_PART}"))?;
        let width = |level| (header.side(level) / header.block * header.polar_angles) as usize;
        let rows = header.azimuth_rows as usize;
        let mut left = &self.packed[..];
        for level in 0..header.levels {
            let blocks = (header.side(level) / header.block) as usize;
            let (texels, rest) = left.split_at(width(level) * blocks * rows);
            left = rest;
            for (j, lines) in texels.chunks_exact(width(level) * rows).enumerate() {
                if lines[..width(level)] != lines[width(level) * (rows - 1)..] {
                    let field = format!("vdim row {} of level {level}", (j + 1) * rows - 1);
                    let allowed = "in the last row of a block, the values of its first row";
                    return Err(FormatError::whole(field, "other values", allowed));
                }
            }
        }
        Ok(Self { ranges, ..self })
    }

    /// Displacement that a view sees in a block: `blended` are its samples, 0 to 1.
    pub(super) fn displacement(
        &self,
        header: &VdimHeader,
        [i, j]: [u32; 2],
        level: u32,
        blended: [f32; 2],
        view: [f32; 3],
    ) -> [f32; 2] {
        let blocks = header.side(level) / header.block;
        let first = header.ranges_extent().texels_of_levels(level) as usize + (j * blocks + i) as usize;
        let (low, extent) = (self.ranges[first], self.ranges[first + (blocks * blocks) as usize]);
        let [along, across] = [0, 1].map(|c| low[c] + extent[c] * blended[c]);
        let [x, y, _] = view;
        let length = (x * x + y * y).sqrt();
        let [cosine, sine] = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        let growth = header.growth_towards(view);
        [growth * (along * cosine - across * sine), growth * (along * sine + across * cosine)]
    }

    /// Sample at an index of the packed map: shares of the range of its block.
    pub(super) fn sample(&self, at: usize) -> [f32; 2] {
        self.packed[at].map(|byte| f32::from(byte) * UNIT)
    }

    /// Filtered height of the surface at its parameters, in tiles.
    pub(super) fn height(&self, header: &VdimHeader, parameters: [f32; 2], detail: f32) -> f32 {
        let [low, high] = self.range;
        let first = |level| header.reference_extent().texels_of_levels(level) as usize;
        let place = Place::new(parameters, detail, header.size, header.levels);
        low + (high - low) * place.sample(|level, at| self.heights[first(level) + at])
    }

    /// Bounds in GPU layout.
    pub fn range_bytes(&self) -> Vec<u8> {
        half_pair_bytes(&self.ranges)
    }

    /// Key and value of the header.
    pub(super) fn entry(&self, header: &VdimHeader) -> (String, Vec<u8>) {
        let [low, high] = self.range.map(f32::to_bits);
        (COMPACT.to_owned(), [VERSION, header.block, low, high].into_iter().flat_map(u32::to_le_bytes).collect())
    }

    /// Block, in texels per side, and range of the heights in a file's header.
    pub(super) fn read_header(packed: &Texture) -> Result<(u32, [f32; 2]), FormatError> {
        let bytes = sized(entry(packed, COMPACT, "compact samples of an indirection map")?, COMPACT, BYTES)?;
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, COMPACT, "version", VERSION..=VERSION)?;
        Ok((cursor.u32("block")?, [cursor.f32("low")?, cursor.f32("high")?]))
    }

    /// Reads the images of a file: packed samples, ranges and heights.
    pub(super) fn from_textures(
        header: &VdimHeader,
        range: [f32; 2],
        packed: &Texture,
        [heights, ranges]: [Texture; 2],
    ) -> Result<Self, FormatError> {
        let of_heights = (TexelFormat::R8Unorm, header.reference_extent(), header.levels);
        check_image(&heights, HEIGHTS_PART, of_heights, COMPACT)?;
        check_image(&ranges, RANGES_PART, (TexelFormat::Rg16Float, header.ranges_extent(), header.levels), COMPACT)?;
        let packed = packed.texels.as_chunks::<2>().0.to_vec();
        Ok(Self { range, ranges: half_pairs(&ranges.texels), packed, heights: heights.texels })
    }
}
