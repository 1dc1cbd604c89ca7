//! Error of one source against another at chosen direction pairs, as a user of a pack sees it.

use super::highlight::{Highlight, HighlightError};
use super::norms::{NormSums, Norms};
use super::rendering::{ReferenceRendering, RenderingError};
use super::sampling::{AlbedoPairs, PairSet};
use super::values::{CHUNK, values_of_list};
use brdfc_core::{Source, Tally};
use brdfc_formats::ErrorSummary;
use brdfc_formats::crop::DirectionRange;
use rayon::prelude::*;
use std::borrow::Cow;

/// Number of the given direction pairs at which reciprocity is measured.
const RECIPROCITY_PAIRS: usize = 2048;

/// All measurements between a reference and an approximation.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Comparison {
    /// `μ`: mean of the reference over the uniform pairs and over channels, 1/sr.
    pub mean: f64,
    /// Norms over all samples.
    pub norms: Norms,
    /// Differences between renderings of both.
    pub rendering: RenderingError,
    /// Directional albedo at a few incoming directions.
    pub albedo: Vec<AlbedoPoint>,
    /// Largest difference of albedo over those directions and channels.
    pub albedo_max_difference: f64,
    /// Retained light of the highlight, at the incoming direction where it is smallest; absent where the reference has
    /// no highlight.
    #[serde(default)]
    pub highlight: Option<HighlightError>,
    /// Mean of `|f'(i, o) - f'(o, i)| / f` of the approximation.
    pub reciprocity: f64,
}

impl Comparison {
    /// The errors as a pack stores them.
    pub fn summary(&self) -> ErrorSummary {
        self.norms.summary(self.albedo_max_difference, self.reciprocity)
    }
}

/// Directional albedo of both sides at one incoming direction.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct AlbedoPoint {
    /// Incoming polar angle, degrees.
    pub theta: f64,
    /// Incoming azimuth, degrees.
    pub phi: f64,
    /// `∫ f cos θo dωo` of the reference, linear RGB, over the compared directions.
    pub reference: [f64; 3],
    /// The same for the approximation.
    pub approximation: [f64; 3],
}

/// Direction pairs of an albedo, and the values of the source there.
struct AlbedoReference {
    at: Cow<'static, AlbedoPairs>,
    value: [f64; 3],
    highlight: Option<Highlight>,
}

/// A reference source, evaluated once at the pairs of a set, of renderings and of albedos.
pub struct Reference {
    set: PairSet,
    grey: bool,
    values: Vec<[f64; 3]>,
    mean: f64,
    rendering: ReferenceRendering,
    albedo: Vec<AlbedoReference>,
    tally: Tally,
}

/// Returns true if a material with this mean `f_r`, 1/sr, is black: it is below the values that packs can store.
pub fn is_black(mean: f64) -> bool {
    mean < f64::from(f32::MIN_POSITIVE)
}

impl Reference {
    /// Evaluates a source at the pairs of `set`, of the renderings and of the albedos.
    pub fn new(source: &dyn Source, set: PairSet) -> Self {
        let (values, mut tally) = values_of_list(source, &set.pairs);
        let (rendering, counts) = ReferenceRendering::new(source, set.directions);
        tally += counts;
        let DirectionRange { light, view } = set.directions;
        let albedo = AlbedoPairs::of_curves(source.symmetry().isotropic)
            .into_par_iter()
            .filter(|all| light.contain(all.incoming))
            .map(|all| {
                let at = if set.directions.is_all() { Cow::Borrowed(all) } else { Cow::Owned(all.within(view)) };
                let (values, _) = values_of_list(source, &at.pairs);
                AlbedoReference { value: albedo(&at, &values), highlight: Highlight::of(&at, &values), at }
            })
            .collect();
        Self { grey: source.is_grey(), mean: mean_value(&values[..set.of_mean]), set, values, rendering, albedo, tally }
    }

    /// Repairs in the source.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Factor from radiance to the values of the source's renderings.
    pub fn exposure(&self) -> f64 {
        self.rendering.exposure()
    }

    /// Returns true if the source is black at all pairs.
    pub fn is_black(&self) -> bool {
        is_black(self.mean)
    }

