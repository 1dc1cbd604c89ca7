//! Drawing of scenes whose parts all use one flat BTF.

use super::device::{Gpu, GpuError};
use super::flat_textures;
use super::load::LoadedScene;
use super::raster::{Rasteriser, load_with_one_material, view_wgsl};
use brdfc_formats::PackKind;
use brdfc_formats::bindings::FrameBlock;
use brdfc_metrics::image::LinearImage;
use brdfc_render::flat::{FlatMaterial, cover_wgsl};
use brdfc_render::scene::{Camera, Frame, Scene};
use wgpu::ShaderStages;

/// The complete shader for a kind of flat BTF: decoder, scene.
pub fn flat_scene_source(kind: PackKind) -> String {
    let decoder = (kind.descriptor().wgsl)();
    [&decoder, &view_wgsl(), &cover_wgsl(kind), include_str!("flat_scene.wgsl")].join("\n")
}

/// Draws a scene whose parts all use one flat BTF, by the shader with exact filters.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] if the adapter cannot hold the material or the image; any error that the driver
/// reports.
pub fn draw_flat_btf(gpu: &Gpu, scene: &Scene, frame: Frame, material: &FlatMaterial) -> Result<LinearImage, GpuError> {
    let kind = material.decoder().parts().reflectance.kind();
    draw_flat_btf_by(gpu, flat_scene_source(kind), scene, frame, material)
}

/// Draws like [`draw_flat_btf`] with another shader than [`flat_scene_source`], such as a deliberately broken one.
///
/// # Errors
/// Returns the errors of [`draw_flat_btf`]; an error if the source does not validate.
pub fn draw_flat_btf_by(
    gpu: &Gpu,
    source: String,
    scene: &Scene,
    frame: Frame,
    material: &FlatMaterial,
) -> Result<LinearImage, GpuError> {
    LoadedFlatBtf::new(gpu, source, scene, frame.samples, (material, FrameBlock::exact()))?.draw(&scene.camera, frame)
}

/// A scene whose parts all use one flat BTF, loaded for any number of frames.
pub struct LoadedFlatBtf<'g> {
    rasteriser: Rasteriser<'g>,
    scene: LoadedScene,
}

impl<'g> LoadedFlatBtf<'g> {
    /// Compiles the shader `source` and uploads scene and material, for frames of `samples` x `samples` per pixel.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] if the adapter cannot hold the material; an error if the source does not validate; any
    /// error that the driver reports.
    pub fn new(
        gpu: &'g Gpu,
        source: String,
        scene: &Scene,
        samples: usize,
        (material, sampling): (&FlatMaterial, FrameBlock),
    ) -> Result<Self, GpuError> {
        let kind = material.decoder().parts().reflectance.kind();
        let slots = flat_textures::slots(gpu, kind, ShaderStages::FRAGMENT);
        let textures = flat_textures::upload(gpu, &slots, material.decoder(), sampling, material.directions())?;
        let finer = (samples as f32).log2();
        let words = [material.repeat(), finer.to_bits(), 0, 0];
        let textures = (&slots.layout, textures);
        let (rasteriser, scene) = load_with_one_material(gpu, source, &material.cover(scene), textures, words)?;
        Ok(Self { rasteriser, scene })
    }

    /// Draws a frame, and reads it back.
    ///
    /// # Errors
    /// Returns an error for images beyond the adapter's limits; any error that the driver reports.
    pub fn draw(&self, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        self.rasteriser.draw(&self.scene, camera, frame)
    }
}
