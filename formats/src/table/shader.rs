//! What a shader needs besides a pack's texture: `formats/src/table/decode.wgsl` and its uniform block.

use super::header::{KNOTS, TableHeader};

/// The WGSL decoder. It declares a uniform block, a texture and a sampler in bind group 1; see the file.
pub const TABLE_BRDF_WGSL: &str = include_str!("decode.wgsl");

/// The uniform block `TableBrdfParameters` of the shader.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableBrdfParameters {
    header: TableHeader,
}

impl TableBrdfParameters {
    /// Bytes of the block.
    pub const SIZE: usize = 144;

    /// The parameters of a pack.
    pub fn new(header: &TableHeader) -> Self {
        Self { header: *header }
    }

    /// The block as the shader reads it: little-endian, fields in order, zeros behind the last knot.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let TableHeader { channels, symmetry, axes, mean, bias, low, span, slope, knots } = self.header;
        let [red, green, blue] = low.map(f32::to_bits);
        let [red_span, green_span, blue_span] = span.map(f32::to_bits);
        let mut words = [0; Self::SIZE / 4];
        words[..16].copy_from_slice(&[
            axes.half,
            axes.difference,
            axes.azimuth,
            axes.layers,
            symmetry.bits(),
            channels,
            mean.to_bits(),
            bias.to_bits(),
            red,
            green,
            blue,
            slope.to_bits(),
            red_span,
            green_span,
            blue_span,
            0,
        ]);
        words[16..16 + KNOTS].copy_from_slice(&knots.map(f32::to_bits));
        let mut bytes = [0; Self::SIZE];
        for (target, word) in bytes.chunks_exact_mut(4).zip(words) {
            target.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}
