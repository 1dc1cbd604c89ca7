//! Buffers, textures, samplers and bind groups on the device, for packs and for everything else.

use super::device::{Gpu, GpuError};
use brdfc_formats::bindings::{Binding, FrameBlock, MAX_UNIFORM_BYTES, Resource, Texels};
use brdfc_formats::container::{Extent, TexelFormat};
use wgpu::util::{BufferInitDescriptor, DeviceExt, TextureDataOrder};
use wgpu::{
    AddressMode, BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor,
    BindGroupLayoutEntry, BindingResource, BindingType, Buffer, BufferBindingType, BufferUsages, Extent3d, FilterMode,
    MipmapFilterMode, Sampler, SamplerBindingType, SamplerDescriptor, ShaderStages, TextureDescriptor,
    TextureDimension, TextureFormat, TextureSampleType, TextureUsages, TextureView, TextureViewDescriptor,
    TextureViewDimension,
};

/// A uniform block.
pub const UNIFORM: BindingType = buffer_type(BufferBindingType::Uniform);
/// A filtering sampler.
pub(super) const SAMPLER: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);
/// A 2D texture.
pub(super) const IMAGE: BindingType = texture_type(FILTERED, TextureViewDimension::D2);
/// A 2D array.
pub(super) const LAYERS: BindingType = texture_type(FILTERED, TextureViewDimension::D2Array);
/// A 3D texture.
pub(super) const VOLUME: BindingType = texture_type(FILTERED, TextureViewDimension::D3);
/// A 2D texture without filtering, such as of 32-bit floats.
pub(super) const UNFILTERED: BindingType =
    texture_type(TextureSampleType::Float { filterable: false }, TextureViewDimension::D2);
/// A 2D texture of integers.
pub(super) const INTEGERS: BindingType = texture_type(TextureSampleType::Uint, TextureViewDimension::D2);

const FILTERED: TextureSampleType = TextureSampleType::Float { filterable: true };

