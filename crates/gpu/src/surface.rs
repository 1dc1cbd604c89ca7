//! Surfaces of parts and the environment on the device: the bindings of `surface.wgsl`, and the texture of an
//! environment.

use super::bindings::{self, UNFILTERED, UNIFORM};
use super::device::{Gpu, GpuError};
use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_render::scene::{Environment, Part};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BufferUsages, ShaderStages, TextureFormat, TextureView};

/// Periodic indices.
pub const PERIODIC_WGSL: &str = include_str!("periodic.wgsl");
/// Bumps and local frames. Bind group 2.
pub const SURFACE_WGSL: &str = include_str!("surface.wgsl");
/// Look-up in environments, without bindings.
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");

/// Layout of the group of a part: surface, heights, environment.
pub(super) fn layout(gpu: &Gpu) -> BindGroupLayout {
    bindings::layout(gpu, "surface", ShaderStages::FRAGMENT, [(0, UNIFORM), (1, UNFILTERED), (2, UNFILTERED)])
}

/// Uploads the surface of the part with this index.
pub(super) fn upload(
    gpu: &Gpu,
    layout: &BindGroupLayout,
    index: u32,
    part: &Part,
    environment: &TextureView,
) -> BindGroup {
    let bump = part.surface.bump.as_ref();
    let size = bump.map_or(0, |bump| bump.size as u32);
    let surface = [part.surface.mirror.to_bits(), size, index, 0];
    let surface = gpu.buffer(bytemuck::cast_slice(&surface), BufferUsages::UNIFORM);
    let heights = bump.map_or(&[0.0][..], |bump| &bump.heights);
    let extent = Extent::D2([size.max(1); 2]);
    let heights = gpu.texture(TextureFormat::R32Float, extent, 1, bytemuck::cast_slice(heights));
    let textures = [&heights, environment].map(BindingResource::TextureView);
    bindings::group(gpu, layout, (0..).zip([surface.as_entire_binding()].into_iter().chain(textures)))
}

/// Uploads an environment.
///
/// # Errors
/// Returns an error for more texels per side than the adapter's limit.
pub(super) fn environment(gpu: &Gpu, environment: &Environment) -> Result<TextureView, GpuError> {
    let texels: Vec<[f32; 4]> = environment.pixels.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
    let extent = Extent::D2([environment.width as u32, environment.height as u32]);
    bindings::texture(gpu, TexelFormat::Rgba32Float, extent, 1, bytemuck::cast_slice(&texels))
}
