//! Chooses domain, interpolation and number of learned terms by leave-one-out cross-validation over the lights.

use crate::assemble::CHANNELS;
use crate::candidates::{Candidate, SquaredSlopes, Texels, decibels, squares, to_srgb};
use crate::components::Components;
use crate::kriging::{Interpolation, Shortlist, rows};
use crate::learned::{Learned, LeftOut, map_side};
use crate::recipe::{DomainName, PwtRecipe, Target};
use crate::stack::LightSamples;
use brdfc_formats::pwt::{Domain, LightCoordinates, LightMap};
use brdfc_readers::pixels::Pixels;
use nalgebra::{DMatrix, DVector, Matrix3xX};
use rayon::prelude::*;

/// Maximum number of lights that terms are learned from; more are averaged in groups.
pub const MAX_LIGHTS: usize = 400;
/// Maximum number of texels from which components are computed.
const LEARNED_FROM: usize = 8192;
/// Maximum numbers of these texels under all lights.
const NUMBERS: usize = 1 << 21;
/// Typical number of fetches.
const FETCHES: u32 = 3;
/// Minimum number of lights to judge by those that are left out.
const MIN_LIGHTS: usize = 6;
/// Number of terms with which domains are compared: three fetches.
const COMPARED_TERMS: usize = 12;
/// Minimum weight of an entry.
const MIN_WEIGHT: f64 = 0.1;
/// PSNR at lights that are left out that counts as equal, dB: without a target, where few fetches matter, and with one, where more
/// terms are closer at the fitted lights.
const EQUAL: [f64; 2] = [0.6, 0.3];

/// The chosen learned terms.
pub struct LearnedCandidate {
    /// Errors of the first of its terms, and of all.
    pub by_terms: Vec<Candidate>,
    /// The interpolation between the lights.
    pub interpolation: Interpolation,
}

/// Maximum number of terms: the map takes at most three quarters of the requested bytes and, unless learned terms are requested,
/// half of three whole textures.
fn most_terms(samples: &LightSamples, recipe: &PwtRecipe) -> usize {
    let [width, height] = samples.size.map(|side| side as u64);
    let fetches = u64::from(recipe.max_fetches.unwrap_or(FETCHES));
    // Four channels per fetch, and a third more for mipmaps.
    let whole = 16 * width * height * fetches / 3;
    let is_requested = recipe.coordinates == Some(LightCoordinates::Learned);
    let budget = match recipe.target {
        Target::Bytes(bytes) if is_requested => bytes / 4 * 3,
        _ if is_requested => return recipe.most_learned(),
        Target::Bytes(bytes) => (bytes / 4 * 3).min(whole / 2),
        _ => whole / 2,
    };
    let of_map = budget / LightMap::bytes_of(map_side(&samples.lights), 1);
    recipe.most_learned().min(of_map.saturating_sub(1) as usize)
}

/// Returns true if learned terms are requested, or if they are possible and polynomials are not requested.
pub fn may_learn(samples: &LightSamples, recipe: &PwtRecipe) -> bool {
    // A degree or a ridge is that of polynomials.
    let of_polynomials = recipe.coordinates.is_some() || recipe.degree.is_some() || recipe.ridge.is_some();
    recipe.coordinates == Some(LightCoordinates::Learned) || (!of_polynomials && most_terms(samples, recipe) > 0)
}

/// Returns true if there are too few lights to judge by those that are left out; then errors at the lights count.
pub fn are_few(lights: &[[f32; 3]]) -> bool {
    lights.len() < MIN_LIGHTS
}

