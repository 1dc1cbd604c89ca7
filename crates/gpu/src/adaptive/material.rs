//! Materials on the device: pack, importance samples, bandwidth maps.

use super::super::bindings;
use super::super::device::{Gpu, GpuError};
use super::super::draw::Decoding;
use super::layouts::Layouts;
use brdfc_formats::BrdfPack;
use brdfc_formats::bandwidth::propagation::DirectedLight;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_render::adaptive::{AdaptiveMaterial, DistantLight};
use wgpu::{BindGroup, BindingResource, TextureView};

/// Bind groups of a part.
pub(super) struct LoadedMaterial {
    pub(super) packs: BindGroup,
    pub(super) surroundings: BindGroup,
    /// The words of the shader's `Material`.
    pub(super) words: [u32; 4],
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
    let maps = maps.into_iter().filter(|(map, kind)| map.header().kind == *kind);
    let maps = maps.flat_map(|(map, _)| map.bindings().all);
    let all: Vec<_> = pack.bindings().all.into_iter().chain(maps).chain(material.samples.bindings().all).collect();
    let packs = layouts.packs.bind(gpu, &all, decoding.frame_block())?;
    let shared = [surroundings.radiance, surroundings.light].map(BindingResource::TextureView);
    let surroundings = bindings::group(gpu, &layouts.surroundings, (0..).zip(shared));
    let [level, hardware] = decoding.words();
    let words = [index as u32, material.albedo.to_bits(), level, hardware];
    Ok(LoadedMaterial { packs, surroundings, words })
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
