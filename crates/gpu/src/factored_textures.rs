//! Factored flat BTFs on the device: bindings 8 to 12 of group 1, as `formats/src/flat_btf/factored/factored.wgsl` declares them.

use super::device::{Gpu, GpuError};
use super::pack::texture_format;
use super::raster::{buffer_type, entry};
use brdfc_formats::container::TexelFormat;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::factored::shader::{FactoredFilter, FactoredParameters};
use wgpu::{
    AddressMode, BindGroupEntry, BindGroupLayoutEntry, BindingResource, BindingType, BufferBindingType, BufferUsages,
    FilterMode, MipmapFilterMode, SamplerBindingType, SamplerDescriptor, ShaderStages, TextureSampleType, TextureView,
    TextureViewDimension,
};

/// The first of the five bindings.
const FIRST: u32 = 8;

/// Their layout.
pub(super) fn entries(stages: ShaderStages) -> [BindGroupLayoutEntry; 5] {
    let texture =
        |sample_type, view_dimension| BindingType::Texture { sample_type, view_dimension, multisampled: false };
    let layers = texture(TextureSampleType::Float { filterable: true }, TextureViewDimension::D2Array);
    let integers = texture(TextureSampleType::Uint, TextureViewDimension::D2);
    let sampler = BindingType::Sampler(SamplerBindingType::Filtering);
    let uniform = buffer_type(BufferBindingType::Uniform);
    let mut binding = FIRST..;
    [uniform, layers, layers, integers, sampler].map(|ty| entry(binding.next().unwrap_or(FIRST), stages, ty))
}

/// What is bound.
pub(super) struct FactoredTextures {
    parameters: wgpu::Buffer,
    weights: TextureView,
    shadow: TextureView,
    basis: TextureView,
    sampler: wgpu::Sampler,
}

impl FactoredTextures {
    /// Uploads the parts with their mipmap levels; where there are none, every texture is one empty texel.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
    pub(super) fn upload(gpu: &Gpu, asset: Option<&FactoredFlatBtf>, filter: FactoredFilter) -> Result<Self, GpuError> {
        let sampler = gpu.device.create_sampler(&SamplerDescriptor {
            address_mode_u: AddressMode::Repeat,
            address_mode_v: AddressMode::Repeat,
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            mipmap_filter: MipmapFilterMode::Linear,
            ..SamplerDescriptor::default()
        });
        let layers = |format, size, levels, texels: &[u8]| gpu.layers(texture_format(format), size, levels, texels);
        let integers = |size, texels: &[u8]| gpu.image(texture_format(TexelFormat::Rgba32Uint), size, texels);
        let no_shadow = || layers(TexelFormat::R8Unorm, [1; 3], 1, &[0]);
        let Some(asset) = asset else {
            return Ok(Self {
                parameters: gpu.buffer(&[0; FactoredParameters::SIZE], BufferUsages::UNIFORM),
                weights: layers(TexelFormat::Rgba8Unorm, [1; 3], 1, &[0; 4]),
                shadow: no_shadow(),
                basis: integers([1; 2], &[0; 16]),
                sampler,
            });
        };
        let header = asset.header();
        let ([width, height], limits) = (header.basis_extent(), gpu.device.limits());
        let most = limits.max_texture_dimension_2d;
        for (part, side) in [("basis", width.max(height)), ("weights", header.size)] {
            if side > most {
                let text = format!("the part {part} has {side} texels on a side; this adapter takes {most}");
                return Err(GpuError::TooLarge(text));
            }
        }
        let (lights, most) = (header.lights.len() as u32, limits.max_texture_array_layers);
        if asset.shadow().is_some() && lights > most {
            let text = format!("{lights} lights; this adapter takes {most} layers: draw the light form, or make fewer");
            return Err(GpuError::TooLarge(text));
        }
        let size = header.size;
        let weights = asset.weights();
        Ok(Self {
            parameters: gpu.buffer(&FactoredParameters::to_bytes(asset, filter), BufferUsages::UNIFORM),
            weights: layers(
                TexelFormat::Rgba8Unorm,
                [size, size, weights.layers()],
                weights.levels(),
                weights.texels(),
            ),
            shadow: match asset.shadow() {
                Some(map) => layers(TexelFormat::R8Unorm, [size, size, lights], map.levels(), map.texels()),
                None => no_shadow(),
            },
            basis: integers([width, height], bytemuck::cast_slice(asset.basis().words())),
            sampler,
        })
    }

    /// The bindings, for a bind group.
    pub(super) fn bindings(&self) -> [BindGroupEntry<'_>; 5] {
        let mut binding = FIRST..;
        [
            self.parameters.as_entire_binding(),
            BindingResource::TextureView(&self.weights),
            BindingResource::TextureView(&self.shadow),
            BindingResource::TextureView(&self.basis),
            BindingResource::Sampler(&self.sampler),
        ]
        .map(|resource| BindGroupEntry { binding: binding.next().unwrap_or(FIRST), resource })
    }
}
