//! Makes packs and maps from photographs, and measures their errors at held-out lights.

use crate::error::Error;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightBasis, PwtDecoder};
use brdfc_pwt::measure::{StackErrors, image_errors, stack_errors};
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{DomainName, LightSamples, PwtEncoded, PwtRecipe, Target, encode};
use brdfc_readers::ptm::Ptm;
use rand::RngExt as _;
use rand::SeedableRng as _;
use serde::Serialize;

/// Errors at held-out lights.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct HeldOut {
    /// Indices of the held-out lights, from 0, counted without lights that have no image or are at or below the horizon; lights of
    /// one direction, whose photographs are averaged, count once.
    pub lights: Vec<usize>,
    /// PSNR of sRGB levels, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

/// Why a pack misses its target.
#[derive(Debug, Clone, PartialEq)]
pub enum Missed {
    /// Errors at the fitted lights are too large.
    Fitted,
    /// Errors at the held-out lights are too large.
    HeldOut,
    /// The photographs have nothing to measure.
    Nothing(String),
}

/// An encoded pack and its errors at held-out lights.
pub struct PwtMade {
    /// The pack and details of its encoding.
    pub encoded: PwtEncoded,
    /// Held-out lights and the errors there.
    pub held_out: Option<HeldOut>,
    /// Number of lights that were fitted.
    pub lights: usize,
}

impl PwtMade {
    /// The reason why the pack misses a target, if it does. Limits of error apply to held-out lights as well.
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

/// Encodes photographs. Holds out `hold_out` of them, chosen by a seeded permutation, to measure errors at those lights.
///
/// # Errors
/// Returns an error if photographs or options are out of range, or if no light is left to fit.
pub fn make(samples: &LightSamples, recipe: &PwtRecipe, hold_out: usize, seed: u64) -> Result<PwtMade, Error> {
    if hold_out == 0 {
        let encoded = encode(samples, recipe).map_err(wrong)?;
        return Ok(PwtMade { encoded, held_out: None, lights: samples.lights.len() });
    }
    let left_out = held_out_lights(samples, hold_out, seed)?;
    let [fitted, unseen] = samples.split(&left_out).map_err(wrong)?;
    let encoded = encode(&fitted, recipe).map_err(wrong)?;
    let errors = stack_errors(&PwtDecoder::new(encoded.pack.clone()), &unseen, 1);
    let held_out = HeldOut { lights: left_out, psnr: errors.psnr, delta_e: errors.delta_e };
    Ok(PwtMade { encoded, held_out: Some(held_out), lights: fitted.lights.len() })
}

/// The lights that a seeded permutation holds out.
pub(super) fn held_out_lights(samples: &LightSamples, hold_out: usize, seed: u64) -> Result<Vec<usize>, Error> {
    if hold_out > 0 && hold_out >= samples.lights.len() {
        let allowed = format!("0 to {}, as at least one light must be fitted", samples.lights.len().saturating_sub(1));
        return Err(Error::wrong_usage("--hold-out", hold_out, allowed));
    }
    Ok(permutation(samples.lights.len(), seed)[..hold_out].to_vec())
}

/// Error about photographs out of range, or about more levels than their size allows.
pub(super) fn wrong(error: FormatError) -> Error {
    match error.field.as_ref() {
        "levels" => Error::wrong_usage("--levels", error.found, error.allowed),
        _ => Error::input(error),
    }
}

/// Random permutation of the numbers below `count` (Fisher and Yates).
pub fn permutation(count: usize, seed: u64) -> Vec<usize> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, random.random_range(0..=last));
    }
    order
}

/// Defaults of a recipe for a file of an RTI viewer: its own terms and scale.
pub fn recipe_of_map(recipe: PwtRecipe, basis: LightBasis) -> PwtRecipe {
    PwtRecipe {
        coordinates: recipe.coordinates.or(Some(basis.coordinates)),
        degree: recipe.degree.or(Some(basis.degree)),
        domain: recipe.domain.or(Some(DomainName::Display)),
        ridge: recipe.ridge.or(Some(1e-9)),
        ..recipe
    }
}

/// Makes a polynomial texture map from photographs, and measures its errors there.
///
/// # Errors
/// Returns an error if photographs are out of range.
pub fn make_map(samples: &LightSamples, model: MapModel) -> Result<(Ptm, StackErrors), Error> {
    let samples = samples.distant().map_err(wrong)?;
    let map = fit_map(&samples, model).map_err(wrong)?;
    let shown = images_of(&map, samples.lights.clone());
    let errors = image_errors(&shown, &samples);
    Ok((map, errors))
}
