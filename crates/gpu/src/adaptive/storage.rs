//! A G-buffer on the device, with the buffers that adaptive shading fills for it.

use super::super::bindings;
use super::super::device::{Gpu, GpuError};
use super::super::raster::Target;
use super::layouts::{Layouts, STORAGE_BUFFERS};
use brdfc_render::adaptive::coarsest_of;
use brdfc_render::scene::{Camera, Frame};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};

/// Maximum number of slices of samples, and of nodes with slices, per submission.
pub(super) const SLICES: usize = 1 << 19;
/// Number of levels in the shader's `Rendering`.
const MAX_LEVELS: usize = 20;
/// 32-bit words of the shader's `Job`.
pub(super) const JOB_WORDS: usize = 4 + super::material::WORDS;
/// 32-bit words of the shader's `Settings`.
pub(super) const SETTINGS_WORDS: usize = 12;
/// Bytes of a vector of four 32-bit numbers.
const VECTOR: u64 = 16;
/// Bytes of the shader's `Node`.
const NODE: u64 = 12;
/// Minimum number of vectors of any buffer: reading a point back takes five.
const MIN_VECTORS: u64 = 64;

/// Points that a camera sees of a scene, on the device.
pub struct LoadedGBuffer {
    /// Frame of the rendering.
    pub(super) frame: Frame,
    pub(super) camera: Camera,
    pub(super) antialiasing_levels: u32,
    /// Points per row, and rows.
    pub(super) size: [usize; 2],
    /// Width, height and first node of each level of the pyramid, finest first.
    pub(super) levels: Vec<[usize; 3]>,
    pub(super) settings: Buffer,
    pub(super) job: Buffer,
    pub(super) group: BindGroup,
    pub(super) storage: Storage,
}

/// Buffers that `points.wgsl` declares in group 1.
pub(super) struct Storage {
    pub(super) predicted: Buffer,
    pub(super) nodes: Buffer,
    pub(super) computed: Buffer,
    pub(super) outcomes: Buffer,
    pub(super) slices: Buffer,
    pub(super) gathers: Buffer,
    pub(super) sums: Buffer,
    pub(super) image: Buffer,
}

impl LoadedGBuffer {
    /// Points per row, and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    pub(super) fn points(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Number of points that the read-back buffer holds.
    pub(super) fn points_at_once(&self) -> usize {
        (self.storage.computed.size() / (5 * VECTOR)) as usize
    }
}

/// Allocates the buffers for a target's points.
///
/// # Errors
/// Returns [`GpuError::TooLarge`] for more than the adapter binds at once; any error that the driver reports.
pub(super) fn allocate(
    gpu: &Gpu,
    layouts: &Layouts,
    target: &Target,
    camera: &Camera,
    frame: Frame,
    antialiasing_levels: u32,
) -> Result<LoadedGBuffer, GpuError> {
    let size = [frame.width << antialiasing_levels, frame.height << antialiasing_levels];
    let levels = levels(size);
    let nodes = levels.iter().map(|[width, height, _]| (width * height) as u64).sum::<u64>();
    let limits = gpu.device.limits();
    let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let required = VECTOR * nodes.max(MIN_VECTORS);
    if required > most || levels.len() > MAX_LEVELS {
        let [width, height] = size;
        let text = format!(
            "adaptive shading of {width} x {height} points takes a buffer of {required} bytes; this adapter binds at \
             most {most}"
        );
        return Err(GpuError::TooLarge(text));
    }
    let uniform = |words: usize| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 4 * words as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    };
    let rendering = rendering_words(camera, frame, antialiasing_levels, size, &levels);
    let rendering = gpu.buffer(bytemuck::cast_slice(&rendering), BufferUsages::UNIFORM);
    let (settings, job) = (uniform(SETTINGS_WORDS), uniform(JOB_WORDS));
    let uniforms = [&rendering, &settings, &job].map(Buffer::as_entire_binding);
    let seen = uniforms.into_iter().chain(target.views().map(BindingResource::TextureView));
    let points = (size[0] * size[1]) as u64;
    let storage = Storage {
        predicted: storage(gpu, VECTOR * points),
        nodes: storage(gpu, NODE * nodes),
        computed: storage(gpu, required),
        outcomes: storage(gpu, VECTOR * points),
        slices: storage(gpu, VECTOR * SLICES as u64),
        gathers: storage(gpu, VECTOR * SLICES as u64),
        sums: storage(gpu, VECTOR * SLICES as u64),
        image: storage(gpu, VECTOR * (frame.width * frame.height) as u64),
    };
    let all: [&Buffer; STORAGE_BUFFERS as usize] = [
        &storage.predicted,
        &storage.nodes,
        &storage.computed,
        &storage.outcomes,
        &storage.slices,
        &storage.gathers,
        &storage.sums,
        &storage.image,
    ];
    let group = bindings::group(gpu, &layouts.points, (0..).zip(seen.chain(all.map(Buffer::as_entire_binding))));
    gpu.check()?;
    let camera = *camera;
    Ok(LoadedGBuffer { frame, camera, antialiasing_levels, size, levels, settings, job, group, storage })
}

fn storage(gpu: &Gpu, bytes: u64) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: bytes,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Sizes of the levels, as in [`brdfc_render::adaptive::Pyramid`], and the first node of each.
fn levels([width, height]: [usize; 2]) -> Vec<[usize; 3]> {
    let mut levels = vec![[width, height, 0]];
    for _ in 0..coarsest_of(width, height) {
        let [width, height, first] = levels[levels.len() - 1];
        levels.push([width.div_ceil(2), height.div_ceil(2), first + width * height]);
    }
    levels
}

/// The shader's `Rendering`.
fn rendering_words(
    camera: &Camera,
    frame: Frame,
    antialiasing_levels: u32,
    size: [usize; 2],
    levels: &[[usize; 3]],
) -> Vec<u32> {
    let (right, up, _) = camera.basis();
    let mut words = Vec::with_capacity(20 + 4 * MAX_LEVELS);
    for vector in [camera.eye, right, up] {
        words.extend(vector.map(|c| (c as f32).to_bits()));
        words.push(0);
    }
    words.extend([size[0], size[1], frame.width, frame.height].map(|c| c as u32));
    words.extend([1 << antialiasing_levels, levels.len() as u32 - 1, 0, 0]);
    for [width, height, first] in levels {
        words.extend([*width as u32, *height as u32, *first as u32, 0]);
    }
    words.resize(20 + 4 * MAX_LEVELS, 0);
    words
}
