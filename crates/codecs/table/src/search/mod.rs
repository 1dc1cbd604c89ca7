//! The search for the smallest table that meets a budget.

pub mod recipe;
pub mod within;

use super::encode::{self, Prepared, measured, samples_for};
use super::recipe::{Size, TableRecipe};
use super::report::TableReport;
use brdfc_codec::{AveragingCost, Budget, EncodeError, Encoded, TAIL, Trial};
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::words::percent;
use brdfc_core::{PackSource, Source};
use brdfc_metrics::compare::{Comparison, Reference};
use brdfc_metrics::sampling::PairSet;
use recipe::{LARGEST, SearchRecipe, Tables};

/// A table with the measurements of its encoding.
pub type EncodedTable = Encoded<TableReport>;

/// Bytes on a GPU of the smallest table that is tried; sizes are doublings. Anisotropic tables start larger, because
/// too few layers leave knobs on the outlines of highlights, which hardly count in a mean.
#[doc(hidden)]
pub const SMALLEST: u64 = 1 << 10;
const SMALLEST_ANISOTROPIC: u64 = 4 << 10;
/// Smallest size with levels of detail: with few nodes a row does not preserve the light of a narrow highlight.
const SMALLEST_WITH_LEVELS: u64 = 8 << 10;
/// Largest power of the size by which the error of tables falls; it is 2/3 for smooth values.
const FASTEST: f64 = 0.8;
/// A pack is closer to the budget than a smaller one only if its excess is below this share of the smaller one's.
const CLOSER: f64 = 0.97;
/// Errors that fall by less than this power of the size have stalled: a tenth less for twice the bytes.
const SLOWEST: f64 = 0.15;
/// Stalled errors may fall this many times as fast at larger sizes, which may suffice for the budget.
const CATCHING_UP: f64 = 2.0;
/// Bytes of a table above which no larger one is tried for its highlight alone.
const MAX_FOR_HIGHLIGHT: u64 = 64 << 10;
/// Number of consecutive misses of the budget after which no smaller size is tried.
const MISSES: u32 = 2;
/// Step between tried sizes while none is expected to meet the budget.
const STRIDE: usize = 2;
/// Number of tables tried for a budget of bytes alone: all of it, a half, a quarter. More nodes do not always help if
/// the format's ten bits or the samples are the limit.
const FILLED: u32 = 3;

/// Tries tables from small to large and returns the first that meets the budget. A budget of bytes alone gets the pack
/// with the smallest colour differences that fits.
///
/// Sizes are skipped if they would miss the budget even with the fastest fall of the error. If a larger one meets it,
/// the sizes skipped since the last miss are tried after all; if none does, some of them are, until errors stall.
/// Factored tables below the smallest table that meets the budget are tried, too: with one more fetch they may be
/// smaller. Where errors of tables stall, factored ones up to that size may still be closer. If no pack meets the
/// budget, the result is the smallest pack that no other beats by much.
///
/// # Errors
/// Returns an error for budgets that no pack can meet at any quality, for error limits of black materials, and if the
/// work is cancelled.
pub fn search(
    source: &dyn Source,
    recipe: &SearchRecipe,
    progress: &dyn Progress,
) -> Result<(EncodedTable, Reference), EncodeError> {
    let budget = recipe.budget;
    let fewest = fewest_fetches(source) + u32::from(recipe.tables == Tables::Factored);
    if let Some(allowed) = budget.fetches
        && allowed < fewest
    {
        let why = "an isotropic table takes 1, other tables take 2, and a curve or levels take 1 more";
        return Err(EncodeError::TooFewFetches { allowed, fewest, why });
    }
    progress.stage(Stage::MeasureOffGrid, 1)?;
    let reference = Reference::new(source, PairSet::within(recipe.table.directions));
    if reference.is_black() && recipe.is_asked {
        return Err(EncodeError::NothingMeasured);
    }
    let mut search =
        Search { source, recipe, reference, progress, prepared: None, made: Vec::new(), tried: Vec::new() };
    if budget.limits_error() {
        search.tables()?;
    } else {
        let most = budget.bytes.unwrap_or(LARGEST).min(search.largest());
        let smallest = smallest_tried(source, recipe);
        for half in (0..FILLED).rev() {
            let bytes = most >> half;
            if half == 0 || bytes >= smallest {
                search.table(bytes, recipe.tables == Tables::Factored)?;
            }
        }
        if recipe.tables == Tables::Both && search.may_be_factored() {
            search.table(most, true)?;
        }
    }
    Ok(search.finish())
}

