//! Draws scenes whose parts have wavelet packs.

use super::device::{Gpu, GpuError};
use super::evaluate::SliceFilter;
use super::load::LoadedScene;
use super::pack;
use super::raster::{Rasteriser, Target, VIEW_WGSL, buffer_type, entry};
use crate::metrics::image::LinearImage;
use crate::render::scene::{Camera, Environment, Frame, Part, Scene};
use brdfc_formats::pack::wavelet_shader::WAVELET_BRDF_WGSL;
use brdfc_formats::pack::{Filter, WaveletPack};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindGroupLayoutDescriptor, BindingResource, BindingType, BufferBindingType,
    BufferUsages, ShaderStages, TextureFormat, TextureSampleType, TextureViewDimension,
};

/// The scene's entry points over the decoder, behind [`VIEW_WGSL`].
pub const SCENE_WGSL: &str = include_str!("../shaders/scene.wgsl");

/// How packs are decoded in an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decoding {
    /// Over inner and outer cells.
    pub filter: Filter,
    /// Who filters slices.
    pub slices: SliceFilter,
    /// A fixed level of detail, or the one that follows from the distance.
    pub level: Option<f32>,
    /// `α` of the level of detail, per unit of distance. Positive.
    pub distance_scale: f64,
}

/// A compiled pipeline.
pub struct Renderer<'g> {
    rasteriser: Rasteriser<'g>,
    pack_layout: wgpu::BindGroupLayout,
    surface_layout: wgpu::BindGroupLayout,
}

impl<'g> Renderer<'g> {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        let image = BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let pack_layout = pack::layout(gpu, ShaderStages::FRAGMENT);
        let surface_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("surface"),
            entries: &[
                entry(0, ShaderStages::FRAGMENT, buffer_type(BufferBindingType::Uniform)),
                entry(1, ShaderStages::FRAGMENT, image),
                entry(2, ShaderStages::FRAGMENT, image),
            ],
        });
        let source = format!("{WAVELET_BRDF_WGSL}\n{VIEW_WGSL}\n{SCENE_WGSL}");
        let rasteriser = Rasteriser::new(gpu, source, &[&pack_layout, &surface_layout])?;
        Ok(Self { rasteriser, pack_layout, surface_layout })
    }

    /// Uploads a scene with one pack for each of its parts.
    ///
    /// # Panics
    /// If there are not as many packs as parts.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn load(&self, scene: &Scene, packs: &[&WaveletPack], decoding: Decoding) -> Result<LoadedScene, GpuError> {
        assert_eq!(packs.len(), scene.parts.len(), "one pack for each part");
        let gpu = self.rasteriser.gpu;
        let environment = environment(gpu, &scene.environment);
        let mut groups = Vec::with_capacity(scene.parts.len());
        for (part, pack) in scene.parts.iter().zip(packs) {
            let pack = pack::upload(gpu, &self.pack_layout, pack, decoding.filter, decoding.distance_scale)?;
            groups.push(vec![pack, self.surface(part, &environment)]);
        }
        let level = decoding.level.map_or(-1.0, |level| level.max(0.0)).to_bits();
        let settings = [level, u32::from(decoding.slices == SliceFilter::Hardware)];
        self.rasteriser.load(scene, groups, settings)
    }

    fn surface(&self, part: &Part, environment: &wgpu::TextureView) -> wgpu::BindGroup {
        let gpu = self.rasteriser.gpu;
        let bump = part.surface.bump.as_ref();
        let size = bump.map_or(0, |bump| bump.size as u32);
        let surface = [part.surface.mirror.to_bits(), size, 0, 0];
        let surface = gpu.buffer(bytemuck::cast_slice(&surface), BufferUsages::UNIFORM);
        let heights = bump.map_or(&[0.0][..], |bump| &bump.heights);
        let heights = gpu.image(TextureFormat::R32Float, [size.max(1); 2], bytemuck::cast_slice(heights));
        gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.surface_layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: surface.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&heights) },
                BindGroupEntry { binding: 2, resource: BindingResource::TextureView(environment) },
            ],
        })
    }

    /// Colour and depth of `width` x `height` pixels.
    ///
    /// # Errors
    /// More than the adapter's limit per side.
    pub fn target(&self, width: usize, height: usize) -> Result<Target, GpuError> {
        self.rasteriser.target(width, height)
    }

    /// Draws one sample per pixel, `sample` = `[column, row]` of the `samples` x `samples` in each, and waits for it.
    ///
    /// # Errors
    /// What the driver reports.
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
    /// Images beyond the adapter's limits; what the driver reports.
    pub fn draw(&self, scene: &LoadedScene, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        self.rasteriser.draw(scene, camera, frame)
    }
}

fn environment(gpu: &Gpu, environment: &Environment) -> wgpu::TextureView {
    let texels: Vec<[f32; 4]> = environment.pixels.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
    let size = [environment.width as u32, environment.height as u32];
    gpu.image(TextureFormat::Rgba32Float, size, bytemuck::cast_slice(&texels))
}
