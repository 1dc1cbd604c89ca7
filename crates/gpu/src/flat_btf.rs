//! Flat BTFs evaluated by the shader: what tests hold against the CPU decoder.

use super::device::{Gpu, GpuError};
use super::flat_textures;
use super::raster::{buffer_type, entry};
use brdfc_formats::flat_btf::shader::{FLAT_BTF_WGSL, IndirectionFilter};
use brdfc_formats::flat_btf::{FlatBtfDecoder, ViewWeights};
use std::borrow::Cow;
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BufferBindingType, BufferUsages,
    ComputePassDescriptor, ComputePipelineDescriptor, PipelineLayoutDescriptor, ShaderModuleDescriptor, ShaderSource,
    ShaderStages,
};

/// The compute entry point over the decoder.
pub const EVALUATE_FLAT_BTF_WGSL: &str = include_str!("evaluate_flat_btf.wgsl");

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
        let buffer = |binding, ty| entry(binding, ShaderStages::COMPUTE, buffer_type(ty));
        let query_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("queries"),
            entries: &[
                buffer(0, BufferBindingType::Uniform),
                buffer(1, BufferBindingType::Storage { read_only: true }),
                buffer(2, BufferBindingType::Storage { read_only: false }),
            ],
        });
        let texture_layout = flat_textures::layout(gpu, ShaderStages::COMPUTE);
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
        Ok(LoadedFlatBtf { group: flat_textures::upload(self.gpu, &self.texture_layout, decoder, filter, true)? })
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
            let evaluation = self.gpu.buffer(bytemuck::cast_slice(&evaluation), BufferUsages::UNIFORM);
            let input = self.gpu.buffer(bytemuck::cast_slice(words.as_flattened()), BufferUsages::STORAGE);
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
