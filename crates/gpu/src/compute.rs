//! Any WGSL function over a list of numbers: what tests hold against its CPU twin.

use super::device::{Gpu, GpuError};
use super::items::ItemPipeline;
use super::pack::texture_format;
use super::raster::{buffer_type, entry};
use brdfc_formats::container::{Extent, TexelFormat};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindingResource,
    BindingType, BufferBindingType, BufferUsages, ShaderStages, TextureSampleType, TextureViewDimension,
    util::DeviceExt as _,
};

/// The compute entry point: it calls `fn compute(at: u32)`, which reads `input` and writes `output`.
pub const COMPUTE_WGSL: &str = concat!(include_str!("compute.wgsl"), include_str!("items.wgsl"));

/// Most numbers in or out at once, within what every adapter binds.
const MOST_NUMBERS: usize = 1 << 24;

/// What a shader reads besides its input, in the order of the bindings of group 1.
#[derive(Debug, Clone, Copy)]
pub enum Resource<'a> {
    /// A uniform block, a multiple of 16 bytes.
    Uniform(&'a [u8]),
    /// A 2D texture of four 32-bit floats, which is not filtered: width, height and texels, row by row.
    Texture([u32; 2], &'a [[f32; 4]]),
    /// A 2D texture of one 16-bit float, which is not filtered: width, height and bytes of the texels, row by row.
    Halves([u32; 2], &'a [u8]),
    /// A 2D texture of four 32-bit integers: width, height and words, row by row.
    Integers([u32; 2], &'a [u32]),
    /// A 2D array that may be filtered, with mipmaps: format, width, height, layers, levels, and texels level by level from
    /// the finest, layer by layer.
    Layers(TexelFormat, [u32; 3], u32, &'a [u8]),
    /// A sampler: linear, also between levels, repeating.
    Sampler,
}

/// A 2D texture that is not filtered.
pub(super) const UNFILTERED: BindingType = BindingType::Texture {
    sample_type: TextureSampleType::Float { filterable: false },
    view_dimension: TextureViewDimension::D2,
    multisampled: false,
};

/// A compiled shader with its resources.
pub struct Compute<'g> {
    pipeline: ItemPipeline<'g>,
    resources: BindGroup,
}

impl<'g> Compute<'g> {
    /// Compiles `source`, which defines `compute(at: u32)`, in front of [`COMPUTE_WGSL`], and uploads the resources.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message; resources that do not fit.
    pub fn new(gpu: &'g Gpu, source: &str, resources: &[Resource<'_>]) -> Result<Self, GpuError> {
        let (layout, resources) = upload(gpu, resources)?;
        let pipeline = ItemPipeline::new(gpu, "compute", format!("{source}\n{COMPUTE_WGSL}"), &layout)?;
        Ok(Self { pipeline, resources })
    }

    /// Runs over `count` items and reads back: `width` numbers of `input` belong to an item, and `width_out` numbers of
    /// the output.
    ///
    /// # Errors
    /// An input of another length, too many numbers; what the driver reports.
    pub fn run(&self, input: &[f32], width: usize, width_out: usize) -> Result<Vec<f32>, GpuError> {
        let count = input.len() / width.max(1);
        let numbers = count.saturating_mul(width_out.max(width));
        if count * width != input.len() || numbers > MOST_NUMBERS {
            let text = format!("{} numbers in items of {width} and {width_out}; at most {MOST_NUMBERS}", input.len());
            return Err(GpuError::TooLarge(text));
        }
        if count * width_out == 0 {
            return Ok(Vec::new());
        }
        let items = self.pipeline.load(input, count, 4 * width_out, [0; 2])?;
        self.pipeline.answers(&items, &self.resources)
    }
}

fn upload(gpu: &Gpu, resources: &[Resource<'_>]) -> Result<(BindGroupLayout, BindGroup), GpuError> {
    let (mut buffers, mut views) = (Vec::new(), Vec::new());
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: wgpu::AddressMode::Repeat,
        address_mode_v: wgpu::AddressMode::Repeat,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    });
    let mut layout = Vec::new();
    for (binding, resource) in resources.iter().enumerate() {
        let ty = match resource {
            Resource::Uniform(bytes) => {
                buffers.push(gpu.buffer(bytes, BufferUsages::UNIFORM));
                buffer_type(BufferBindingType::Uniform)
            }
            Resource::Texture(size, texels) => {
                views.push(texture(gpu, TexelFormat::Rgba32Float, *size, bytemuck::cast_slice(texels))?);
                UNFILTERED
            }
            Resource::Halves(size, texels) => {
                views.push(texture(gpu, TexelFormat::R16Float, *size, texels)?);
                UNFILTERED
            }
            Resource::Integers(size, words) => {
                views.push(texture(gpu, TexelFormat::Rgba32Uint, *size, bytemuck::cast_slice(words))?);
                let sample_type = TextureSampleType::Uint;
                BindingType::Texture { sample_type, view_dimension: TextureViewDimension::D2, multisampled: false }
            }
            Resource::Layers(format, sides, levels, texels) => {
                views.push(layers(gpu, *format, *sides, *levels, texels)?);
                let view_dimension = TextureViewDimension::D2Array;
                let sample_type = TextureSampleType::Float { filterable: true };
                BindingType::Texture { sample_type, view_dimension, multisampled: false }
            }
            Resource::Sampler => BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        };
        layout.push(entry(binding as u32, ShaderStages::COMPUTE, ty));
    }
    let layout =
        gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some("resources"), entries: &layout });
    let (mut buffers, mut views) = (buffers.iter(), views.iter());
    let mut entries = Vec::new();
    for (binding, resource) in resources.iter().enumerate() {
        let resource = match resource {
            Resource::Uniform(_) => buffers.next().map(wgpu::Buffer::as_entire_binding),
            Resource::Sampler => Some(BindingResource::Sampler(&sampler)),
            _ => views.next().map(BindingResource::TextureView),
        };
        entries.extend(resource.map(|resource| BindGroupEntry { binding: binding as u32, resource }));
    }
    let group = gpu.device.create_bind_group(&BindGroupDescriptor {
        label: Some("resources"),
        layout: &layout,
        entries: &entries,
    });
    gpu.check()?;
    Ok((layout, group))
}

