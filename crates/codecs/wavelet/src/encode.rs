//! The encoder of wavelet packs, as a sequence of stages.

use super::crop::{crop, needed_coefficients, window};
use super::energy::preserve_energy;
use super::log_encode::{LogEncoding, log_encode};
use super::measure::{GridError, grid_error};
use super::quantise::quantise;
use super::recipe::{Ranking, Recipe, Target};
use super::table::Table;
use super::tabulated::Tabulated;
use super::visible::visible_energies;
use super::{haar, threshold};
use brdfc_codec::EncodeError;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::words::format_number;
use brdfc_core::{PackSource, Source, Tally};
use brdfc_formats::ErrorSummary;
use brdfc_formats::crop::{DirectionRange, Window};
use brdfc_formats::wavelet::{Header, MAX_SLICES, WaveletDecoder, WaveletPack, gpu_bytes};
use brdfc_metrics::compare::{Comparison, compare};
use brdfc_metrics::sampling::PairSet;

/// A pack with the measurements of its encoding.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// The pack in memory.
    pub pack: WaveletPack,
    /// Bytes on a GPU that cropping saves, compared with a pack for all directions.
    pub cropped_bytes: u64,
    /// Contents of the pack's KTX2 file.
    pub bytes: Vec<u8>,
    /// Codec error: decoded table against table.
    pub on_grid: GridError,
    /// Error against the source, at pairs and in renderings that depend on no codec.
    pub off_grid: Comparison,
    /// Repairs during resampling.
    pub tally: Tally,
    /// Number of evaluated samples of the table; symmetry makes it smaller than the table.
    pub evaluated: u64,
}

/// Runs all stages.
///
/// # Errors
/// Returns an error if the budget cannot be met or the work is cancelled.
pub fn encode(source: &dyn Source, recipe: &Recipe, progress: &dyn Progress) -> Result<Encoded, EncodeError> {
    check(recipe)?;
    progress.stage(Stage::Resample, 1)?;
    encode_tabulated(&Tabulated::new(source, recipe.grid()), source, recipe, progress)
}

pub(super) fn check(recipe: &Recipe) -> Result<(), EncodeError> {
    let most = 1usize << (2 * recipe.stored_levels);
    if let Target::Ratio(ratio) = recipe.target {
        let coarser = if recipe.energy_preserving { recipe.levels as usize } else { 0 };
        let found = ratio_count(recipe.grid().cells(), ratio, most) + 1 + coarser;
        if found > MAX_SLICES {
            return Err(EncodeError::Size {
                field: "ratio",
                found: format!("{}, which needs {found} slices", format_number(ratio)),
                allowed: format!("at most {MAX_SLICES} slices; use a higher ratio or a smaller grid"),
            });
        }
    }
    Ok(())
}

/// Runs all stages after sampling: `tabulated` is the source on the grid of the recipe.
///
/// # Errors
/// Returns an error if the budget cannot be met or the work is cancelled.
pub fn encode_tabulated(
    tabulated: &Tabulated,
    source: &dyn Source,
    recipe: &Recipe,
    progress: &dyn Progress,
) -> Result<Encoded, EncodeError> {
    check(recipe)?;
    let Tabulated { table, tally } = tabulated;
    let grid = table.grid;
    let start = |stage| progress.stage(stage, 1);

    start(Stage::LogEncode)?;
    let encoding = LogEncoding::of(table, recipe.bias);
    let logarithms = log_encode(table, encoding);

    start(Stage::Haar)?;
    let coefficients = haar::transform(&logarithms);
    drop(logarithms);

    start(Stage::Threshold)?;
    let energies = match recipe.ranking {
        Ranking::Energy => threshold::slice_energies(&coefficients),
        Ranking::Visible => visible_energies(&coefficients, table, encoding),
    };
    let ranking = threshold::ranking(&energies, recipe.stored_levels);
    let header = Header {
        parameterisation: grid.parameterisation,
        levels: grid.levels,
        stored_levels: recipe.stored_levels,
        channels: coefficients.channels() as u32,
        bits: recipe.bits,
        mean: encoding.mean as f32,
        bias: encoding.bias as f32,
        energy_preserving: recipe.energy_preserving,
    };
    let needs = Needs::new(&header, recipe);
    let slices = choose(&coefficients, table, &ranking, header, &needs, recipe.target)?;

    start(Stage::Quantise)?;
    let mut pack = assemble(&coefficients, table, &slices, header);
    drop(coefficients);

    start(Stage::MeasureOnGrid)?;
    let on_grid = grid_error(table, &WaveletDecoder::new(&pack), recipe.directions);

    let whole = pack.gpu_bytes();
    pack = crop(pack, recipe.directions);
    let cropped_bytes = whole - pack.gpu_bytes();

    start(Stage::MeasureOffGrid)?;
    let decoded = PackSource::new(&pack, None);
    let off_grid = match recipe.measure_off_grid {
        true => compare(source, &decoded, &PairSet::within(recipe.directions)).0,
        false => Comparison::default(),
    };
    pack.on_grid = on_grid.summary();
    pack.off_grid = off_grid.summary();

    start(Stage::Pack)?;
    let bytes = pack.to_bytes(recipe.supercompress);
    Ok(Encoded { pack, cropped_bytes, bytes, on_grid, off_grid, evaluated: tally.evaluations, tally: *tally })
}

