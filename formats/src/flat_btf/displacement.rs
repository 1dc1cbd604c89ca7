//! The part `displacement`: an indirection map in a sixteenth of its bytes. Displacements stand for the view's own frame,
//! divided by what they grow with towards the horizon, so that bytes between two bounds for each block are enough.

use super::indirection::{FIELDS, IndirectionHeader};
use super::layout::{VERSION, check_format, half_bytes, halves, word, wrong_extent};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{Extent, TexelFormat, Texture, half};
use crate::cursor::Cursor;

const PART: &str = "displacement";
/// The entry that tells a map of displacements.
pub(crate) const HEADER: &str = "brdfc.displacement";
/// Largest tangent of a polar angle that displacements are divided by.
pub const MAX_TANGENT: f32 = 8.0;
/// What is added to the tangent.
pub const TANGENT_BIAS: f32 = 0.25;
/// How far neighbours may be apart along each axis, in units of their distance on the reference plane, to be on one side of a
/// silhouette: what lies between them is then interpolated.
pub const SAME_SIDE: f32 = 4.0;
/// What a byte of a texel counts.
const UNIT: f32 = 1.0 / 255.0;

/// What is special to displacements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacementHeader {
    /// Blocks, and which views their samples are; `size` is N, blocks per side, each for `(M / N)²` texels of the reference.
    pub blocks: IndirectionHeader,
    /// Tangent of the largest polar angle, [`MAX_TANGENT`] at most.
    pub largest_tangent: f32,
}

impl DisplacementHeader {
    /// A header of these blocks.
    pub fn new(blocks: IndirectionHeader) -> Self {
        let tangent = f64::from(blocks.largest_angle).tan() as f32;
        let tangent = if tangent > 0.0 { tangent.min(MAX_TANGENT) } else { MAX_TANGENT };
        Self { blocks, largest_tangent: tangent }
    }

    /// What displacements of the views in column `k` of a block are divided by.
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

    /// Checks ranges and that the texture is not too large.
    ///
    /// # Errors
    /// Names the field that is out of range.
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

/// Displacements of the parameters for all sampled views, as two bytes: along the view's azimuth, and across.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacementMap {
    header: DisplacementHeader,
    /// Of each block, as halves: lowest and extent of what is along, lowest and extent of what is across.
    ranges: Vec<[u16; 4]>,
    /// Row by row of the texture.
    texels: Vec<[u8; 2]>,
}

impl DisplacementMap {
    /// A map of `N²` ranges, row by row of the blocks, and the texels of the texture.
    ///
    /// # Errors
    /// A header or numbers of ranges or texels out of range; ranges beyond -1024 to 1024; a last row of a block that is not
    /// its first.
    pub fn new(header: DisplacementHeader, ranges: Vec<[u16; 4]>, texels: Vec<[u8; 2]>) -> Result<Self, FormatError> {
        header.check()?;
        let blocks = u64::from(header.blocks.size).pow(2);
        for (what, found, wanted) in
            [("ranges", ranges.len(), blocks), ("texels", texels.len(), Extent::D2(header.blocks.extent()).texels())]
        {
            if found as u64 != wanted {
                let allowed = format!("{wanted}, as the header says");
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
                return Err(FormatError::whole(field, "other texels", "those of the first row of the blocks"));
            }
        }
        Ok(Self { header, ranges, texels })
    }

    /// Sizes and angles.
    pub fn header(&self) -> &DisplacementHeader {
        &self.header
    }

    /// The ranges as a GPU takes them: a texture of four halves per block.
    pub fn range_bytes(&self) -> Vec<u8> {
        half_bytes(&self.ranges)
    }

    /// The texels as a GPU takes them.
    pub fn texel_bytes(&self) -> &[u8] {
        self.texels.as_flattened()
    }

    /// Bytes of texels and ranges in graphics memory.
    pub fn gpu_bytes(&self) -> u64 {
        (self.texel_bytes().len() + size_of_val(&self.ranges[..])) as u64
    }

    /// Sample `(k, a)` of block `(i, j)`, `a` up to `A`: shares of the block's ranges.
    pub(super) fn sample(&self, block: [u32; 2], k: u32, a: u32) -> [f32; 2] {
        let [column, row] = self.header.blocks.texel(block, k, a);
        self.texels[row as usize * self.header.blocks.extent()[0] as usize + column as usize]
            .map(|byte| f32::from(byte) * UNIT)
    }

    /// What a blend of samples of block `(i, j)` stands for: along the view's azimuth, and across, divided by [`Self::scale`].
    pub(super) fn in_view(&self, [i, j]: [u32; 2], [along, across]: [f32; 2]) -> [f32; 2] {
        let range = self.ranges[(j * self.header.blocks.size + i) as usize].map(half::decode);
        [range[0] + range[1] * along, range[2] + range[3] * across]
    }

    /// What displacements in a view were divided by.
    pub(super) fn scale(&self, [x, y, z]: [f32; 3]) -> f32 {
        let most = self.header.largest_tangent;
        let tangent = if z > 0.0 { ((x * x + y * y).sqrt() / z).min(most) } else { most };
        tangent + TANGENT_BIAS
    }

    /// Whether displacements of two blocks that are so far apart are on one side of a silhouette.
    pub(super) fn on_one_side(&self, difference: [f32; 2], scale: f32) -> bool {
        let most = difference[0].abs().max(difference[1].abs());
        most * scale <= SAME_SIDE / self.header.blocks.size as f32
    }

    /// The entry of the header.
    pub(super) fn entry(&self) -> (String, Vec<u8>) {
        (HEADER.to_owned(), self.header.to_bytes())
    }

    /// Reads and checks the image of a file with its entry, and that of the ranges.
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
