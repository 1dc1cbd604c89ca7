//! Scenes on the device: buffers, textures and bind groups of what `scene.wgsl` declares.

use super::device::GpuError;
use super::draw::{Decoding, Renderer};
use super::evaluate::SliceFilter;
use super::pack;
use crate::render::scene::{Camera, Environment, Part, Scene};
use brdfc_formats::pack::WaveletPack;
use wgpu::util::{DeviceExt, TextureDataOrder};
use wgpu::{
    BindGroupDescriptor, BindGroupEntry, BindingResource, BufferUsages, Extent3d, TextureDescriptor, TextureDimension,
    TextureFormat, TextureUsages,
};

/// 32-bit words of a vertex: position, normal, tangent, uv.
pub(super) const VERTEX_WORDS: usize = 11;
/// 32-bit words of the shader's `View`.
const VIEW_WORDS: usize = 24;

/// A scene on the device.
pub struct LoadedScene {
    pub(super) view: wgpu::Buffer,
    pub(super) view_group: wgpu::BindGroup,
    pub(super) parts: Vec<LoadedPart>,
    pub(super) background: [f32; 3],
    pub(super) lights: u32,
    pub(super) decoding: Decoding,
}

pub(super) struct LoadedPart {
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) count: u32,
    pub(super) pack: wgpu::BindGroup,
    pub(super) surface: wgpu::BindGroup,
}

impl Renderer<'_> {
    /// Uploads a scene with one pack for each of its parts.
    ///
    /// # Panics
    /// If there are not as many packs as parts.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn load(&self, scene: &Scene, packs: &[&WaveletPack], decoding: Decoding) -> Result<LoadedScene, GpuError> {
        assert_eq!(packs.len(), scene.parts.len(), "one pack for each part");
        let view = self.gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * VIEW_WORDS as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut words: Vec<f32> = Vec::new();
        for light in &scene.lights {
            words.extend(light.position.map(|c| c as f32));
            words.push(0.0);
            words.extend(light.intensity.map(|c| c as f32));
            words.push(0.0);
        }
        words.resize(words.len().max(8), 0.0);
        let lights = self.buffer(bytemuck::cast_slice(&words), BufferUsages::STORAGE);
        let environment = self.environment(&scene.environment);
        let view_group = self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.view_layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: view.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: lights.as_entire_binding() },
                BindGroupEntry { binding: 2, resource: BindingResource::TextureView(&environment) },
            ],
        });
        let parts = scene
            .parts
            .iter()
            .zip(packs)
            .map(|(part, pack)| self.part(part, pack, decoding))
            .collect::<Result<_, _>>()?;
        self.gpu.check()?;
        Ok(LoadedScene {
            view,
            view_group,
            parts,
            background: scene.background,
            lights: scene.lights.len() as u32,
            decoding,
        })
    }

    fn part(&self, part: &Part, pack: &WaveletPack, decoding: Decoding) -> Result<LoadedPart, GpuError> {
        let mut words: Vec<f32> = Vec::with_capacity(VERTEX_WORDS * part.mesh.vertices.len());
        for vertex in &part.mesh.vertices {
            words.extend(vertex.position);
            words.extend(vertex.normal);
            words.extend(vertex.tangent);
            words.extend(vertex.uv);
        }
        let bump = part.surface.bump.as_ref();
        let size = bump.map_or(0, |bump| bump.size as u32);
        let surface = [part.surface.mirror.to_bits(), size, 0, 0];
        let surface = self.buffer(bytemuck::cast_slice(&surface), BufferUsages::UNIFORM);
        let heights = bump.map_or(&[0.0][..], |bump| &bump.heights);
        let heights = self.image(TextureFormat::R32Float, size.max(1), size.max(1), bytemuck::cast_slice(heights));
        let surface = self.gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &self.surface_layout,
            entries: &[
                BindGroupEntry { binding: 0, resource: surface.as_entire_binding() },
                BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&heights) },
            ],
        });
        Ok(LoadedPart {
            vertices: self.buffer(bytemuck::cast_slice(&words), BufferUsages::VERTEX),
            indices: self.buffer(bytemuck::cast_slice(&part.mesh.triangles), BufferUsages::INDEX),
            count: 3 * part.mesh.triangles.len() as u32,
            pack: pack::upload(self.gpu, &self.pack_layout, pack, decoding.filter, decoding.distance_scale)?,
            surface,
        })
    }

    fn buffer(&self, contents: &[u8], usage: BufferUsages) -> wgpu::Buffer {
        self.gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    }

    fn image(&self, format: TextureFormat, width: u32, height: u32, bytes: &[u8]) -> wgpu::TextureView {
        let descriptor = TextureDescriptor {
            label: None,
            size: Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let gpu = self.gpu;
        let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn environment(&self, environment: &Environment) -> wgpu::TextureView {
        let texels: Vec<[f32; 4]> = environment.pixels.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
        let (width, height) = (environment.width as u32, environment.height as u32);
        self.image(TextureFormat::Rgba32Float, width, height, bytemuck::cast_slice(&texels))
    }
}

pub(super) fn view_words(
    scene: &LoadedScene,
    camera: &Camera,
    [width, height]: [f64; 2],
    sample: [usize; 2],
    samples: usize,
) -> [u32; VIEW_WORDS] {
    let (right, up, forward) = camera.basis();
    let [half_width, half_height] = camera.half_extent(width as usize, height as usize);
    let mut words = [0; VIEW_WORDS];
    let rows = [camera.eye, right.map(|c| c / half_width), up.map(|c| c / half_height), forward];
    for (target, row) in words.chunks_exact_mut(4).zip(rows) {
        (0..3).for_each(|k| target[k] = (row[k] as f32).to_bits());
    }
    // Pixels are sampled at their centres: the image moves by what the wanted point is off.
    let off = |index: usize| 0.5 - (index as f64 + 0.5) / samples as f64;
    words[16] = ((2.0 * off(sample[0]) / width) as f32).to_bits();
    words[17] = ((-2.0 * off(sample[1]) / height) as f32).to_bits();
    words[18] = scene.decoding.level.map_or(-1.0, |level| level.max(0.0)).to_bits();
    words[19] = u32::from(scene.decoding.slices == SliceFilter::Hardware);
    words[20] = scene.lights;
    words
}
