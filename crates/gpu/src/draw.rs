//! Drawing of scenes whose parts have packs of any BRDF codec.

use super::bindings::Slots;
use super::device::{Gpu, GpuError};
use super::load::{LoadedScene, load};
use super::pack;
use super::raster::{Rasteriser, Target, view_wgsl};
use super::surface::{self, ENVIRONMENT_WGSL, PERIODIC_WGSL, SURFACE_WGSL};
use brdfc_formats::BrdfPack;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::wavelet::Filter;
use brdfc_metrics::image::LinearImage;
use brdfc_render::scene::{Camera, Frame, Scene};
use wgpu::ShaderStages;

/// The complete shader: decoders, surfaces, environment, scene.
pub fn scene_source() -> String {
    let scene = include_str!("scene.wgsl");
    [&pack::brdf_source(), &view_wgsl(), PERIODIC_WGSL, SURFACE_WGSL, ENVIRONMENT_WGSL, scene].join("\n")
}

/// Unit that filters slices over the outer direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SliceFilter {
    /// The texture unit, as in engines: weights have few bits.
    Hardware,
    /// The shader, with exact weights: bit-identical to the CPU decoder where arithmetic is correctly rounded.
    Exact,
}

/// Decoding of packs in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoding {
    /// Filter over inner and outer cells.
    pub filter: Filter,
    /// Unit that filters slices.
    pub slices: SliceFilter,
    /// A fixed level of detail; `None` to follow the distance.
    pub level: Option<f32>,
    /// `α` of the level of detail, per unit of distance. Positive.
    pub distance_scale: f64,
}

impl Decoding {
    /// Uniform block for the decoders.
    pub(super) fn frame_block(&self) -> FrameBlock {
        FrameBlock {
            distance_scale: self.distance_scale as f32,
            sampler_filters: self.slices == SliceFilter::Hardware,
            blend: self.filter,
        }
    }

    /// The shader's words `level` and `hardware`.
    pub(super) fn words(&self) -> [u32; 2] {
        let level = self.level.map_or(-1.0, |level| level.max(0.0)).to_bits();
        [level, u32::from(self.slices == SliceFilter::Hardware)]
    }
}

/// A compiled pipeline.
pub struct Renderer<'g> {
    rasteriser: Rasteriser<'g>,
    slots: Slots,
    surface_layout: wgpu::BindGroupLayout,
}

impl<'g> Renderer<'g> {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        let slots = pack::slots(gpu, ShaderStages::FRAGMENT);
        let surface_layout = surface::layout(gpu);
        let rasteriser = Rasteriser::new(gpu, scene_source(), &[&slots.layout, &surface_layout])?;
        Ok(Self { rasteriser, slots, surface_layout })
    }

    /// Uploads a scene with one pack for each of its parts.
    ///
    /// # Panics
    /// If the number of packs differs from the number of parts.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn load(&self, scene: &Scene, packs: &[&BrdfPack], decoding: Decoding) -> Result<LoadedScene, GpuError> {
        assert_eq!(packs.len(), scene.parts.len(), "one pack for each part");
        let gpu = self.rasteriser.gpu;
        let environment = surface::environment(gpu, &scene.environment)?;
        let mut groups = Vec::with_capacity(scene.parts.len());
        for (index, (part, pack)) in (0..).zip(scene.parts.iter().zip(packs)) {
            let pack = self.slots.bind(gpu, &pack.bindings().all, decoding.frame_block())?;
            groups.push(vec![pack, surface::upload(gpu, &self.surface_layout, index, part, &environment)]);
        }
        load(gpu, &self.rasteriser.view_layout, scene, groups, decoding.words())
    }

    /// Allocates colour and depth of `width` x `height` pixels.
    ///
    /// # Errors
    /// Returns an error for more pixels per side than the adapter's limit.
    pub fn target(&self, width: usize, height: usize) -> Result<Target, GpuError> {
        self.rasteriser.target(width, height)
    }

    /// Draws one sample per pixel, `sample` = `[column, row]` of the `samples` x `samples` in each, and waits until it
    /// is done.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn draw_sample(
        &self,
        scene: &LoadedScene,
        camera: &Camera,
        target: &Target,
        sample: [usize; 2],
        samples: usize,
    ) -> Result<(), GpuError> {
        self.rasteriser.draw_sample(scene, camera, target, sample, samples)
    }

    /// Draws a whole image: the mean of `samples²` samples per pixel, summed in a fixed order.
    ///
    /// # Errors
    /// Returns an error for images beyond the adapter's limits; any error that the driver reports.
    pub fn draw(&self, scene: &LoadedScene, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        self.rasteriser.draw(scene, camera, frame)
    }
}
