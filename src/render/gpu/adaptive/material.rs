//! Materials on the device: pack, importance samples, bandwidth maps.

use super::super::compute::texture;
use super::super::device::{Gpu, GpuError};
use super::super::draw::Decoding;
use super::super::pack;
use super::kernels::Kernels;
use crate::render::adaptive::{AdaptiveMaterial, DistantLight};
use brdfc_formats::pack::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::pack::bandwidth_shader::BandwidthParameters;
use brdfc_formats::pack::{TexelFormat, WaveletPack};
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindingResource, BufferUsages, Extent3d, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, TextureView,
};

/// The bind groups of a part.
pub(super) struct LoadedMaterial {
    pub(super) pack: BindGroup,
    pub(super) maps: BindGroup,
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
    kernels: &Kernels<'_>,
    surroundings: &Surroundings<'_>,
    index: usize,
    material: &AdaptiveMaterial<'_>,
    pack: &WaveletPack,
) -> Result<LoadedMaterial, GpuError> {
    let (gpu, decoding) = (kernels.gpu, surroundings.decoding);
    let pack = pack::upload(gpu, &kernels.pack_layout, pack, decoding.filter, decoding.distance_scale)?;
    let header = material.samples.header();
    let importance = gpu.buffer(&header.uniform(), BufferUsages::UNIFORM);
    let texels = bytemuck::cast_slice(material.samples.texels());
    let samples = texture(gpu, TexelFormat::Rgba32Float, [header.samples, header.rows()], texels)?;
    let (lobes, brdf_scale) = map(gpu, material.bandwidth, BandwidthKind::Brdf)?;
    let (light, environment_scale) = map(gpu, surroundings.bandwidth, BandwidthKind::Environment)?;
    let parameters = BandwidthParameters { brdf_scale, environment_scale, ..BandwidthParameters::default() };
    let parameters = gpu.buffer(&parameters.to_bytes(), BufferUsages::UNIFORM);
    let [level, hardware] = decoding.words();
    let own = [index as u32, material.albedo.to_bits(), level, hardware];
    let own = gpu.buffer(bytemuck::cast_slice(&own), BufferUsages::UNIFORM);
    let view = BindingResource::TextureView;
    let resources = [
        importance.as_entire_binding(),
        view(&samples),
        parameters.as_entire_binding(),
        view(&lobes),
        view(&light),
        // No texture has a map: the light's stands in its place.
        view(&light),
        own.as_entire_binding(),
        view(surroundings.radiance),
        view(surroundings.light),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
    let descriptor = BindGroupDescriptor { label: None, layout: &kernels.material_layout, entries: &entries };
    let maps = gpu.device.create_bind_group(&descriptor);
    gpu.check()?;
    Ok(LoadedMaterial { pack, maps })
}

/// Means of light as mip levels.
pub(super) fn light(gpu: &Gpu, light: &DistantLight) -> TextureView {
    let levels = light.levels();
    let texels: Vec<[f32; 4]> = levels
        .iter()
        .flat_map(|level| &level.texels)
        .map(|texel| [texel.radiance, texel.bandwidth, texel.squares, texel.varying])
        .collect();
    let size = Extent3d { width: levels[0].width as u32, height: levels[0].height as u32, depth_or_array_layers: 1 };
    let descriptor = TextureDescriptor {
        label: Some("light"),
        size,
        mip_level_count: levels.len() as u32,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format: TextureFormat::Rgba32Float,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let bytes = bytemuck::cast_slice(&texels);
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::MipMajor, bytes);
    texture.create_view(&Default::default())
}

/// A map of this kind with its scale; one of another kind has 0 everywhere.
fn map(gpu: &Gpu, map: &BandwidthMap, kind: BandwidthKind) -> Result<(TextureView, f32), GpuError> {
    let scale = if map.header().kind == kind { map.scale() } else { 0.0 };
    Ok((texture(gpu, TexelFormat::R16Float, map.size(), &map.texel_bytes())?, scale))
}
