//! Flat BTFs evaluated by the shader: what tests hold against the CPU decoder.

use super::device::{Gpu, GpuError};
use super::pack::texture_format;
use brdfc_formats::pack::TexelFormat;
use brdfc_formats::pack::flat_btf::{FlatBtfDecoder, ViewWeights};
use brdfc_formats::pack::flat_btf_shader::{FLAT_BTF_WGSL, FlatBtfParameters, IndirectionFilter};
use std::borrow::Cow;
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    AddressMode, BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingResource,
    BindingType, BufferBindingType, BufferUsages, ComputePassDescriptor, ComputePipelineDescriptor, Extent3d,
    FilterMode, PipelineLayoutDescriptor, SamplerBindingType, SamplerDescriptor, ShaderModuleDescriptor, ShaderSource,
    ShaderStages, TextureDescriptor, TextureDimension, TextureSampleType, TextureUsages, TextureViewDescriptor,
    TextureViewDimension,
};

/// The compute entry point over the decoder.
pub const EVALUATE_FLAT_BTF_WGSL: &str = include_str!("../shaders/flat_btf.wgsl");

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups of a row; more go to the next row.
const ROW_OF_GROUPS: u32 = 1024;
/// Most queries at once: 112 bytes each, within what every adapter binds.
const MOST_QUERIES: usize = 1 << 20;

/// Where, from where and under which light a flat BTF is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfQuery {
    /// Point of the reference plane, in tiles.
    pub uv: [f32; 2],
    /// Unit vector to the viewer.
    pub view: [f32; 3],
    /// Unit vector to the light, for the light form.
    pub light: [f32; 3],
    /// Sampled views of the full form.
    pub views: ViewWeights,
    /// Sampled lights of the full form.
    pub lights: ViewWeights,
}

/// What the shader returns for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfAnswer {
    /// Parameters and height of what is seen.
    pub indirection: [f32; 3],
    /// The full form; zero without views.
    pub full: [f32; 3],
    /// The light form.
    pub light: [f32; 3],
}

/// A flat BTF on the device.
pub struct LoadedFlatBtf {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct FlatBtfEvaluator<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    query_layout: wgpu::BindGroupLayout,
    texture_layout: wgpu::BindGroupLayout,
}

