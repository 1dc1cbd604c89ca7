//! Draws scenes whose parts are all of one polynomial wavelet tree.

use super::bindings::{self, Slots, UNIFORM};
use super::device::{Gpu, GpuError};
use super::load::LoadedScene;
use super::pwt_textures;
use super::raster::{Rasteriser, view_wgsl};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_metrics::image::LinearImage;
use brdfc_render::pwt::PwtMaterial;
use brdfc_render::scene::{Camera, Frame, Scene};
use wgpu::{BindGroupLayout, BufferUsages, ShaderStages};

/// The entry points over the decoder, behind [`view_wgsl`].
pub const PWT_SCENE_WGSL: &str = include_str!("pwt_scene.wgsl");

/// The whole shader: decoder and scene.
pub fn pwt_scene_source() -> String {
    [PWT_WGSL, &view_wgsl(), PWT_SCENE_WGSL].join("\n")
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
    let renderer = PwtRenderer::new(gpu)?;
    let loaded = renderer.load(scene, material, sampling)?;
    renderer.draw(&loaded, &scene.camera, frame)
}

/// A compiled pipeline.
pub struct PwtRenderer<'g> {
    rasteriser: Rasteriser<'g>,
    slots: Slots,
    material_layout: BindGroupLayout,
}

impl<'g> PwtRenderer<'g> {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shader(gpu, pwt_scene_source())
    }

    /// Compiles another shader than [`pwt_scene_source`], such as a broken one.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shader(gpu: &'g Gpu, source: String) -> Result<Self, GpuError> {
        let slots = pwt_textures::slots(gpu, ShaderStages::FRAGMENT);
        let material_layout = bindings::layout(gpu, "light-dependent picture", ShaderStages::FRAGMENT, [(0, UNIFORM)]);
        let rasteriser = Rasteriser::new(gpu, source, &[&slots.layout, &material_layout])?;
        Ok(Self { rasteriser, slots, material_layout })
    }

    /// Uploads a scene with a material for all of its parts.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
    pub fn load(&self, scene: &Scene, material: &PwtMaterial, sampling: FrameBlock) -> Result<LoadedScene, GpuError> {
        let gpu = self.rasteriser.gpu;
        let textures = pwt_textures::upload(gpu, &self.slots, material.decoder().pack(), sampling)?;
        let uniform = gpu.buffer(bytemuck::cast_slice(&[material.repeat(), 0, 0, 0]), BufferUsages::UNIFORM);
        let group = bindings::group(gpu, &self.material_layout, [(0, uniform.as_entire_binding())]);
        let groups = vec![vec![textures, group]; scene.parts.len()];
        self.rasteriser.load(scene, groups, [0; 2])
    }

    /// Draws a whole image: the mean of `samples²` samples per pixel, summed in a fixed order.
    ///
    /// # Errors
    /// Images beyond the adapter's limits; what the driver reports.
    pub fn draw(&self, scene: &LoadedScene, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        self.rasteriser.draw(scene, camera, frame)
    }
}
