//! Polynomial wavelet trees evaluated by the shader: what tests hold against the CPU decoder.

use super::device::{Gpu, GpuError};
use super::pwt_textures;
use super::raster::{buffer_type, entry};
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::pwt::shader::{PWT_WGSL, PwtFilter};
use std::borrow::Cow;
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BufferBindingType, BufferUsages,
    ComputePassDescriptor, ComputePipelineDescriptor, PipelineLayoutDescriptor, ShaderModuleDescriptor, ShaderSource,
    ShaderStages,
};

/// The compute entry point over the decoder.
pub const EVALUATE_PWT_WGSL: &str = include_str!("evaluate_pwt.wgsl");

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups of a row; more go to the next row.
const ROW_OF_GROUPS: u32 = 1024;
/// Most queries at once: 32 bytes each, within what every adapter binds.
const MOST_QUERIES: usize = 1 << 21;

/// Where and under which light a picture is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtQuery {
    /// 0 to 1 across the picture and down from its top.
    pub uv: [f32; 2],
    /// Mipmap level, 0 at the picture's own resolution.
    pub level: f32,
    /// Unit vector to the light.
    pub light: [f32; 3],
}

/// What the shader returns for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtAnswer {
    /// Channels in the domain of the pack.
    pub channels: [f32; 3],
    /// Linear RGB.
    pub value: [f32; 3],
    /// Fetches of the channels, where the entry point was instrumented; else 0.
    pub fetches: f32,
}

/// A pack on the device.
pub struct LoadedPwt {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct PwtEvaluator<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    query_layout: wgpu::BindGroupLayout,
    texture_layout: wgpu::BindGroupLayout,
}

impl<'g> PwtEvaluator<'g> {
    /// Compiles the shipped shader.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, PWT_WGSL, EVALUATE_PWT_WGSL)
    }

    /// Compiles another decoder and entry point, such as a broken or an instrumented one.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shaders(gpu: &'g Gpu, decoder: &str, entry_point: &str) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("polynomial wavelet tree"),
            source: ShaderSource::Wgsl(Cow::Owned(format!("{decoder}\n{entry_point}"))),
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
        let texture_layout = pwt_textures::layout(gpu, ShaderStages::COMPUTE);
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&query_layout), Some(&texture_layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some("polynomial wavelet tree"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("evaluate"),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline, query_layout, texture_layout })
    }

    /// Uploads a pack.
    ///
    /// # Errors
    /// More than the adapter takes; what the driver reports.
    pub fn load(&self, pack: &PwtPack, filter: PwtFilter) -> Result<LoadedPwt, GpuError> {
        Ok(LoadedPwt { group: pwt_textures::upload(self.gpu, &self.texture_layout, pack, filter)? })
    }

    /// Evaluates and reads back, in the order of `queries`. Below the horizon channels are whatever the terms give.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn eval(&self, loaded: &LoadedPwt, queries: &[PwtQuery]) -> Result<Vec<PwtAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MOST_QUERIES) {
            let words: Vec<[f32; 8]> = chunk.iter().map(query_words).collect();
            let evaluation = [chunk.len() as u32, GROUP * ROW_OF_GROUPS, 0, 0];
            let evaluation = self.gpu.buffer(bytemuck::cast_slice(&evaluation), BufferUsages::UNIFORM);
            let input = self.gpu.buffer(bytemuck::cast_slice(words.as_flattened()), BufferUsages::STORAGE);
            let answers = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 32 * chunk.len() as u64,
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
                all.extend(words.chunks_exact(8).map(|w| PwtAnswer {
                    channels: [w[0], w[1], w[2]],
                    value: [w[4], w[5], w[6]],
                    fetches: w[3],
                }));
            })?;
        }
        Ok(all)
    }
}

fn query_words(query: &PwtQuery) -> [f32; 8] {
    let ([u, v], [x, y, z]) = (query.uv, query.light);
    [u, v, query.level, 0.0, x, y, z, 0.0]
}
