//! Chooses domain, interpolation and number of learned terms by leave-one-out cross-validation over the lights.

use crate::candidates::{Candidate, Texels, decibels, squares, to_srgb};
use crate::components::Components;
use crate::kriging::{Interpolation, Shortlist, rows};
use crate::learned::{Learned, left_out, map_side};
use crate::recipe::{DomainName, PwtRecipe, Target};
use crate::stack::LightSamples;
use brdfc_formats::pwt::{Domain, LightCoordinates, LightMap};
use brdfc_readers::pixels::Pixels;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Maximum number of lights that terms are learned from; more are averaged in groups.
pub const MOST_LIGHTS: usize = 400;
/// Maximum number of texels from which components are computed.
const LEARNED_FROM: usize = 8192;
/// Maximum numbers of these texels under all lights.
const NUMBERS: usize = 1 << 21;
/// Typical number of fetches.
const FETCHES: u32 = 3;
/// Minimum number of lights, unless learned terms are requested.
const MIN_LIGHTS: usize = 6;
/// Numbers of terms that are tried are multiples of the texels' channels.
const STEP: usize = 4;
/// Number of terms with which domains are compared: three fetches.
const COMPARED_TERMS: usize = 12;
/// PSNR at lights that are left out that counts as equal, dB.
const EQUAL: f64 = 0.3;

/// A candidate with learned terms.
pub struct LearnedCandidate {
    /// Its errors.
    pub candidate: Candidate,
    /// The interpolation between the lights.
    pub interpolation: Interpolation,
}

/// Maximum number of terms: unless learned terms are requested, the map takes at most half of the requested bytes, or of three
/// whole textures.
fn most_terms(samples: &LightSamples, recipe: &PwtRecipe) -> usize {
    let [width, height] = samples.size.map(|side| side as u64);
    let fetches = u64::from(recipe.max_fetches.unwrap_or(FETCHES));
    // Four channels per fetch, and a third more for mipmaps.
    let whole = 16 * width * height * fetches / 3;
    let is_requested = recipe.coordinates == Some(LightCoordinates::Learned);
    let budget = match recipe.target {
        Target::Bytes(bytes) if is_requested => bytes,
        _ if is_requested => return recipe.most_learned(),
        Target::Bytes(bytes) => bytes.min(whole),
        _ => whole,
    };
    let of_map = budget / 2 / LightMap::bytes_of(map_side(samples.lights.len()), 1);
    recipe.most_learned().min(of_map.saturating_sub(1) as usize)
}

/// Returns true if learned terms are requested, or if they are possible and polynomials are not requested.
pub fn may_learn(samples: &LightSamples, recipe: &PwtRecipe) -> bool {
    // A degree or a ridge is that of polynomials.
    let of_polynomials = recipe.coordinates.is_some() || recipe.degree.is_some() || recipe.ridge.is_some();
    let is_possible = samples.lights.len() >= MIN_LIGHTS && most_terms(samples, recipe) > 0;
    recipe.coordinates == Some(LightCoordinates::Learned) || (is_possible && !of_polynomials)
}

/// The best candidate of each domain, the chosen one first.
pub fn tried(texels: &Texels, samples: &LightSamples, recipe: &PwtRecipe) -> Vec<LearnedCandidate> {
    let most = recipe.degree.map_or(most_terms(samples, recipe).max(1), |degree| degree as usize);
    let shortlist = Shortlist::new(&samples.lights, &rows(&texels.encoded(Domain::Display)));
    let names = recipe.domain.map_or(DomainName::ALL.to_vec(), |one| vec![one]);
    let domains = names.iter().flat_map(|name| texels.domains(*name).into_iter().map(|domain| (*name, domain)));
    let domains: Vec<(DomainName, Domain)> = domains.collect();
    let one = |domain: &(DomainName, Domain)| Trial::new(texels, *domain, &shortlist);
    let trials: Vec<Trial<'_>> = domains.par_iter().map(one).collect();
    let with_few = |trial: &Trial<'_>| trial.by_terms(most.min(COMPARED_TERMS));
    let mut errors: Vec<Vec<Errors>> = trials.par_iter().map(with_few).collect();
    let last = |errors: &Vec<Errors>| *errors.last().expect("one or more");
    let merits: Vec<f64> = errors.iter().map(|errors| last(errors).merit()).collect();
    let best = (0..trials.len()).max_by(|a, b| merits[*a].total_cmp(&merits[*b]).then(b.cmp(a)));
    let best = best.expect("one or more domains");
    if most > COMPARED_TERMS {
        errors[best] = trials[best].by_terms(most);
    }
    let chosen = chosen(&errors[best], recipe);
    let others = (0..trials.len()).filter(|k| *k != best).map(|k| trials[k].candidate(last(&errors[k])));
    [trials[best].candidate(chosen)].into_iter().chain(others).collect()
}

