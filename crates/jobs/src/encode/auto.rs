//! The search for the smallest pack that meets a budget.

use super::error::PackError;
use super::pack::{EncodedPack, of_table, of_wavelet};
use super::recipe::{AutoRecipe, Budget, TAIL};
use super::trial::Trial;
use brdfc_metrics::compare::{Comparison, Reference};
use brdfc_metrics::sampling::PairSet;
use brdfc_source::progress::{Progress, Stage};
use brdfc_source::{PackSource, Source, TableSource};
use brdfc_table::encode::{Encoded, Prepared, measured, samples_for};
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::recipe::{Recipe, Target};

/// Sizes of tables that are tried, bytes on a GPU.
const TABLE_BYTES: [u64; 8] = [2 << 10, 4 << 10, 8 << 10, 16 << 10, 32 << 10, 64 << 10, 128 << 10, 256 << 10];
/// Ratios of wavelet packs that are tried behind tables.
const RATIOS: [f64; 3] = [16.0, 8.0, 4.0];
/// Materials with a mirror-like peak are no reason to make megabytes: samples are drawn for tables of this size first.
const FIRST_SAMPLES: u64 = 16 << 10;

/// A pack that may be made.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Candidate {
    Table(u64),
    Wavelet(Target),
}

/// Tries tables from small to large, then wavelet packs, and stops at the first that meets the budget. A budget of bytes alone is
/// filled.
///
/// # Errors
/// Budgets that no pack can meet whatever its quality, error budgets for black materials, cancellation.
pub(super) fn search(
    source: &dyn Source,
    recipe: &AutoRecipe,
    progress: &dyn Progress,
) -> Result<EncodedPack, PackError> {
    let budget = recipe.budget;
    let fewest = if source.symmetry().isotropic { 1 } else { 2 };
    if let Some(allowed) = budget.fetches
        && allowed < fewest
    {
        return Err(PackError::TooFewFetches { allowed, fewest });
    }
    progress.stage(Stage::MeasureOffGrid, 1)?;
    let reference = Reference::new(source, PairSet::comparison());
    if reference.is_black() && budget.limits_error() && budget != Budget::default() {
        return Err(PackError::NothingMeasured);
    }
    let mut search = Search { source, recipe, reference, prepared: None, best: None, tried: Vec::new(), last: None };
    for candidate in candidates(recipe) {
        if search.is_hopeless(candidate) {
            continue;
        }
        progress.stage(Stage::Try, 1)?;
        if search.consider(candidate)? && budget.limits_error() {
            break;
        }
    }
    search.finish()
}

/// What is tried, from small to large; a budget of bytes alone asks for as much as it holds.
fn candidates(recipe: &AutoRecipe) -> Vec<Candidate> {
    let Budget { bytes, fetches, .. } = recipe.budget;
    let wavelet =
        recipe.wavelet.as_ref().filter(|wavelet| fetches.is_none_or(|most| 4 * (4 * wavelet.levels + 1) <= most));
    if let Some(bytes) = bytes.filter(|_| !recipe.budget.limits_error()) {
        // More than the largest table helps nobody.
        let table = Candidate::Table(bytes.min(TABLE_BYTES[TABLE_BYTES.len() - 1] * 4));
        let wavelet = wavelet.map(|_| Candidate::Wavelet(Target::MaxBytes(bytes)));
        return std::iter::once(table).chain(wavelet.filter(|_| bytes > WAVELET_FROM)).collect();
    }
    let within = |size: &u64| bytes.is_none_or(|most| *size <= most);
    let mut tables: Vec<u64> = TABLE_BYTES.into_iter().filter(within).collect();
    if let Some(bytes) = bytes.filter(|bytes| *bytes < TABLE_BYTES[TABLE_BYTES.len() - 1] && !tables.contains(bytes)) {
        tables.push(bytes);
    }
    let wavelets = wavelet.into_iter().flat_map(|_| RATIOS.map(|ratio| Candidate::Wavelet(Target::Ratio(ratio))));
    tables.into_iter().map(Candidate::Table).chain(wavelets).collect()
}

/// Power of the size by which the error of tables falls at most; it is 2/3 where values are smooth.
const FASTEST: f64 = 0.8;
/// Fewer bytes hold so few slices that no wavelet pack is worth a trial.
const WAVELET_FROM: u64 = 128 << 10;

struct Search<'a> {
    source: &'a dyn Source,
    recipe: &'a AutoRecipe,
    reference: Reference,
    prepared: Option<Prepared>,
    /// The best so far, with how far over the budget it is.
    best: Option<(f64, EncodedPack)>,
    tried: Vec<Trial>,
    /// The last table that was tried: its size, and how far over the budget it is.
    last: Option<(u64, f64)>,
}