/// Requirements of the cropped directions.
struct Needs {
    directions: DirectionRange,
    window: Window,
    coefficients: Vec<bool>,
}

impl Needs {
    fn new(header: &Header, recipe: &Recipe) -> Self {
        let DirectionRange { light, view } = recipe.directions;
        Self {
            directions: recipe.directions,
            window: window(header, light),
            coefficients: needed_coefficients(header, view),
        }
    }
}

/// Chooses the slices for the target.
fn choose(
    coefficients: &Table,
    reference: &Table,
    ranking: &[u32],
    header: Header,
    needs: &Needs,
    target: Target,
) -> Result<Vec<u32>, EncodeError> {
    let count = match target {
        Target::Ratio(ratio) => ratio_count(header.cells(), ratio, ranking.len()),
        Target::MaxBytes(bytes) => {
            let bytes_of = |slices: usize| gpu_bytes(&header, needs.window, slices);
            if bytes_of(1) > bytes {
                return Err(EncodeError::TooFewBytes { allowed: bytes, smallest: bytes_of(1) });
            }
            let needed: Vec<u32> = ranking.iter().copied().filter(|k| needs.coefficients[*k as usize]).collect();
            let most = needed.len().min(most_slices(&header));
            let count = (1..=most).collect::<Vec<_>>().partition_point(|slices| bytes_of(*slices) <= bytes);
            return Ok(threshold::keep(&needed, count));
        }
        Target::MaxError(allowed) => {
            if reference.values.iter().all(|value| *value <= 0.0) {
                return Err(EncodeError::NothingMeasured);
            }
            let error = |count: usize| {
                let pack = assemble(coefficients, reference, &threshold::keep(ranking, count), header);
                grid_error(reference, &WaveletDecoder::new(&pack), needs.directions).norms.relative_mean
            };
            fewest_within(allowed, ranking.len().min(most_slices(&header)), error).map_err(|(found, slices)| {
                let best = format!("all {slices} slices at {} bits", header.bits);
                EncodeError::BudgetMissed { found, allowed, best }
            })?
        }
    };
    Ok(threshold::keep(ranking, count))
}

/// Maximum number of slices of wavelet coefficients.
fn most_slices(header: &Header) -> usize {
    MAX_SLICES - 1 - header.coarser_scalings()
}

/// Number of slices at a ratio, of at most as many as the stored levels have: a pack with fewer levels is already
/// smaller than requested.
fn ratio_count(cells: usize, ratio: f64, most: usize) -> usize {
    ((cells as f64 / ratio).round() as usize).clamp(1, most)
}

/// The smallest count in `1..=most` whose error is within `allowed`, by bisection. The error falls with the count
/// except for ripples of quantisation, so smaller counts are tried from the result on while they meet the limit.
fn fewest_within(allowed: f64, most: usize, error: impl Fn(usize) -> f64) -> Result<usize, (f64, usize)> {
    let at_most = error(most);
    if at_most > allowed {
        return Err((at_most, most));
    }
    let (mut missed, mut met) = (0, most);
    while met - missed > 1 {
        let middle = missed.midpoint(met);
        if error(middle) <= allowed {
            met = middle;
        } else {
            missed = middle;
        }
    }
    while met > 1 && error(met - 1) <= allowed {
        met -= 1;
    }
    Ok(met)
}

/// Assembles a pack of the chosen slices, without measuring its errors.
fn assemble(coefficients: &Table, reference: &Table, slices: &[u32], header: Header) -> WaveletPack {
    let pack = plain(coefficients, slices, Header { energy_preserving: false, ..header });
    if header.energy_preserving { preserve_energy(pack, reference) } else { pack }
}

/// Assembles a pack with the paper's scaling coefficient.
fn plain(coefficients: &Table, slices: &[u32], header: Header) -> WaveletPack {
    let quantised = quantise(coefficients, slices, &header);
    let mut index = vec![0u16; header.cells()];
    for (slice, k) in (1..).zip(slices) {
        index[*k as usize] = slice;
    }
    WaveletPack {
        header,
        index,
        scales: quantised.scales,
        on_grid: ErrorSummary::default(),
        off_grid: ErrorSummary::default(),
        crop: None,
        texels: quantised.texels,
    }
}

impl GridError {
    /// The errors as a pack stores them.
    pub fn summary(&self) -> ErrorSummary {
        self.norms.summary(self.albedo_max_difference, self.reciprocity)
    }
}