/// The best terms of all domains, and the best candidate of each other domain.
pub fn tried(texels: &Texels, samples: &LightSamples, recipe: &PwtRecipe) -> (LearnedCandidate, Vec<Candidate>) {
    let most = recipe.degree.map_or(most_terms(samples, recipe).max(1), |degree| degree as usize);
    let shortlist = Shortlist::new(&samples.lights, &rows(&texels.encoded(Domain::Display)));
    let names = recipe.domain.map_or(DomainName::ALL.to_vec(), |one| vec![one]);
    let domains = names.iter().flat_map(|name| texels.domains(*name).into_iter().map(|domain| (*name, domain)));
    let domains: Vec<(DomainName, Domain)> = domains.collect();
    let one = |domain: &(DomainName, Domain)| Trial::new(texels, *domain, &shortlist);
    let mut trials: Vec<Trial<'_>> = domains.par_iter().map(one).collect();
    let with_few = |trial: &Trial<'_>| trial.candidate(most.min(COMPARED_TERMS));
    let mut found: Vec<Candidate> = trials.par_iter().map(with_few).collect();
    let best = (0..found.len()).max_by(|a, b| merit(&found[*a]).total_cmp(&merit(&found[*b])).then(b.cmp(a)));
    let best = best.expect("one or more domains");
    found.swap_remove(best);
    let trial = trials.swap_remove(best);
    let mut by_terms = trial.by_terms(most);
    if recipe.degree.is_none() && !are_few(&samples.lights) {
        by_terms.truncate(enough(&by_terms, recipe));
    }
    (LearnedCandidate { by_terms, interpolation: trial.interpolation }, found)
}

fn merit(candidate: &Candidate) -> f64 {
    candidate.held_out_psnr.unwrap_or(candidate.psnr)
}

/// Number of the candidates up to the one with enough terms.
fn enough(by_terms: &[Candidate], recipe: &PwtRecipe) -> usize {
    let largest = by_terms.iter().map(merit).fold(f64::NEG_INFINITY, f64::max);
    let is_default = matches!(recipe.target, Target::Loss(_) | Target::Energy(_));
    let equal = EQUAL[usize::from(!is_default)];
    let is_equal = |candidate: &Candidate| merit(candidate) >= largest - equal;
    // Three fetches are enough if more gain little.
    let few = |candidate: &Candidate| is_equal(candidate) && candidate.degree as usize >= COMPARED_TERMS;
    let few = by_terms.iter().position(few).filter(|_| is_default);
    few.or_else(|| by_terms.iter().rposition(is_equal)).map_or(by_terms.len(), |at| at + 1)
}

/// A domain, and the interpolation for it.
struct Trial<'a> {
    texels: &'a Texels,
    domain: (DomainName, Domain),
    values: DMatrix<f64>,
    interpolation: Interpolation,
}

impl<'a> Trial<'a> {
    fn new(texels: &'a Texels, domain: (DomainName, Domain), shortlist: &Shortlist) -> Self {
        let values = rows(&texels.encoded(domain.1));
        let interpolation = shortlist.combined(&values).unwrap_or_default();
        Self { texels, domain, values, interpolation }
    }

    /// Errors with `most` principal components, or as many as there are.
    fn candidate(&self, most: usize) -> Candidate {
        let fit = self.fit(most);
        self.with_terms(&fit, fit.components.axes.ncols())
    }

    /// Errors with 4, 8, … principal components, up to `most`; once, if there are none.
    fn by_terms(&self, most: usize) -> Vec<Candidate> {
        let fit = self.fit(most);
        let found = fit.components.axes.ncols();
        let numbers = (0..found.div_ceil(CHANNELS).max(1)).map(|k| (CHANNELS * (k + 1)).min(found));
        numbers.map(|terms| self.with_terms(&fit, terms)).collect()
    }

    fn fit(&self, most: usize) -> Fit {
        let (lights, columns) = self.values.shape();
        let entries = DMatrix::from_column_slice(3 * lights, columns / 3, self.values.as_slice());
        let components = Components::new(&entries, weights(self.domain.1, &entries), most);
        let coefficients = components.coefficients(&entries);
        Fit { entries, components, coefficients }
    }

    /// Errors with the first components of a fit.
    fn with_terms(&self, fit: &Fit, terms: usize) -> Candidate {
        let coefficients = fit.coefficients.rows(0, terms);
        let unseen = LeftOut::new(&fit.components, &self.interpolation);
        Candidate {
            domain: self.domain.0,
            epsilon: self.domain.1.code().1,
            coordinates: LightCoordinates::Learned,
            degree: terms.max(1) as u32,
            ridge: 0.0,
            psnr: self.psnr(|light| fit.components.colours(light, &coefficients)),
            held_out_psnr: unseen.map(|them| self.psnr(|light| them.colours(light, &coefficients, &fit.entries))),
        }
    }

