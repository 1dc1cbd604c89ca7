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
            fetches: case.fetches,
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
