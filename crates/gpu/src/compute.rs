//! Any WGSL function over a list of numbers: what tests hold against its CPU twin.

use super::bindings;
use super::device::{Gpu, GpuError};
use super::items::ItemPipeline;
use brdfc_shaders::resources::Resource;
use wgpu::{BindGroup, ShaderStages};

/// The compute entry point: it calls `fn compute(at: u32)`, which reads `input` and writes `output`.
pub const COMPUTE_WGSL: &str = concat!(include_str!("compute.wgsl"), include_str!("items.wgsl"));

/// Most numbers in or out at once, within what every adapter binds.
const MOST_NUMBERS: usize = 1 << 24;

/// A compiled shader with its resources.
pub struct Compute<'g> {
    pipeline: ItemPipeline<'g>,
    resources: BindGroup,
}

impl<'g> Compute<'g> {
    /// Compiles `source`, which defines `compute(at: u32)`, in front of [`COMPUTE_WGSL`], and uploads the resources of its
    /// group 1.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message; resources that do not fit.
    pub fn new(gpu: &'g Gpu, source: &str, resources: Vec<Resource>) -> Result<Self, GpuError> {
        let types = resources.iter().map(|resource| (resource.binding, bindings::type_of(&resource.contents)));
        let layout = bindings::layout(gpu, "resources", ShaderStages::COMPUTE, types);
        let resources = bindings::bind(gpu, &layout, resources, &[])?;
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