/// Uploads a 2D array with mipmaps.
fn layers(
    gpu: &Gpu,
    format: TexelFormat,
    sides: [u32; 3],
    levels: u32,
    texels: &[u8],
) -> Result<wgpu::TextureView, GpuError> {
    let [width, height, depth_or_array_layers] = sides;
    let (limits, extent) = (gpu.device.limits(), Extent::D2Array(sides));
    let bytes = extent.texels_of_levels(levels) * format.texel_bytes() as u64;
    let fits = width.max(height) <= limits.max_texture_dimension_2d
        && depth_or_array_layers <= limits.max_texture_array_layers
        && (1..=extent.most_levels()).contains(&levels);
    if !fits || texels.len() as u64 != bytes {
        let text = format!("{} bytes for {levels} levels of {extent}, of which there should be {bytes}", texels.len());
        return Err(GpuError::TooLarge(text));
    }
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: texture_format(format),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    };
    let order = wgpu::util::TextureDataOrder::MipMajor;
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, order, texels);
    let dimension = Some(TextureViewDimension::D2Array);
    Ok(texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() }))
}

/// Uploads a 2D texture.
///
/// # Errors
/// Other texels than the size says, or more than the adapter's limit per side.
pub(super) fn texture(
    gpu: &Gpu,
    format: TexelFormat,
    size: [u32; 2],
    texels: &[u8],
) -> Result<wgpu::TextureView, GpuError> {
    let most = gpu.device.limits().max_texture_dimension_2d;
    let [width, height] = size;
    let bytes = u64::from(width) * u64::from(height) * format.texel_bytes() as u64;
    if width.max(height) > most || width.min(height) == 0 || texels.len() as u64 != bytes {
        let text = format!("{} bytes for a texture of {width} x {height}; at most {most} per side", texels.len());
        return Err(GpuError::TooLarge(text));
    }
    Ok(gpu.image(texture_format(format), size, texels))
}
