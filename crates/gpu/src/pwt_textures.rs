//! Polynomial wavelet trees on the device: the bind group that `formats/src/pwt/pwt.wgsl` declares.

use super::bindings::{self, LAYERS, SAMPLER, UNIFORM};
use super::device::{Gpu, GpuError};
use brdfc_formats::pwt::shader::PwtFilter;
use brdfc_formats::pwt::{MAX_TEXTURES, PwtPack};
use brdfc_shaders::resources;
use wgpu::{BindGroup, BindGroupLayout, ShaderStages};

/// The layout of group 1: the sampler is behind the last texture.
pub(super) fn layout(gpu: &Gpu, stages: ShaderStages) -> BindGroupLayout {
    let types = [UNIFORM].into_iter().chain([LAYERS; MAX_TEXTURES]).chain([SAMPLER]);
    bindings::layout(gpu, "polynomial wavelet tree", stages, (0..).zip(types))
}

/// Uploads a pack with all of its mipmap levels; textures that it has not are one empty texel.
///
/// # Errors
/// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    pack: &PwtPack,
    filter: PwtFilter,
) -> Result<BindGroup, GpuError> {
    let (extent, most) = (pack.header().extent, gpu.device.limits().max_texture_dimension_2d);
    let side = extent[0].max(extent[1]);
    if side > most {
        return Err(GpuError::TooLarge(format!("a picture of {side} texels on a side; this adapter takes {most}")));
    }
    bindings::bind(gpu, layout, resources::pwt(pack, filter), &[])
}
