//! The part `displacement`: an indirection map in a sixteenth of its size. Displacements are in the view's own frame
//! and divided by their growth towards the horizon, so that a byte between two bounds per block is precise enough.

use super::indirection::{FIELDS, IndirectionHeader};
use super::layout::{VERSION, check_format, half_bytes, halves, word, wrong_extent};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, TexelFormat, Texture, half};
use crate::cursor::Cursor;

const PART: &str = "displacement";
/// Key of the header.
pub(crate) const HEADER: &str = "brdfc.displacement";
/// Maximum tangent of a polar angle in the divisor.
pub const MAX_TANGENT: f32 = 8.0;
/// Offset added to the tangent.
pub const TANGENT_BIAS: f32 = 0.25;
/// Maximum difference of neighbours along each axis on the same side of a silhouette, in units of their distance on the
/// reference plane. Such neighbours are interpolated.
pub const SAME_SIDE: f32 = 4.0;
/// Step of a byte.
const UNIT: f32 = 1.0 / 255.0;

/// Header of a displacement map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacementHeader {
    /// Blocks and view samples; `size` is N, blocks per side, each covering `(M / N)²` texels of the reference.
    pub blocks: IndirectionHeader,
    /// Tangent of the largest polar angle, at most [`MAX_TANGENT`].
    pub largest_tangent: f32,
}

impl DisplacementHeader {
    /// Header for these blocks.
    pub fn new(blocks: IndirectionHeader) -> Self {
        let tangent = f64::from(blocks.largest_angle).tan() as f32;
        let tangent = if tangent > 0.0 { tangent.min(MAX_TANGENT) } else { MAX_TANGENT };
        Self { blocks, largest_tangent: tangent }
    }

    /// Divisor of displacements for views in column `k` of a block.
    pub fn divisor(&self, k: u32) -> f64 {
        let [polar, _] = self.blocks.view_angles(k, 0);
        let (tangent, most) = (polar.tan(), f64::from(self.largest_tangent));
        f64::from(TANGENT_BIAS) + if (0.0..most).contains(&tangent) { tangent } else { most }
    }

    fn to_bytes(self) -> Vec<u8> {
        let IndirectionHeader { size, zenith_samples, azimuth_samples, largest_angle } = self.blocks;
        let angles = [largest_angle, self.largest_tangent].map(f32::to_bits);
        [VERSION, size, zenith_samples, azimuth_samples, angles[0], angles[1]]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect()
    }

    fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(sized(bytes, HEADER, 24)?);
        word(&mut cursor, HEADER, "version", VERSION..=VERSION)?;
        let mut field = |k: usize| word(&mut cursor, HEADER, FIELDS[k].0, FIELDS[k].1.clone());
        let [size, zenith_samples, azimuth_samples] = [field(0)?, field(1)?, field(2)?];
        let largest_angle = cursor.f32("largest angle")?;
        let header = Self {
            blocks: IndirectionHeader { size, zenith_samples, azimuth_samples, largest_angle },
            largest_tangent: cursor.f32("largest tangent")?,
        };
        header.check()?;
        Ok(header)
    }

    /// Checks all ranges, and that the texture is not too large.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        self.blocks.check_as(HEADER, PART)?;
        if !(self.largest_tangent > 0.0 && self.largest_tangent <= MAX_TANGENT) {
            let field = format!("{HEADER} largest tangent");
            let allowed = format!("above 0, up to {MAX_TANGENT}");
            return Err(FormatError::whole(field, self.largest_tangent.to_string(), allowed));
        }
        Ok(())
    }
}

/// Displacements of the parameters for all sampled views, as two bytes: along and across the view's azimuth.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementMap {
    header: DisplacementHeader,
    /// Ranges of each block, as halves: minimum and extent along the azimuth, minimum and extent across it.
    ranges: Vec<[u16; 4]>,
    /// Texels of the texture, row by row.
    texels: Vec<[u8; 2]>,
}

