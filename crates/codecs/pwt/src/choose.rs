//! Chooses domain, coordinates, degree and ridge by leave-one-out cross-validation over the lights, on texels spread
//! over the image.

use crate::candidates::{Candidate, Texels, decibels, squares, to_srgb};
use crate::choose_learned::{LearnedCandidate, MAX_LIGHTS, are_few, may_learn, tried as tried_learned};
use crate::design::{Design, RIDGES};
use crate::recipe::{DomainName, PwtRecipe};
use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, MAX_DEGREE};
use rayon::prelude::*;
use std::borrow::Cow;

/// PSNR at lights that are left out that polynomials must gain over learned terms, dB.
const FAVOURED: f64 = 0.6;
/// Maximum numbers in photographs that polynomials are fitted to, as all are in memory as floats: 6 GiB.
const MAX_NUMBERS: usize = 3 << 29;

/// The choice, and what it was chosen from.
pub struct Choice<'a> {
    /// The best candidate of each pair of domain and coordinates, the chosen one first.
    pub candidates: Vec<Candidate>,
    /// The chosen candidate, if its terms are learned, with the images to learn from.
    pub(crate) learned: Option<(LearnedCandidate, Cow<'a, LightSamples>)>,
}

/// Chooses among polynomials and learned terms; among learned terms alone if photographs are too large for polynomials.
///
/// # Errors
/// Returns an error if photographs are too large for polynomials, and terms cannot be learned from them.
pub fn choose<'a>(samples: &'a LightSamples, recipe: &PwtRecipe) -> Result<Choice<'a>, FormatError> {
    let may_learn = may_learn(samples, recipe);
    let [width, height] = samples.size;
    let is_large = 3 * width * height * samples.lights.len() > MAX_NUMBERS;
    if is_large && !may_learn {
        let found = format!("{} of {width} x {height} pixels", samples.lights.len());
        let allowed = format!("at most {} million pixels in all for polynomials", MAX_NUMBERS / 3_000_000);
        return Err(FormatError::whole("photographs", found, allowed));
    }
    // Of many lights, both kinds see the same averages.
    let few = if may_learn { samples.at_most(MAX_LIGHTS) } else { Cow::Borrowed(samples) };
    let texels = Texels::new(&few);
    let polynomials = match recipe.coordinates {
        Some(LightCoordinates::Learned) => Vec::new(),
        _ if is_large => Vec::new(),
        _ => best_of_each(polynomials(&texels, &few, recipe)),
    };
    let (learned, others) = may_learn.then(|| tried_learned(&texels, &few, recipe)).unzip();
    let all = learned.iter().map(LearnedCandidate::candidate).chain(others.into_iter().flatten());
    let mut candidates = best_of_each(all.chain(polynomials.iter().copied()).collect());
    let least = polynomials.first().map_or(f64::NEG_INFINITY, Candidate::merit);
    // Learned terms take fewer fetches than polynomials, and are closer at the lights.
    let is_chosen =
        |learned: &LearnedCandidate| are_few(&few.lights) || learned.candidate().merit() >= least - FAVOURED;
    let chosen = learned.filter(is_chosen);
    let first = chosen.as_ref().map_or(candidates[0], LearnedCandidate::candidate);
    candidates.retain(|other| (other.domain, other.coordinates) != (first.domain, first.coordinates));
    candidates.insert(0, first);
    Ok(Choice { candidates, learned: chosen.map(|chosen| (chosen, few)) })
}

/// Candidates of polynomials.
fn polynomials(texels: &Texels, samples: &LightSamples, recipe: &PwtRecipe) -> Vec<Candidate> {
    let coordinates = recipe.coordinates.map_or(LightCoordinates::POLYNOMIAL.to_vec(), |one| vec![one]);
    let ridges: Vec<f64> = recipe.ridge.map_or(RIDGES.to_vec(), |one| vec![one]);
    let first = recipe.domain.unwrap_or(DomainName::Display);
    // First coordinates and ridge in one domain; then all domains, with ridges near the best one.
    let mut found = texels.tried(samples, recipe, &[first], &coordinates, &ridges);
    let Some(best) = best(&found) else { return found };
    if recipe.domain.is_none() {
        let at = ridges.iter().position(|ridge| *ridge == best.ridge).unwrap_or(0);
        let ridges: Vec<f64> = ridges[at.saturating_sub(2)..ridges.len().min(at + 3)].to_vec();
        let others: Vec<DomainName> = DomainName::ALL.into_iter().filter(|domain| *domain != first).collect();
        found.extend(texels.tried(samples, recipe, &others, &[best.coordinates], &ridges));
    }
    found
}

