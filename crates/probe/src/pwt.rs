//! Polynomial wavelet trees evaluated by the shader: what tests hold against the CPU decoder.

use super::items::ItemPipeline;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError, pwt_textures};
use wgpu::ShaderStages;

/// The compute entry point over the decoder.
pub const EVALUATE_PWT_WGSL: &str = concat!(include_str!("evaluate_pwt.wgsl"), include_str!("items.wgsl"));

/// Most queries at once: 32 bytes each, within what every adapter binds.
const MAX_QUERIES: usize = 1 << 21;

/// Where and under which light a rendering is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtQuery {
    /// 0 to 1 across the rendering and down from its top.
    pub uv: [f32; 2],
    /// Mipmap level, 0 at the rendering's own resolution.
    pub level: f32,
    /// Unit vector to the light.
    pub light: [f32; 3],
}

/// What the shader returns for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtAnswer {
    /// Channels in the domain of the pack.
    pub channels: [f32; 3],
    /// Linear RGB.
    pub value: [f32; 3],
    /// Fetches of the channels, where the entry point was instrumented; else 0.
    pub fetches: f32,
}

/// A pack on the device.
pub struct LoadedPwt {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct PwtEvaluator<'g> {
    pipeline: ItemPipeline<'g>,
    slots: Slots,
}

impl<'g> PwtEvaluator<'g> {
    /// Compiles the shipped shader.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, PWT_WGSL, EVALUATE_PWT_WGSL)
    }

    /// Compiles another decoder and entry point, such as a broken or an instrumented one.
    ///
    /// # Errors
    /// A source that does not validate, with the compiler's message.
    pub fn with_shaders(gpu: &'g Gpu, decoder: &str, entry_point: &str) -> Result<Self, GpuError> {
        let slots = pwt_textures::slots(gpu, ShaderStages::COMPUTE);
        let source = format!("{decoder}\n{entry_point}");
        let pipeline = ItemPipeline::new(gpu, "polynomial wavelet tree", source, &slots.layout)?;
        Ok(Self { pipeline, slots })
    }

    /// Uploads a pack.
    ///
    /// # Errors
    /// More than the adapter takes; what the driver reports.
    pub fn load(&self, pack: &PwtPack, frame: FrameBlock) -> Result<LoadedPwt, GpuError> {
        Ok(LoadedPwt { group: pwt_textures::upload(self.pipeline.gpu(), &self.slots, pack, frame)? })
    }

    /// Evaluates and reads back, in the order of `queries`. Below the horizon channels are whatever the terms give.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn eval(&self, loaded: &LoadedPwt, queries: &[PwtQuery]) -> Result<Vec<PwtAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MAX_QUERIES) {
            let words: Vec<[f32; 8]> = chunk.iter().map(query_words).collect();
            let items = self.pipeline.load(&words, chunk.len(), 32, [0; 2])?;
            let answers: Vec<[f32; 8]> = self.pipeline.answers(&items, &loaded.group)?;
            all.extend(answers.into_iter().map(|w| PwtAnswer {
                channels: [w[0], w[1], w[2]],
                value: [w[4], w[5], w[6]],
                fetches: w[3],
            }));
        }
        Ok(all)
    }
}

fn query_words(query: &PwtQuery) -> [f32; 8] {
    let ([u, v], [x, y, z]) = (query.uv, query.light);
    [u, v, query.level, 0.0, x, y, z, 0.0]
}
