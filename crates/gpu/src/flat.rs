//! Draws scenes whose parts are all of one flat BTF.

use super::device::{Gpu, GpuError};
use super::flat_textures;
use super::raster::{draw_with_one_material, view_wgsl};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_metrics::image::LinearImage;
use brdfc_render::flat::{FlatForm, FlatMaterial};
use brdfc_render::scene::{Frame, Scene};
use wgpu::ShaderStages;

/// The whole shader: decoders, scene.
pub fn flat_scene_source() -> String {
    [&flat_btf_value_wgsl(), &view_wgsl(), include_str!("flat_scene.wgsl")].join("\n")
}

/// Draws a scene whose parts are all of one flat BTF, by the shader with exact filters.
///
/// # Errors
/// [`GpuError::TooLarge`] where the adapter cannot hold the material or the image; what the driver reports.
///
/// # Panics
/// For the full form of a material without values of views: see [`FlatMaterial::has_views`].
pub fn draw_flat_btf(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    material: &FlatMaterial,
    form: FlatForm,
) -> Result<LinearImage, GpuError> {
    draw_flat_btf_by(gpu, flat_scene_source(), scene, frame, material, form)
}

/// [`draw_flat_btf`] by another shader than [`flat_scene_source`], such as a broken one. Values of views go along only for the
/// full form.
///
/// # Errors
/// As there; a source that does not validate, with the compiler's message.
///
/// # Panics
/// As there.
pub fn draw_flat_btf_by(
    gpu: &Gpu,
    source: String,
    scene: &Scene,
    frame: Frame,
    material: &FlatMaterial,
    form: FlatForm,
) -> Result<LinearImage, GpuError> {
    let full = form == FlatForm::Full;
    let directions = full.then(|| material.sampled_directions());
    let slots = flat_textures::slots(gpu, ShaderStages::FRAGMENT);
    let textures = flat_textures::upload(gpu, &slots, material.decoder(), FrameBlock::exact(), full, directions)?;
    let finer = (frame.samples as f32).log2();
    let words = [material.repeat(), u32::from(full), finer.to_bits(), 0];
    draw_with_one_material(gpu, source, scene, frame, (&slots.layout, textures), words)
}
