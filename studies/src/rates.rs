//! Evaluations per second, by shaders and on the CPU.

use super::timing::best_of;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::{BrdfPack, PackKind};
use brdfc_gpu::{Gpu, GpuError, SliceFilter};
use brdfc_metrics::sampling::random_pairs;
use brdfc_probe::{Evaluator, LoadedPack};
use rayon::prelude::*;
use std::time::Instant;

/// Pairs per run of the shader.
const SHADER_PAIRS: usize = 1 << 17;
/// Pairs per run on the CPU.
const CPU_PAIRS: usize = 1 << 15;
/// Number of runs, of which the fastest counts.
const RUNS: usize = 3;
const SEED: u64 = 5;

/// Compiled shaders and the pairs that they evaluate.
pub(crate) struct Rates<'g> {
    evaluators: Vec<(PackKind, Evaluator<'g>)>,
    pairs: Vec<DirectionPair>,
}

impl<'g> Rates<'g> {
    pub(crate) fn new(gpu: &'g Gpu) -> Result<Self, GpuError> {
        let brdfs = PackKind::ALL.into_iter().filter_map(|kind| Some((kind, kind.descriptor().brdf?)));
        let evaluators = brdfs.map(|(kind, brdf)| Ok((kind, Evaluator::of(gpu, kind, brdf)?)));
        Ok(Self { evaluators: evaluators.collect::<Result<_, GpuError>>()?, pairs: random_pairs(SHADER_PAIRS, SEED) })
    }

    /// Evaluations per second of a pack at a level of detail, with the sampler's weights or exact ones.
    pub(crate) fn shader(
        &self,
        pack: &BrdfPack,
        filter: Filter,
        level: f32,
        slices: SliceFilter,
    ) -> Result<f64, GpuError> {
        let found = self.evaluators.iter().find(|(kind, _)| *kind == pack.kind());
        let (_, evaluator) = found.expect("all codecs of BRDFs have one");
        self.shader_of(evaluator, &evaluator.load(pack, filter)?, level, slices)
    }

    /// Evaluations per second of a loaded pack.
    pub(crate) fn shader_of(
        &self,
        evaluator: &Evaluator<'_>,
        loaded: &LoadedPack,
        level: f32,
        slices: SliceFilter,
    ) -> Result<f64, GpuError> {
        let on_device = evaluator.load_pairs(&self.pairs, level, slices)?;
        // The first run compiles and transfers remaining data.
        evaluator.run(loaded, &on_device)?;
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            evaluator.run(loaded, &on_device)?;
            best = best.min(start.elapsed().as_secs_f64());
        }
        Ok(self.pairs.len() as f64 / best)
    }

    /// Evaluations per second on the CPU, on one thread or on all.
    pub(crate) fn cpu(&self, all: bool, eval: impl Fn(DirectionPair) -> f32 + Sync) -> f64 {
        let pairs = &self.pairs[..CPU_PAIRS];
        let run = || -> f32 {
            if all {
                pairs.par_iter().map(|pair| eval(*pair)).sum()
            } else {
                pairs.iter().map(|pair| eval(*pair)).sum()
            }
        };
        pairs.len() as f64 / best_of(RUNS, run)
    }
}
