//! Surfaces of parts and the environment on the device: what `surface.wgsl` declares, and an environment's texture.

use super::compute::{UNFILTERED, texture};
use super::device::{Gpu, GpuError};
use super::raster::{buffer_type, entry};
use brdfc_formats::container::TexelFormat;
use brdfc_render::scene::{Environment, Part};
use wgpu::{
    BindGroup, BindGroupDescriptor, BindGroupEntry, BindGroupLayout, BindGroupLayoutDescriptor, BindingResource,
    BufferBindingType, BufferUsages, ShaderStages, TextureFormat, TextureView,
};

/// Indices of what repeats.
pub const PERIODIC_WGSL: &str = include_str!("periodic.wgsl");
/// Bumps and local frames. Bind group 2.
pub const SURFACE_WGSL: &str = include_str!("surface.wgsl");
/// The look-up of environments, without bindings.
pub const ENVIRONMENT_WGSL: &str = include_str!("environment.wgsl");

/// The layout of the group of a part: surface, heights, environment.
pub(super) fn layout(gpu: &Gpu) -> BindGroupLayout {
    gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
        label: Some("surface"),
        entries: &[
            entry(0, ShaderStages::FRAGMENT, buffer_type(BufferBindingType::Uniform)),
            entry(1, ShaderStages::FRAGMENT, UNFILTERED),
            entry(2, ShaderStages::FRAGMENT, UNFILTERED),
        ],
    })
}

/// Uploads the surface of the part of this index.
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
    let heights = gpu.image(TextureFormat::R32Float, [size.max(1); 2], bytemuck::cast_slice(heights));
    gpu.device.create_bind_group(&BindGroupDescriptor {
        label: None,
        layout,
        entries: &[
            BindGroupEntry { binding: 0, resource: surface.as_entire_binding() },
            BindGroupEntry { binding: 1, resource: BindingResource::TextureView(&heights) },
            BindGroupEntry { binding: 2, resource: BindingResource::TextureView(environment) },
        ],
    })
}

/// Uploads an environment.
///
/// # Errors
/// More than the adapter's limit per side.
pub(super) fn environment(gpu: &Gpu, environment: &Environment) -> Result<TextureView, GpuError> {
    let texels: Vec<[f32; 4]> = environment.pixels.iter().map(|p| [p[0], p[1], p[2], 1.0]).collect();
    let size = [environment.width as u32, environment.height as u32];
    texture(gpu, TexelFormat::Rgba32Float, size, bytemuck::cast_slice(&texels))
}
