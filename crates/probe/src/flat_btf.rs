//! Flat BTFs evaluated by the shader, for comparison with the CPU decoder.

use super::items::ItemPipeline;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::shader::FLAT_BTF_WGSL;
use brdfc_formats::flat_btf::{FlatBtfDecoder, ViewWeights};
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError, flat_textures};
use wgpu::ShaderStages;

/// The compute entry point over the decoder.
pub const EVALUATE_FLAT_BTF_WGSL: &str = concat!(include_str!("evaluate_flat_btf.wgsl"), include_str!("items.wgsl"));

/// Maximum number of queries at once: 112 bytes each, within the limits of every adapter.
const MAX_QUERIES: usize = 1 << 20;

/// Point, viewer and light at which a flat BTF is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfQuery {
    /// Point of the reference plane, in tiles.
    pub uv: [f32; 2],
    /// Unit vector to the viewer.
    pub view: [f32; 3],
    /// Unit vector to the light, for the light form.
    pub light: [f32; 3],
    /// Sampled views of the full form.
    pub views: ViewWeights,
    /// Sampled lights of the full form.
    pub lights: ViewWeights,
}

/// Result of the shader for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfAnswer {
    /// Parameters and height of the visible point.
    pub indirection: [f32; 3],
    /// The full form; zero without views.
    pub full: [f32; 3],
    /// The light form.
    pub light: [f32; 3],
}

/// A flat BTF on the device.
pub struct LoadedFlatBtf {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct FlatBtfEvaluator<'g> {
    pipeline: ItemPipeline<'g>,
    slots: Slots,
}

impl<'g> FlatBtfEvaluator<'g> {
    /// Compiles the shipped shader.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shader(gpu, FLAT_BTF_WGSL)
    }

    /// Compiles another decoder, such as a deliberately broken one.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if the source does not validate.
    pub fn with_shader(gpu: &'g Gpu, decoder: &str) -> Result<Self, GpuError> {
        let slots = flat_textures::slots(gpu, ShaderStages::COMPUTE);
        let source = format!("{decoder}\n{EVALUATE_FLAT_BTF_WGSL}");
        let pipeline = ItemPipeline::new(gpu, "flat BTF", source, &slots.layout)?;
        Ok(Self { pipeline, slots })
    }

    /// Uploads a flat BTF. Without views the texture of the full form is one empty texel.
    ///
    /// # Errors
    /// Returns an error for more than the adapter takes; any error that the driver reports.
    pub fn load(&self, decoder: &FlatBtfDecoder, frame: FrameBlock) -> Result<LoadedFlatBtf, GpuError> {
        let gpu = self.pipeline.gpu();
        Ok(LoadedFlatBtf { group: flat_textures::upload(gpu, &self.slots, decoder, frame, true, None)? })
    }

    /// Evaluates and reads back, in the order of `queries`.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn eval(&self, loaded: &LoadedFlatBtf, queries: &[FlatBtfQuery]) -> Result<Vec<FlatBtfAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MAX_QUERIES) {
            let words: Vec<[u32; 28]> = chunk.iter().map(query_words).collect();
            let items = self.pipeline.load(&words, chunk.len(), 48, [0; 2])?;
            let answers: Vec<[f32; 12]> = self.pipeline.answers(&items, &loaded.group)?;
            all.extend(answers.into_iter().map(|w| FlatBtfAnswer {
                indirection: [w[0], w[1], w[2]],
                full: [w[4], w[5], w[6]],
                light: [w[8], w[9], w[10]],
            }));
        }
        Ok(all)
    }
}

fn query_words(query: &FlatBtfQuery) -> [u32; 28] {
    let mut words = [0; 28];
    let floats = [
        (0, &query.uv[..]),
        (4, &query.view),
        (8, &query.light),
        (16, &query.views.weights),
        (24, &query.lights.weights),
    ];
    for (start, values) in floats {
        for (word, value) in words[start..].iter_mut().zip(values) {
            *word = value.to_bits();
        }
    }
    words[12..15].copy_from_slice(&query.views.indices);
    words[20..23].copy_from_slice(&query.lights.indices);
    words
}
