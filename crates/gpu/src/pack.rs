//! Packs on the device: one bind group for either codec, so that one shader draws both. What the codec of a pack does not use is
//! zero.

use super::bindings::{IMAGE, SAMPLER, Slots, UNFILTERED, UNIFORM, VOLUME};
use super::device::Gpu;
use brdfc_formats::bindings::{FRAME_SLOT, combined_wgsl};
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use wgpu::{BindingType, ShaderStages};

/// Chooses the decoder of a pack, behind both.
const BRDF_WGSL: &str = include_str!("brdf.wgsl");

/// Both decoders and what chooses between them.
pub(super) fn brdf_source() -> String {
    combined_wgsl([WAVELET_BRDF_WGSL, TABLE_BRDF_WGSL, BRDF_WGSL])
}

/// What both decoders have bound in group 1.
pub(super) const SLOTS: [(u32, BindingType); 9] = [
    (FRAME_SLOT, UNIFORM),
    (1, UNIFORM),
    (2, VOLUME),
    (3, SAMPLER),
    (4, IMAGE),
    (5, UNIFORM),
    (6, VOLUME),
    (7, UNFILTERED),
    (8, SAMPLER),
];

/// The layout of group 1.
pub(super) fn slots(gpu: &Gpu, stages: ShaderStages) -> Slots {
    Slots::new(gpu, "pack", stages, SLOTS)
}
