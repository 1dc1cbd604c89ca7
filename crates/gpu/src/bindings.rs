//! Buffers, textures, samplers and bind groups on the device: of what [`brdfc_shaders::resources`] says, and of anything else.

use super::device::{Gpu, GpuError};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_shaders::resources::{Contents, Resource};
use wgpu::util::{BufferInitDescriptor, DeviceExt, TextureDataOrder};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBindingType, BufferUsages, Extent3d, FilterMode,
    MipmapFilterMode, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages, TextureDescriptor,
    TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension,
};

/// A uniform block.
pub(super) const UNIFORM: BindingType = buffer_type(BufferBindingType::Uniform);
/// A sampler that filters.
pub(super) const SAMPLER: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);
/// A 2D texture.
pub(super) const IMAGE: BindingType = texture_type(FILTERED, TextureViewDimension::D2);
/// A 2D array.
pub(super) const LAYERS: BindingType = texture_type(FILTERED, TextureViewDimension::D2Array);
/// A 3D texture.
pub(super) const VOLUME: BindingType = texture_type(FILTERED, TextureViewDimension::D3);
/// A 2D texture that is not filtered, as of 32-bit floats.
pub(super) const UNFILTERED: BindingType =
    texture_type(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2);
/// A 2D texture of integers.
pub(super) const INTEGERS: BindingType = texture_type(TextureSampleType::Uint, TextureViewDimension::D2);

const FILTERED: TextureSampleType = TextureSampleType::Float { filterable: true };

