//! Layouts of the bind groups that the steps read and write.

use super::super::compute::UNFILTERED;
use super::super::device::Gpu;
use super::super::pack;
use super::super::raster::{buffer_type, entry};
use wgpu::{BindGroupLayout, BindGroupLayoutDescriptor, BufferBindingType, ShaderStages};

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
            let entries: Vec<_> =
                (0..).zip(types).map(|(binding, ty)| entry(binding, ShaderStages::COMPUTE, *ty)).collect();
            gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let uniform = buffer_type(BufferBindingType::Uniform);
        let storage = buffer_type(BufferBindingType::Storage { read_only: false });
        let image = UNFILTERED;
        let frame = group("frame", &[uniform, uniform, uniform, image, image, image]);
        let written = group("storage", &[storage; STORAGE_BUFFERS as usize]);
        let pack = pack::layout(gpu, ShaderStages::COMPUTE);
        let material = group("material", &[uniform, image, uniform, image, image, image, image, image]);
        Self { frame, storage: written, pack, material }
    }
}
