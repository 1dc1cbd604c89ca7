//! Flat BTFs evaluated by the shader, for comparison with the CPU decoder.

use super::items::ItemPipeline;
use brdfc_formats::PackKind;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_formats::flat_btf::{FlatBtfDecoder, MacroSurface, SampledDirections};
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError, flat_textures};
use wgpu::ShaderStages;

/// The compute entry point over the decoder.
pub const EVALUATE_FLAT_BTF_WGSL: &str = concat!(include_str!("evaluate_flat_btf.wgsl"), include_str!("items.wgsl"));

/// Maximum number of queries at once: 80 bytes each, within the limits of every adapter.
const MAX_QUERIES: usize = 1 << 20;

/// Point, viewer and light at which a flat BTF is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfQuery {
    /// Point of the reference plane, in tiles.
    pub uv: [f32; 2],
    /// Level of detail of the flat BTF, 0 the finest.
    pub level: f32,
    /// Unit vector to the viewer.
    pub view: [f32; 3],
    /// Unit vector to the light.
    pub light: [f32; 3],
    /// The surface around the point.
    pub surface: MacroSurface,
}

/// Result of the shader for a query.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatBtfAnswer {
    /// Position of the visible point over the reference plane, in tiles.
    pub at: [f32; 2],
    /// Height of the visible point, 0 to 1.
    pub height: f32,
    /// Sheet of the visible point: 0 base, 1 top, 2 underside.
    pub sheet: u32,
    /// Parameters of the visible point.
    pub parameters: [f32; 2],
    /// Height of the visible point above the point that is drawn, in its frame and in tiles.
    pub rise: f32,
    /// Value of the visible point, linear RGB.
    pub value: [f32; 3],
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
        Self::with_shader(gpu, &flat_btf_value_wgsl())
    }

    /// Compiles another decoder, such as a deliberately broken one.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if the source does not validate.
    pub fn with_shader(gpu: &'g Gpu, decoder: &str) -> Result<Self, GpuError> {
        let slots = flat_textures::slots(gpu, PackKind::FlatBtf, ShaderStages::COMPUTE);
        let source = format!("{decoder}\n{EVALUATE_FLAT_BTF_WGSL}");
        let pipeline = ItemPipeline::new(gpu, "flat BTF", source, &slots.layout)?;
        Ok(Self { pipeline, slots })
    }

    /// Uploads a flat BTF. One with components needs the meshes of its directions.
    ///
    /// # Errors
    /// Returns an error for more than the adapter takes; any error that the driver reports.
    pub fn load(
        &self,
        decoder: &FlatBtfDecoder,
        frame: FrameBlock,
        directions: Option<&SampledDirections>,
    ) -> Result<LoadedFlatBtf, GpuError> {
        let gpu = self.pipeline.gpu();
        Ok(LoadedFlatBtf { group: flat_textures::upload(gpu, &self.slots, decoder, frame, directions)? })
    }

    /// Evaluates and reads back, in the order of `queries`.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn eval(&self, loaded: &LoadedFlatBtf, queries: &[FlatBtfQuery]) -> Result<Vec<FlatBtfAnswer>, GpuError> {
        let mut all = Vec::with_capacity(queries.len());
        for chunk in queries.chunks(MAX_QUERIES) {
            let words: Vec<[f32; 20]> = chunk.iter().map(query_words).collect();
            let items = self.pipeline.load(&words, chunk.len(), 48, [0; 2])?;
            let answers: Vec<[f32; 12]> = self.pipeline.answers(&items, &loaded.group)?;
            all.extend(answers.into_iter().map(|w| FlatBtfAnswer {
                at: [w[0], w[1]],
                height: w[2],
                sheet: w[3] as u32,
                parameters: [w[4], w[5]],
                rise: w[6],
                value: [w[8], w[9], w[10]],
            }));
        }
        Ok(all)
    }
}

fn query_words(query: &FlatBtfQuery) -> [f32; 20] {
    let ([u, v], [x, y, z], [a, b, c]) = (query.uv, query.view, query.light);
    let MacroSurface { curvature: [uu, uv, vv], height, stretch: [ut, ub, vt, vb] } = query.surface;
    [u, v, query.level, 0.0, x, y, z, 0.0, a, b, c, 0.0, uu, uv, vv, height, ut, ub, vt, vb]
}
