//! Block compression of a table's slices: 16 texels in 16 bytes, a quarter of a table pack.
//!
//! A GPU samples it with the feature `texture-compression-bc-sliced-3d`, which desktop GPUs have and phones do not.

use super::volume::{Meaning, Volume};
use block_compression::half::f16;
use block_compression::{BC6HSettings, BC7Settings, CompressionVariant, decode, encode};
use brdfc_formats::table::Axes;

/// Texels of a block per side.
const SIDE: u32 = 4;

/// Rounds sizes up to complete blocks.
pub(super) fn whole_blocks(axes: Axes) -> Axes {
    let whole = |count: u32| (count.div_ceil(SIDE) * SIDE).min(256);
    Axes { half: whole(axes.half), difference: whole(axes.difference), ..axes }
}

/// Encoding of numbers in blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Blocks {
    /// BC6H of `f` itself, filtered linearly.
    RawBc6h,
    /// BC6H of logarithms.
    LogBc6h,
    /// BC7 of logarithms, between the lowest and the highest of each channel.
    LogBc7,
}

impl Blocks {
    pub(super) const ALL: [Self; 3] = [Self::RawBc6h, Self::LogBc6h, Self::LogBc7];

    pub(super) fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::RawBc6h => ("bc6h", "f_r"),
            Self::LogBc6h => ("bc6h", "log"),
            Self::LogBc7 => ("bc7", "log"),
        }
    }

    /// Bytes of the blocks of a volume of logarithms, including the repeated slice, and the values that a sampler
    /// returns.
    pub(super) fn coded(self, volume: &Volume) -> (u64, Volume) {
        let header = volume.header;
        let slice = (header.axes.half * header.axes.difference) as usize;
        let ranges: [(f32, f32); 3] = std::array::from_fn(|channel| {
            let of_channel = || volume.nodes.iter().map(|node| node[channel]);
            (of_channel().fold(f32::INFINITY, f32::min), of_channel().fold(f32::NEG_INFINITY, f32::max))
        });
        let mut coded = volume.clone();
        for nodes in coded.nodes.chunks_mut(slice) {
            match self {
                Self::RawBc6h => {
                    let shown = |v: f32| (header.mean * (v.exp() - header.bias)).clamp(0.0, f16::MAX.to_f32());
                    let values: Vec<[f32; 3]> = nodes.iter().map(|node| node.map(shown)).collect();
                    nodes.copy_from_slice(&bc6h(&values, header.axes));
                }
                Self::LogBc6h => {
                    // Unsigned halves near 1, where steps are uniform.
                    let to = |node: &[f32; 3]| std::array::from_fn(|c| 1.0 + share(node[c], ranges[c]));
                    let values: Vec<[f32; 3]> = nodes.iter().map(to).collect();
                    for (node, value) in nodes.iter_mut().zip(bc6h(&values, header.axes)) {
                        *node = std::array::from_fn(|c| from_share(value[c] - 1.0, ranges[c]));
                    }
                }
                Self::LogBc7 => {
                    let values: Vec<[f32; 3]> =
                        nodes.iter().map(|node| std::array::from_fn(|c| share(node[c], ranges[c]))).collect();
                    for (node, value) in nodes.iter_mut().zip(bc7(&values, header.axes)) {
                        *node = std::array::from_fn(|c| from_share(value[c], ranges[c]));
                    }
                }
            }
        }
        if self == Self::RawBc6h {
            coded.meaning = Meaning::Value;
        }
        // A block of 16 texels has 16 bytes.
        (header.texels() as u64, coded)
    }
}

fn share(value: f32, (low, high): (f32, f32)) -> f32 {
    if high > low { (value - low) / (high - low) } else { 0.0 }
}

fn from_share(share: f32, (low, high): (f32, f32)) -> f32 {
    low + share * (high - low)
}

fn bc6h(values: &[[f32; 3]], axes: Axes) -> Vec<[f32; 3]> {
    let (width, height) = (axes.half, axes.difference);
    let texels: Vec<f16> = values.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0].map(f16::from_f32)).collect();
    let variant = CompressionVariant::BC6H(BC6HSettings::very_slow());
    let mut blocks = vec![0; variant.blocks_byte_size(width, height)];
    encode::compress_rgba16(variant, &texels, &mut blocks, width, height, 4 * width);
    // Block by block, since the library returns three components in rows of four for whole images.
    let mut decoded = vec![[0.0; 3]; values.len()];
    let blocks_per_row = (width / SIDE) as usize;
    for (number, block) in blocks.chunks_exact(16).enumerate() {
        let mut texels = [0.0f32; 48];
        decode::decode_block_bc6h_float(block, &mut texels, 12, false);
        let (row, column) = (4 * (number / blocks_per_row), 4 * (number % blocks_per_row));
        for (k, texel) in texels.as_chunks::<3>().0.iter().enumerate() {
            decoded[(row + k / 4) * width as usize + column + k % 4] = *texel;
        }
    }
    decoded
}

fn bc7(values: &[[f32; 3]], axes: Axes) -> Vec<[f32; 3]> {
    let (width, height) = (axes.half, axes.difference);
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    let texels: Vec<u8> = values.iter().flat_map(|[r, g, b]| [byte(*r), byte(*g), byte(*b), 255]).collect();
    let variant = CompressionVariant::BC7(BC7Settings::opaque_slow());
    let mut blocks = vec![0; variant.blocks_byte_size(width, height)];
    encode::compress_rgba8(variant, &texels, &mut blocks, width, height, 4 * width);
    let mut decoded = vec![0; 4 * values.len()];
    decode::decompress_blocks_as_rgba8(variant, width, height, &blocks, &mut decoded);
    decoded.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b].map(|c| f32::from(c) / 255.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth numbers are reproduced within the precision of a block format, each at its own position.
    #[test]
    fn blocks_hold_smooth_numbers() {
        let axes = Axes { half: 12, difference: 8, azimuth: 2, layers: 1 };
        let smooth = |k: usize| {
            // Colours of a block are on a line, which suits block compression.
            let share = 0.05 * (k % 12) as f32 + 0.04 * (k / 12) as f32;
            [0.2 + 0.6 * share, 0.1 + 0.7 * share, 0.3 + 0.4 * share]
        };
        let values: Vec<[f32; 3]> = (0..96).map(smooth).collect();
        for (name, decoded) in [("bc6h", bc6h(&values, axes)), ("bc7", bc7(&values, axes))] {
            for (expected, found) in values.iter().zip(&decoded) {
                assert!((0..3).all(|c| (expected[c] - found[c]).abs() < 0.03), "{name}: {expected:?} {found:?}");
            }
        }
        assert_eq!(whole_blocks(Axes { half: 9, difference: 8, ..axes }), Axes { half: 12, difference: 8, ..axes });
    }
}
