//! Layouts of the bind groups that the steps read and write.

use super::super::bindings::{self, Slots, UNFILTERED, UNIFORM, buffer_type};
use super::super::device::Gpu;
use super::super::pack;
use wgpu::{BindGroupLayout, BufferBindingType, ShaderStages};

/// Number of G-buffer buffers that the steps write.
pub(super) const STORAGE_BUFFERS: u32 = 8;

/// Bindings for importance samples and bandwidth maps, after the bindings of the pack decoders.
const LOOKUPS: [(u32, wgpu::BindingType); 8] = [
    (29, UNIFORM),
    (30, UNFILTERED),
    (31, UNIFORM),
    (32, UNFILTERED),
    (33, UNIFORM),
    (34, UNFILTERED),
    (35, UNIFORM),
    (36, UNFILTERED),
];

/// Groups 0 to 2, in order, without gaps.
pub(super) struct Layouts {
    pub(super) points: BindGroupLayout,
    pub(super) packs: Slots,
    pub(super) surroundings: BindGroupLayout,
}

impl Layouts {
    /// Creates the layouts.
    pub(super) fn new(gpu: &Gpu) -> Self {
        let group = |label, types: &[wgpu::BindingType]| {
            bindings::layout(gpu, label, ShaderStages::COMPUTE, (0..).zip(types.iter().copied()))
        };
        let storage = buffer_type(BufferBindingType::Storage { read_only: false });
        let (uniform, image) = (UNIFORM, UNFILTERED);
        let seen = [uniform, uniform, uniform, image, image, image];
        let points = group("points", &[&seen[..], &[storage; STORAGE_BUFFERS as usize]].concat());
        let packs = Slots::new(gpu, "packs", ShaderStages::COMPUTE, pack::slot_types().into_iter().chain(LOOKUPS));
        let surroundings = group("surroundings", &[image; 3]);
        Self { points, packs, surroundings }
    }
}
