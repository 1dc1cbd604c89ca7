//! Error of one source against another at chosen direction pairs: what a user of a pack sees.

use super::norms::{NormSums, Norms};
use super::sampling::{albedo_directions, cosine_directions};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::ErrorSummary;
use brdfc_source::{Source, Tally};
use rayon::prelude::*;

/// Direction pairs per unit of parallel work: fixed, so that sums do not depend on threads.
const CHUNK: usize = 1024;
/// Outgoing directions per axis of an albedo.
const ALBEDO_SIDE: usize = 16;
/// Direction pairs, of those given, that reciprocity is measured at.
const RECIPROCITY_PAIRS: usize = 2048;

/// Everything that is measured between a reference and an approximation.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Comparison {
    /// Norms over all samples.
    pub norms: Norms,
    /// Directional albedo at a few incoming directions.
    pub albedo: Vec<AlbedoPoint>,
    /// Largest difference of albedo over those directions and channels.
    pub albedo_max_difference: f64,
    /// Mean of `|f'(i, o) - f'(o, i)| / f` of the approximation.
    pub reciprocity: f64,
}

impl Comparison {
    /// The form that a pack holds.
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
    /// `∫ f cos θo dωo` of the reference, linear RGB.
    pub reference: [f64; 3],
    /// The same of the approximation.
    pub approximation: [f64; 3],
}

/// Mean of `f_r` of a source over direction pairs and channels: the `μ` of a comparison that has no table.
pub fn mean_value(source: &dyn Source, pairs: &[DirectionPair]) -> f64 {
    let sums: Vec<f64> = pairs
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut tally = Tally::default();
            chunk.iter().flat_map(|pair| source.eval(*pair, &mut tally)).map(|f| f.max(0.0)).sum()
        })
        .collect();
    if pairs.is_empty() { 0.0 } else { sums.iter().sum::<f64>() / (3 * pairs.len()) as f64 }
}

/// Compares `approximation` with `reference` at `pairs`; `mean` is the `μ` of the relative norms' floor.
///
/// Negative reference values count as 0, as they do in a table.
pub fn compare(
    reference: &dyn Source,
    approximation: &dyn Source,
    pairs: &[DirectionPair],
    mean: f64,
) -> (Comparison, Tally) {
    let grey = reference.is_grey() && approximation.is_grey();
    let channels = if grey { 1 } else { 3 };
    let parts: Vec<(NormSums, Reciprocity, Tally)> = pairs
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk_number, chunk)| {
            let mut sums = NormSums::new(mean);
            let mut reciprocity = Reciprocity::default();
            let mut tally = Tally::default();
            let mut other = Tally::default();
            for (k, pair) in chunk.iter().enumerate() {
                let f = reference.eval(*pair, &mut tally);
                let g = approximation.eval(*pair, &mut other);
                for channel in 0..channels {
                    sums.add(f[channel].max(0.0), g[channel], pair.incoming[2].max(0.0));
                }
                if chunk_number * CHUNK + k < RECIPROCITY_PAIRS {
                    let exchanged = approximation.eval(pair.exchanged(), &mut other);
                    for channel in 0..channels {
                        reciprocity.add(f[channel], g[channel], exchanged[channel], mean);
                    }
                }
            }
            (sums, reciprocity, tally)
        })
        .collect();
    let mut sums = NormSums::new(mean);
    let mut reciprocity = Reciprocity::default();
    let mut tally = Tally::default();
    for (part, exchange, counts) in &parts {
        sums.merge(part);
        reciprocity.merge(exchange);
        tally += *counts;
    }
    let albedo = albedo_curves(reference, approximation);
    let albedo_max_difference = albedo
        .iter()
        .flat_map(|point| (0..3).map(|c| (point.approximation[c] - point.reference[c]).abs()))
        .fold(0.0, f64::max);
    let comparison = Comparison { norms: sums.norms(), albedo, albedo_max_difference, reciprocity: reciprocity.mean() };
    (comparison, tally)
}

fn albedo_curves(reference: &dyn Source, approximation: &dyn Source) -> Vec<AlbedoPoint> {
    let outgoing = cosine_directions(ALBEDO_SIDE);
    albedo_directions(reference.symmetry().isotropic)
        .into_par_iter()
        .map(|([theta, phi], incoming)| {
            let mut tally = Tally::default();
            let mut albedo = |source: &dyn Source| {
                let mut sum = [0.0; 3];
                for direction in &outgoing {
                    let f = source.eval(DirectionPair::new(incoming, *direction), &mut tally);
                    for channel in 0..3 {
                        sum[channel] += f[channel].max(0.0);
                    }
                }
                sum.map(|s| s * std::f64::consts::PI / outgoing.len() as f64)
            };
            AlbedoPoint { theta, phi, reference: albedo(reference), approximation: albedo(approximation) }
        })
        .collect()
}

/// Sum of `|f'(i, o) - f'(o, i)| / f` over samples above the floor.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reciprocity {
    sum: f64,
    count: u64,
}

impl Reciprocity {
    /// Adds a sample: reference, approximation, and approximation with directions exchanged.
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

    /// The mean; 0 for no samples.
    pub fn mean(self) -> f64 {
        if self.count == 0 { 0.0 } else { self.sum / self.count as f64 }
    }
}