impl<'g> FlatBtfEvaluator<'g> {
    /// Compiles the shipped shader.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shader(gpu, FLAT_BTF_WGSL)
    }

    /// Compiles another decoder, such as a broken one.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shader(gpu: &'g Gpu, decoder: &str) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("flat BTF"),
            source: ShaderSource::Wgsl(Cow::Owned(format!("{decoder}\n{EVALUATE_FLAT_BTF_WGSL}"))),
        });
        gpu.check()?;
        let entry = |binding, ty| BindGroupLayoutEntry { binding, visibility: ShaderStages::COMPUTE, ty, count: None };
        let buffer =
            |binding, ty| entry(binding, BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None });
        let texture = |binding, filterable, view_dimension| {
            let sample_type = TextureSampleType::Float { filterable };
            entry(binding, BindingType::Texture { sample_type, view_dimension, multisampled: false })
        };
        let query_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("queries"),
            entries: &[
                buffer(0, BufferBindingType::Uniform),
                buffer(1, BufferBindingType::Storage { read_only: true }),
                buffer(2, BufferBindingType::Storage { read_only: false }),
            ],
        });
        let texture_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("flat BTF"),
            entries: &[
                buffer(0, BufferBindingType::Uniform),
                texture(1, false, TextureViewDimension::D2),
                texture(2, true, TextureViewDimension::D2),
                entry(3, BindingType::Sampler(SamplerBindingType::Filtering)),
                texture(4, true, TextureViewDimension::D2),
                texture(5, true, TextureViewDimension::D2),
                texture(6, true, TextureViewDimension::D2Array),
            ],
        });
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&query_layout), Some(&texture_layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some("flat BTF"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("evaluate"),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline, query_layout, texture_layout })
    }

    /// Uploads the parts. Without views the texture of the full form is one empty texel.
    ///
    /// # Errors
    /// More than the adapter takes; what the driver reports.
    pub fn load(&self, decoder: &FlatBtfDecoder, filter: IndirectionFilter) -> Result<LoadedFlatBtf, GpuError> {
        let parts = decoder.parts();
        let (atlas, views) = (decoder.atlas(), parts.views.len() as u32);
        let [width, height] = if views == 0 { [1, 1] } else { atlas.extent() };
        let limits = self.gpu.device.limits();
        let largest = limits.max_texture_dimension_2d;
        let packed = parts.indirection.header().extent();
        let sides = [width, height, packed[0], packed[1], parts.reference.size(), parts.diffuse.size()];
        if let Some(side) = sides.into_iter().find(|side| *side > largest) {
            return Err(GpuError::TooLarge(format!(
                "a texture of {side} texels on a side; the adapter takes {largest}"
            )));
        }
        if views > limits.max_texture_array_layers {
            let most = limits.max_texture_array_layers;
            return Err(GpuError::TooLarge(format!("{views} views; the adapter takes {most} layers")));
        }
        let reference: &[[f32; 2]] = parts.reference.parameters();
        let size = [parts.diffuse.size(); 2];
        let reference =
            self.texture(TexelFormat::Rg32Float, [parts.reference.size(); 2], None, bytemuck::cast_slice(reference));
        let packed = self.texture(TexelFormat::Rgba16Float, packed, None, &parts.indirection.texel_bytes());
        let normal = self.texture(TexelFormat::Rgba16Float, size, None, &parts.normal.texel_bytes());
        let diffuse = self.texture(TexelFormat::Rgb9E5, size, None, bytemuck::cast_slice(parts.diffuse.texels()));
        let layers: Vec<u32> = match views {
            0 => vec![0],
            _ => parts.views.iter().flat_map(|view| atlas.layer(view)).collect(),
        };
        let layers =
            self.texture(TexelFormat::Rgb9E5, [width, height], Some(views.max(1)), bytemuck::cast_slice(&layers));
        let parameters = FlatBtfParameters::new(decoder, filter).to_bytes();
        let parameters = self.buffer(&parameters, BufferUsages::UNIFORM);
        let sampler = self.gpu.device.create_sampler(&SamplerDescriptor {
            address_mode_u: AddressMode::ClampToEdge,
            address_mode_v: AddressMode::ClampToEdge,
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..SamplerDescriptor::default()
        });
        let group = self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.texture_layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: parameters.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&reference) },
                BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&packed) },
                BindGroupEntry { binding: 3, resource: BindingResource::Sampler(&sampler) },
                BindGroupEntry { binding: 4, resource: BindingResource::TextureView(&normal) },
                BindGroupEntry { binding: 5, resource: BindingResource::TextureView(&diffuse) },
                BindGroupEntry { binding: 6, resource: BindingResource::TextureView(&layers) },
            ],
        });
        self.gpu.check()?;
        Ok(LoadedFlatBtf { group })
    }

    /// Evaluates and reads back, in the order of `queries`.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn eval(&self, loaded: &LoadedFlatBtf, queries: &[FlatBtfQuery]) -> Result<Vec<FlatBtfAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MOST_QUERIES) {
            let words: Vec<[u32; 28]> = chunk.iter().map(query_words).collect();
            let evaluation = [chunk.len() as u32, GROUP * ROW_OF_GROUPS, 0, 0];
            let evaluation = self.buffer(bytemuck::cast_slice(&evaluation), BufferUsages::UNIFORM);
            let input = self.buffer(bytemuck::cast_slice(words.as_flattened()), BufferUsages::STORAGE);
            let answers = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 48 * chunk.len() as u64,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let group = self.gpu.device.create_bind_group(&BindGroupDescriptor {
                label: None,
                layout: &self.query_layout,
                entries: &[
                    BindGroupEntry { binding: 0, resource: evaluation.as_entire_binding() },
                    BindGroupEntry { binding: 1, resource: input.as_entire_binding() },
                    BindGroupEntry { binding: 2, resource: answers.as_entire_binding() },
                ],
            });
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            let groups = (chunk.len() as u32).div_ceil(GROUP);
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.set_bind_group(1, &loaded.group, &[]);
            pass.dispatch_workgroups(groups.min(ROW_OF_GROUPS), groups.div_ceil(ROW_OF_GROUPS), 1);
            drop(pass);
            let buffer = self.gpu.read_buffer(answers.size());
            encoder.copy_buffer_to_buffer(&answers, 0, &buffer, 0, answers.size());
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.read(&buffer, |bytes| {
                let words: &[f32] = bytemuck::cast_slice(bytes);
                all.extend(words.chunks_exact(12).map(|w| FlatBtfAnswer {
                    indirection: [w[0], w[1], w[2]],
                    full: [w[4], w[5], w[6]],
                    light: [w[8], w[9], w[10]],
                }));
            })?;
        }
        Ok(all)
    }

    fn buffer(&self, contents: &[u8], usage: BufferUsages) -> wgpu::Buffer {
        self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    }

    /// A 2D texture, or an array of so many layers.
    fn texture(
        &self,
        format: TexelFormat,
        [width, height]: [u32; 2],
        layers: Option<u32>,
        bytes: &[u8],
    ) -> wgpu::TextureView {
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers: layers.unwrap_or(1) },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format: texture_format(format),
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let gpu = self.gpu;
        let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
        let dimension = if layers.is_some() { TextureViewDimension::D2Array } else { TextureViewDimension::D2 };
        texture.create_view(&TextureViewDescriptor { dimension: Some(dimension), ..TextureViewDescriptor::default() })
    }
}

fn query_words(query: &FlatBtfQuery) -> [u32; 28] {
    let mut words = [0; 28];
    let floats = [
        (0, &query.uv[..]),
        (4, &query.view),
        (8, &query.light),
        (16, &query.views.weights),
        (24, &query.lights.weights),
    ];
    for (start, values) in floats {
        for (word, value) in words[start..].iter_mut().zip(values) {
            *word = value.to_bits();
        }
    }
    words[12..15].copy_from_slice(&query.views.indices);
    words[20..23].copy_from_slice(&query.lights.indices);
    words
}