const fn texture_type(sample_type: TextureSampleType, view_dimension: TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// A whole buffer.
pub(super) const fn buffer_type(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// What fits this.
pub(super) fn type_of(contents: &Contents) -> BindingType {
    match contents {
        Contents::Uniform(_) => UNIFORM,
        Contents::Sampler { .. } => SAMPLER,
        Contents::Texture(texels) => match (texels.format, texels.extent) {
            (TexelFormat::R32Uint | TexelFormat::Rgba32Uint, _) => INTEGERS,
            (TexelFormat::Rg32Float | TexelFormat::Rgba32Float, _) => UNFILTERED,
            (_, Extent::D2(_)) => IMAGE,
            (_, Extent::D2Array(_)) => LAYERS,
            (_, Extent::D3(_)) => VOLUME,
        },
    }
}

/// A layout of these bindings by their numbers.
pub(super) fn layout(
    gpu: &Gpu,
    label: &str,
    visibility: ShaderStages,
    types: impl IntoIterator<Item = (u32, BindingType)>,
) -> BindGroupLayout {
    let entry = |(binding, ty)| BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = types.into_iter().map(entry).collect();
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A bind group of these, by their numbers.
pub(super) fn group<'a>(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    bound: impl IntoIterator<Item = (u32, BindingResource<'a>)>,
) -> BindGroup {
    let entry = |(binding, resource)| BindGroupEntry { binding, resource };
    let entries: Vec<_> = bound.into_iter().map(entry).collect();
    gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// What was uploaded.
enum Uploaded {
    Uniform(Buffer),
    Texture(TextureView),
    Sampler(Sampler),
}

/// Uploads resources, and makes a bind group of them and of these textures, which are there already.
///
/// # Errors
/// As [`texture`]; what the driver reports.
pub(super) fn bind(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    resources: Vec<Resource>,
    textures: &[(u32, &TextureView)],
) -> Result<BindGroup, GpuError> {
    let upload = |resource: Resource| {
        let uploaded = match resource.contents {
            Contents::Uniform(bytes) => Uploaded::Uniform(gpu.buffer(&bytes, BufferUsages::UNIFORM)),
            Contents::Texture(texels) => {
                Uploaded::Texture(texture(gpu, texels.format, texels.extent, texels.levels, &texels.bytes)?)
            }
            Contents::Sampler { repeats } => Uploaded::Sampler(sampler(gpu, repeats)),
        };
        Ok((resource.binding, uploaded))
    };
    let uploaded = resources.into_iter().map(upload).collect::<Result<Vec<_>, GpuError>>()?;
    let own = uploaded.iter().map(|(binding, uploaded)| match uploaded {
        Uploaded::Uniform(buffer) => (*binding, buffer.as_entire_binding()),
        Uploaded::Texture(view) => (*binding, BindingResource::TextureView(view)),
        Uploaded::Sampler(sampler) => (*binding, BindingResource::Sampler(sampler)),
    });
    let others = textures.iter().map(|(binding, view)| (*binding, BindingResource::TextureView(view)));
    let group = group(gpu, layout, own.chain(others));
    gpu.check()?;
    Ok(group)
}

/// Linear, also between mipmap levels.
fn sampler(gpu: &Gpu, repeats: bool) -> Sampler {
    let address = if repeats { AddressMode::Repeat } else { AddressMode::ClampToEdge };
    gpu.device.create_sampler(&SamplerDescriptor {
        address_mode_u: address,
        address_mode_v: address,
        address_mode_w: address,
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        mipmap_filter: MipmapFilterMode::Linear,
        ..SamplerDescriptor::default()
    })
}

/// Uploads a texture: texels level by level from the finest, layer by layer.
///
/// # Errors
/// [`GpuError::TooLarge`] for more than the adapter takes, and for other bytes than the extent says.
pub(super) fn texture(
    gpu: &Gpu,
    format: TexelFormat,
    extent: Extent,
    levels: u32,
    bytes: &[u8],
) -> Result<TextureView, GpuError> {
    let limits = gpu.device.limits();
    let (sides, layers, most) = match extent {
        Extent::D2([width, height]) => ([width, height, 1], 1, limits.max_texture_dimension_2d),
        Extent::D2Array([width, height, layers]) => ([width, height, 1], layers, limits.max_texture_dimension_2d),
        Extent::D3(sides) => (sides, 1, limits.max_texture_dimension_3d),
    };
    let most_layers = limits.max_texture_array_layers;
    let expected = extent.texels_of_levels(levels) * format.texel_bytes() as u64;
    let fits = sides.iter().all(|side| (1..=most).contains(side)) && (1..=most_layers).contains(&layers);
    if !fits || bytes.len() as u64 != expected {
        let found = bytes.len();
        return Err(GpuError::TooLarge(format!(
            "{found} bytes for {levels} levels of {extent}; this adapter takes {most} texels on a side and {most_layers} \
             layers"
        )));
    }
    Ok(gpu.texture(texture_format(format), extent, levels, bytes))
}

impl Gpu {
    /// A buffer with contents.
    pub(super) fn buffer(&self, contents: &[u8], usage: BufferUsages) -> Buffer {
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    /// A texture with mipmap levels: all layers of the finest first.
    pub(super) fn texture(&self, format: TextureFormat, extent: Extent, levels: u32, bytes: &[u8]) -> TextureView {
        let (dimension, view_dimension, [width, height, depth_or_array_layers]) = match extent {
            Extent::D2([width, height]) => (TextureDimension::D2, TextureViewDimension::D2, [width, height, 1]),
            Extent::D2Array(size) => (TextureDimension::D2, TextureViewDimension::D2Array, size),
            Extent::D3(size) => (TextureDimension::D3, TextureViewDimension::D3, size),
        };
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers },
            mip_level_count: levels,
            sample_count: 1,
            dimension,
            format,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let order = TextureDataOrder::MipMajor;
        let texture = self.device.create_texture_with_data(&self.queue, &descriptor, order, bytes);
        texture.create_view(&TextureViewDescriptor { dimension: Some(view_dimension), ..Default::default() })
    }
}

/// How wgpu calls a texel format.
pub fn texture_format(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::R8Unorm => TextureFormat::R8Unorm,
        TexelFormat::Rg8Unorm => TextureFormat::Rg8Unorm,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::R16Unorm => TextureFormat::R16Unorm,
        TexelFormat::R16Float => TextureFormat::R16Float,
        TexelFormat::Rgba16Unorm => TextureFormat::Rgba16Unorm,
        TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
        TexelFormat::Rg32Float => TextureFormat::Rg32Float,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
        TexelFormat::R32Uint => TextureFormat::R32Uint,
        TexelFormat::Rgba32Uint => TextureFormat::Rgba32Uint,
        TexelFormat::Rgb9E5 => TextureFormat::Rgb9e5Ufloat,
        TexelFormat::Rgb10A2Unorm => TextureFormat::Rgb10a2Unorm,
    }
}