/// Chooses a number of terms.
fn chosen(by_terms: &[Errors], recipe: &PwtRecipe) -> Errors {
    let most = *by_terms.last().expect("one or more");
    if recipe.degree.is_some() {
        return most;
    }
    let largest = by_terms.iter().map(Errors::merit).fold(f64::NEG_INFINITY, f64::max);
    let is_default = matches!(recipe.target, Target::Loss(_) | Target::Energy(_));
    let mut enough = by_terms.iter().filter(|errors| errors.merit() >= largest - EQUAL);
    // Three fetches are enough if more gain nothing. Where a size or an error is requested, more terms are closer at the fitted lights.
    let few = enough.clone().find(|errors| is_default && errors.terms >= COMPARED_TERMS);
    few.or_else(|| enough.next_back()).copied().unwrap_or(most)
}

/// Errors with a number of terms.
#[derive(Debug, Clone, Copy)]
struct Errors {
    terms: usize,
    /// PSNR at the fitted lights.
    psnr: f64,
    /// PSNR at lights that are left out, if available.
    held_out_psnr: Option<f64>,
}

impl Errors {
    fn merit(&self) -> f64 {
        self.held_out_psnr.unwrap_or(self.psnr)
    }
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

    /// Errors with 4, 8, … principal components, up to `most`.
    fn by_terms(&self, most: usize) -> Vec<Errors> {
        let (lights, columns) = self.values.shape();
        let entries = DMatrix::from_column_slice(3 * lights, columns / 3, self.values.as_slice());
        let components = Components::new(&entries, most);
        let coefficients = components.coefficients(&entries);
        let unseen = left_out(&components, &self.interpolation).map(|unseen| self.psnrs(&unseen, &coefficients));
        let errors = |(k, psnr): (usize, f64)| Errors {
            terms: (STEP * (k + 1)).min(components.axes.ncols()).max(1),
            psnr,
            held_out_psnr: unseen.as_ref().map(|unseen| unseen[k]),
        };
        self.psnrs(&components, &coefficients).into_iter().enumerate().map(errors).collect()
    }

    /// PSNR with 4, 8, … components, shown as those of `shown`; once, if there are none.
    fn psnrs(&self, shown: &Components, coefficients: &DMatrix<f64>) -> Vec<f64> {
        let (lights, columns) = self.values.shape();
        let mut sum = DMatrix::from_fn(3 * lights, columns / 3, |entry, _| shown.mean[entry]);
        let psnr = |sum: &DMatrix<f64>| {
            let of_light = |light: usize| {
                let row: Vec<f32> = (0..columns).map(|k| sum.as_slice()[light + lights * k] as f32).collect();
                squares(&to_srgb(self.domain.1, row), &self.texels.codes[light])
            };
            let all: Vec<f64> = (0..lights).into_par_iter().map(of_light).collect();
            decibels(all.iter().sum::<f64>() / (lights * columns).max(1) as f64)
        };
        let found = shown.axes.ncols();
        let with_more = |first: usize| {
            let count = STEP.min(found - first);
            sum += shown.axes.columns(first, count) * coefficients.rows(first, count);
            psnr(&sum)
        };
        (0..found.max(1)).step_by(STEP).map(with_more).collect()
    }

    fn candidate(&self, Errors { terms, psnr, held_out_psnr }: Errors) -> LearnedCandidate {
        let (domain, interpolation) = (self.domain.0, self.interpolation.clone());
        let (epsilon, coordinates) = (self.domain.1.code().1, LightCoordinates::Learned);
        let candidate =
            Candidate { domain, epsilon, coordinates, degree: terms as u32, ridge: 0.0, psnr, held_out_psnr };
        LearnedCandidate { candidate, interpolation }
    }
}

impl LearnedCandidate {
    /// Learns the terms.
    pub fn learn(&self, samples: &LightSamples) -> Learned {
        let at = samples.spread_texels(LEARNED_FROM.min(NUMBERS / (3 * samples.lights.len())));
        let domain = self.candidate.domain();
        let of_light = |image: &Pixels| -> Vec<f32> {
            let mut values: Vec<f32> = at.iter().flat_map(|texel| image.pixel(*texel)).collect();
            domain.encode_each(&mut values);
            values
        };
        let values: Vec<Vec<f32>> = samples.images.par_iter().map(of_light).collect();
        let entries = DMatrix::from_column_slice(3 * values.len(), at.len(), rows(&values).as_slice());
        let components = Components::new(&entries, self.candidate.degree as usize);
        Learned::new(&components, &self.interpolation, &samples.lights)
    }
}
