//! Wavelet BRDF pack (Claustres et al. 2007, section 5): stored coefficient slices as a 3D texture, and an index map
//! from coefficients to slices. Byte layout: `spec.md` and `layout.rs`.

use crate::container::TexelFormat;
use crate::crop::{Crop, DirectionRange, Window};
use crate::direction::Parameterisation;
use crate::{ErrorSummary, FormatError};

/// Maximum number of levels: 6 is a 64 x 64 grid per hemisphere.
pub const MAX_LEVELS: u32 = 6;
/// Maximum number of slices of a pack, including the zero slice: the depth limit of a 3D texture.
pub const MAX_SLICES: usize = crate::container::MAX_EXTENT as usize;

/// GPU memory of the index map per coefficient, bytes.
const INDEX_BYTES: usize = 16;

/// Header of a wavelet pack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Header {
    /// Meaning of the two hemispheres of the table.
    pub parameterisation: Parameterisation,
    /// `N`: the grid of each hemisphere is `2^N x 2^N`, 1 to [`MAX_LEVELS`].
    pub levels: u32,
    /// Levels of detail that may have slices, 0 to `levels`; all coefficients of finer levels are zero.
    pub stored_levels: u32,
    /// Colour channels: 1 (grey) or 3 (linear RGB).
    pub channels: u32,
    /// Significant bits per component: 8, or 10 to 16 in a 16-bit texture.
    pub bits: u32,
    /// `μ`, mean of all samples of the table, 1/sr, positive.
    pub mean: f32,
    /// `ε` of the log encoding `ln(f / μ + ε)`, positive.
    pub bias: f32,
    /// True for energy-preserving packs, in which each level of detail has a tree of its own, of logarithms of means; false
    /// for one tree, as in the paper, whose coarser levels are means of logarithms and darker.
    pub energy_preserving: bool,
}

impl Header {
    /// Cells per axis, `2^N`.
    pub fn grid(&self) -> usize {
        1 << self.levels
    }

    /// Cells of one hemisphere, which is also the number of wavelet coefficients.
    pub fn cells(&self) -> usize {
        self.grid() * self.grid()
    }

    /// Number of levels of detail below the finest that have a tree of their own: the stored ones of energy-preserving
    /// packs, and none of others.
    pub fn trees(&self) -> u32 {
        if self.energy_preserving { self.stored_levels } else { 0 }
    }

    /// Number of the first coefficient of the tree of a level of detail below [`Self::trees`].
    pub fn first_of_tree(&self, level: u32) -> usize {
        self.cells() + coefficients_below(level)
    }

    /// Coefficient of the finest tree in the place of a coefficient of any tree.
    pub fn in_finest_tree(&self, coefficient: usize) -> usize {
        let first = (0..self.trees()).rev().map(|level| self.first_of_tree(level)).find(|first| coefficient >= *first);
        coefficient - first.unwrap_or(0)
    }

    /// Number of coefficients: those of the finest level, and those of the other trees.
    pub fn coefficients(&self) -> usize {
        self.first_of_tree(self.trees())
    }

    /// Columns and rows of the index map: a row of `2^N` texels for `2^N` coefficients.
    pub fn index_extent(&self) -> [u32; 2] {
        [self.grid() as u32, self.coefficients().div_ceil(self.grid()) as u32]
    }

    /// Texel format: 1 or 4 components of 8 or 16 bits.
    pub fn texel_format(&self) -> TexelFormat {
        match (self.channels, self.bits) {
            (1, 8) => TexelFormat::R8Unorm,
            (1, _) => TexelFormat::R16Unorm,
            (_, 8) => TexelFormat::Rgba8Unorm,
            _ => TexelFormat::Rgba16Unorm,
        }
    }
}

/// Dequantisation: `coefficient = offset + scale * texel`, texel in `[0, 1]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SliceScale {
    /// Range of the slice, not negative.
    pub scale: f32,
    /// Value of texel 0.
    pub offset: f32,
}

/// A wavelet pack in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveletPack {
    /// Sizes, parameterisation and constants of the pack.
    pub header: Header,
    /// Compression map of the paper: slice of each coefficient, 0 if it was dropped. Has
    /// [`Header::coefficients`] elements. Element 0, the scaling coefficient, has slice 1.
    pub index: Vec<u16>,
    /// One per slice; slice 0, the zero slice, has scale and offset 0.
    pub scales: Vec<SliceScale>,
    /// Codec error: decoded samples against the encoded table.
    pub on_grid: ErrorSummary,
    /// Error of the filtered pack against the source at independent test directions.
    pub off_grid: ErrorSummary,
    /// Covered directions and stored window; `None` for uncropped packs.
    pub crop: Option<Crop>,
    /// Texels `[slice][row][column][component]`, little-endian; column = longitude, row = colatitude of the outer
    /// direction. With 3 channels the fourth component has its largest value.
    pub texels: Vec<u8>,
}

impl WaveletPack {
    /// Removes the outer cells outside a window.
    ///
    /// # Errors
    /// Returns an error if the window is empty or not within the grid, or if the pack is already cropped.
    pub fn cropped(&self, crop: Crop) -> Result<Self, FormatError> {
        if self.crop.is_some() {
            return Err(FormatError::whole("wavelet pack", "a cropped pack", "an uncropped pack"));
        }
        let (grid, texel_bytes) = (self.header.grid() as u32, self.header.texel_format().texel_bytes());
        crop.check([grid, grid], 1)?;
        let slices = self.texels.chunks(self.header.cells() * texel_bytes);
        let texels = slices.flat_map(|slice| crop.window.cut(slice, grid, texel_bytes)).flatten().copied();
        Ok(Self { texels: texels.collect(), crop: Some(crop), ..self.clone() })
    }

    /// Stored outer cells, in terms of the grid.
    pub fn window(&self) -> Window {
        let grid = self.header.grid() as u32;
        self.crop.map_or(Window::whole([grid, grid]), |crop| crop.window)
    }

    /// Directions that the pack covers.
    pub fn directions(&self) -> DirectionRange {
        self.crop.map_or(DirectionRange::ALL, |crop| crop.directions)
    }

    /// Size of the texture.
    pub fn extent(&self) -> [u32; 3] {
        let [columns, rows] = self.window().size;
        [columns, rows, self.slices() as u32]
    }

    /// Slices of the texture, including the zero slice.
    pub fn slices(&self) -> usize {
        self.scales.len()
    }

    /// Coefficients of the finest level that have a slice.
    pub fn retained(&self) -> usize {
        self.index[..self.header.cells()].iter().filter(|slice| **slice != 0).count()
    }

    /// GPU memory of the texture and the index map, bytes. The index map has a slice number, scale and offset per
    /// coefficient (16 bytes, see [`crate::wavelet::shader`]).
    pub fn gpu_bytes(&self) -> u64 {
        gpu_bytes(&self.header, self.window(), self.slices())
    }
}

/// GPU memory of a pack with this many slices of such a window, including the zero slice, bytes.
pub fn gpu_bytes(header: &Header, window: Window, slices: usize) -> u64 {
    let texture = (window.size[0] * window.size[1]) as usize * slices * header.texel_format().texel_bytes();
    let [columns, rows] = header.index_extent();
    (texture + INDEX_BYTES * (columns * rows) as usize) as u64
}

/// Number of coefficients of the trees of all levels below one: `Σ 4^l`.
fn coefficients_below(level: u32) -> usize {
    ((1 << (2 * level)) - 1) / 3
}
