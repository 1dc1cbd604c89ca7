//! BRDF evaluations per second, by the shader and by the CPU decoder (section 6.3 of Claustres et al. 2007).

use super::rates::Rates;
use brdfc_formats::BrdfPack;
use brdfc_formats::wavelet::Filter;
use brdfc_gpu::{AdapterDescription, Gpu, GpuError, SliceFilter};
use schemars::JsonSchema;
use serde::Serialize;

/// Rates of packs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Throughput {
    /// Adapter that ran the shader.
    pub adapter: AdapterDescription,
    /// Threads of the last column.
    pub threads: usize,
    /// A row for each filter and level of detail of each pack.
    pub rows: Vec<Rate>,
}

/// Evaluations per second of one pack.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Rate {
    /// The variant of its codec, as in `--codec`.
    pub codec: String,
    /// For wavelet packs `nearest` or `bilinear`, over the four inner cells; in both, the sampler filters slices
    /// bilinearly. For packs with a single filter `trilinear`.
    pub filter: String,
    /// Level of detail.
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

/// A row to measure.
struct Case<'a> {
    pack: &'a BrdfPack,
    filter: Filter,
    name: &'static str,
    level: u32,
}

/// Measures packs. Calls `progress` with the number of finished rows and the total.
///
/// # Errors
/// Returns an error that the driver reports.
pub fn throughput(gpu: &Gpu, packs: &[BrdfPack], progress: impl Fn(usize, usize)) -> Result<Throughput, GpuError> {
    let rates = Rates::new(gpu)?;
    let cases: Vec<Case<'_>> = packs.iter().flat_map(cases).collect();
    let mut rows = Vec::new();
    for case in &cases {
        let (level, decoder) = (case.level as f32, case.pack.decoder());
        let cpu = |all| rates.cpu(all, |pair| decoder.eval(pair, level, case.filter)[0]);
        let shader = |slices| rates.shader(case.pack, case.filter, level, slices);
        rows.push(Rate {
            codec: case.pack.variant().to_owned(),
            filter: case.name.to_owned(),
            level: case.level,
            fetches: case.pack.fetches_at(case.level, case.filter),
            bytes_on_gpu: case.pack.gpu_bytes(),
            shader: shader(SliceFilter::Hardware)?,
            shader_exact: shader(SliceFilter::Exact)?,
            cpu_one: cpu(false),
            cpu_all: cpu(true),
        });
        progress(rows.len(), cases.len());
    }
    Ok(Throughput { adapter: gpu.description().clone(), threads: rayon::current_num_threads(), rows })
}

/// Measurements of a pack: every level of detail, with both filters if it has two.
fn cases(pack: &BrdfPack) -> impl Iterator<Item = Case<'_>> {
    let filters = if pack.fetches_at(0, Filter::Slices) == pack.fetches_at(0, Filter::Bilinear) {
        vec![(Filter::Bilinear, "trilinear")]
    } else {
        vec![(Filter::Slices, "nearest"), (Filter::Bilinear, "bilinear")]
    };
    filters
        .into_iter()
        .flat_map(move |(filter, name)| (0..=pack.levels()).map(move |level| Case { pack, filter, name, level }))
}
