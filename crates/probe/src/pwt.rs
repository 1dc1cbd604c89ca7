//! Polynomial wavelet trees evaluated by the shader, for comparison with the CPU decoder.

use super::items::ItemPipeline;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::pwt::PwtPack;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError, pwt_textures};
use wgpu::ShaderStages;

/// The compute entry point over the decoder.
pub const EVALUATE_PWT_WGSL: &str = concat!(include_str!("evaluate_pwt.wgsl"), include_str!("items.wgsl"));

/// Maximum number of queries at once: 48 bytes each, within the limits of every adapter.
const MAX_QUERIES: usize = 1 << 20;

/// Place, view and light at which a tree is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtQuery {
    /// 0 to 1 across the image and down from its top.
    pub uv: [f32; 2],
    /// Mipmap level, 0 at the image's own resolution.
    pub level: f32,
    /// Unit vector to the light.
    pub light: [f32; 3],
    /// Unit vector to the viewer.
    pub outgoing: [f32; 3],
    /// View of the sum.
    pub view: u32,
}

/// Result of the shader for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PwtAnswer {
    /// RGB in the domain of the pack.
    pub sum: [f32; 3],
    /// Linear RGB.
    pub value: [f32; 3],
    /// Fetches of the sum if the entry point is instrumented, otherwise 0.
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
    /// Returns an error that the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, PWT_WGSL, EVALUATE_PWT_WGSL)
    }

    /// Compiles another decoder and entry point, such as a deliberately broken or an instrumented one.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if a source does not validate.
    pub fn with_shaders(gpu: &'g Gpu, decoder: &str, entry_point: &str) -> Result<Self, GpuError> {
        let slots = pwt_textures::slots(gpu, ShaderStages::COMPUTE);
        let source = format!("{decoder}\n{entry_point}");
        let pipeline = ItemPipeline::new(gpu, "polynomial wavelet tree", source, &slots.layout)?;
        Ok(Self { pipeline, slots })
    }

    /// Uploads a pack.
    ///
    /// # Errors
    /// Returns an error for more than the adapter takes; any error that the driver reports.
    pub fn load(&self, pack: &PwtPack, frame: FrameBlock) -> Result<LoadedPwt, GpuError> {
        Ok(LoadedPwt { group: pwt_textures::upload(self.pipeline.gpu(), &self.slots, pack, frame)? })
    }

    /// Evaluates and reads back, in the order of `queries`. Sums below the horizon are extrapolated.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn eval(&self, loaded: &LoadedPwt, queries: &[PwtQuery]) -> Result<Vec<PwtAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MAX_QUERIES) {
            let words: Vec<[f32; 12]> = chunk.iter().map(query_words).collect();
            let items = self.pipeline.load(&words, chunk.len(), 32, [0; 2])?;
            let answers: Vec<[f32; 8]> = self.pipeline.answers(&items, &loaded.group)?;
            all.extend(answers.into_iter().map(|w| PwtAnswer {
                sum: [w[0], w[1], w[2]],
                value: [w[4], w[5], w[6]],
                fetches: w[3],
            }));
        }
        Ok(all)
    }
}

fn query_words(query: &PwtQuery) -> [f32; 12] {
    let ([u, v], [x, y, z], [ox, oy, oz]) = (query.uv, query.light, query.outgoing);
    [u, v, query.level, 0.0, x, y, z, 0.0, ox, oy, oz, query.view as f32]
}
