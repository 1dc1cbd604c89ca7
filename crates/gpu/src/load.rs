//! Scenes on the device: the buffers and bind groups that `view.wgsl` declares.

use super::bindings;
use super::device::{Gpu, GpuError};
use brdfc_render::scene::{Camera, Part, Scene};
use wgpu::{BindGroup, BindGroupLayout, BufferUsages};

/// 32-bit words of a vertex: position, normal, tangent, uv, height above its surface, distance from its border.
pub(super) const VERTEX_WORDS: usize = 13;
/// 32-bit words of the shader's `View`.
const VIEW_WORDS: usize = 24;

/// A scene on the device.
pub struct LoadedScene {
    pub(super) view: wgpu::Buffer,
    pub(super) view_group: BindGroup,
    pub(super) parts: Vec<LoadedPart>,
    pub(super) background: [f32; 3],
    lights: u32,
    /// `level` and `hardware` of the shader's `View`.
    settings: [u32; 2],
}

pub(super) struct LoadedPart {
    pub(super) vertices: wgpu::Buffer,
    pub(super) indices: wgpu::Buffer,
    pub(super) count: u32,
    /// Bind groups from 1 on.
    pub(super) groups: Vec<BindGroup>,
}

/// Uploads a scene, with bind group 0 of this layout. `groups` are the bind groups from 1 on of each part, `settings`
/// the words `level` and `hardware` of the shader's `View`.
///
/// # Errors
/// Returns an error that the driver reports.
pub(super) fn load(
    gpu: &Gpu,
    view_layout: &BindGroupLayout,
    scene: &Scene,
    groups: Vec<Vec<BindGroup>>,
    settings: [u32; 2],
) -> Result<LoadedScene, GpuError> {
    let view = gpu.device.create_buffer(&wgpu::BufferDescriptor {
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
    let lights = gpu.buffer(bytemuck::cast_slice(&words), BufferUsages::STORAGE);
    let view_group =
        bindings::group(gpu, view_layout, [(0, view.as_entire_binding()), (1, lights.as_entire_binding())]);
    let parts = scene.parts.iter().zip(groups).map(|(part, groups)| load_part(gpu, part, groups)).collect();
    gpu.check()?;
    Ok(LoadedScene {
        view,
        view_group,
        parts,
        background: scene.background,
        lights: scene.lights.len() as u32,
        settings,
    })
}

fn load_part(gpu: &Gpu, part: &Part, groups: Vec<BindGroup>) -> LoadedPart {
    let mut words: Vec<f32> = Vec::with_capacity(VERTEX_WORDS * part.mesh.vertices.len());
    for vertex in &part.mesh.vertices {
        words.extend(vertex.position);
        words.extend(vertex.normal);
        words.extend(vertex.tangent);
        words.extend(vertex.uv);
        words.extend([vertex.raised_by, vertex.border]);
    }
    LoadedPart {
        vertices: gpu.buffer(bytemuck::cast_slice(&words), BufferUsages::VERTEX),
        indices: gpu.buffer(bytemuck::cast_slice(&part.mesh.triangles), BufferUsages::INDEX),
        count: 3 * part.mesh.triangles.len() as u32,
        groups,
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
    // Pixels are sampled at their centres: the image moves by the offset of the sample from the centre.
    let off = |index: usize| 0.5 - (index as f64 + 0.5) / samples as f64;
    words[16] = ((2.0 * off(sample[0]) / width) as f32).to_bits();
    words[17] = ((-2.0 * off(sample[1]) / height) as f32).to_bits();
    words[18] = scene.settings[0];
    words[19] = scene.settings[1];
    words[20] = scene.lights;
    words
}
