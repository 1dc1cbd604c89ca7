//! Packs on the device: the bind group that `formats/src/wavelet/decode.wgsl` declares.

use super::device::{Gpu, GpuError};
use brdfc_formats::container::TexelFormat;
use brdfc_formats::wavelet::shader::{WaveletBrdfParameters, index_texels};
use brdfc_formats::wavelet::{Filter, WaveletPack};
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    AddressMode, BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingResource,
    BindingType, BufferBindingType, BufferUsages, Extent3d, FilterMode, SamplerBindingType, SamplerDescriptor,
    ShaderStages, TextureDescriptor, TextureDimension, TextureFormat, TextureSampleType, TextureUsages,
    TextureViewDimension,
};

/// How the device calls a texel format.
pub(super) fn texture_format(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::R8Unorm => TextureFormat::R8Unorm,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::R16Unorm => TextureFormat::R16Unorm,
        TexelFormat::R16Float => TextureFormat::R16Float,
        TexelFormat::Rgba16Unorm => TextureFormat::Rgba16Unorm,
        TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
        TexelFormat::Rg32Float => TextureFormat::Rg32Float,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
        TexelFormat::Rgb9E5 => TextureFormat::Rgb9e5Ufloat,
    }
}

/// The layout of group 1.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| BindGroupLayoutEntry { binding, visibility: stages, ty, count: None };
    let texture = |filterable, view_dimension| BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable },
        view_dimension,
        multisampled: false,
    };
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("wavelet pack"),
        entries: &[
            entry(
                0,
                BindingType::Buffer {
                    ty: BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
            ),
            entry(1, texture(true, TextureViewDimension::D3)),
            entry(2, texture(false, TextureViewDimension::D2)),
            entry(3, BindingType::Sampler(SamplerBindingType::Filtering)),
        ],
    })
}

/// Uploads a pack.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    pack: &WaveletPack,
    filter: Filter,
    distance_scale: f64,
) -> Result<wgpu::BindGroup, GpuError> {
    let grid = pack.header.grid() as u32;
    let format = texture_format(pack.header.texel_format());
    let texture = |dimension, format, depth, bytes: &[u8]| {
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width: grid, height: grid, depth_or_array_layers: depth },
            mip_level_count: 1,
            sample_count: 1,
            dimension,
            format,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    };
    let slices = texture(TextureDimension::D3, format, pack.slices() as u32, &pack.texels);
    let index = index_texels(pack);
    let index = texture(TextureDimension::D2, TextureFormat::Rgba32Float, 1, bytemuck::cast_slice(&index));
    let parameters = WaveletBrdfParameters::new(pack, filter, distance_scale as f32).to_bytes();
    let parameters = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: &parameters,
        usage: BufferUsages::UNIFORM,
    });
    let sampler = gpu.device.create_sampler(&SamplerDescriptor {
        address_mode_u: AddressMode::ClampToEdge,
        address_mode_v: AddressMode::ClampToEdge,
        address_mode_w: AddressMode::ClampToEdge,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..SamplerDescriptor::default()
    });
    let group = gpu.device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout,
        entries: &[
            BindGroupEntry { binding: 0, resource: parameters.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&slices) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&index) },
            BindGroupEntry { binding: 3, resource: BindingResource::Sampler(&sampler) },
        ],
    });
    gpu.check()?;
    Ok(group)
}
