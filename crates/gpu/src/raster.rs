//! The rasteriser, which draws scenes with any materials into linear images of 32-bit floats.

use super::bindings::{self, UNIFORM, buffer_type};
use super::device::{Gpu, GpuError};
use super::load::{LoadedScene, VERTEX_WORDS, load, view_words};
use brdfc_metrics::image::LinearImage;
use brdfc_render::camera::CORNER_WGSL;
use brdfc_render::scene::{Camera, Frame, Scene};
use brdfc_render::shading_point::SHADING_POINT_WGSL;
use std::borrow::Cow;
use wgpu::{
    BindGroup, BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, BufferBindingType, BufferUsages,
    CompareFunction, DepthStencilState, Extent3d, FragmentState, LoadOp, Operations, PipelineLayoutDescriptor,
    PrimitiveState, RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
    RenderPipelineDescriptor, ShaderModuleDescriptor, ShaderSource, ShaderStages, StoreOp, TextureDescriptor,
    TextureDimension, TextureFormat, TextureUsages, VertexBufferLayout, VertexState, VertexStepMode, vertex_attr_array,
};

/// Declarations that the shaders of scenes share: camera, lights, corners, `project`. Bind group 0.
pub fn view_wgsl() -> String {
    [SHADING_POINT_WGSL, CORNER_WGSL, include_str!("view.wgsl")].concat()
}

const COLOUR: TextureFormat = TextureFormat::Rgba32Float;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Bytes of a pixel of the target.
const PIXEL: u64 = 16;
/// Approximate size of the bands in which rows are read back.
const BAND_BYTES: u64 = 32 << 20;

/// Compiled pipelines, one for each pass over the scene.
pub(super) struct Rasteriser<'g> {
    pub(super) gpu: &'g Gpu,
    passes: Vec<Pass>,
    pub(super) view_layout: BindGroupLayout,
}

struct Pass {
    pipeline: wgpu::RenderPipeline,
    colours: usize,
}

/// Colours and depth of a frame. The colours of all passes follow each other.
pub struct Target {
    colours: Vec<(wgpu::Texture, wgpu::TextureView)>,
    depth_view: wgpu::TextureView,
}

impl Target {
    pub(super) fn views(&self) -> impl Iterator<Item = &wgpu::TextureView> {
        self.colours.iter().map(|(_, view)| view)
    }
}

/// Draws a scene as [`load_with_one_material`] loads it.
///
/// # Errors
/// Returns the errors of [`load_with_one_material`]; an error for images beyond the adapter's limits.
pub(super) fn draw_with_one_material(
    gpu: &Gpu,
    source: String,
    scene: &Scene,
    frame: Frame,
    textures: (&BindGroupLayout, BindGroup),
    words: [u32; 4],
) -> Result<LinearImage, GpuError> {
    let (rasteriser, loaded) = load_with_one_material(gpu, source, scene, textures, words)?;
    rasteriser.draw(&loaded, &scene.camera, frame)
}

/// Loads a scene whose parts all have `textures` as group 1, with its layout, and these words as a uniform block in
/// group 2.
///
/// # Errors
/// Returns an error if the source does not validate, with the compiler's message; any error that the driver reports.
pub(super) fn load_with_one_material<'g>(
    gpu: &'g Gpu,
    source: String,
    scene: &Scene,
    (layout, textures): (&BindGroupLayout, BindGroup),
    words: [u32; 4],
) -> Result<(Rasteriser<'g>, LoadedScene), GpuError> {
    let material_layout = bindings::layout(gpu, "material", ShaderStages::FRAGMENT, [(0, UNIFORM)]);
    let rasteriser = Rasteriser::new(gpu, source, &[layout, &material_layout])?;
    let uniform = gpu.buffer(bytemuck::cast_slice(&words), BufferUsages::UNIFORM);
    let material = bindings::group(gpu, &material_layout, [(0, uniform.as_entire_binding())]);
    let groups = vec![vec![textures, material]; scene.parts.len()];
    let loaded = load(gpu, &rasteriser.view_layout, scene, groups, [0; 2])?;
    Ok((rasteriser, loaded))
}