    /// Compares an approximation with the source, and renderings of both.
    ///
    /// The `μ` of the relative norms' floor is the source's mean over pairs of the set: the figures depend on the two
    /// sources alone. Negative values of the source count as 0, as in a pack.
    pub fn compare(&self, approximation: &dyn Source) -> Comparison {
        let (pairs, mean) = (&self.set.pairs, self.mean);
        let channels = if self.grey && approximation.is_grey() { 1 } else { 3 };
        let (found, _) = values_of_list(approximation, pairs);
        let parts: Vec<(NormSums, Reciprocity)> = pairs
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk_number, chunk)| {
                let mut sums = NormSums::new(mean);
                let mut reciprocity = Reciprocity::default();
                let mut other = Tally::default();
                for (k, pair) in chunk.iter().enumerate() {
                    let (f, g) = (self.values[chunk_number * CHUNK + k], found[chunk_number * CHUNK + k]);
                    for channel in 0..channels {
                        sums.add(f[channel].max(0.0), g[channel], pair.incoming[2].max(0.0));
                    }
                    let known_both_ways = self.set.directions.contains(pair.exchanged());
                    if chunk_number * CHUNK + k < RECIPROCITY_PAIRS && known_both_ways {
                        let exchanged = approximation.eval(pair.exchanged(), &mut other);
                        for channel in 0..channels {
                            reciprocity.add(f[channel], g[channel], exchanged[channel], mean);
                        }
                    }
                }
                (sums, reciprocity)
            })
            .collect();
        let mut sums = NormSums::new(mean);
        let mut reciprocity = Reciprocity::default();
        for (part, exchange) in &parts {
            sums.merge(part);
            reciprocity.merge(exchange);
        }
        let (albedo, highlights): (Vec<AlbedoPoint>, Vec<Option<HighlightError>>) = self
            .albedo
            .par_iter()
            .map(|AlbedoReference { at, value, highlight }| {
                let [theta, phi] = at.angles;
                let (values, _) = values_of_list(approximation, &at.pairs);
                let point = AlbedoPoint { theta, phi, reference: *value, approximation: albedo(at, &values) };
                (point, highlight.as_ref().map(|highlight| highlight.retained(at, &values)))
            })
            .unzip();
        let highlight = highlights.into_iter().flatten().min_by(|a, b| a.retained().total_cmp(&b.retained()));
        let albedo_max_difference = albedo
            .iter()
            .flat_map(|point| (0..3).map(|c| (point.approximation[c] - point.reference[c]).abs()))
            .fold(0.0, f64::max);
        let mut norms = sums.norms();
        // The errors of one pair's channels are correlated: they count as one sample.
        norms.relative_standard_error *= f64::from(channels as u32).sqrt();
        let rendering = self.rendering.compare(approximation);
        Comparison { mean, norms, rendering, albedo, albedo_max_difference, highlight, reciprocity: reciprocity.mean() }
    }
}

/// Compares `approximation` with `reference` at the pairs of a set; the tally is the reference's.
pub fn compare(reference: &dyn Source, approximation: &dyn Source, set: &PairSet) -> (Comparison, Tally) {
    let reference = Reference::new(reference, set.clone());
    (reference.compare(approximation), reference.tally())
}

/// `∫ f cos θo dωo` at an incoming direction, from the values at its pairs.
fn albedo(at: &AlbedoPairs, values: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (f, counted) in values.iter().zip(&at.counted) {
        (0..3).for_each(|channel| sum[channel] += f[channel].max(0.0) * counted);
    }
    sum
}

/// Mean over values and channels; negative ones count as 0.
pub fn mean_value(values: &[[f64; 3]]) -> f64 {
    let sums = values.chunks(CHUNK).map(|chunk| chunk.iter().flatten().map(|f| f.max(0.0)).sum::<f64>());
    if values.is_empty() { 0.0 } else { sums.sum::<f64>() / (3 * values.len()) as f64 }
}

/// Mean of `|f'(i, o) - f'(o, i)| / f` over samples above the floor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reciprocity {
    sum: f64,
    count: u64,
}

impl Reciprocity {
    /// Adds a sample: reference, approximation, and approximation with exchanged directions.
    pub fn add(&mut self, f: f64, g: f64, exchanged: f64, mean: f64) {
        if f >= super::norms::RELATIVE_FLOOR * mean && f > 0.0 {
            self.sum += (g - exchanged).abs() / f;
            self.count += 1;
        }
    }

    /// Adds the samples of another set.
    pub fn merge(&mut self, other: &Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    /// The mean; 0 without samples.
    pub fn mean(self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }
}