/// The best candidate of each pair of domain and coordinates, the best of all first.
fn best_of_each(mut found: Vec<Candidate>) -> Vec<Candidate> {
    let mut selected: Vec<Candidate> = Vec::new();
    found.sort_by(|a, b| b.merit().total_cmp(&a.merit()));
    for candidate in found {
        if !selected.iter().any(|k| (k.domain, k.coordinates) == (candidate.domain, candidate.coordinates)) {
            selected.push(candidate);
        }
    }
    selected
}

/// The best candidate; the first of equals.
fn best(candidates: &[Candidate]) -> Option<Candidate> {
    candidates.iter().copied().reduce(|best, other| if other.merit() > best.merit() { other } else { best })
}

impl Texels {
    fn tried(
        &self,
        samples: &LightSamples,
        recipe: &PwtRecipe,
        names: &[DomainName],
        coordinates: &[LightCoordinates],
        ridges: &[f64],
    ) -> Vec<Candidate> {
        let domains = names.iter().flat_map(|name| self.domains(*name).into_iter().map(|domain| (*name, domain)));
        let encoded = |(name, domain)| (name, domain, self.encoded(domain));
        let encoded: Vec<(DomainName, Domain, Vec<Vec<f32>>)> = domains.map(encoded).collect();
        let designs = || coordinates.iter().flat_map(|c| ridges.iter().map(move |ridge| (*c, *ridge)));
        let trials: Vec<_> = encoded.iter().flat_map(|values| designs().map(move |design| (values, design))).collect();
        let one = |((name, domain, encoded), (coordinates, ridge)): &(&(DomainName, Domain, Vec<Vec<f32>>), _)| {
            let highest = recipe.degree.unwrap_or(MAX_DEGREE);
            let design =
                Design::new(LightBasis { coordinates: *coordinates, degree: highest }, &samples.lights, *ridge);
            // A requested degree is always used.
            let lowest = recipe.degree.unwrap_or(0);
            let candidate = |(degree, psnr, held_out_psnr): (u32, f64, Option<f64>)| Candidate {
                domain: *name,
                epsilon: domain.code().1,
                coordinates: *coordinates,
                degree,
                ridge: *ridge,
                psnr,
                held_out_psnr,
            };
            self.by_degree(&design, *domain, encoded, lowest).into_iter().map(candidate).collect::<Vec<_>>()
        };
        let found: Vec<Vec<Candidate>> = trials.par_iter().map(one).collect();
        found.into_iter().flatten().collect()
    }

    /// PSNR of every degree from the lowest: at fitted lights and, if available, in cross-validation.
    fn by_degree(
        &self,
        design: &Design,
        domain: Domain,
        encoded: &[Vec<f32>],
        lowest: u32,
    ) -> Vec<(u32, f64, Option<f64>)> {
        let (terms, numbers) = (design.terms(), encoded.first().map_or(0, Vec::len));
        let mut coefficients = vec![vec![0.0f32; numbers]; terms];
        for (light, values) in encoded.iter().enumerate() {
            for (row, weight) in coefficients.iter_mut().zip(design.row(light)) {
                let weight = *weight as f32;
                row.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let mut predictions = vec![vec![0.0f32; numbers]; encoded.len()];
        let mut found = Vec::new();
        let mut first = 0;
        for degree in 0..=design.basis.degree {
            let last = LightBasis { degree, ..design.basis }.terms();
            let leverages = design.leverages(degree);
            let mut errors = [0.0f64; 2];
            for (light, prediction) in predictions.iter_mut().enumerate() {
                for (row, weight) in coefficients[first..last].iter().zip(&design.row(light)[first..last]) {
                    let weight = *weight as f32;
                    prediction.iter_mut().zip(row).for_each(|(sum, c)| *sum += weight * c);
                }
                if degree < lowest {
                    continue;
                }
                // 0 if cross-validation is not available.
                let share = leverages.as_ref().map_or(0.0, |leverages| (1.0 / (1.0 - leverages[light])) as f32);
                let unseen = |(predicted, value): (&f32, &f32)| value - (value - predicted) * share;
                let unseen = prediction.iter().zip(&encoded[light]).map(unseen).collect();
                for (sum, values) in errors.iter_mut().zip([prediction.clone(), unseen]) {
                    *sum += squares(&to_srgb(domain, values), &self.codes[light]);
                }
            }
            first = last;
            if degree >= lowest {
                let count = (numbers * encoded.len()).max(1) as f64;
                let [fitted, left_out] = errors.map(|error| decibels(error / count));
                found.push((degree, fitted, leverages.is_some().then_some(left_out)));
            }
        }
        found
    }
}