impl<'g> Rasteriser<'g> {
    /// Compiles a shader with the entry points `project` and `shade`. `layouts` are the layouts of the groups from 1 on.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn new(gpu: &'g Gpu, source: String, layouts: &[&BindGroupLayout]) -> Result<Self, GpuError> {
        Self::with_passes(gpu, source, layouts, &[("shade", 1)])
    }

    /// Compiles a shader with any passes over the scene: the fragment entry point of each, and the number of colours it
    /// writes. Every pass starts with an empty depth buffer, so that all of them see the same surfaces.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn with_passes(
        gpu: &'g Gpu,
        source: String,
        layouts: &[&BindGroupLayout],
        passes: &[(&str, usize)],
    ) -> Result<Self, GpuError> {
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: Some("scene"),
            source: ShaderSource::Wgsl(Cow::Owned(source)),
        });
        let entry = |binding, visibility, ty| BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let lights = buffer_type(BufferBindingType::Storage { read_only: true });
        let view_layout = gpu.device.create_bind_group_layout(&BindGroupLayoutDescriptor {
            label: Some("view"),
            entries: &[entry(0, ShaderStages::VERTEX_FRAGMENT, UNIFORM), entry(1, ShaderStages::FRAGMENT, lights)],
        });
        let groups: Vec<_> = std::iter::once(&view_layout).chain(layouts.iter().copied()).map(Some).collect();
        let layout = gpu.device.create_pipeline_layout(&PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let pipeline = |fragment: &str, colours: usize| {
            gpu.device.create_render_pipeline(&RenderPipelineDescriptor {
                label: Some("scene"),
                layout: Some(&layout),
                vertex: VertexState {
                    module: &module,
                    entry_point: Some("project"),
                    compilation_options: Default::default(),
                    buffers: &[Some(VertexBufferLayout {
                        array_stride: 4 * VERTEX_WORDS as u64,
                        step_mode: VertexStepMode::Vertex,
                        attributes: &vertex_attr_array![
                            0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Float32, 5 => Float32
                        ],
                    })],
                },
                primitive: PrimitiveState::default(),
                depth_stencil: Some(DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &vec![Some(COLOUR.into()); colours],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let passes =
            passes.iter().map(|(fragment, colours)| Pass { pipeline: pipeline(fragment, *colours), colours: *colours });
        let passes = passes.collect();
        gpu.check()?;
        Ok(Self { gpu, passes, view_layout })
    }

    /// Allocates colour and depth of `width` x `height` pixels.
    ///
    /// # Errors
    /// Returns an error for more pixels per side than the adapter's limit.
    pub(super) fn target(&self, width: usize, height: usize) -> Result<Target, GpuError> {
        let most = self.gpu.device.limits().max_texture_dimension_2d as usize;
        if width > most || height > most {
            let text = format!("found {width} x {height} pixels, expected at most {most} per side on this adapter");
            return Err(GpuError::TooLarge(text));
        }
        let texture = |format, usage| {
            self.gpu.device.create_texture(&TextureDescriptor {
                label: None,
                size: Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let colour = |_| {
            let texture = texture(COLOUR, usage);
            let view = view(&texture);
            (texture, view)
        };
        let colours = (0..self.passes.iter().map(|pass| pass.colours).sum()).map(colour).collect();
        let depth_view = view(&texture(DEPTH, TextureUsages::RENDER_ATTACHMENT));
        self.gpu.check()?;
        Ok(Target { colours, depth_view })
    }

    /// Draws one sample per pixel, `sample` = `[column, row]` of the `samples` x `samples` in each, and waits until it
    /// is done.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub(super) fn draw_sample(
        &self,
        scene: &LoadedScene,
        camera: &Camera,
        target: &Target,
        sample: [usize; 2],
        samples: usize,
    ) -> Result<(), GpuError> {
        let texture = &target.colours[0].0;
        let size = [texture.width() as f64, texture.height() as f64];
        let words = view_words(scene, camera, size, sample, samples);
        self.gpu.queue.write_buffer(&scene.view, 0, bytemuck::cast_slice(&words));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut views = target.views();
        for Pass { pipeline, colours } in &self.passes {
            let attachment = |view| {
                Some(RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: Operations { load: LoadOp::Clear(wgpu::Color::TRANSPARENT), store: StoreOp::Store },
                })
            };
            let attachments: Vec<_> = views.by_ref().take(*colours).map(attachment).collect();
            let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
                label: None,
                color_attachments: &attachments,
                depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                    view: &target.depth_view,
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &scene.view_group, &[]);
            for part in &scene.parts {
                for (index, group) in (1..).zip(&part.groups) {
                    pass.set_bind_group(index, group, &[]);
                }
                pass.set_vertex_buffer(0, part.vertices.slice(..));
                pass.set_index_buffer(part.indices.slice(..), wgpu::IndexFormat::Uint32);
                pass.draw_indexed(0..part.count, 0, 0..1);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()
    }

    /// Draws a whole image: the mean of `samples²` samples per pixel, summed in a fixed order.
    ///
    /// # Errors
    /// Images beyond the adapter's limits; any error that the driver reports.
    pub(super) fn draw(&self, scene: &LoadedScene, camera: &Camera, frame: Frame) -> Result<LinearImage, GpuError> {
        let target = self.target(frame.width, frame.height)?;
        let mut sums = vec![[0.0f64; 4]; frame.width * frame.height];
        for row in 0..frame.samples {
            for column in 0..frame.samples {
                self.draw_sample(scene, camera, &target, [column, row], frame.samples)?;
                self.add(&target, &mut sums)?;
            }
        }
        let share = 1.0 / (frame.samples * frame.samples) as f64;
        let mean = |sum: &[f64; 4]| [0, 1, 2].map(|channel| (sum[channel] * share) as f32);
        Ok(LinearImage {
            width: frame.width,
            height: frame.height,
            pixels: sums.iter().map(mean).collect(),
            background: scene.background,
            coverage: sums.iter().map(|sum| (sum[3] * share) as f32).collect(),
        })
    }

    /// Reads a target back and adds it to `sums`, band by band.
    fn add(&self, target: &Target, sums: &mut [[f64; 4]]) -> Result<(), GpuError> {
        let texture = &target.colours[0].0;
        let (width, height) = (texture.width(), texture.height());
        let row_bytes = (u64::from(width) * PIXEL).next_multiple_of(u64::from(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT));
        let band = (BAND_BYTES / row_bytes).clamp(1, u64::from(height)) as u32;
        let buffer = self.gpu.read_buffer(row_bytes * u64::from(band));
        for first in (0..height).step_by(band as usize) {
            let rows = band.min(height - first);
            let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(row_bytes as u32),
                        rows_per_image: None,
                    },
                },
                Extent3d { width, height: rows, depth_or_array_layers: 1 },
            );
            self.gpu.queue.submit([encoder.finish()]);
            let band_sums = &mut sums[(first * width) as usize..][..(rows * width) as usize];
            self.gpu.read(&buffer, |bytes| {
                for (row, sums) in
                    bytes.chunks_exact(row_bytes as usize).zip(band_sums.chunks_exact_mut(width as usize))
                {
                    let pixels: &[[f32; 4]] = bytemuck::cast_slice(&row[..width as usize * PIXEL as usize]);
                    for (pixel, sum) in pixels.iter().zip(sums) {
                        (0..4).for_each(|channel| sum[channel] += f64::from(pixel[channel]));
                    }
                }
            })?;
        }
        Ok(())
    }
}
