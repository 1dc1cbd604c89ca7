//! A pack of any codec on a device of wgpu: everything that an engine needs to bind one.

use brdfc_formats::bindings::{Binding, FrameBlock, Resource};
use brdfc_formats::container::Extent;
use brdfc_gpu::texture_format;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _, TextureDataOrder};
use wgpu::*;

/// Uploaded resources.
enum Made {
    Buffer(Buffer),
    Texture(TextureView),
    Sampler(Sampler),
}

/// Uploads everything that a pack's shader binds, and makes a bind group of it by slots.
pub fn bind(device: &Device, queue: &Queue, pack: &[Binding<'_>], frame: FrameBlock) -> (BindGroupLayout, BindGroup) {
    let visibility = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
    let made = pack.iter().map(|Binding { slot, resource, .. }| {
        let (ty, made) = upload(device, queue, resource, &frame.to_bytes());
        (BindGroupLayoutEntry { binding: *slot, visibility, ty, count: None }, made)
    });
    let (types, made): (Vec<_>, Vec<_>) = made.unzip();
    let entries = types.iter().zip(&made).map(|(ty, made)| BindGroupEntry {
        binding: ty.binding,
        resource: match made {
            Made::Buffer(buffer) => buffer.as_entire_binding(),
            Made::Texture(view) => BindingResource::TextureView(view),
            Made::Sampler(sampler) => BindingResource::Sampler(sampler),
        },
    });
    let entries = &entries.collect::<Vec<_>>();
    let layout = device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: None, entries: &types });
    let group = device.create_bind_group(&BindGroupDescriptor { label: None, layout: &layout, entries });
    (layout, group)
}

fn upload(device: &Device, queue: &Queue, resource: &Resource<'_>, frame: &[u8]) -> (BindingType, Made) {
    let block = |contents: &[u8]| {
        let descriptor = BufferInitDescriptor { label: None, contents, usage: BufferUsages::UNIFORM };
        let ty = BufferBindingType::Uniform;
        let ty = BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        (ty, Made::Buffer(device.create_buffer_init(&descriptor)))
    };
    match resource {
        Resource::Frame => block(frame),
        Resource::Uniform(bytes) => block(bytes),
        Resource::Sampler { repeats } => {
            let mode = if *repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
            let sampler = device.create_sampler(&SamplerDescriptor {
                address_mode_u: mode,
                address_mode_v: mode,
                address_mode_w: mode,
                mag_filter: FilterMode::Linear,
                min_filter: FilterMode::Linear,
                mipmap_filter: MipmapFilterMode::Linear,
                ..Default::default()
            });
            (BindingType::Sampler(SamplerBindingType::Filtering), Made::Sampler(sampler))
        }
        Resource::Texture(texels) => {
            let (dimension, view_dimension) = match texels.extent {
                Extent::D2(_) => (TextureDimension::D2, TextureViewDimension::D2),
                Extent::D2Array(_) => (TextureDimension::D2, TextureViewDimension::D2Array),
                Extent::D3(_) => (TextureDimension::D3, TextureViewDimension::D3),
                Extent::Cube(_) => (TextureDimension::D2, TextureViewDimension::Cube),
            };
            let [width, height, depth_or_array_layers] = texels.extent.size();
            let descriptor = TextureDescriptor {
                label: None,
                size: Extent3d { width, height, depth_or_array_layers },
                mip_level_count: texels.levels,
                sample_count: 1,
                dimension,
                format: texture_format(texels.format),
                usage: TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            };
            let order = TextureDataOrder::MipMajor;
            let texture = device.create_texture_with_data(queue, &descriptor, order, &texels.bytes);
            let view = TextureViewDescriptor { dimension: Some(view_dimension), ..Default::default() };
            let float = TextureSampleType::Float { filterable: texels.sampler.is_some() };
            let sample_type = if texels.format.is_integer() { TextureSampleType::Uint } else { float };
            let ty = BindingType::Texture { sample_type, view_dimension, multisampled: false };
            (ty, Made::Texture(texture.create_view(&view)))
        }
    }
}
