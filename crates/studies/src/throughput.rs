//! BRDF evaluations per second, by the shader and by the CPU decoder (section 6.3 of Claustres et al. 2007).

use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::{BrdfDecoder, BrdfPack};
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

/// Rates of packs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Throughput {
    /// What ran the shader.
    pub adapter: AdapterDescription,
    /// Threads of the last column.
    pub threads: usize,
    /// A row for each table, and for each filter and level of detail of wavelet packs.
    pub rows: Vec<Rate>,
}

/// Evaluations per second of one pack.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Rate {
    /// `table`, `factored` or `wavelet`.
    pub codec: String,
    /// Of wavelet packs `nearest` or `bilinear`, over the four inner cells; slices are filtered bilinearly by the sampler in
    /// both. Of tables `trilinear`.
    pub filter: String,
    /// Level of detail; tables have one.
    pub level: u32,
    /// Texture fetches of one evaluation with the sampler.
    pub fetches: u32,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// The shader, filtered by the sampler.
    pub shader: f64,
    /// The shader, filtered with exact weights.
    pub shader_exact: f64,
    /// The CPU decoder on one thread.
    pub cpu_one: f64,
    /// The CPU decoder on all threads.
    pub cpu_all: f64,
}

/// One row that is to be measured.
struct Case<'a> {
    pack: &'a BrdfPack,
    filter: Filter,
    name: &'static str,
    level: u32,
    fetches: u32,
}

/// Measures packs. `progress` hears how many rows of how many are done.
///
/// # Errors
/// What the driver reports.
pub fn throughput(gpu: &Gpu, packs: &[BrdfPack], progress: impl Fn(usize, usize)) -> Result<Throughput, GpuError> {
    let (of_tables, of_wavelets) = (Evaluator::of_tables(gpu)?, Evaluator::new(gpu)?);
    let pairs = random_pairs(SHADER_PAIRS, SEED);
    let cases: Vec<Case<'_>> = packs.iter().flat_map(cases).collect();
    let mut rows = Vec::new();
    for case in &cases {
        let evaluator = match case.pack {
            BrdfPack::Table(_) => &of_tables,
            BrdfPack::Wavelet(_) => &of_wavelets,
        };
        let (level, decoder) = (case.level as f32, BrdfDecoder::new(case.pack));
        let loaded = evaluator.load(case.pack, case.filter)?;
        let rate = |slices| -> Result<f64, GpuError> {
            let on_device = evaluator.load_pairs(&pairs, level, slices)?;
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
            let eval = |pair: &DirectionPair| decoder.eval(*pair, level, case.filter)[0];
            let run = || -> f32 { if all { pairs.par_iter().map(eval).sum() } else { pairs.iter().map(eval).sum() } };
            pairs.len() as f64 / best_of(run)
        };
        rows.push(Rate {
            codec: case.pack.codec().to_owned(),
            filter: case.name.to_owned(),
            level: case.level,
            fetches: case.fetches,
            bytes_on_gpu: case.pack.gpu_bytes(),
            shader: rate(SliceFilter::Hardware)?,
            shader_exact: rate(SliceFilter::Exact)?,
            cpu_one: cpu(&pairs[..CPU_PAIRS], false),
            cpu_all: cpu(&pairs[..CPU_PAIRS], true),
        });
        progress(rows.len(), cases.len());
    }
    Ok(Throughput { adapter: gpu.description().clone(), threads: rayon::current_num_threads(), rows })
}

/// What is measured of a pack.
fn cases(pack: &BrdfPack) -> Vec<Case<'_>> {
    match pack {
        BrdfPack::Table(_) => {
            vec![Case { pack, filter: Filter::Bilinear, name: "trilinear", level: 0, fetches: pack.fetches() }]
        }
        BrdfPack::Wavelet(wavelet) => [(Filter::Slices, "nearest", 1), (Filter::Bilinear, "bilinear", 4)]
            .into_iter()
            .flat_map(|(filter, name, reconstructions)| {
                (0..=wavelet.header.levels).map(move |level| {
                    let fetches = reconstructions * (4 * level + 1);
                    Case { pack, filter, name, level, fetches }
                })
            })
            .collect(),
    }
}

fn best_of<T>(run: impl Fn() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}
