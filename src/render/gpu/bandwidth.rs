//! Bandwidth maps looked up by the shader: what tests hold against the CPU.

use super::device::{Gpu, GpuError};
use super::pack::texture_format;
use super::raster::{buffer_type, entry};
use brdfc_formats::pack::TexelFormat;
use brdfc_formats::pack::bandwidth::{BandwidthKind, BandwidthMap};
use brdfc_formats::pack::bandwidth_shader::{BANDWIDTH_WGSL, BandwidthParameters};
use std::borrow::Cow;
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindingResource,
    BindingType, BufferBindingType, BufferUsages, ComputePassDescriptor, ComputePipelineDescriptor,
    PipelineLayoutDescriptor, ShaderModuleDescriptor, ShaderSource, ShaderStages, TextureSampleType,
    TextureViewDimension,
};

/// The compute entry point over the look-ups.
pub const EVALUATE_BANDWIDTH_WGSL: &str = include_str!("../shaders/bandwidth.wgsl");

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups of a row; more go to the next row.
const ROW_OF_GROUPS: u32 = 1024;
/// Most queries at once: 80 bytes each, within what every adapter binds.
const MOST_QUERIES: usize = 1 << 20;

/// Where maps are looked up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandwidthQuery {
    /// Unit vector to the light.
    pub incoming: [f32; 3],
    /// Unit vector to the viewer.
    pub outgoing: [f32; 3],
    /// Direction of the environment.
    pub direction: [f32; 3],
    /// Point of the texture.
    pub uv: [f32; 2],
}

/// The layout of group 1.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> BindGroupLayout {
    let texture = |binding| {
        let sample_type = TextureSampleType::Float { filterable: true };
        let view_dimension = TextureViewDimension::D2;
        entry(binding, stages, BindingType::Texture { sample_type, view_dimension, multisampled: false })
    };
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("bandwidth"),
        entries: &[entry(0, stages, buffer_type(BufferBindingType::Uniform)), texture(1), texture(2), texture(3)],
    })
}

/// Uploads up to one map of each kind.
pub(super) fn upload(gpu: &Gpu, layout: &BindGroupLayout, maps: &[BandwidthMap]) -> Result<BindGroup, GpuError> {
    let texture = |is: fn(BandwidthKind) -> bool| {
        let map = maps.iter().rev().find(|map| is(map.header().kind));
        let (size, bytes) = map.map_or(([1, 1], vec![0; 2]), |map| (map.size(), map.texel_bytes()));
        gpu.image(texture_format(TexelFormat::R16Float), size, &bytes)
    };
    let views = [
        texture(|kind| kind == BandwidthKind::Brdf),
        texture(|kind| kind == BandwidthKind::Environment),
        texture(|kind| matches!(kind, BandwidthKind::Texture { .. })),
    ];
    let parameters = gpu.buffer(&BandwidthParameters::new(maps).to_bytes(), BufferUsages::UNIFORM);
    let view = |k: usize| BindGroupEntry { binding: k as u32 + 1, resource: BindingResource::TextureView(&views[k]) };
    let group = gpu.device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout,
        entries: &[BindGroupEntry { binding: 0, resource: parameters.as_entire_binding() }, view(0), view(1), view(2)],
    });
    gpu.check()?;
    Ok(group)
}

/// A compiled compute pipeline.
pub struct BandwidthEvaluator<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    query_layout: BindGroupLayout,
    map_layout: BindGroupLayout,
}

impl<'g> BandwidthEvaluator<'g> {
    /// Compiles the shipped shader.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shader(gpu, BANDWIDTH_WGSL)
    }

    /// Compiles other look-ups, such as broken ones.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shader(gpu: &'g Gpu, lookups: &str) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("bandwidth"),
            source: ShaderSource::Wgsl(Cow::Owned(format!("{lookups}\n{EVALUATE_BANDWIDTH_WGSL}"))),
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
        let map_layout = layout(gpu, ShaderStages::COMPUTE);
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&query_layout), Some(&map_layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some("bandwidth"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("evaluate"),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline, query_layout, map_layout })
    }

    /// `[brdf, environment, texture]` of each query, in up to one map of each kind; 0 of absent ones.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn eval(&self, maps: &[BandwidthMap], queries: &[BandwidthQuery]) -> Result<Vec<[f32; 3]>, GpuError> {
        let maps = upload(self.gpu, &self.map_layout, maps)?;
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MOST_QUERIES) {
            let words: Vec<[f32; 16]> = chunk.iter().map(query_words).collect();
            let evaluation = [chunk.len() as u32, GROUP * ROW_OF_GROUPS, 0, 0];
            let evaluation = self.gpu.buffer(bytemuck::cast_slice(&evaluation), BufferUsages::UNIFORM);
            let input = self.gpu.buffer(bytemuck::cast_slice(words.as_flattened()), BufferUsages::STORAGE);
            let answers = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 16 * chunk.len() as u64,
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
            pass.set_bind_group(1, &maps, &[]);
            pass.dispatch_workgroups(groups.min(ROW_OF_GROUPS), groups.div_ceil(ROW_OF_GROUPS), 1);
            drop(pass);
            let buffer = self.gpu.read_buffer(answers.size());
            encoder.copy_buffer_to_buffer(&answers, 0, &buffer, 0, answers.size());
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.read(&buffer, |bytes| {
                let words: &[f32] = bytemuck::cast_slice(bytes);
                all.extend(words.chunks_exact(4).map(|w| [w[0], w[1], w[2]]));
            })?;
        }
        Ok(all)
    }
}

fn query_words(query: &BandwidthQuery) -> [f32; 16] {
    let mut words = [0.0; 16];
    words[..3].copy_from_slice(&query.incoming);
    words[4..7].copy_from_slice(&query.outgoing);
    words[8..11].copy_from_slice(&query.direction);
    words[12..14].copy_from_slice(&query.uv);
    words
}
