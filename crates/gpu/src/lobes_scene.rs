//! Drawing of scenes that a prefiltered environment lights, by the lobes of one material.

use super::bindings::Slots;
use super::device::{Gpu, GpuError};
use super::load::load;
use super::raster::{Rasteriser, view_wgsl};
use super::surface::{self, PERIODIC_WGSL, SURFACE_WGSL};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::environment::ENVIRONMENT_WGSL;
use brdfc_formats::lobes::LOBES_WGSL;
use brdfc_metrics::image::LinearImage;
use brdfc_render::lobes::LobesMaterial;
use brdfc_render::scene::{Environment, Frame, Scene};
use wgpu::ShaderStages;

/// The complete shader: decoders, surfaces, scene.
pub fn lobes_scene_source() -> String {
    let scene = include_str!("lobes_scene.wgsl");
    [ENVIRONMENT_WGSL, LOBES_WGSL, &view_wgsl(), PERIODIC_WGSL, SURFACE_WGSL, scene].join("\n")
}

/// Draws a scene whose parts all have one material.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] if the adapter cannot hold the environment or the image; any error that the driver
/// reports.
pub fn draw_lobes(gpu: &Gpu, scene: &Scene, frame: Frame, material: &LobesMaterial) -> Result<LinearImage, GpuError> {
    draw_lobes_by(gpu, lobes_scene_source(), scene, frame, material)
}

/// Draws like [`draw_lobes`] with another shader than [`lobes_scene_source`], such as a deliberately broken one.
///
/// # Errors
/// Returns the errors of [`draw_lobes`]; an error if the source does not validate.
pub fn draw_lobes_by(
    gpu: &Gpu,
    source: String,
    scene: &Scene,
    frame: Frame,
    material: &LobesMaterial,
) -> Result<LinearImage, GpuError> {
    let (environment, lobes) = (material.environment().bindings(), material.lobes().bindings());
    let bindings = [environment.all, lobes.all].concat();
    let slots = Slots::of(gpu, "lobes", ShaderStages::FRAGMENT, &bindings);
    let surface_layout = surface::layout(gpu);
    let rasteriser = Rasteriser::new(gpu, source, &[&slots.layout, &surface_layout])?;
    // The shader reads no image of the environment, which the layout of surfaces has.
    let mirrored = surface::environment(gpu, &Environment::of(1, 1, |_| [0.0; 3]))?;
    let packs = slots.bind(gpu, &bindings, FrameBlock::default())?;
    let group = |(index, part)| vec![packs.clone(), surface::upload(gpu, &surface_layout, index, part, &mirrored)];
    let groups = (0..).zip(&scene.parts).map(group).collect();
    let loaded = load(gpu, &rasteriser.view_layout, scene, groups, [0; 2])?;
    rasteriser.draw(&loaded, &scene.camera, frame)
}
