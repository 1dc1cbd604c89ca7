//! Draws scenes whose parts are all of one polynomial wavelet tree.

use super::device::{Gpu, GpuError};
use super::pwt_textures;
use super::raster::{draw_with_one_material, view_wgsl};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_metrics::image::LinearImage;
use brdfc_render::pwt::PwtMaterial;
use brdfc_render::scene::{Frame, Scene};
use wgpu::ShaderStages;

/// The whole shader: decoder and scene.
pub fn pwt_scene_source() -> String {
    [PWT_WGSL, &view_wgsl(), include_str!("pwt_scene.wgsl")].join("\n")
}

/// Draws a scene whose parts are all of one pack. Mipmap levels follow from how uv changes between pixels.
///
/// # Errors
/// [`GpuError::TooLarge`] where the adapter cannot hold the pack or the image; what the driver reports.
pub fn draw_pwt(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    material: &PwtMaterial,
    sampling: FrameBlock,
) -> Result<LinearImage, GpuError> {
    draw_pwt_by(gpu, pwt_scene_source(), scene, frame, material, sampling)
}

/// [`draw_pwt`] by another shader than [`pwt_scene_source`], such as a broken one.
///
/// # Errors
/// As there; a source that does not validate, with the compiler's message.
pub fn draw_pwt_by(
    gpu: &Gpu,
    source: String,
    scene: &Scene,
    frame: Frame,
    material: &PwtMaterial,
    sampling: FrameBlock,
) -> Result<LinearImage, GpuError> {
    let slots = pwt_textures::slots(gpu, ShaderStages::FRAGMENT);
    let textures = pwt_textures::upload(gpu, &slots, material.decoder().pack(), sampling)?;
    draw_with_one_material(gpu, source, scene, frame, (&slots.layout, textures), [material.repeat(), 0, 0, 0])
}
