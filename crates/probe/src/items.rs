//! Compute shaders over a list of items, one per invocation, which evaluate packs or any function of numbers.

use brdfc_gpu::bindings::{self, UNIFORM, buffer_type};
use brdfc_gpu::{Gpu, GpuError};
use std::borrow::Cow;
use wgpu::{
    BindGroup, BindGroupLayout, BufferBindingType, BufferUsages, CommandEncoder, ComputePassDescriptor,
    ComputePipelineDescriptor, PipelineLayoutDescriptor, ShaderModuleDescriptor, ShaderSource, ShaderStages,
};

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups per row of a dispatch; further groups go to the next row.
const ROW_OF_GROUPS: u32 = 1024;
/// Padding for an empty list, since no binding may be empty: at least as many bytes as the largest item.
const NO_ITEMS: [u8; 256] = [0; 256];

/// A compiled shader.
pub(super) struct ItemPipeline<'g> {
    gpu: &'g Gpu,
    pipeline: wgpu::ComputePipeline,
    item_layout: BindGroupLayout,
}

/// Items on the device with room for their answers, ready for any number of runs.
pub(super) struct Items {
    group: BindGroup,
    answers: wgpu::Buffer,
    count: usize,
}

impl<'g> ItemPipeline<'g> {
    /// Compiles a source that ends with `items.wgsl`. `resources` is the layout of its group 1.
    ///
    /// # Errors
    /// Returns an error if the source does not validate, with the compiler's message, which contains the label.
    pub(super) fn new(
        gpu: &'g Gpu,
        label: &str,
        source: String,
        resources: &BindGroupLayout,
    ) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some(label),
            source: ShaderSource::Wgsl(Cow::Owned(source)),
        });
        gpu.check()?;
        let storage = |read_only| buffer_type(BufferBindingType::Storage { read_only });
        let types = [(0, UNIFORM), (1, storage(true)), (2, storage(false))];
        let item_layout = bindings::layout(gpu, "items", ShaderStages::COMPUTE, types);
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&item_layout), Some(resources)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some(label),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        gpu.check()?;
        Ok(Self { gpu, pipeline, item_layout })
    }

    /// Device that the shader was compiled for.
    pub(super) fn gpu(&self) -> &'g Gpu {
        self.gpu
    }

    /// Uploads items as the shader declares them, with two words that all of them share. An answer has `answer_bytes`.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn load<T: bytemuck::Pod>(
        &self,
        items: &[T],
        count: usize,
        answer_bytes: usize,
        parameters: [u32; 2],
    ) -> Result<Items, GpuError> {
        let computation = [count as u32, GROUP * ROW_OF_GROUPS, parameters[0], parameters[1]];
        let computation = self.gpu.buffer(bytemuck::cast_slice(&computation), BufferUsages::UNIFORM);
        let contents: &[u8] = if count == 0 { &NO_ITEMS } else { bytemuck::cast_slice(items) };
        let items = self.gpu.buffer(contents, BufferUsages::STORAGE);
        let answers = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: (count.max(1) * answer_bytes) as u64,
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let buffers = [&computation, &items, &answers].map(wgpu::Buffer::as_entire_binding);
        let group = bindings::group(self.gpu, &self.item_layout, (0..).zip(buffers));
        self.gpu.check()?;
        Ok(Items { group, answers, count })
    }

    /// Runs once and waits until it is done, without reading back.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn run(&self, items: &Items, resources: &BindGroup) -> Result<(), GpuError> {
        self.gpu.queue.submit([self.pass(items, resources).finish()]);
        self.gpu.wait()
    }

    /// Runs once and reads back all answers, in the order of the items.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn answers<A: bytemuck::Pod>(&self, items: &Items, resources: &BindGroup) -> Result<Vec<A>, GpuError> {
        if items.count == 0 {
            return Ok(Vec::new());
        }
        let mut encoder = self.pass(items, resources);
        let buffer = self.gpu.read_buffer(items.answers.size());
        encoder.copy_buffer_to_buffer(&items.answers, 0, &buffer, 0, items.answers.size());
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.read(&buffer, bytemuck::pod_collect_to_vec)
    }

    fn pass(&self, items: &Items, resources: &BindGroup) -> CommandEncoder {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let groups = (items.count as u32).div_ceil(GROUP);
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &items.group, &[]);
        pass.set_bind_group(1, resources, &[]);
        pass.dispatch_workgroups(groups.min(ROW_OF_GROUPS), groups.div_ceil(ROW_OF_GROUPS), 1);
        drop(pass);
        encoder
    }
}