const fn texture_type(sample_type: TextureSampleType, view_dimension: TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// A whole buffer.
pub const fn buffer_type(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

/// Binding type of a resource.
pub(super) fn type_of(resource: &Resource<'_>) -> BindingType {
    match resource {
        Resource::Frame | Resource::Uniform(_) => UNIFORM,
        Resource::Sampler { .. } => SAMPLER,
        Resource::Texture(texels) => {
            let sample_type = match (texels.format.is_integer(), &texels.sampler) {
                (true, _) => TextureSampleType::Uint,
                (false, sampler) => TextureSampleType::Float { filterable: sampler.is_some() },
            };
            texture_type(sample_type, view_dimension(texels.extent))
        }
    }
}

fn view_dimension(extent: Extent) -> TextureViewDimension {
    match extent {
        Extent::D2(_) => TextureViewDimension::D2,
        Extent::D2Array(_) => TextureViewDimension::D2Array,
        Extent::D3(_) => TextureViewDimension::D3,
        Extent::Cube(_) => TextureViewDimension::Cube,
    }
}

/// Zeros, which are bound to a slot of this type if a pack has nothing for it.
fn nothing(ty: BindingType) -> Resource<'static> {
    match ty {
        BindingType::Buffer { .. } => Resource::Uniform(vec![0; MAX_UNIFORM_BYTES as usize].into()),
        BindingType::Texture { sample_type, view_dimension, .. } => {
            let extent = match view_dimension {
                TextureViewDimension::D3 => Extent::D3([1; 3]),
                TextureViewDimension::D2Array => Extent::D2Array([1; 3]),
                TextureViewDimension::Cube => Extent::Cube(1),
                _ => Extent::D2([1; 2]),
            };
            let is_integer = sample_type == TextureSampleType::Uint;
            let format = if is_integer { TexelFormat::R32Uint } else { TexelFormat::R8Unorm };
            Resource::Texture(Texels::empty(format, extent))
        }
        _ => Resource::Sampler { repeats: false },
    }
}

/// Creates a layout of these bindings, given with their numbers.
pub fn layout(
    gpu: &Gpu,
    label: &str,
    visibility: ShaderStages,
    types: impl IntoIterator<Item = (u32, BindingType)>,
) -> BindGroupLayout {
    let entry = |(binding, ty)| BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = types.into_iter().map(entry).collect();
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// Creates a bind group of these resources, given with their numbers.
pub fn group<'a>(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    bound: impl IntoIterator<Item = (u32, BindingResource<'a>)>,
) -> BindGroup {
    let entry = |(binding, resource)| BindGroupEntry { binding, resource };
    let entries: Vec<_> = bound.into_iter().map(entry).collect();
    gpu.device.create_bind_group(&BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// An uploaded resource.
enum Uploaded {
    Uniform(Buffer),
    Texture(TextureView),
    Sampler(Sampler),
}

/// Slots and types of a bind group.
pub struct Slots {
    /// The layout.
    pub layout: BindGroupLayout,
    types: Vec<(u32, BindingType)>,
}

impl Slots {
    /// Creates a layout of these slots.
    pub fn new(
        gpu: &Gpu,
        label: &str,
        visibility: ShaderStages,
        types: impl IntoIterator<Item = (u32, BindingType)>,
    ) -> Self {
        let types: Vec<_> = types.into_iter().collect();
        Self { layout: layout(gpu, label, visibility, types.iter().copied()), types }
    }

    /// Creates a layout for the bindings of packs.
    pub fn of(gpu: &Gpu, label: &str, visibility: ShaderStages, bindings: &[Binding<'_>]) -> Self {
        let types = bindings.iter().map(|binding| (binding.slot, type_of(&binding.resource)));
        Self::new(gpu, label, visibility, types)
    }

    /// Uploads the bindings of a pack and makes a bind group of them. Slots without a resource have zeros.
    ///
    /// # Errors
    /// Returns the errors of `texture`; any error that the driver reports.
    pub fn bind(&self, gpu: &Gpu, bindings: &[Binding<'_>], frame: FrameBlock) -> Result<BindGroup, GpuError> {
        let upload = |(slot, ty): &(u32, BindingType)| {
            let found = bindings.iter().find(|binding| binding.slot == *slot).map(|binding| &binding.resource);
            let uploaded = match found {
                Some(resource) => upload(gpu, resource, frame)?,
                None => upload(gpu, &nothing(*ty), frame)?,
            };
            Ok((*slot, uploaded))
        };
        let uploaded = self.types.iter().map(upload).collect::<Result<Vec<_>, GpuError>>()?;
        let bound = uploaded.iter().map(|(slot, uploaded)| match uploaded {
            Uploaded::Uniform(buffer) => (*slot, buffer.as_entire_binding()),
            Uploaded::Texture(view) => (*slot, BindingResource::TextureView(view)),
            Uploaded::Sampler(sampler) => (*slot, BindingResource::Sampler(sampler)),
        });
        let group = group(gpu, &self.layout, bound);
        gpu.check()?;
        Ok(group)
    }
}

fn upload(gpu: &Gpu, resource: &Resource<'_>, frame: FrameBlock) -> Result<Uploaded, GpuError> {
    Ok(match resource {
        Resource::Frame => Uploaded::Uniform(gpu.buffer(&frame.to_bytes(), BufferUsages::UNIFORM)),
        Resource::Uniform(bytes) => Uploaded::Uniform(gpu.buffer(bytes, BufferUsages::UNIFORM)),
        Resource::Sampler { repeats } => Uploaded::Sampler(sampler(gpu, *repeats)),
        Resource::Texture(Texels { format, extent, levels, bytes, .. }) => {
            Uploaded::Texture(texture(gpu, *format, *extent, *levels, bytes)?)
        }
    })
}

/// A linear sampler, also between mipmap levels.
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
/// Returns [`GpuError::TooLarge`] for more than the adapter takes, or if the number of bytes does not match the extent.
pub(super) fn texture(
    gpu: &Gpu,
    format: TexelFormat,
    extent: Extent,
    levels: u32,
    bytes: &[u8],
) -> Result<TextureView, GpuError> {
    let limits = gpu.device.limits();
    let [width, height, depth] = extent.size();
    let (sides, layers, most) = match extent {
        Extent::D3(sides) => (sides, 1, limits.max_texture_dimension_3d),
        _ => ([width, height, 1], depth, limits.max_texture_dimension_2d),
    };
    let most_layers = limits.max_texture_array_layers;
    let expected = extent.texels_of_levels(levels) * format.texel_bytes() as u64;
    let fits = sides.iter().all(|side| (1..=most).contains(side)) && (1..=most_layers).contains(&layers);
    if !fits || bytes.len() as u64 != expected {
        let found = bytes.len();
        return Err(GpuError::TooLarge(format!(
            "found {found} bytes for {levels} levels of {extent}, expected {expected} bytes, and at most {most} texels \
             per side and {most_layers} layers on this adapter"
        )));
    }
    Ok(gpu.texture(texture_format(format), extent, levels, bytes))
}

impl Gpu {
    /// A buffer with contents.
    #[doc(hidden)]
    pub fn buffer(&self, contents: &[u8], usage: BufferUsages) -> Buffer {
        self.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    }

    /// Creates a texture with mipmap levels: all layers of the finest first.
    pub(super) fn texture(&self, format: TextureFormat, extent: Extent, levels: u32, bytes: &[u8]) -> TextureView {
        let [width, height, depth_or_array_layers] = extent.size();
        let dimension = if matches!(extent, Extent::D3(_)) { TextureDimension::D3 } else { TextureDimension::D2 };
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
        texture.create_view(&TextureViewDescriptor { dimension: Some(view_dimension(extent)), ..Default::default() })
    }
}

/// The wgpu format of a texel format.
pub fn texture_format(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::R8Unorm => TextureFormat::R8Unorm,
        TexelFormat::Rg8Unorm => TextureFormat::Rg8Unorm,
        TexelFormat::Rgba8Unorm => TextureFormat::Rgba8Unorm,
        TexelFormat::R16Unorm => TextureFormat::R16Unorm,
        TexelFormat::R16Float => TextureFormat::R16Float,
        TexelFormat::Rgba16Unorm => TextureFormat::Rgba16Unorm,
        TexelFormat::Rgba16Float => TextureFormat::Rgba16Float,
        TexelFormat::Rg16Float => TextureFormat::Rg16Float,
        TexelFormat::Rgba32Float => TextureFormat::Rgba32Float,
        TexelFormat::R32Uint => TextureFormat::R32Uint,
        TexelFormat::Rgba32Uint => TextureFormat::Rgba32Uint,
        TexelFormat::Rgb9E5 => TextureFormat::Rgb9e5Ufloat,
        TexelFormat::Rgb10A2Unorm => TextureFormat::Rgb10a2Unorm,
    }
}
