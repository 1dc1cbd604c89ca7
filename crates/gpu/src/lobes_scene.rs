//! Drawing of scenes that a prefiltered environment lights, by the lobes of their materials.

use super::bindings::Slots;
use super::device::{Gpu, GpuError};
use super::load::{LoadedScene, load};
use super::raster::{Rasteriser, view_wgsl};
use super::surface::{self, PERIODIC_WGSL, SURFACE_WGSL};
use brdfc_formats::bindings::{Binding, FrameBlock};
use brdfc_formats::environment::ENVIRONMENT_WGSL;
use brdfc_formats::lobes::{Anchor, LOBES_WGSL, Lobe, LobesHeader, LobesPack};
use brdfc_metrics::image::LinearImage;
use brdfc_render::lobes::PrefilteredLight;
use brdfc_render::scene::{Camera, Environment, Frame, Scene};
use wgpu::{BindGroup, BindGroupLayout, ShaderStages};

/// The complete shader: decoders, surfaces, scene.
pub fn lobes_scene_source() -> String {
    let scene = include_str!("lobes_scene.wgsl");
    [ENVIRONMENT_WGSL, LOBES_WGSL, &view_wgsl(), PERIODIC_WGSL, SURFACE_WGSL, scene].join("\n")
}

/// A compiled pipeline, for one environment.
pub struct LobesRenderer<'a> {
    rasteriser: Rasteriser<'a>,
    slots: Slots,
    surface_layout: BindGroupLayout,
    light: &'a PrefilteredLight,
}

impl<'a> LobesRenderer<'a> {
    /// Compiles a shader: [`lobes_scene_source`], or another one, such as a deliberately broken one.
    ///
    /// # Errors
    /// Returns an error if the source does not validate; any error that the driver reports.
    pub fn new(gpu: &'a Gpu, source: String, light: &'a PrefilteredLight) -> Result<Self, GpuError> {
        let slots = Slots::of(gpu, "lobes", ShaderStages::FRAGMENT, &bindings(light, &black()));
        let surface_layout = surface::layout(gpu);
        let rasteriser = Rasteriser::new(gpu, source, &[&slots.layout, &surface_layout])?;
        Ok(Self { rasteriser, slots, surface_layout, light })
    }

    /// Uploads a scene with the lobes of each part. Parts without lobes are black.
    ///
    /// # Panics
    /// If there are fewer lobes than parts.
    ///
    /// # Errors
    /// Returns [`GpuError::TooLarge`] if the adapter cannot hold the environment; any error that the driver reports.
    pub fn load(&self, scene: &Scene, lobes: &[Option<&LobesPack>]) -> Result<LoadedScene, GpuError> {
        let gpu = self.rasteriser.gpu;
        let black = black();
        let of_part = |part: usize| lobes[part].unwrap_or(&black);
        // The shader reads no image of the environment, which the layout of surfaces has.
        let mirrored = surface::environment(gpu, &Environment::of(1, 1, |_| [0.0; 3]))?;
        let mut groups: Vec<Vec<BindGroup>> = Vec::with_capacity(scene.parts.len());
        for (index, part) in scene.parts.iter().enumerate() {
            // Parts of one material share its group, and so the environment's textures.
            let same = (0..index).find(|earlier| std::ptr::eq(of_part(*earlier), of_part(index)));
            let packs = match same {
                Some(earlier) => groups[earlier][0].clone(),
                None => self.slots.bind(gpu, &bindings(self.light, of_part(index)), FrameBlock::default())?,
            };
            groups.push(vec![packs, surface::upload(gpu, &self.surface_layout, index as u32, part, &mirrored)]);
        }
        load(gpu, &self.rasteriser.view_layout, scene, groups, [0; 2])
    }

    /// Draws a whole image, as [`Renderer::draw`](crate::Renderer::draw).
    ///
    /// # Errors
    /// Returns an error for images beyond the adapter's limits; any error that the driver reports.
    pub fn draw(&self, scene: &LoadedScene, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        self.rasteriser.draw(scene, camera, frame)
    }
}

/// Draws a scene by the lobes of each part. Parts without lobes are black.
///
/// # Panics
/// If there are fewer lobes than parts.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] if the adapter cannot hold the environment or the image; any error that the driver
/// reports.
pub fn draw_lobes(
    gpu: &Gpu,
    scene: &Scene,
    frame: Frame,
    light: &PrefilteredLight,
    lobes: &[Option<&LobesPack>],
) -> Result<LinearImage, GpuError> {
    let renderer = LobesRenderer::new(gpu, lobes_scene_source(), light)?;
    renderer.draw(&renderer.load(scene, lobes)?, &scene.camera, frame)
}

/// Bindings of both decoders.
fn bindings<'a>(light: &'a PrefilteredLight, lobes: &'a LobesPack) -> Vec<Binding<'a>> {
    [light.pack().bindings().all, lobes.bindings().all].concat()
}

/// Lobes that reflect nothing.
fn black() -> LobesPack {
    let lobes = vec![Lobe { anchor: Anchor::Normal, tilt: [0.0; 2], row: 0 }];
    let header = LobesHeader { nodes: 2, azimuths: 1, rows: 1, scale: 1.0, delta_e: [0.0; 2], lobes };
    LobesPack::new(header, &[[0.0; 4]; 2]).expect("every value is in range")
}
