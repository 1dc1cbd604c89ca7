//! Polynomial wavelet trees on the device: the bindings of `formats/src/pwt/pwt.wgsl`.

use super::bindings::{INTEGERS, LAYERS, SAMPLER, Slots, UNIFORM};
use super::device::{Gpu, GpuError};
use brdfc_formats::bindings::{FRAME_SLOT, FrameBlock};
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::pwt::shader::TEXTURE_SLOTS;
use wgpu::{BindGroup, ShaderStages};

/// Layout of group 1.
pub fn slots(gpu: &Gpu, stages: ShaderStages) -> Slots {
    let textures = TEXTURE_SLOTS.map(|slot| (slot, LAYERS));
    let others = [(FRAME_SLOT, UNIFORM), (9, UNIFORM), (14, SAMPLER), (28, INTEGERS), (43, LAYERS), (44, SAMPLER)];
    Slots::new(gpu, "polynomial wavelet tree", stages, textures.into_iter().chain(others))
}

/// Uploads a pack with all of its mipmap levels. Missing textures are one empty texel.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more than the adapter takes; any error that the driver reports.
pub fn upload(gpu: &Gpu, slots: &Slots, pack: &PwtPack, frame: FrameBlock) -> Result<BindGroup, GpuError> {
    let (extent, most) = (pack.header().extent, gpu.device.limits().max_texture_dimension_2d);
    let side = extent[0].max(extent[1]);
    if side > most {
        return Err(GpuError::TooLarge(format!(
            "found {side} texels per side, expected at most {most} on this adapter"
        )));
    }
    slots.bind(gpu, &pack.bindings().all, frame)
}
