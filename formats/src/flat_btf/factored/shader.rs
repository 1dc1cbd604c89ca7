//! Shader side of factored flat BTFs: `formats/src/flat_btf/factored/factored.wgsl` and its uniform block.

use super::decode::FactoredFlatBtf;
use super::header::{BASE_LAYERS, GROUP, MAX_GROUPS, MAX_MATERIALS};
use super::maps::ResidualMap;

/// WGSL decoder, to be appended to [`crate::flat_btf::shader::FLAT_BTF_WGSL`]. It declares a uniform block, four
/// textures and a sampler in bind group 1; see the file.
pub const FACTORED_WGSL: &str = include_str!("factored.wgsl");

/// Maximum error of hardware filtering against exact weights, in units of the largest difference of neighbouring
/// texels. Samplers use weights of 8 bits or fewer.
pub const FACTORED_FILTER_PRECISION: f32 = 1.0 / 128.0;

/// The uniform block `FactoredParameters`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FactoredParameters;

impl FactoredParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 48 + 16 * (MAX_MATERIALS + 3 * MAX_GROUPS + 2 * (BASE_LAYERS + MAX_GROUPS)) as usize;

    /// The block of an asset as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(asset: &FactoredFlatBtf) -> Vec<u8> {
        let header = asset.header();
        let chroma = header.chroma.word();
        let mut words = vec![header.size, header.levels, header.groups, header.wide_groups, header.residual, chroma];
        words.extend([asset.lowest_light().to_bits(), header.materials, header.axes, header.table_levels]);
        let levels = asset.residual().map_or(0, ResidualMap::levels);
        words.extend([asset.residual_octaves().to_bits(), levels]);
        let mut numbers = |numbers: Vec<f32>, layers: u32| {
            let first = words.len();
            words.extend(numbers.into_iter().map(f32::to_bits));
            words.resize(first + GROUP * layers as usize, 0);
        };
        numbers(header.albedos.iter().flat_map(|[r, g, b]| [*r, *g, *b, 0.0]).collect(), MAX_MATERIALS);
        header.steps.iter().for_each(|steps| numbers(steps.clone(), MAX_GROUPS));
        numbers(asset.weights().ranges().iter().map(|range| range.scale).collect(), BASE_LAYERS + MAX_GROUPS);
        numbers(asset.weights().ranges().iter().map(|range| range.low).collect(), BASE_LAYERS + MAX_GROUPS);
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}
