//! Polynomial wavelet trees on the device: the bind group that `formats/src/pwt/pwt.wgsl` declares.

use super::device::{Gpu, GpuError};
use super::pack::texture_format;
use super::raster::{buffer_type, entry};
use brdfc_formats::container::TexelFormat;
use brdfc_formats::pwt::shader::{PwtFilter, PwtParameters};
use brdfc_formats::pwt::{MAX_TEXTURES, PwtPack};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindingResource, BindingType, BufferBindingType, BufferUsages, FilterMode, MipmapFilterMode, SamplerBindingType,
    SamplerDescriptor, ShaderStages, TextureSampleType, TextureView, TextureViewDimension,
};

/// Binding of the first texture; the sampler is behind the last.
const FIRST: u32 = 1;

/// The layout of group 1.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> BindGroupLayout {
    let array = BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable: true },
        view_dimension: TextureViewDimension::D2Array,
        multisampled: false,
    };
    let last = FIRST + MAX_TEXTURES as u32;
    let mut entries = vec![entry(0, stages, buffer_type(BufferBindingType::Uniform))];
    entries.extend((FIRST..last).map(|binding| entry(binding, stages, array)));
    entries.push(entry(last, stages, BindingType::Sampler(SamplerBindingType::Filtering)));
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("polynomial wavelet tree"),
        entries: &entries,
    })
}

/// Uploads a pack with all of its mipmap levels; textures that it has not are one empty texel.
///
/// # Errors
/// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    pack: &PwtPack,
    filter: PwtFilter,
) -> Result<BindGroup, GpuError> {
    let header = pack.header();
    let (most, limits) = (header.extent[0].max(header.extent[1]), gpu.device.limits());
    if most > limits.max_texture_dimension_2d {
        let takes = limits.max_texture_dimension_2d;
        return Err(GpuError::TooLarge(format!("a picture of {most} texels on a side; this adapter takes {takes}")));
    }
    let textures: Vec<TextureView> = (0..MAX_TEXTURES).map(|index| texture(gpu, pack, index)).collect();
    let parameters = gpu.buffer(&PwtParameters::to_bytes(pack, filter), BufferUsages::UNIFORM);
    let address = if header.repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
    let sampler = gpu.device.create_sampler(&SamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: MipmapFilterMode::Linear,
        ..SamplerDescriptor::default()
    });
    let mut resources = vec![parameters.as_entire_binding()];
    resources.extend(textures.iter().map(BindingResource::TextureView));
    resources.push(BindingResource::Sampler(&sampler));
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| BindGroupEntry { binding, resource }).collect();
    let group = gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries });
    gpu.check()?;
    Ok(group)
}

fn texture(gpu: &Gpu, pack: &PwtPack, index: usize) -> TextureView {
    let (format, [width, height], layers, levels, texels) = match pack.header().textures.get(index) {
        Some(header) => {
            let sides = pack.header().texture_extent(index);
            (header.texel_format(), sides, header.layers(), pack.levels_of(index), pack.texels(index))
        }
        None => (TexelFormat::R8Unorm, [1; 2], 1, 1, &[0][..]),
    };
    gpu.layers(texture_format(format), [width, height, layers], levels, texels)
}
