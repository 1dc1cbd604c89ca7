//! Materials on the device: pack, importance samples, bandwidth maps.

use super::super::compute::texture;
use super::super::device::{Gpu, GpuError};
use super::super::draw::Decoding;
use super::super::pack;
use super::layouts::Layouts;
use brdfc_formats::BrdfPack;
use brdfc_formats::bandwidth::propagation::DirectedLight;
use brdfc_formats::bandwidth::shader::BandwidthParameters;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::container::TexelFormat;
use brdfc_render::adaptive::{AdaptiveMaterial, DistantLight};
use wgpu::{BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, BufferUsages, TextureView};

/// The bind groups of a part.
pub(super) struct LoadedMaterial {
    pub(super) pack: BindGroup,
    pub(super) maps: BindGroup,
    /// The words of the shader's `Material`.
    pub(super) words: [u32; 4],
}

/// What all materials of a scene share.
pub(super) struct Surroundings<'a> {
    pub(super) radiance: &'a TextureView,
    /// [`light`].
    pub(super) light: &'a TextureView,
    pub(super) bandwidth: &'a BandwidthMap,
    pub(super) decoding: Decoding,
}

/// Uploads the material of the part of this index.
///
/// # Errors
/// [`GpuError::TooLarge`] for textures beyond the adapter's limits; what the driver reports.
pub(super) fn upload(
    gpu: &Gpu,
    layouts: &Layouts,
    surroundings: &Surroundings<'_>,
    index: usize,
    material: &AdaptiveMaterial<'_>,
    pack: &BrdfPack,
) -> Result<LoadedMaterial, GpuError> {
    let decoding = surroundings.decoding;
    let pack = pack::upload(gpu, &layouts.pack, pack, decoding.filter, decoding.distance_scale)?;
    let header = material.samples.header();
    let importance = gpu.buffer(&header.uniform(), BufferUsages::UNIFORM);
    let texels = bytemuck::cast_slice(material.samples.texels());
    let samples = texture(gpu, TexelFormat::Rgba32Float, [header.samples, header.rows()], texels)?;
    let (lobes, brdf_scale) = map(gpu, material.bandwidth, BandwidthKind::Brdf)?;
    let (light, environment_scale) = map(gpu, surroundings.bandwidth, BandwidthKind::Environment)?;
    let parameters = BandwidthParameters { brdf_scale, environment_scale, ..BandwidthParameters::default() };
    let parameters = gpu.buffer(&parameters.to_bytes(), BufferUsages::UNIFORM);
    let [level, hardware] = decoding.words();
    let words = [index as u32, material.albedo.to_bits(), level, hardware];
    let view = BindingResource::TextureView;
    let resources = [
        importance.as_entire_binding(),
        view(&samples),
        parameters.as_entire_binding(),
        view(&lobes),
        view(&light),
        // No texture has a map: the light's stands in its place.
        view(&light),
        view(surroundings.radiance),
        view(surroundings.light),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
    let descriptor = BindGroupDescriptor { label: None, layout: &layouts.material, entries: &entries };
    let maps = gpu.device.create_bind_group(&descriptor);
    gpu.check()?;
    Ok(LoadedMaterial { pack, maps, words })
}

/// The levels of light, one below the other.
///
/// # Errors
/// [`GpuError::TooLarge`] for more than the adapter's limit per side.
pub(super) fn light(gpu: &Gpu, light: &DistantLight) -> Result<TextureView, GpuError> {
    let width = light.levels()[0].width;
    let row = |texels: &[DirectedLight]| -> Vec<[f32; 4]> {
        let mut row: Vec<_> = texels.iter().map(|t| [t.radiance, t.bandwidth, t.squares, t.varying]).collect();
        row.resize(width, [0.0; 4]);
        row
    };
    let texels: Vec<[f32; 4]> =
        light.levels().iter().flat_map(|level| level.texels.chunks(level.width)).flat_map(row).collect();
    let size = [width as u32, (texels.len() / width) as u32];
    texture(gpu, TexelFormat::Rgba32Float, size, bytemuck::cast_slice(&texels))
}

/// A map of this kind with its scale; one of another kind has 0 everywhere.
fn map(gpu: &Gpu, map: &BandwidthMap, kind: BandwidthKind) -> Result<(TextureView, f32), GpuError> {
    let scale = if map.header().kind == kind { map.scale() } else { 0.0 };
    Ok((texture(gpu, TexelFormat::R16Float, map.size(), &map.texel_bytes())?, scale))
}
