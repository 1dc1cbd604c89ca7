//! Any WGSL function over a list of numbers, for comparison with its CPU twin.

use super::items::ItemPipeline;
use brdfc_formats::bindings::{Binding, FrameBlock};
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError};
use wgpu::{BindGroup, ShaderStages};

/// The compute entry point: it calls `fn compute(at: u32)`, which reads `input` and writes `output`.
pub const COMPUTE_WGSL: &str = concat!(include_str!("compute.wgsl"), include_str!("items.wgsl"));

/// Maximum number of numbers in or out at once, within the limits of every adapter.
const MAX_NUMBERS: usize = 1 << 24;

/// A compiled shader with its resources.
pub struct Compute<'g> {
    pipeline: ItemPipeline<'g>,
    bound: BindGroup,
}

impl<'g> Compute<'g> {
    /// Compiles `source`, which defines `compute(at: u32)`, followed by [`COMPUTE_WGSL`], and uploads the bindings of
    /// its group 1.
    ///
    /// # Errors
    /// Returns an error if the source does not validate, with the compiler's message, or if textures do not fit.
    pub fn new(gpu: &'g Gpu, source: &str, bindings: &[Binding<'_>], frame: FrameBlock) -> Result<Self, GpuError> {
        let slots = Slots::of(gpu, "bindings", ShaderStages::COMPUTE, bindings);
        let bound = slots.bind(gpu, bindings, frame)?;
        let pipeline = ItemPipeline::new(gpu, "compute", format!("{source}\n{COMPUTE_WGSL}"), &slots.layout)?;
        Ok(Self { pipeline, bound })
    }

    /// Runs over `count` items and reads back. Each item has `width` numbers of `input` and `width_out` numbers of the
    /// output.
    ///
    /// # Errors
    /// Returns an error for an input of another length or too many numbers; any error that the driver reports.
    pub fn run(&self, input: &[f32], width: usize, width_out: usize) -> Result<Vec<f32>, GpuError> {
        let count = input.len() / width.max(1);
        let numbers = count.saturating_mul(width_out.max(width));
        if count * width != input.len() || numbers > MAX_NUMBERS {
            let found = input.len();
            let text =
                format!("found {found} numbers in items of {width} and {width_out}, expected at most {MAX_NUMBERS}");
            return Err(GpuError::TooLarge(text));
        }
        if count * width_out == 0 {
            return Ok(Vec::new());
        }
        let items = self.pipeline.load(input, count, 4 * width_out, [0; 2])?;
        self.pipeline.answers(&items, &self.bound)
    }
}