impl DisplacementMap {
    /// Creates a map from `N²` ranges, block by block in rows, and the texels of the texture.
    ///
    /// # Errors
    /// Returns an error if the header, the number of ranges or the number of texels is out of range, ranges exceed
    /// -1024 to 1024, or the last row of a block differs from its first.
    pub fn new(header: DisplacementHeader, ranges: Vec<[u16; 4]>, texels: Vec<[u8; 2]>) -> Result<Self, FormatError> {
        header.check()?;
        let blocks = u64::from(header.blocks.size).pow(2);
        for (what, found, expected) in
            [("ranges", ranges.len(), blocks), ("texels", texels.len(), Extent::D2(header.blocks.extent()).texels())]
        {
            if found as u64 != expected {
                let allowed = format!("{expected}, as the header says");
                return Err(FormatError::whole(format!("{what} of the part {PART}"), found.to_string(), allowed));
            }
        }
        let good = |bits: &u16| half::decode(*bits).abs() <= super::MAX_COORDINATE;
        if let Some(k) = ranges.iter().position(|range| !range.iter().all(good)) {
            let found = format!("{:?}", ranges[k].map(half::decode));
            return Err(FormatError::whole(format!("range {k} of the part {PART}"), found, "numbers of -1024 to 1024"));
        }
        let width = header.blocks.extent()[0] as usize;
        let rows = header.blocks.azimuth_samples as usize + 1;
        for (block, lines) in texels.chunks_exact(width * rows).enumerate() {
            if lines[..width] != lines[width * (rows - 1)..] {
                let field = format!("{PART} row {}", (block + 1) * rows - 1);
                let found = "differs from the first row of the blocks";
                return Err(FormatError::whole(field, found, "equal rows").problem());
            }
        }
        Ok(Self { header, ranges, texels })
    }

    /// Sizes of the blocks, and angles of their view samples.
    pub fn header(&self) -> &DisplacementHeader {
        &self.header
    }

    /// Ranges in GPU layout: a texture of four halves per block.
    pub fn range_bytes(&self) -> Vec<u8> {
        half_bytes(&self.ranges)
    }

    /// Texels in GPU layout.
    pub fn texel_bytes(&self) -> &[u8] {
        self.texels.as_flattened()
    }

    /// GPU memory of texels and ranges, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        (self.texel_bytes().len() + size_of_val(&self.ranges[..])) as u64
    }

    /// Sample `(k, a)` of block `(i, j)`, `a` up to `A`: fractions of the block's ranges.
    pub(super) fn sample(&self, block: [u32; 2], k: u32, a: u32) -> [f32; 2] {
        let [column, row] = self.header.blocks.texel(block, k, a);
        self.texels[row as usize * self.header.blocks.extent()[0] as usize + column as usize]
            .map(|byte| f32::from(byte) * UNIT)
    }

    /// Displacement of blended samples of block `(i, j)`, along and across the view's azimuth, before multiplication by
    /// [`Self::scale`].
    pub(super) fn in_view(&self, [i, j]: [u32; 2], [along, across]: [f32; 2]) -> [f32; 2] {
        let range = self.ranges[(j * self.header.blocks.size + i) as usize].map(half::decode);
        [range[0] + range[1] * along, range[2] + range[3] * across]
    }

    /// Divisor of displacements for a view.
    pub(super) fn scale(&self, [x, y, z]: [f32; 3]) -> f32 {
        let most = self.header.largest_tangent;
        let tangent = if z > 0.0 { ((x * x + y * y).sqrt() / z).min(most) } else { most };
        tangent + TANGENT_BIAS
    }

    /// Returns true if two blocks whose displacements differ by `difference` are on the same side of a silhouette.
    pub(super) fn on_one_side(&self, difference: [f32; 2], scale: f32) -> bool {
        let most = difference[0].abs().max(difference[1].abs());
        most * scale <= SAME_SIDE / self.header.blocks.size as f32
    }

    /// Key and value of the header.
    pub(super) fn entry(&self) -> (String, Vec<u8>) {
        (HEADER.to_owned(), self.header.to_bytes())
    }

    /// Reads and validates the image of a file with its header, and the image of the ranges.
    pub(super) fn from_textures(texture: &Texture, ranges: &Texture) -> Result<Self, FormatError> {
        let header = DisplacementHeader::from_bytes(entry(texture, HEADER, "a map of displacements")?)?;
        check_format(texture, PART, TexelFormat::Rg8Unorm)?;
        check_format(ranges, "ranges", TexelFormat::Rgba16Float)?;
        let extent = Extent::D2(header.blocks.extent());
        if texture.extent != extent {
            return Err(wrong_extent(PART, texture.extent, format!("a 2D texture of {extent}, as {HEADER} says")));
        }
        Self::new(header, halves(&ranges.texels), texture.texels.as_chunks::<2>().0.to_vec())
    }
}
