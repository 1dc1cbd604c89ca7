//! Materials on the device: pack, importance samples, bandwidth maps.

use super::super::bindings;
use super::super::device::{Gpu, GpuError};
use super::super::draw::Decoding;
use super::layouts::Layouts;
use brdfc_formats::BrdfPack;
use brdfc_formats::bandwidth::propagation::DirectedLight;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_render::adaptive::{AdaptiveMaterial, DistantLight, PartTexture};
use wgpu::{BindGroup, BindingResource, TextureView};

/// 32-bit words of the shader's `Material`.
pub(super) const WORDS: usize = 12;

/// Bind groups of a part.
pub(super) struct LoadedMaterial {
    pub(super) packs: BindGroup,
    pub(super) surroundings: BindGroup,
    /// The words of the shader's `Material`.
    pub(super) words: [u32; WORDS],
}

/// Resources that all materials of a scene share.
pub(super) struct Surroundings<'a> {
    pub(super) radiance: &'a TextureView,
    /// Texture made by [`light`].
    pub(super) light: &'a TextureView,
    pub(super) bandwidth: &'a BandwidthMap,
    pub(super) decoding: Decoding,
}

/// Uploads the material of the part with this index.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for textures beyond the adapter's limits; any error that the driver reports.
pub(super) fn upload(
    gpu: &Gpu,
    layouts: &Layouts,
    surroundings: &Surroundings<'_>,
    index: usize,
    material: &AdaptiveMaterial<'_>,
    pack: &BrdfPack,
) -> Result<LoadedMaterial, GpuError> {
    let decoding = surroundings.decoding;
    let maps = [(material.bandwidth, BandwidthKind::Brdf), (surroundings.bandwidth, BandwidthKind::Environment)];
    let maps = maps.into_iter().filter(|(map, kind)| map.header().kind == *kind).map(|(map, _)| map);
    let of_texture = material.texture.map(|texture| texture.bandwidth).filter(|map| map.metres().is_some());
    let maps = maps.chain(of_texture).flat_map(|map| map.bindings().all);
    let all: Vec<_> = pack.bindings().all.into_iter().chain(maps).chain(material.samples.bindings().all).collect();
    let packs = layouts.packs.bind(gpu, &all, decoding.frame_block())?;
    let colours = &texture(gpu, material.texture.as_ref())?;
    let all = [surroundings.radiance, surroundings.light, colours].map(BindingResource::TextureView);
    let surroundings = bindings::group(gpu, &layouts.surroundings, (0..).zip(all));
    let [level, hardware] = decoding.words();
    let mut words = [0; WORDS];
    words[..4].copy_from_slice(&[index as u32, material.albedo.to_bits(), level, hardware]);
    if let Some(texture) = &material.texture {
        let [width, height] = texture.colours.size().map(|side| side as u32);
        let [[across, down], [metres_across, metres_down]] = [texture.repeats, texture.metres()];
        words[4..7].copy_from_slice(&[width, height, texture.colours.levels().len() as u32]);
        words[8..].copy_from_slice(&[across, down, metres_across, metres_down].map(f32::to_bits));
    }
    Ok(LoadedMaterial { packs, surroundings, words })
}

/// Uploads the levels of a texture as one texture, one below the other; a white texel without a texture.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more texels per side than the adapter takes.
fn texture(gpu: &Gpu, texture: Option<&PartTexture<'_>>) -> Result<TextureView, GpuError> {
    let Some(texture) = texture else {
        return bindings::texture(
            gpu,
            TexelFormat::Rgba32Float,
            Extent::D2([1; 2]),
            1,
            bytemuck::bytes_of(&[1.0f32; 4]),
        );
    };
    let [width, _] = texture.colours.size();
    let row = |texels: &[[f32; 3]]| -> Vec<[f32; 4]> {
        let mut row: Vec<_> = texels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
        row.resize(width, [0.0; 4]);
        row
    };
    let levels = texture.colours.levels().iter();
    let texels: Vec<[f32; 4]> = levels.flat_map(|level| level.texels.chunks(level.width)).flat_map(row).collect();
    let extent = Extent::D2([width as u32, (texels.len() / width) as u32]);
    bindings::texture(gpu, TexelFormat::Rgba32Float, extent, 1, bytemuck::cast_slice(&texels))
}

/// Uploads the levels of the light as one texture, one below the other.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more texels per side than the adapter takes.
pub(super) fn light(gpu: &Gpu, light: &DistantLight) -> Result<TextureView, GpuError> {
    let width = light.levels()[0].width;
    let row = |texels: &[DirectedLight]| -> Vec<[f32; 4]> {
        let mut row: Vec<_> = texels.iter().map(|t| [t.radiance, t.bandwidth, t.squares, t.varying]).collect();
        row.resize(width, [0.0; 4]);
        row
    };
    let texels: Vec<[f32; 4]> =
        light.levels().iter().flat_map(|level| level.texels.chunks(level.width)).flat_map(row).collect();
    let extent = Extent::D2([width as u32, (texels.len() / width) as u32]);
    bindings::texture(gpu, TexelFormat::Rgba32Float, extent, 1, bytemuck::cast_slice(&texels))
}
