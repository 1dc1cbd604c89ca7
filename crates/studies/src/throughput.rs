//! BRDF evaluations per second, by the shader and by the CPU decoder (section 6.3 of Claustres et al. 2007).

use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_gpu::{AdapterDescription, Evaluator, Gpu, GpuError, SliceFilter};
use brdfc_metrics::sampling::random_pairs;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Pairs per run of the shader.
const SHADER_PAIRS: usize = 1 << 17;
/// Pairs per run on the CPU.
const CPU_PAIRS: usize = 1 << 15;
/// Runs, of which the fastest counts.
const RUNS: usize = 3;
const SEED: u64 = 5;

/// Rates of one pack.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Throughput {
    /// What ran the shader.
    pub adapter: AdapterDescription,
    /// Threads of the last column.
    pub threads: usize,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// A row for each filter and level of detail.
    pub rows: Vec<Rate>,
}

/// Evaluations per second at one level of detail.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Rate {
    /// `nearest` or `bilinear`, over the four inner cells; slices are filtered bilinearly by the sampler in both.
    pub filter: String,
    /// Level of detail.
    pub level: u32,
    /// Texture fetches of one evaluation with the sampler.
    pub fetches: u32,
    /// The shader, slices filtered by the sampler.
    pub shader: f64,
    /// The shader, slices filtered with exact weights.
    pub shader_exact: f64,
    /// The CPU decoder on one thread.
    pub cpu_one: f64,
    /// The CPU decoder on all threads.
    pub cpu_all: f64,
}

/// Measures a pack. `progress` hears how many rows of how many are done.
///
/// # Errors
/// What the driver reports.
pub fn throughput(gpu: &Gpu, pack: &WaveletPack, progress: impl Fn(usize, usize)) -> Result<Throughput, GpuError> {
    let evaluator = Evaluator::new(gpu)?;
    let decoder = WaveletDecoder::new(pack);
    let pairs = random_pairs(SHADER_PAIRS, SEED);
    let levels = pack.header.levels;
    let mut rows = Vec::new();
    for (filter, name, reconstructions) in [(Filter::Slices, "nearest", 1), (Filter::Bilinear, "bilinear", 4)] {
        let loaded = evaluator.load(pack, filter)?;
        for level in 0..=levels {
            let rate = |slices| -> Result<f64, GpuError> {
                let on_device = evaluator.load_pairs(&pairs, level as f32, slices)?;
                // The first run compiles and moves what is left to move.
                evaluator.run(&loaded, &on_device)?;
                let mut best = f64::INFINITY;
                for _ in 0..RUNS {
                    let start = Instant::now();
                    evaluator.run(&loaded, &on_device)?;
                    best = best.min(start.elapsed().as_secs_f64());
                }
                Ok(pairs.len() as f64 / best)
            };
            let cpu = |pairs: &[DirectionPair], all: bool| {
                let eval = |pair: &DirectionPair| decoder.eval(*pair, level as f32, filter)[0];
                let run =
                    || -> f32 { if all { pairs.par_iter().map(eval).sum() } else { pairs.iter().map(eval).sum() } };
                pairs.len() as f64 / best_of(run)
            };
            rows.push(Rate {
                filter: name.to_owned(),
                level,
                fetches: reconstructions * (4 * level + 1),
                shader: rate(SliceFilter::Hardware)?,
                shader_exact: rate(SliceFilter::Exact)?,
                cpu_one: cpu(&pairs[..CPU_PAIRS], false),
                cpu_all: cpu(&pairs[..CPU_PAIRS], true),
            });
            progress(rows.len(), 2 * (levels as usize + 1));
        }
    }
    Ok(Throughput {
        adapter: gpu.description().clone(),
        threads: rayon::current_num_threads(),
        grid: pack.header.grid(),
        rows,
    })
}

fn best_of<T>(run: impl Fn() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}
