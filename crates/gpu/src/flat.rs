//! Draws scenes whose parts are all of one flat BTF.

use super::bindings::{self, Slots, UNIFORM};
use super::device::{Gpu, GpuError};
use super::flat_textures;
use super::load::LoadedScene;
use super::raster::{Rasteriser, view_wgsl};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_metrics::image::LinearImage;
use brdfc_render::flat::{FlatForm, FlatMaterial};
use brdfc_render::scene::{Camera, Frame, Scene};
use wgpu::{BindGroupLayout, BufferUsages, ShaderStages};

/// The entry points over the decoder of flat BTFs, behind [`view_wgsl`].
pub const FLAT_SCENE_WGSL: &str = include_str!("flat_scene.wgsl");

/// The whole shader: decoders, scene.
pub fn flat_scene_source() -> String {
    [&flat_btf_value_wgsl(), &view_wgsl(), FLAT_SCENE_WGSL].join("\n")
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
    let renderer = FlatRenderer::new(gpu)?;
    let loaded = renderer.load(scene, material, form, frame.samples)?;
    renderer.draw(&loaded, &scene.camera, frame)
}

/// A compiled pipeline.
pub struct FlatRenderer<'g> {
    rasteriser: Rasteriser<'g>,
    slots: Slots,
    material_layout: BindGroupLayout,
}

impl<'g> FlatRenderer<'g> {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shader(gpu, flat_scene_source())
    }

    /// Compiles another shader than [`flat_scene_source`], such as a broken one.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shader(gpu: &'g Gpu, source: String) -> Result<Self, GpuError> {
        let slots = flat_textures::slots(gpu, ShaderStages::FRAGMENT);
        let material_layout = bindings::layout(gpu, "flat material", ShaderStages::FRAGMENT, [(0, UNIFORM)]);
        let rasteriser = Rasteriser::new(gpu, source, &[&slots.layout, &material_layout])?;
        Ok(Self { rasteriser, slots, material_layout })
    }

    /// Uploads a scene with a material for all of its parts, to be drawn with `samples²` samples per pixel. Values of views go along
    /// only for the full form.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] for more than the adapter takes; what the driver reports.
    ///
    /// # Panics
    /// For the full form of a material without values of views.
    pub fn load(
        &self,
        scene: &Scene,
        material: &FlatMaterial,
        form: FlatForm,
        samples: usize,
    ) -> Result<LoadedScene, GpuError> {
        let gpu = self.rasteriser.gpu;
        let full = form == FlatForm::Full;
        let directions = full.then(|| material.sampled_directions());
        let textures =
            flat_textures::upload(gpu, &self.slots, material.decoder(), FrameBlock::exact(), full, directions)?;
        let finer = (samples as f32).log2();
        let words = [material.repeat(), u32::from(full), finer.to_bits(), 0];
        let uniform = gpu.buffer(bytemuck::cast_slice(&words), BufferUsages::UNIFORM);
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
