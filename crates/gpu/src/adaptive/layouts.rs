//! Layouts of the bind groups that the steps read and write.

use super::super::bindings::{self, UNFILTERED, UNIFORM, buffer_type};
use super::super::device::Gpu;
use super::super::pack;
use wgpu::{BindGroupLayout, BufferBindingType, ShaderStages};

/// Buffers of a G-buffer that the steps write.
pub(super) const STORAGE_BUFFERS: u32 = 8;

/// Groups 0 to 3 of `points.wgsl`, in their order.
pub(super) struct Layouts {
    pub(super) frame: BindGroupLayout,
    pub(super) storage: BindGroupLayout,
    pub(super) pack: BindGroupLayout,
    pub(super) material: BindGroupLayout,
}

impl Layouts {
    /// Makes them.
    pub(super) fn new(gpu: &Gpu) -> Self {
        let group = |label, types: &[wgpu::BindingType]| {
            bindings::layout(gpu, label, ShaderStages::COMPUTE, (0..).zip(types.iter().copied()))
        };
        let storage = buffer_type(BufferBindingType::Storage { read_only: false });
        let (uniform, image) = (UNIFORM, UNFILTERED);
        let frame = group("frame", &[uniform, uniform, uniform, image, image, image]);
        let written = group("storage", &[storage; STORAGE_BUFFERS as usize]);
        let pack = pack::layout(gpu, ShaderStages::COMPUTE);
        let material = group("material", &[uniform, image, uniform, image, image, image, image, image]);
        Self { frame, storage: written, pack, material }
    }
}