/// Filtered fetches of a plain table.
fn fewest_fetches(source: &dyn Source) -> u32 {
    if source.symmetry().isotropic { 1 } else { 2 }
}

/// Bytes of the smallest table that is tried.
pub fn smallest_tried(source: &dyn Source, recipe: &SearchRecipe) -> u64 {
    match (recipe.table.levels, source.symmetry().isotropic) {
        (1.., _) => SMALLEST_WITH_LEVELS,
        (0, true) => SMALLEST,
        (0, false) => SMALLEST_ANISOTROPIC,
    }
}

struct Search<'a> {
    source: &'a dyn Source,
    recipe: &'a SearchRecipe,
    reference: Reference,
    progress: &'a dyn Progress,
    prepared: Option<Prepared>,
    /// Candidates with their size in bytes, true for factored ones, and their excess over the budget.
    made: Vec<((u64, bool), Excess, EncodedTable)>,
    tried: Vec<Trial>,
}

/// Forwards cancellation only, and hides the stages of a trial.
struct CancelOnly<'a>(&'a dyn Progress);

impl Progress for CancelOnly<'_> {
    fn check(&self) -> Result<(), Cancelled> {
        self.0.check()
    }

    fn part<'b>(&'b self, _: &'b str) -> Box<dyn Progress + 'b> {
        Box::new(CancelOnly(self.0))
    }
}