impl Search<'_> {
    /// Whether a table is too small, going by those that were tried: its error falls no faster than by [`FASTEST`].
    fn is_hopeless(&self, candidate: Candidate) -> bool {
        let (Candidate::Table(bytes), Some((smaller, excess))) = (candidate, self.last) else { return false };
        let largest =
            self.recipe.budget.bytes.is_some_and(|most| TABLE_BYTES.iter().all(|size| *size <= bytes || *size > most));
        !largest && excess * (bytes as f64 / smaller as f64).powf(-FASTEST) > 1.0
    }

    /// Makes a candidate; whether it meets the budget.
    fn consider(&mut self, candidate: Candidate) -> Result<bool, PackError> {
        let made = match candidate {
            Candidate::Table(bytes) => self.table(bytes)?,
            Candidate::Wavelet(target) => match self.wavelet(target)? {
                Some(made) => made,
                None => return Ok(false),
            },
        };
        let bytes_on_gpu = made.pack.gpu_bytes();
        if self.recipe.budget.bytes.is_some_and(|most| bytes_on_gpu > most) {
            return Ok(false);
        }
        let excess = self.excess(&made.off_grid);
        let meets = excess <= 1.0;
        if let Candidate::Table(bytes) = candidate {
            self.last = Some((bytes, excess));
        }
        let picture = &made.off_grid.picture.delta_e;
        self.tried.push(Trial {
            codec: made.codec.name().to_owned(),
            size: made.codec.size(),
            bytes_on_gpu,
            fetches: made.pack.fetches(),
            delta_e: picture.mean,
            delta_e_p95: picture.p95,
            relative_error: made.off_grid.norms.relative_mean,
            meets,
        });
        let limits_error = self.recipe.budget.limits_error();
        let better = |best: &(f64, EncodedPack)| {
            if limits_error { excess < best.0 } else { picture.mean < best.1.off_grid.picture.delta_e.mean }
        };
        if self.best.as_ref().is_none_or(better) {
            self.best = Some((excess, made));
        }
        Ok(meets)
    }

    /// How many times over the tightest limit of error a pack is.
    fn excess(&self, error: &Comparison) -> f64 {
        let Budget { delta_e, error: relative, .. } = self.recipe.budget;
        let picture = &error.picture.delta_e;
        let ratios = [
            delta_e.map(|limit| picture.mean / limit),
            delta_e.map(|limit| picture.p95 / (TAIL * limit)),
            relative.map(|limit| error.norms.relative_mean / limit),
        ];
        ratios.into_iter().flatten().fold(0.0, f64::max)
    }

    fn table(&mut self, bytes: u64) -> Result<EncodedPack, PackError> {
        let recipe = TableRecipe { size: Size::Bytes(bytes), ..self.recipe.table.clone() };
        let wanted = samples_for(Size::Bytes(bytes.max(FIRST_SAMPLES)), self.source.is_grey());
        let prepared = match self.prepared.take().filter(|prepared| prepared.samples.len() >= wanted) {
            Some(prepared) => prepared,
            None => Prepared::new(self.source, &recipe, wanted, &())?,
        };
        let mut pack = prepared.pack(recipe.size, &())?;
        let off_grid = self.reference.compare(&TableSource::new(&pack));
        measured(&mut pack, &off_grid);
        let bytes = pack.to_bytes(recipe.supercompress);
        let (asymmetry, tally) = (prepared.asymmetry, prepared.samples.tally);
        self.prepared = Some(prepared);
        Ok(of_table(Encoded { pack, bytes, asymmetry, off_grid, tally }))
    }

    fn wavelet(&self, target: Target) -> Result<Option<EncodedPack>, PackError> {
        let Some(wavelet) = &self.recipe.wavelet else { return Ok(None) };
        let recipe = Recipe { target, measure_off_grid: false, ..wavelet.clone() };
        let mut encoded = brdfc_wavelet::encode::encode(self.source, &recipe, &())?;
        encoded.off_grid = self.reference.compare(&PackSource::new(&encoded.pack, None));
        encoded.pack.off_grid = encoded.off_grid.summary();
        encoded.bytes = encoded.pack.to_bytes(recipe.supercompress);
        Ok(Some(of_wavelet(encoded, &recipe)))
    }

    fn finish(self) -> Result<EncodedPack, PackError> {
        let Some((excess, mut made)) = self.best else {
            // No candidate fitted into the bytes.
            let allowed = self.recipe.budget.bytes.unwrap_or(0);
            let smallest = TABLE_BYTES[0];
            return Err(brdfc_table::encode::EncodeError::TooFewBytes { allowed, smallest }.into());
        };
        made.missed = (excess > 1.0).then(|| missed(&self.recipe.budget, &made.off_grid));
        made.tried = self.tried;
        Ok(made)
    }
}

/// The sentence about a budget that nothing meets.
fn missed(budget: &Budget, best: &Comparison) -> String {
    let picture = &best.picture.delta_e;
    let mut parts = Vec::new();
    if let Some(limit) = budget.delta_e
        && (picture.mean > limit || picture.p95 > TAIL * limit)
    {
        parts.push(format!(
            "ΔE: found a mean of {:.2} and 95 % below {:.2}; allowed {limit} and {}",
            picture.mean,
            picture.p95,
            TAIL * limit
        ));
    }
    if let Some(limit) = budget.error
        && best.norms.relative_mean > limit
    {
        parts.push(format!("ε_r: found {:.2} %; allowed {} %", 100.0 * best.norms.relative_mean, 100.0 * limit));
    }
    format!("nothing that was tried meets the budget, the best is kept; {}", parts.join("; "))
}
