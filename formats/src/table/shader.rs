//! Shader side of table packs: `formats/src/table/decode.wgsl` and its uniform block.

use super::curve::{CURVE, Curve};
use super::header::{KNOTS, TableHeader, UNIFORM_BYTES};
use super::pack::TablePack;
use crate::arc_tangent::arc_tangent_wgsl;
use crate::bindings::{Binding, Bindings, Texels};
use crate::container::{Extent, TexelFormat};
use crate::crop::Window;
use crate::cursor::block_bytes;

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("table", 1);

/// WGSL decoder. It declares a uniform block, two textures and a sampler in bind group 1; see the file.
pub const TABLE_BRDF_WGSL: &str = concat!(
    include_str!("../bindings/frame.wgsl"),
    include_str!("decode.wgsl"),
    arc_tangent_wgsl!("table_brdf", "TABLE_BRDF")
);

/// Flag next to the symmetry bits.
const GREY: u32 = 16;

/// Values of the uniform block `TableBrdfParameters`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableBrdfParameters {
    header: TableHeader,
    window: Window,
    curve_nodes: u32,
    curve_levels: u32,
}

impl TableBrdfParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = UNIFORM_BYTES;

    /// Parameters of a pack.
    pub fn new(pack: &TablePack) -> Self {
        let curve = pack.curve();
        Self {
            header: *pack.header(),
            window: pack.window(),
            curve_nodes: curve.map_or(0, |curve| curve.nodes() as u32),
            curve_levels: curve.map_or(0, Curve::levels),
        }
    }

    /// The block as the shader reads it: little-endian fields in order, padded with zeros after the last knot.
    pub fn to_bytes(&self) -> [u8; Self::SIZE] {
        let TableHeader { channels, symmetry, axes, mean, bias, low, span, slope, knots } = self.header;
        let axis = |nodes: u32, k: usize| nodes | self.window.first[k] << 10 | self.window.size[k] << 20;
        let [red, green, blue] = low.map(f32::to_bits);
        let [red_span, green_span, blue_span] = span.map(f32::to_bits);
        let mut words = [0; Self::SIZE / 4];
        words[..16].copy_from_slice(&[
            axis(axes.half, 0),
            axis(axes.difference, 1),
            axes.azimuth,
            axes.layers,
            symmetry.bits() | if channels == 1 { GREY } else { 0 },
            self.curve_nodes | self.curve_levels << 16,
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
        block_bytes(words)
    }
}

impl TablePack {
    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        const SAMPLER: &str = "table_brdf_sampler";
        let curve = match self.curve() {
            Some(curve) => Texels::new(curve.texel_format(), curve.extent(), curve.texels()).sampled(SAMPLER),
            None => Texels::empty(TexelFormat::R16Float, Extent::D2([1; 2])).sampled(SAMPLER),
        };
        let texels = Texels::new(self.header().texel_format(), Extent::D3(self.extent()), self.texels());
        let parameters = TableBrdfParameters::new(self).to_bytes().to_vec();
        Bindings::new(
            DECODER.0,
            DECODER.1,
            [
                Binding::frame(),
                Binding::uniform(1, "table_brdf_parameters", parameters),
                Binding::texture(2, "table_brdf_texels", texels.of_file().sampled(SAMPLER)),
                Binding::sampler(3, SAMPLER, false),
                Binding::texture(4, CURVE, curve),
            ],
        )
    }
}
