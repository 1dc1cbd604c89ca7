//! Packs and maps of photographs, and how wrong they are at lights left out.

use crate::error::Error;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightCoordinates, PwtDecoder};
use brdfc_pwt::measure::{StackErrors, picture_errors, stack_errors};
use brdfc_pwt::ptm::{MapModel, fit_map, pictures_of};
use brdfc_pwt::{DomainName, LightSamples, PwtEncoded, PwtRecipe, Target, encode};
use brdfc_readers::ptm::Ptm;
use rand::RngExt as _;
use rand::SeedableRng as _;
use serde::Serialize;

/// Errors at lights that the fit has not seen.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct HeldOut {
    /// Which lights, by their place in the list.
    pub lights: Vec<usize>,
    /// Peak signal-to-noise ratio of sRGB codes, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

/// Why a pack does not meet a target that was asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Missed {
    /// Errors at the lights that were fitted.
    Fitted,
    /// Errors at lights that were held out.
    HeldOut,
    /// Photographs say nothing.
    Nothing(String),
}

/// What is made, and what was left out to measure it.
pub struct PwtMade {
    /// The pack and what was found on the way.
    pub encoded: PwtEncoded,
    /// Lights that the fit has not seen, and the errors there.
    pub held_out: Option<HeldOut>,
    /// Lights that were fitted.
    pub lights: usize,
}

impl PwtMade {
    /// Why it misses a target. Limits of error hold at lights that were held out, too.
    pub fn missed(&self, target: Target) -> Option<Missed> {
        let fails = |psnr: f64, delta_e: f64| match target {
            Target::Quality(least) => psnr < least,
            Target::DeltaE(most) => delta_e > most,
            Target::Bytes(_) | Target::Energy(_) | Target::Loss(_) => false,
        };
        let is_error = matches!(target, Target::Quality(_) | Target::DeltaE(_));
        if let Some(nothing) = self.encoded.errors.nothing_shown().filter(|_| is_error) {
            return Some(Missed::Nothing(nothing));
        }
        if !self.encoded.met {
            return Some(Missed::Fitted);
        }
        self.held_out.as_ref().filter(|held| fails(held.psnr, held.delta_e)).map(|_| Missed::HeldOut)
    }
}

/// Encodes photographs, some of them left out by a seeded permutation: their errors are those of unseen lights.
///
/// # Errors
/// Photographs or options out of range; more lights left out than there are to spare.
pub fn make(samples: &LightSamples, recipe: &PwtRecipe, hold_out: usize, seed: u64) -> Result<PwtMade, Error> {
    if hold_out == 0 {
        let encoded = encode(samples, recipe).map_err(wrong)?;
        return Ok(PwtMade { encoded, held_out: None, lights: samples.lights.len() });
    }
    if hold_out >= samples.lights.len() {
        let allowed = format!("0 to {}: one light is fitted at least", samples.lights.len().saturating_sub(1));
        return Err(Error::wrong_usage("--hold-out", hold_out, allowed));
    }
    let left_out = &permutation(samples.lights.len(), seed)[..hold_out];
    let encoded = encode(&samples.without(left_out), recipe).map_err(wrong)?;
    let rest: Vec<usize> = (0..samples.lights.len()).filter(|light| !left_out.contains(light)).collect();
    let errors = stack_errors(&PwtDecoder::new(encoded.pack.clone()), &samples.without(&rest), 1);
    let held_out = HeldOut { lights: left_out.to_vec(), psnr: errors.psnr, delta_e: errors.delta_e };
    Ok(PwtMade { encoded, held_out: Some(held_out), lights: rest.len() })
}

/// Photographs out of range; or levels, of which there may be as many as their size allows.
fn wrong(error: FormatError) -> Error {
    match error.field.as_ref() {
        "levels" => Error::wrong_usage("--levels", error.found, error.allowed),
        _ => Error::input(error),
    }
}

/// The numbers below `count` in an order that a seed decides (Fisher and Yates).
pub fn permutation(count: usize, seed: u64) -> Vec<usize> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, random.random_range(0..=last));
    }
    order
}

/// What of a recipe a polynomial texture map has by its nature: its own terms and scale, unless others are asked for.
pub fn recipe_of_map(recipe: PwtRecipe) -> PwtRecipe {
    PwtRecipe {
        coordinates: recipe.coordinates.or(Some(LightCoordinates::Projected)),
        degree: recipe.degree.or(Some(2)),
        domain: recipe.domain.or(Some(DomainName::Display)),
        ridge: recipe.ridge.or(Some(1e-9)),
        ..recipe
    }
}

/// A polynomial texture map of photographs, and its errors there.
///
/// # Errors
/// Photographs out of range.
pub fn make_map(samples: &LightSamples, model: MapModel) -> Result<(Ptm, StackErrors), Error> {
    let map = fit_map(samples, model).map_err(wrong)?;
    let shown = pictures_of(&map, samples.lights.clone());
    let errors = picture_errors(&shown, samples);
    Ok((map, errors))
}
