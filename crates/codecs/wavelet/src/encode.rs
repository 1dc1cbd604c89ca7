//! The encoder of wavelet packs, as a sequence of stages.

use super::crop::{crop, needed_coefficients, window};
use super::energy::{means, needed_in_trees, padded, slices_of_pack, slices_of_tree};
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
use brdfc_formats::wavelet::{Header, MAX_SLICES, SliceScale, WaveletDecoder, WaveletPack, gpu_bytes};
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
        let needs = Needs::new(&recipe.header(1, 1.0, 1.0), recipe);
        let found = needs.slices(ratio_count(recipe.grid().cells(), ratio, most), most);
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
    let header = recipe.header(table.channels() as u32, encoding.mean as f32, encoding.bias as f32);
    let is_cut = header.energy_preserving && header.stored_levels < header.levels;
    let logarithms = match is_cut {
        true => log_encode(&means(table, header.stored_levels), encoding),
        false => log_encode(table, encoding),
    };
    let samples_of_trees: Vec<Table> = (0..header.trees()).map(|level| means(table, level)).collect();

    start(Stage::Haar)?;
    let coefficients = haar::transform(&logarithms);
    let coefficients = if is_cut { padded(&coefficients, grid) } else { coefficients };
    let of_trees = samples_of_trees.iter().map(|samples| haar::transform(&log_encode(samples, encoding)));
    let trees: Vec<Table> = of_trees.collect();
    drop(logarithms);

    start(Stage::Threshold)?;
    let ranking = |coefficients: &Table, samples: &Table, stored_levels: u32| {
        let energies = match recipe.ranking {
            Ranking::Energy => threshold::slice_energies(coefficients),
            Ranking::Visible => visible_energies(coefficients, samples, encoding),
        };
        threshold::ranking(&energies, stored_levels)
    };
    let needs = Needs::new(&header, recipe);
    let of_finest = ranking(&coefficients, table, recipe.stored_levels);
    let (slices, of) = choose(&coefficients, table, &of_finest, header, &needs, recipe.target)?;
    let slices_of_coarser = |(level, coefficients): (usize, &Table)| {
        let needed = needs.of(&ranking(coefficients, &samples_of_trees[level], level as u32));
        threshold::keep(&needed, slices_of_tree(needed.len(), [slices.len(), of]))
    };
    let slices_of_trees: Vec<Vec<u32>> = trees.iter().enumerate().map(slices_of_coarser).collect();

    start(Stage::Quantise)?;
    let chosen = std::iter::once((&coefficients, &slices)).chain(trees.iter().zip(&slices_of_trees));
    let mut pack = assemble(chosen, header);
    drop((coefficients, trees, samples_of_trees));

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
    /// Number of these in each tree but the finest.
    in_trees: Vec<usize>,
}

impl Needs {
    fn new(header: &Header, recipe: &Recipe) -> Self {
        let DirectionRange { light, view } = recipe.directions;
        let coefficients = needed_coefficients(header, view);
        Self {
            directions: recipe.directions,
            window: window(header, light),
            in_trees: needed_in_trees(header, &coefficients),
            coefficients,
        }
    }

    /// The coefficients of a ranking that are needed.
    fn of(&self, ranking: &[u32]) -> Vec<u32> {
        ranking.iter().copied().filter(|k| self.coefficients[*k as usize]).collect()
    }

    /// Number of slices of a pack whose finest tree keeps `retained` of `of` coefficients.
    fn slices(&self, retained: usize, of: usize) -> usize {
        slices_of_pack(retained, &self.in_trees, [retained, of])
    }

    /// Maximum number of slices of the finest tree.
    fn most_slices(&self, of: usize) -> usize {
        (1..=of).collect::<Vec<_>>().partition_point(|retained| self.slices(*retained, of) <= MAX_SLICES)
    }
}

/// Chooses the slices of the finest tree for the target, and says of how many coefficients.
fn choose(
    coefficients: &Table,
    reference: &Table,
    ranking: &[u32],
    header: Header,
    needs: &Needs,
    target: Target,
) -> Result<(Vec<u32>, usize), EncodeError> {
    let count = match target {
        Target::Ratio(ratio) => ratio_count(header.cells(), ratio, ranking.len()),
        Target::MaxBytes(bytes) => {
            let needed = needs.of(ranking);
            let bytes_of = |retained| gpu_bytes(&header, needs.window, needs.slices(retained, needed.len()));
            if bytes_of(1) > bytes {
                return Err(EncodeError::TooFewBytes { allowed: bytes, smallest: bytes_of(1) });
            }
            let counts: Vec<usize> = (1..=needs.most_slices(needed.len())).collect();
            let count = counts.partition_point(|slices| bytes_of(*slices) <= bytes);
            return Ok((threshold::keep(&needed, count), needed.len()));
        }
        Target::MaxError(allowed) => {
            if reference.values.iter().all(|value| *value <= 0.0) {
                return Err(EncodeError::NothingMeasured);
            }
            let error = |count: usize| {
                let slices = threshold::keep(ranking, count);
                let finest = Header { energy_preserving: false, ..header };
                let pack = assemble(std::iter::once((coefficients, &slices)), finest);
                grid_error(reference, &WaveletDecoder::new(&pack), needs.directions).norms.relative_mean
            };
            fewest_within(allowed, needs.most_slices(ranking.len()), error).map_err(|(found, slices)| {
                let best = format!("all {slices} slices at {} bits", header.bits);
                EncodeError::BudgetMissed { found, allowed, best }
            })?
        }
    };
    Ok((threshold::keep(ranking, count), ranking.len()))
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

/// Assembles a pack of the chosen slices of each tree, the finest first and then from the coarsest on, without measuring its
/// errors.
fn assemble<'a>(trees: impl Iterator<Item = (&'a Table, &'a Vec<u32>)>, header: Header) -> WaveletPack {
    let mut pack = WaveletPack {
        header,
        index: Vec::with_capacity(header.coefficients()),
        scales: vec![SliceScale::default()],
        on_grid: ErrorSummary::default(),
        off_grid: ErrorSummary::default(),
        crop: None,
        texels: vec![0; header.cells() * header.texel_format().texel_bytes()],
    };
    trees.for_each(|(coefficients, slices)| add_tree(&mut pack, coefficients, slices));
    pack
}

/// Adds the chosen slices of a tree to a pack.
fn add_tree(pack: &mut WaveletPack, coefficients: &Table, chosen: &[u32]) {
    let quantised = quantise(coefficients, chosen, &pack.header);
    let first = pack.index.len();
    pack.index.resize(first + coefficients.grid.cells(), 0);
    for (slice, k) in (pack.scales.len()..).zip(chosen) {
        pack.index[first + *k as usize] = slice as u16;
    }
    // Without another zero slice.
    let slice_bytes = pack.header.cells() * pack.header.texel_format().texel_bytes();
    pack.scales.extend(&quantised.scales[1..]);
    pack.texels.extend(&quantised.texels[slice_bytes..]);
}

impl GridError {
    /// The errors as a pack stores them.
    pub fn summary(&self) -> ErrorSummary {
        self.norms.summary(self.albedo_max_difference, self.reciprocity)
    }
}