impl Search<'_> {
    /// Tries tables, plain or factored or both.
    fn tables(&mut self) -> Result<(), EncodeError> {
        let sizes = sizes(smallest_tried(self.source, self.recipe), self.recipe.budget.bytes, self.largest());
        let plain = self.smallest(&sizes, self.recipe.tables == Tables::Factored)?;
        if self.recipe.tables != Tables::Both || !self.may_be_factored() {
            return Ok(());
        }
        let below = match plain {
            Found::Met(met) => met,
            // Near the size above which more nodes did not help.
            Found::Missed { closest, last } => {
                let from = closest.saturating_sub(2 * STRIDE);
                match self.smallest(&sizes[from..=last], true)? {
                    Found::Met(met) => from + met,
                    Found::Missed { .. } => return Ok(()),
                }
            }
        };
        // Highlights may fall between nodes of one size but not of the next smaller one: a single miss does not end the
        // search.
        let mut misses = 0;
        for size in sizes[..below].iter().rev() {
            misses = if self.table(*size, true)?.is_met() { 0 } else { misses + 1 };
            if misses == MISSES {
                break;
            }
        }
        Ok(())
    }

    /// Bytes of the largest table that is tried: grey texels are half as large.
    fn largest(&self) -> u64 {
        if self.source.is_grey() { LARGEST / 2 } else { LARGEST }
    }

    /// Returns true if the limit of fetches allows a curve.
    fn may_be_factored(&self) -> bool {
        self.recipe.budget.fetches.is_none_or(|most| most > fewest_fetches(self.source))
    }

    /// Tries tables of one kind.
    fn smallest(&mut self, sizes: &[u64], factored: bool) -> Result<Found, EncodeError> {
        // Excess over the budget of each size.
        let mut excesses: Vec<Option<Excess>> = vec![None; sizes.len()];
        let mut next = Some(0);
        let mut met = None;
        while let Some(k) = next {
            let excess = self.table(sizes[k], factored)?;
            excesses[k] = Some(excess);
            if excess.is_met() {
                met = Some(k);
                break;
            }
            let hopeless = |larger: usize| {
                let expected =
                    |at: usize| Some(excesses[at]?.error * (sizes[larger] as f64 / sizes[at] as f64).powf(-FASTEST));
                (0..=k).filter_map(expected).fold(f64::INFINITY, f64::min) > 1.0
            };
            let last = sizes.len() - 1;
            // The loss of a highlight does not fall evenly, and may not fall at all.
            let is_lost = excess.error <= 1.0 && sizes[k] >= MAX_FOR_HIGHLIGHT;
            if is_lost || excess.error > 1.0 && has_stalled(&tried(sizes, &excesses), sizes[last]) {
                break;
            }
            let stride = (k < last).then_some((k + STRIDE).min(last));
            next = (k + 1..sizes.len()).find(|larger| !hopeless(*larger)).or(stride);
        }
        let Some(mut met) = met else {
            let least = excesses.iter().flatten().map(Excess::rank).fold(f64::INFINITY, f64::min);
            let is_close = |excess: &Option<Excess>| excess.is_some_and(|excess| CLOSER * excess.rank() <= least);
            let closest = excesses.iter().position(is_close).unwrap_or(0);
            return Ok(Found::Missed { closest, last: excesses.iter().rposition(Option::is_some).unwrap_or(0) });
        };
        let missed = (0..met).rev().find(|k| excesses[*k].is_some());
        for skipped in missed.map_or(0, |k| k + 1)..met {
            if self.table(sizes[skipped], factored)?.is_met() {
                met = skipped;
                break;
            }
        }
        Ok(Found::Met(met))
    }

    /// Encodes a table, unless it was tried, and returns its excess over the budget.
    fn table(&mut self, bytes: u64, factored: bool) -> Result<Excess, EncodeError> {
        let size = (bytes, factored);
        if let Some((_, excess, _)) = self.made.iter().find(|(tried, ..)| *tried == size) {
            return Ok(*excess);
        }
        self.progress.stage(Stage::Try, 1)?;
        let within = CancelOnly(self.progress);
        let recipe = TableRecipe { size: Size::Bytes(bytes), factored, ..self.recipe.table.clone() };
        let count = samples_for(recipe.size, self.source.is_grey());
        let prepared = match self.prepared.take().filter(|prepared| prepared.samples.len() == count) {
            Some(prepared) => prepared,
            None => Prepared::new(self.source, &recipe, count, &within)?,
        };
        let made = prepared.pack(&recipe, &within);
        if let (Err(EncodeError::TooFewBytes { .. }), true, false) = (&made, factored, self.tried.is_empty()) {
            // A curve does not fit, but a table did.
            self.prepared = Some(prepared);
            return Ok(Excess { error: f64::INFINITY, highlight: 0.0 });
        }
        let mut pack = made?;
        let off_grid = self.reference.compare(&PackSource::new(&pack, None));
        measured(&mut pack, &off_grid);
        let bytes = pack.to_bytes(recipe.supercompress);
        let (asymmetry, tally) = (prepared.asymmetry, prepared.samples.tally);
        self.prepared = Some(prepared);
        Ok(self.consider(size, encode::Encoded { pack, bytes, asymmetry, off_grid, tally }.into()))
    }

    /// Records a pack, adds it to the candidates if it may be the result, and returns its excess over the budget.
    fn consider(&mut self, size: (u64, bool), made: EncodedTable) -> Excess {
        let excess = Excess::of(&self.recipe.budget, &made.off_grid);
        self.tried.push(made.trial(&made.codec, excess.is_met()));
        self.made.push((size, excess, made));
        excess
    }

    fn finish(self) -> (EncodedTable, Reference) {
        let budget = &self.recipe.budget;
        let rendering = |made: &EncodedTable| made.off_grid.rendering.delta_e.mean;
        let bytes = |made: &EncodedTable| made.pack.gpu_bytes();
        let least = self.made.iter().map(|(_, excess, _)| excess.rank()).fold(f64::INFINITY, f64::min);
        let best = if budget.limits_error() {
            let is_one = |excess: &Excess| if least <= 1.0 { excess.is_met() } else { CLOSER * excess.rank() <= least };
            self.made.into_iter().filter(|(_, excess, _)| is_one(excess)).min_by_key(|(.., made)| bytes(made))
        } else {
            // Packs that retain the highlight come first.
            let is_lost = |excess: &Excess| excess.highlight > 1.0;
            self.made.into_iter().min_by(|(_, a, first), (_, b, second)| {
                is_lost(a).cmp(&is_lost(b)).then(rendering(first).total_cmp(&rendering(second)))
            })
        };
        let (_, excess, mut made) = best.expect("a table was made, or an error was returned");
        made.missed = (!excess.is_met()).then(|| missed(budget, &made.off_grid));
        if self.recipe.table.reciprocal {
            made.averaging = Some(AveragingCost::of(self.source, &self.reference));
        }
        made.tried = self.tried;
        (made, self.reference)
    }
}

