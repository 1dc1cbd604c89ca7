//! Drawing of scenes whose parts all use one polynomial wavelet tree.

use super::device::{Gpu, GpuError};
use super::pwt_textures;
use super::raster::{draw_with_one_material, view_wgsl};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_metrics::image::LinearImage;
use brdfc_render::pwt::PwtMaterial;
use brdfc_render::scene::{Frame, Scene};
use wgpu::ShaderStages;

/// The complete shader: decoder and scene.
pub fn pwt_scene_source() -> String {
    [PWT_WGSL, &view_wgsl(), include_str!("pwt_scene.wgsl")].join("\n")
}

/// Draws a scene whose parts all use one pack. Mipmap levels follow from the change of uv between pixels.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] if the adapter cannot hold the pack or the image; any error that the driver reports.
pub fn draw_pwt(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    material: &PwtMaterial,
    sampling: FrameBlock,
) -> Result<LinearImage, GpuError> {
    draw_pwt_by(gpu, pwt_scene_source(), scene, frame, material, sampling)
}

/// Draws like [`draw_pwt`] with another shader than [`pwt_scene_source`], such as a deliberately broken one.
///
/// # Errors
/// Returns the errors of [`draw_pwt`]; an error if the source does not validate.
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
