//! Packs evaluated at direction pairs by the shader, for comparison with the CPU decoder and for throughput
//! measurements.

use super::items::{ItemPipeline, Items};
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use brdfc_formats::{BrdfPack, BrdfShader, PackKind};
use brdfc_gpu::bindings::Slots;
use brdfc_gpu::{Gpu, GpuError, SliceFilter, pack};
use wgpu::ShaderStages;

/// The compute entry point with the decoder of wavelet packs.
pub const EVALUATE_WGSL: &str =
    concat!(include_str!("evaluate_wavelet.wgsl"), include_str!("evaluate.wgsl"), include_str!("items.wgsl"));

/// The compute entry point with the decoder of table packs.
pub const EVALUATE_TABLE_WGSL: &str =
    concat!(include_str!("evaluate_table.wgsl"), include_str!("evaluate.wgsl"), include_str!("items.wgsl"));

/// The entry point alone, for a decoder with the functions that it calls.
pub const EVALUATE_ENTRY_WGSL: &str = concat!(include_str!("evaluate.wgsl"), include_str!("items.wgsl"));

/// Maximum number of pairs at once: 32 bytes each in two buffers, within the limits of every adapter.
const MAX_PAIRS: usize = 1 << 21;

/// Result of the shader for a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluated {
    /// `ln(f / μ + ε)`; 0 if a direction is not above the horizon.
    pub log_value: [f32; 3],
    /// `f_r`, 1/sr.
    pub f_r: [f32; 3],
    /// Result of the entry point's function `fetches`: 0 unless the source is instrumented.
    pub fetches: f32,
}

/// A pack on the device, with its filter.
pub struct LoadedPack {
    group: wgpu::BindGroup,
}

/// A compiled compute pipeline.
pub struct Evaluator<'g> {
    pipeline: ItemPipeline<'g>,
    slots: Slots,
    /// Value of the entry point's variable `change`, for decoders in which a test made changes that depend on it.
    /// Applies to pairs that are loaded afterwards.
    pub change: u32,
}

/// Pairs on the device, ready for any number of runs.
pub struct LoadedPairs {
    items: Items,
}

impl<'g> Evaluator<'g> {
    /// Compiles the shipped shader of wavelet packs.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, WAVELET_BRDF_WGSL, EVALUATE_WGSL)
    }

    /// Compiles the shipped shader of table packs.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn of_tables(gpu: &'g Gpu) -> Result<Self, GpuError> {
        Self::with_shaders(gpu, TABLE_BRDF_WGSL, EVALUATE_TABLE_WGSL)
    }

    /// Compiles the shipped shader of a BRDF codec, for `f_r` alone: log values are 0.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn of(gpu: &'g Gpu, kind: PackKind, brdf: BrdfShader) -> Result<Self, GpuError> {
        let BrdfShader { either, level_of_detail, .. } = brdf;
        let calls = format!(
            "fn f_r_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {{\n{either}\n}}\n\
             fn log_value_of(wi: vec3<f32>, wo: vec3<f32>, level: f32, hardware: bool) -> vec3<f32> {{\n    \
             return vec3<f32>(0.0);\n}}\n\
             fn level_at(distance: f32) -> f32 {{\n    return {level_of_detail};\n}}\n"
        );
        Self::with_shaders(gpu, &(kind.descriptor().wgsl)(), &(calls + EVALUATE_ENTRY_WGSL))
    }

    /// Compiles other sources, such as instrumented ones. `entry` is appended to `decoder`.
    ///
    /// # Errors
    /// Returns an error with the compiler's message if a source does not validate.
    pub fn with_shaders(gpu: &'g Gpu, decoder: &str, entry: &str) -> Result<Self, GpuError> {
        let slots = pack::slots(gpu, ShaderStages::COMPUTE);
        let pipeline = ItemPipeline::new(gpu, "evaluate", format!("{decoder}\n{entry}"), &slots.layout)?;
        Ok(Self { pipeline, slots, change: 0 })
    }

    /// Uploads a pack of the compiled shader's codec. `filter` applies to wavelet packs.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn load(&self, pack: &BrdfPack, filter: Filter) -> Result<LoadedPack, GpuError> {
        let frame = FrameBlock { blend: filter, ..FrameBlock::default() };
        let group = self.slots.bind(self.pipeline.gpu(), &pack.bindings().all, frame)?;
        Ok(LoadedPack { group })
    }

    /// Uploads at most 2 million pairs, with the level of detail and the unit that filters slices. A negative level is
    /// minus the distance that determines the level in the shader.
    ///
    /// # Errors
    /// Returns an error for too many pairs; any error that the driver reports.
    pub fn load_pairs(
        &self,
        pairs: &[DirectionPair],
        level: f32,
        slices: SliceFilter,
    ) -> Result<LoadedPairs, GpuError> {
        if pairs.len() > MAX_PAIRS {
            let text = format!("found {} direction pairs, expected at most {MAX_PAIRS}", pairs.len());
            return Err(GpuError::TooLarge(text));
        }
        let words: Vec<[f32; 8]> = pairs.iter().map(pair_words).collect();
        let mode = self.change << 1 | u32::from(slices == SliceFilter::Hardware);
        Ok(LoadedPairs { items: self.pipeline.load(&words, pairs.len(), 32, [level.to_bits(), mode])? })
    }

    /// Evaluates once and waits until it is done, without reading back.
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn run(&self, pack: &LoadedPack, pairs: &LoadedPairs) -> Result<(), GpuError> {
        self.pipeline.run(&pairs.items, &pack.group)
    }

    /// Evaluates and reads back, in the order of `pairs`. `level` as in [`Self::load_pairs`].
    ///
    /// # Errors
    /// Returns an error that the driver reports.
    pub fn eval(
        &self,
        pack: &LoadedPack,
        pairs: &[DirectionPair],
        level: f32,
        slices: SliceFilter,
    ) -> Result<Vec<Evaluated>, GpuError> {
        let mut all = Vec::with_capacity(pairs.len());
        for chunk in pairs.chunks(MAX_PAIRS) {
            let loaded = self.load_pairs(chunk, level, slices)?;
            let values: Vec<[f32; 8]> = self.pipeline.answers(&loaded.items, &pack.group)?;
            all.extend(values.into_iter().map(|w| Evaluated {
                log_value: [w[0], w[1], w[2]],
                f_r: [w[4], w[5], w[6]],
                fetches: w[3],
            }));
        }
        Ok(all)
    }
}

fn pair_words(pair: &DirectionPair) -> [f32; 8] {
    let [[x, y, z], [a, b, c]] = [pair.incoming, pair.outgoing].map(|direction| direction.map(|c| c as f32));
    [x, y, z, 0.0, a, b, c, 0.0]
}