/// Result of trials of several sizes, as indices of sizes.
enum Found {
    /// The smallest size that meets the budget.
    Met(usize),
    /// None does. `closest` is the smallest that no other is [`CLOSER`] than, and `last` was tried last.
    Missed { closest: usize, last: usize },
}

/// The tried sizes with their excess over the budget.
fn tried(sizes: &[u64], excesses: &[Option<Excess>]) -> Vec<(u64, f64)> {
    sizes.iter().zip(excesses).filter_map(|(size, excess)| Some((*size, (*excess)?.error))).collect()
}

/// Returns true if the last two sizes are hardly better than the best before them, and the trend is too weak for the
/// largest size to meet the budget.
#[doc(hidden)]
pub fn has_stalled(tried: &[(u64, f64)], largest: u64) -> bool {
    let [before @ .., (_, a), (size, b)] = tried else { return false };
    let Some((earlier, best)) = before.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { return false };
    let now = a.min(*b);
    let power = (best / now).ln() / (*size as f64 / *earlier as f64).ln();
    power < SLOWEST && now * (largest as f64 / *size as f64).powf(-CATCHING_UP * power.max(0.0)) > 1.0
}

/// Errors of a pack relative to their limits; infinite if an error is not finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excess {
    /// Ratio to the tightest limit of ΔE and `ε_r`. It falls with the size.
    pub error: f64,
    /// Lost share of the highlight, relative to its limit. It falls in steps, as nodes enter the highlight.
    pub highlight: f64,
}

impl Excess {
    /// Excess of a pack.
    pub fn of(budget: &Budget, found: &Comparison) -> Self {
        let rendering = &found.rendering.delta_e;
        let ratios = [
            budget.delta_e.map(|limit| rendering.mean / limit),
            budget.delta_e.map(|limit| rendering.p95 / (TAIL * limit)),
            budget.error.map(|limit| found.norms.relative_mean / limit),
        ];
        let number = |ratio: f64| if ratio.is_nan() { f64::INFINITY } else { ratio };
        let lost = |least: f64| found.highlight.map_or(0.0, |highlight| (1.0 - highlight.retained()) / (1.0 - least));
        Self {
            error: ratios.into_iter().flatten().map(number).fold(0.0, f64::max),
            highlight: budget.highlight.map_or(0.0, |least| number(lost(least))),
        }
    }

    /// Returns true if all limits are met.
    pub fn is_met(&self) -> bool {
        self.error <= 1.0 && self.highlight <= 1.0
    }

    /// Order of packs that miss a limit: highlights count once errors are met.
    fn rank(&self) -> f64 {
        // Shares of highlights are from 0 to 1/(1 - 0.999).
        if self.error > 1.0 { 1000.0 * self.error } else { self.highlight.min(1000.0) }
    }
}

/// Sizes of tables within a budget, from small to large; the last fills it.
#[doc(hidden)]
pub fn sizes(smallest: u64, most: Option<u64>, largest: u64) -> Vec<u64> {
    let most = most.unwrap_or(largest).min(largest);
    let mut sizes: Vec<u64> =
        std::iter::successors(Some(smallest), |size| Some(2 * size)).take_while(|size| *size < most).collect();
    sizes.push(most);
    sizes
}

/// Message about limits that no pack meets.
fn missed(budget: &Budget, best: &Comparison) -> String {
    let rendering = &best.rendering.delta_e;
    let mut parts = Vec::new();
    if let Some(limit) = budget.delta_e
        && (rendering.mean > limit || rendering.p95 > TAIL * limit)
    {
        parts.push(format!(
            "a mean ΔE of {:.2} and 95 % below {:.2}, limits {limit} and {}",
            rendering.mean,
            rendering.p95,
            TAIL * limit
        ));
    }
    if let (Some(least), Some(found)) = (budget.highlight, best.highlight)
        && found.retained() < least
    {
        parts.push(format!("a highlight with {}, limit {}", found.summary(), percent(least)));
    }
    if let Some(limit) = budget.error
        && best.norms.relative_mean > limit
    {
        parts.push(format!("ε_r {:.2} %, limit {} %", 100.0 * best.norms.relative_mean, 100.0 * limit));
    }
    let within = budget.bytes.map_or_else(String::new, |most| format!(" of at most {most} bytes"));
    format!("no tried pack{within} meets the limits; the closest one has {}", parts.join("; "))
}
