//! Shader side of polynomial wavelet trees: `formats/src/pwt/pwt.wgsl` and its uniform block.

use super::header::{MAX_COMPONENTS, MAX_TEXTURES, TextureHeader};
use super::light_map::LightMap;
use super::pack::{LIGHT_MAP, LIGHT_MAP_FORMAT, PwtPack, TEXTURES, VIEWS, map_extent, mesh_extent, mesh_texels};
use crate::bindings::{Binding, Bindings, Texels};
use crate::container::{Extent, TexelFormat};

/// Name of the decoder and version of its bindings.
pub(super) const DECODER: (&str, u32) = ("pwt", 2);

/// WGSL of the look-up alone, which follows the frame block and the mesh of directions.
pub(crate) const TREE_WGSL: &str = include_str!("pwt.wgsl");

/// WGSL decoder. It declares a uniform block, ten textures and two samplers in bind group 1; see the file.
pub const PWT_WGSL: &str = concat!(
    include_str!("../bindings/frame.wgsl"),
    include_str!("../direction_mesh/direction_mesh.wgsl"),
    include_str!("pwt.wgsl"),
);

/// Maximum error of hardware filtering against exact weights, in units of the largest difference of neighbouring
/// texels. Samplers use weights of 8 bits or fewer.
pub const PWT_FILTER_PRECISION: f32 = 1.0 / 128.0;

/// Slots of the textures.
pub const TEXTURE_SLOTS: [u32; MAX_TEXTURES] = [10, 11, 12, 13, 45, 46, 47, 48];

/// Rows of four numbers of the triangle: 36 terms.
const TRIANGLE_ROWS: usize = 167;

/// Words before the triangle: 16 numbers, three numbers for each texture, and the colours.
const FIRST_TRIANGLE: usize = 16 + 3 * MAX_TEXTURES + 12;

/// The uniform block `PwtParameters`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PwtParameters;

impl PwtParameters {
    /// Size of the block, bytes.
    pub const SIZE: usize = 4 * FIRST_TRIANGLE + 16 * (TRIANGLE_ROWS + MAX_COMPONENTS);

    /// The block of a pack as the shader reads it: little-endian fields in order, padded with zeros.
    pub fn to_bytes(pack: &PwtPack) -> Vec<u8> {
        let header = pack.header();
        let (domain, epsilon) = header.domain.code();
        let [size, extent] = [header.size, header.extent].map(|sides| sides.map(|side| (side as f32).to_bits()));
        let coordinates = header.basis.coordinates as u32;
        let mut words = vec![size[0], size[1], extent[0], extent[1]];
        words.extend([u32::from(header.repeats), coordinates, header.basis.degree, domain]);
        let side = header.light_map.as_ref().map_or(0, LightMap::side);
        words.extend([epsilon.to_bits(), header.textures.len() as u32, header.levels, side]);
        words.extend([header.view_count(), 0, 0, 0]);
        let of_textures: [fn(&TextureHeader) -> u32; 3] = [|t| t.level, TextureHeader::layers, |t| t.channels];
        for number in of_textures {
            words.extend((0..MAX_TEXTURES).map(|k| header.textures.get(k).map_or(0, number)));
        }
        for colour in header.colour {
            words.extend(colour.map(f32::to_bits));
            words.push(0);
        }
        words.extend(header.triangle.iter().map(|c| c.to_bits()));
        words.resize(FIRST_TRIANGLE + 4 * TRIANGLE_ROWS, 0);
        for component in header.components() {
            words.extend([component.channel as f32, component.term as f32].map(f32::to_bits));
            words.extend([component.scale, component.low].map(f32::to_bits));
        }
        words.resize(Self::SIZE / 4, 0);
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}

impl PwtPack {
    /// Bindings of the pack's shader.
    pub fn bindings(&self) -> Bindings<'_> {
        let mut all = self.own_bindings();
        all.push(Binding::frame());
        all.sort_by_key(|binding| binding.slot);
        Bindings::new(DECODER.0, DECODER.1, all)
    }

    /// Bindings without the frame block, in any order.
    pub(crate) fn own_bindings(&self) -> Vec<Binding<'_>> {
        const SAMPLER: &str = "pwt_sampler";
        const MAP_SAMPLER: &str = "pwt_light_map_sampler";
        let texels = |index: usize| {
            let Some(header) = self.header().textures.get(index) else {
                return Texels::empty(TexelFormat::R8Unorm, Extent::D2Array([1; 3]));
            };
            let texels = Texels::new(header.texel_format(), self.texture_shape(index), self.texels(index));
            let texels = texels.with_levels(self.levels_of(index));
            if index == 0 { texels.of_file() } else { texels }
        };
        let textures = TEXTURES
            .iter()
            .zip(TEXTURE_SLOTS)
            .enumerate()
            .map(|(index, (name, slot))| Binding::texture(slot, name, texels(index).sampled(SAMPLER)));
        let first = [Binding::uniform(9, "pwt", PwtParameters::to_bytes(self))];
        let sampler = Binding::sampler(14, SAMPLER, self.header().repeats);
        let views = match &self.header().views {
            Some(mesh) => Texels::new(TexelFormat::R32Uint, mesh_extent(mesh), mesh_texels(mesh)),
            None => Texels::empty(TexelFormat::R32Uint, Extent::D2([1; 2])),
        };
        let map = match &self.header().light_map {
            Some(map) => Texels::new(LIGHT_MAP_FORMAT, map_extent(map.side(), map.terms()), map.to_bytes()),
            None => Texels::empty(LIGHT_MAP_FORMAT, Extent::D2Array([1; 3])),
        };
        let map = [Binding::texture(43, LIGHT_MAP, map.sampled(MAP_SAMPLER)), Binding::sampler(44, MAP_SAMPLER, false)];
        let others = [sampler, Binding::texture(28, VIEWS, views)].into_iter().chain(map);
        first.into_iter().chain(textures).chain(others).collect()
    }
}
