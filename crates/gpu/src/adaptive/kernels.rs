//! Compute pipelines of the steps, and their dispatch.

use super::super::device::{Gpu, GpuError};
use super::layouts::Layouts;
use super::material::{self, LoadedMaterial};
use super::storage::{JOB_WORDS, LoadedGBuffer};
use std::borrow::Cow;
use wgpu::{
    BindGroupLayout, ComputePassDescriptor, ComputePipeline, ComputePipelineDescriptor, PipelineLayoutDescriptor,
    ShaderModuleDescriptor, ShaderSource,
};

/// Invocations of a workgroup.
const GROUP: u32 = 64;
/// Workgroups per row of a dispatch; further groups go to the next row.
const ROW_OF_GROUPS: u32 = 1024;

/// The compiled steps.
pub(super) struct Kernels<'g> {
    pub(super) gpu: &'g Gpu,
    pub(super) layouts: Layouts,
    pub(super) read_back: ComputePipeline,
    pub(super) curvatures: ComputePipeline,
    pub(super) predict: ComputePipeline,
    pub(super) deviations: ComputePipeline,
    pub(super) rates: ComputePipeline,
    pub(super) even: ComputePipeline,
    pub(super) merge: ComputePipeline,
    pub(super) decide: ComputePipeline,
    pub(super) shade: ComputePipeline,
    pub(super) gather: ComputePipeline,
    pub(super) resolve: ComputePipeline,
}

/// Range that a step runs over.
#[derive(Debug, Clone, Copy)]
pub(super) struct Job {
    /// Number of items, from the first.
    pub(super) count: usize,
    /// Level of the pyramid, for steps that depend on it.
    pub(super) level: u32,
    /// Maximum number of items per submission, so that drivers do not take it for a hang.
    pub(super) at_once: usize,
}

impl Job {
    /// A job over `count` items in one submission.
    pub(super) fn over(count: usize) -> Self {
        Self { count, level: 0, at_once: usize::MAX }
    }
}

impl<'g> Kernels<'g> {
    /// Compiles the steps.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if the source does not validate.
    pub(super) fn new(gpu: &'g Gpu, source: &str) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("adaptive shading"),
            source: ShaderSource::Wgsl(Cow::Borrowed(source)),
        });
        gpu.check()?;
        let layouts = Layouts::new(gpu);
        let layout = |groups: &[Option<&BindGroupLayout>]| {
            gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let Layouts { points, packs, surroundings } = &layouts;
        let of_points = layout(&[Some(points)]);
        let of_materials = layout(&[Some(points), Some(&packs.layout), Some(surroundings)]);
        let pipeline = |layout, name| {
            gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
                label: Some(name),
                layout: Some(layout),
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        let kernels = Self {
            gpu,
            read_back: pipeline(&of_points, "read_back"),
            curvatures: pipeline(&of_points, "curvatures"),
            predict: pipeline(&of_materials, "predict"),
            deviations: pipeline(&of_points, "deviations"),
            rates: pipeline(&of_points, "rates"),
            even: pipeline(&of_points, "even"),
            merge: pipeline(&of_points, "merge"),
            decide: pipeline(&of_points, "decide"),
            shade: pipeline(&of_materials, "shade"),
            gather: pipeline(&of_points, "gather"),
            resolve: pipeline(&of_points, "resolve"),
            layouts,
        };
        gpu.check()?;
        Ok(kernels)
    }

    /// Runs a step. Steps that read materials need `material`.
    pub(super) fn run(&self, step: &ComputePipeline, on: &LoadedGBuffer, material: Option<&LoadedMaterial>, job: Job) {
        for first in (0..job.count).step_by(job.at_once.max(1)) {
            self.run_part(step, on, material, [first, job.at_once.min(job.count - first)], job.level);
        }
    }

    /// Runs a step over the items `[first, count]` in one submission.
    pub(super) fn run_part(
        &self,
        step: &ComputePipeline,
        on: &LoadedGBuffer,
        material: Option<&LoadedMaterial>,
        [first, count]: [usize; 2],
        level: u32,
    ) {
        let of_material = material.map_or([0; material::WORDS], |material| material.words);
        let mut words = [0; JOB_WORDS];
        words[..4].copy_from_slice(&[first as u32, count as u32, GROUP * ROW_OF_GROUPS, level]);
        words[4..].copy_from_slice(&of_material);
        self.gpu.queue.write_buffer(&on.job, 0, bytemuck::cast_slice(&words));
        let groups = (count as u32).div_ceil(GROUP);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(step);
        pass.set_bind_group(0, &on.group, &[]);
        if let Some(material) = material {
            pass.set_bind_group(1, &material.packs, &[]);
            pass.set_bind_group(2, &material.surroundings, &[]);
        }
        pass.dispatch_workgroups(groups.min(ROW_OF_GROUPS), groups.div_ceil(ROW_OF_GROUPS), 1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
    }
}