    /// PSNR of colours of the texels under each light.
    fn psnr(&self, colours: impl Fn(usize) -> Matrix3xX<f64> + Sync) -> f64 {
        let (lights, columns) = self.values.shape();
        let of_light = |light: usize| {
            // Channel by channel of each texel.
            let values: Vec<f32> = colours(light).iter().map(|value| *value as f32).collect();
            squares(&to_srgb(self.domain.1, values), &self.texels.codes[light])
        };
        let all: Vec<f64> = (0..lights).into_par_iter().map(of_light).collect();
        decibels(all.iter().sum::<f64>() / (lights * columns).max(1) as f64)
    }
}

/// Weights of entries, so that errors count as in sRGB encoding: the root of the mean squared slope of each row, relative to that of
/// all. Dark photographs count less in logarithms, and more in linear values.
fn weights(domain: Domain, entries: &DMatrix<f64>) -> DVector<f64> {
    let slopes = SquaredSlopes::new(domain);
    let of_row = |row: usize| {
        let sum: f64 = entries.row(row).iter().map(|value| f64::from(slopes.at(*value as f32))).sum();
        (sum / entries.ncols().max(1) as f64).sqrt()
    };
    let weights: Vec<f64> = (0..entries.nrows()).into_par_iter().map(of_row).collect();
    let weights = DVector::from_vec(weights);
    let mean = weights.norm() / (weights.len().max(1) as f64).sqrt();
    if mean > 0.0 { weights.map(|weight| (weight / mean).max(MIN_WEIGHT)) } else { weights.map(|_| 1.0) }
}

/// Principal components of the texels.
struct Fit {
    /// Red, green and blue under all lights: a column for each texel.
    entries: DMatrix<f64>,
    components: Components,
    coefficients: DMatrix<f64>,
}

impl LearnedCandidate {
    /// The candidate with all terms.
    pub fn candidate(&self) -> Candidate {
        *self.by_terms.last().expect("one or more numbers of terms")
    }

    /// Learns the terms.
    pub fn learn(&self, samples: &LightSamples) -> Learned {
        let at = samples.spread_texels(LEARNED_FROM.min(NUMBERS / (3 * samples.lights.len())));
        let domain = self.candidate().domain();
        let of_light = |image: &Pixels| -> Vec<f32> {
            let mut values: Vec<f32> = at.iter().flat_map(|texel| image.pixel(*texel)).collect();
            domain.encode_each(&mut values);
            values
        };
        let values: Vec<Vec<f32>> = samples.images.par_iter().map(of_light).collect();
        let entries = DMatrix::from_column_slice(3 * values.len(), at.len(), rows(&values).as_slice());
        let components = Components::new(&entries, weights(domain, &entries), self.candidate().degree as usize);
        Learned::new(&components, &self.interpolation, &samples.lights)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors in sRGB encoding are smaller with the weights than with equal ones where half of the photographs are dark.
    #[test]
    fn dark_photographs_count_as_in_srgb() {
        let domain = Domain::Logarithm { epsilon: 1e-4 };
        let lights = 12;
        let entries = DMatrix::from_fn(3 * lights, 80, |entry, texel| {
            let (light, texel) = (entry % lights, texel as f64);
            let brightness = if light % 2 == 0 { 0.003 } else { 0.4 };
            let change = (texel * (1.3 + 0.7 * light as f64)).sin() + (2.1 * texel).cos();
            f64::from(domain.encode((brightness * (1.0 + 0.45 * change)) as f32))
        });
        let codes = |values: &DMatrix<f64>| to_srgb(domain, values.iter().map(|value| *value as f32).collect());
        let error = |weights: DVector<f64>| {
            let components = Components::new(&entries, weights, 3);
            let mut fitted = components.unweighted() * components.coefficients(&entries);
            fitted.column_iter_mut().for_each(|mut column| column += &components.mean);
            squares(&codes(&fitted), &codes(&entries))
        };
        let found = weights(domain, &entries);
        assert!((found.norm_squared() / found.len() as f64 - 1.0).abs() < 0.01, "{found}");
        assert!(found[0] < 0.5 * found[1], "{found}");
        let [with, without] = [error(found), error(DVector::from_element(3 * lights, 1.0))];
        assert!(with < 0.9 * without, "{with} {without}");
        // Black photographs have a weight, too.
        let black = weights(Domain::Linear, &DMatrix::zeros(3, 5));
        assert!(black.iter().all(|weight| (weight - 1.0).abs() < 1e-9), "{black}");
    }
}
