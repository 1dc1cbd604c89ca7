//! Packs evaluated at direction pairs by the shader: what tests hold against the CPU decoder, and what throughput is
//! measured on.

use super::device::{Gpu, GpuError};
use super::pack;
use brdfc_formats::BrdfPack;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use std::borrow::Cow;
use wgpu::util::DeviceExt;
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BindingType,
    BufferBindingType, BufferUsages, ComputePassDescriptor, ComputePipelineDescriptor, PipelineLayoutDescriptor,
    ShaderModuleDescriptor, ShaderSource, ShaderStages,
};

/// The compute entry point over the decoder.
pub const EVALUATE_WGSL: &str = concat!(include_str!("evaluate_wavelet.wgsl"), include_str!("evaluate.wgsl"));

/// The same over the decoder of table packs.
pub const EVALUATE_TABLE_WGSL: &str = concat!(include_str!("evaluate_table.wgsl"), include_str!("evaluate.wgsl"));

/// The entry point alone, for a decoder that has the functions that it calls.
pub const EVALUATE_ENTRY_WGSL: &str = include_str!("evaluate.wgsl");

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups of a row; more go to the next row.
const ROW_OF_GROUPS: u32 = 1024;
/// Most pairs at once: 32 bytes each in two buffers, within what every adapter binds.
const MOST_PAIRS: usize = 1 << 21;

/// Who filters slices over the outer direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SliceFilter {
    /// The texture unit, as engines do: weights of few bits.
    Hardware,
    /// The shader, with exact weights: the same bits as the CPU decoder where arithmetic is correctly rounded.
    Exact,
}

/// What the shader returns for a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluated {
    /// `ln(f / μ + ε)`; 0 where a direction is not above the horizon.
    pub log_value: [f32; 3],
    /// `f_r`, 1/sr.
    pub f_r: [f32; 3],
    /// What the function `fetches` of the entry point returns: 0 unless the source was instrumented.
    pub fetches: f32,
}

/// A pack on the device, with the filter that it is evaluated with.
pub struct LoadedPack {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct Evaluator<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    pairs_layout: wgpu::BindGroupLayout,
    pack_layout: wgpu::BindGroupLayout,
}

/// Pairs on the device, ready for any number of runs.
pub struct LoadedPairs {
    group: wgpu::BindGroup,
    values: wgpu::Buffer,
    count: usize,
}

impl<'g> Evaluator<'g> {
    /// Compiles the shipped shader of wavelet packs.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, WAVELET_BRDF_WGSL, EVALUATE_WGSL)
    }

    /// Compiles the shipped shader of table packs.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn of_tables(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, &pack::table_source(1), EVALUATE_TABLE_WGSL)
    }

    /// Compiles other sources, such as instrumented ones. `entry` is pasted behind `decoder`.
    ///
    /// # Errors
    /// Sources that do not validate, with the compiler's message.
    pub fn with_shaders(gpu: &'g Gpu, decoder: &str, entry: &str) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("evaluate"),
            source: ShaderSource::Wgsl(Cow::Owned(format!("{decoder}\n{entry}"))),
        });
        gpu.check()?;
        let buffer = |binding, ty| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::COMPUTE,
            ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let pairs_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("pairs"),
            entries: &[
                buffer(0, BufferBindingType::Uniform),
                buffer(1, BufferBindingType::Storage { read_only: true }),
                buffer(2, BufferBindingType::Storage { read_only: false }),
            ],
        });
        let pack_layout = pack::layout(gpu, ShaderStages::COMPUTE);
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&pairs_layout), Some(&pack_layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some("evaluate"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("evaluate"),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline, pairs_layout, pack_layout })
    }

    /// Uploads a pack of the codec whose shader was compiled. `filter` is that of wavelet packs.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn load(&self, pack: &BrdfPack, filter: Filter) -> Result<LoadedPack, GpuError> {
        let group = pack::upload(self.gpu, &self.pack_layout, pack, filter, DEFAULT_DISTANCE_SCALE)?;
        Ok(LoadedPack { group })
    }

    /// Uploads at most 2 million pairs, with the level of detail and the way that slices are filtered. A negative level
    /// is minus the distance from which the shader finds the level.
    ///
    /// # Errors
    /// Too many pairs; what the driver reports.
    pub fn load_pairs(
        &self,
        pairs: &[DirectionPair],
        level: f32,
        slices: SliceFilter,
    ) -> Result<LoadedPairs, GpuError> {
        if pairs.len() > MOST_PAIRS {
            return Err(GpuError::TooLarge(format!("{} direction pairs at once; at most {MOST_PAIRS}", pairs.len())));
        }
        let mut words: Vec<f32> = Vec::with_capacity(8 * pairs.len().max(1));
        for pair in pairs {
            for direction in [pair.incoming, pair.outgoing] {
                words.extend(direction.map(|c| c as f32));
                words.push(0.0);
            }
        }
        words.resize(words.len().max(8), 0.0);
        let device = &self.gpu.device;
        let init = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let hardware = u32::from(slices == SliceFilter::Hardware);
        let evaluation = [level.to_bits(), hardware, pairs.len() as u32, GROUP * ROW_OF_GROUPS];
        let evaluation = init(bytemuck::cast_slice(&evaluation), BufferUsages::UNIFORM);
        let input = init(bytemuck::cast_slice(&words), BufferUsages::STORAGE);
        let values = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * words.len() as u64,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let group = device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.pairs_layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: evaluation.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: input.as_entire_binding() },
                BindGroupEntry { binding: 2, resource: values.as_entire_binding() },
            ],
        });
        self.gpu.check()?;
        Ok(LoadedPairs { group, values, count: pairs.len() })
    }

    /// Evaluates once and waits for it, without reading back.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn run(&self, pack: &LoadedPack, pairs: &LoadedPairs) -> Result<(), GpuError> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let groups = (pairs.count as u32).div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &pairs.group, &[]);
        pass.set_bind_group(1, &pack.group, &[]);
        pass.dispatch_workgroups(groups.min(ROW_OF_GROUPS), groups.div_ceil(ROW_OF_GROUPS), 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    /// Evaluates and reads back, in the order of `pairs`. `level` as in [`Self::load_pairs`].
    ///
    /// # Errors
    /// What the driver reports.
    pub fn eval(
        &self,
        pack: &LoadedPack,
        pairs: &[DirectionPair],
        level: f32,
        slices: SliceFilter,
    ) -> Result<Vec<Evaluated>, GpuError> {
        let mut all = Vec::with_capacity(pairs.len());
        for chunk in pairs.chunks(MOST_PAIRS) {
            let loaded = self.load_pairs(chunk, level, slices)?;
            self.run(pack, &loaded)?;
            let buffer = self.gpu.read_buffer(loaded.values.size());
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&loaded.values, 0, &buffer, 0, loaded.values.size());
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.read(&buffer, |bytes| {
                let words: &[f32] = bytemuck::cast_slice(bytes);
                all.extend(words.chunks_exact(8).take(chunk.len()).map(|w| Evaluated {
                    log_value: [w[0], w[1], w[2]],
                    f_r: [w[4], w[5], w[6]],
                    fetches: w[3],
                }));
            })?;
        }
        Ok(all)
    }
}
