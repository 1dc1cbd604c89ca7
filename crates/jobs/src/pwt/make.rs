//! Makes packs and maps from photographs, and measures their errors at held-out lights.

use crate::encode::Message;
use crate::error::Error;
use brdfc_core::words::apart;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightBasis, PwtDecoder};
use brdfc_pwt::measure::{StackErrors, image_errors, images_at, photograph_sums, stack_errors};
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{DomainName, LightSamples, PwtEncoded, PwtRecipe, Target, encode};
use brdfc_readers::ptm::Ptm;
use rand::RngExt as _;
use rand::SeedableRng as _;
use serde::Serialize;
use std::cell::LazyCell;

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

/// Errors at held-out views, blended from the other views.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct HeldOutViews {
    /// Indices of the held-out views, from 0.
    pub views: Vec<usize>,
    /// PSNR of sRGB levels at these views under the fitted lights, dB.
    pub psnr: f64,
    /// Mean ΔE (CIE76) of the same images.
    pub delta_e: f64,
    /// PSNR at these views under the held-out lights, dB; null without held-out lights.
    pub psnr_at_held_out_lights: Option<f64>,
    /// Mean ΔE of the same images.
    pub delta_e_at_held_out_lights: Option<f64>,
}

/// Numbers of lights and views to hold out of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HoldOut {
    /// Number of lights.
    pub lights: usize,
    /// Number of views.
    pub views: usize,
    /// Seed of the permutations that choose them.
    pub seed: u64,
}

/// An encoded pack and its errors at held-out lights.
pub struct PwtMade {
    /// The pack and details of its encoding.
    pub encoded: PwtEncoded,
    /// Held-out lights and the errors there.
    pub held_out: Option<HeldOut>,
    /// Held-out views and the errors there.
    pub held_out_views: Option<HeldOutViews>,
    /// Number of lights that were fitted.
    pub lights: usize,
}

impl PwtMade {
    /// The limit that the pack misses, with the key of the option, if it misses one. Limits of error apply to held-out lights and views as
    /// well.
    pub fn missed(&self, target: Target) -> Option<Message> {
        let errors = &self.encoded.errors;
        let is_error = matches!(target, Target::Quality(_) | Target::DeltaE(_));
        if let Some(nothing) = errors.nothing_shown().filter(|_| is_error) {
            return Some(format!("photographs: {nothing}").into());
        }
        let of = |key: &str, text: String| Some(Message::default().with_key(key).with_text(format!(": {text}")));
        let lights = self.held_out.as_ref().map(|held| (held.psnr, held.delta_e, " at held-out lights"));
        let views = self.held_out_views.as_ref().map(|held| (held.psnr, held.delta_e, " at held-out views"));
        let fitted = (errors.psnr, errors.delta_e, "");
        let fails = |(psnr, delta_e, _): &(f64, f64, &str)| match target {
            Target::Quality(least) => *psnr < least,
            Target::DeltaE(most) => *delta_e > most,
            Target::Bytes(_) | Target::Energy(_) | Target::Loss(_) => false,
        };
        let failed = if self.encoded.met { lights.into_iter().chain(views).find(fails)? } else { fitted };
        let (psnr, delta_e, at) = failed;
        match target {
            Target::Quality(least) => {
                of("quality", format!("found {} dB{at}, expected at least {least} dB", apart(psnr, least)))
            }
            Target::DeltaE(limit) => {
                let found = apart(delta_e, limit);
                of("max_delta_e", format!("found a mean ΔE of {found}{at}, expected at most {limit}"))
            }
            Target::Bytes(bytes) => {
                let found = self.encoded.pack.gpu_bytes();
                of("max_bytes", format!("found {found} bytes, expected at most {bytes}"))
            }
            Target::Energy(share) => {
                let text = "all terms and details remove less than";
                of("energy", format!("{text} {share} of the squared error; use a lower value"))
            }
            Target::Loss(loss) => of("loss", format!("the best pack loses more than {loss} dB; use a higher value")),
        }
    }
}

/// Encodes photographs. Holds out some lights and views, chosen by seeded permutations, to measure errors there.
///
/// # Errors
/// Returns an error if photographs or options are out of range, or if too few lights or views are left to fit.
pub fn make(samples: &LightSamples, recipe: &PwtRecipe, hold_out: HoldOut) -> Result<PwtMade, Error> {
    let unseen_views = held_out_views(samples, hold_out)?;
    let seen: Vec<usize> = (0..samples.view_count()).filter(|view| !unseen_views.contains(view)).collect();
    let some = (hold_out.views > 0).then(|| samples.only_views(&seen)).transpose().map_err(wrong)?;
    let fitted_views = some.as_ref().unwrap_or(samples);
    let left_out = held_out_lights(samples, hold_out.lights, hold_out.seed)?;
    let split = (hold_out.lights > 0).then(|| fitted_views.split(&left_out)).transpose().map_err(wrong)?;
    let fitted = split.as_ref().map_or(fitted_views, |[fitted, _]| fitted);
    let encoded = encode(fitted, recipe).map_err(wrong)?;
    // Without anything held out, the texels need no copy.
    let decoder = LazyCell::new(|| PwtDecoder::new(encoded.pack.clone()));
    let held_out = split.as_ref().map(|[_, unseen]| {
        let errors = stack_errors(&decoder, unseen, 1);
        HeldOut { lights: left_out.clone(), psnr: errors.psnr, delta_e: errors.delta_e }
    });
    let held_out_views = (hold_out.views > 0).then(|| errors_at_views(&decoder, samples, unseen_views, &left_out));
    Ok(PwtMade { lights: fitted.lights.len(), encoded, held_out, held_out_views })
}

/// The views that a seeded permutation holds out.
fn held_out_views(samples: &LightSamples, HoldOut { views, seed, .. }: HoldOut) -> Result<Vec<usize>, Error> {
    let count = samples.view_count();
    if views > count.saturating_sub(2) {
        let allowed = match count {
            1 => "0, as the input has one view".to_owned(),
            _ => format!("0 to {}, as at least two views must be fitted", count - 2),
        };
        return Err(Error::wrong_usage("--hold-out-views", views, allowed));
    }
    Ok(permutation(count, seed)[..views].to_vec())
}

/// Errors of a pack at views that it was not fitted to, under the fitted lights and those left out.
fn errors_at_views(
    decoder: &PwtDecoder,
    samples: &LightSamples,
    views: Vec<usize>,
    left_out: &[usize],
) -> HeldOutViews {
    let [mut fitted, mut unseen] = [Vec::new(), Vec::new()];
    for view in &views {
        let direction = samples.views.as_ref().map_or([0.0, 0.0, 1.0], |all| all.direction(*view));
        let images = images_at(decoder, direction, 0, &samples.lights);
        for (light, image) in images.iter().enumerate() {
            let sums = photograph_sums(image, &samples.images[light].linear(samples.pixels_of_view(*view)));
            if left_out.contains(&light) { unseen.push(sums) } else { fitted.push(sums) }
        }
    }
    let StackErrors { psnr, delta_e, .. } = StackErrors::of_photographs(&fitted);
    let both = (!left_out.is_empty()).then(|| StackErrors::of_photographs(&unseen));
    HeldOutViews {
        views,
        psnr,
        delta_e,
        psnr_at_held_out_lights: both.map(|errors| errors.psnr),
        delta_e_at_held_out_lights: both.map(|errors| errors.delta_e),
    }
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
        "wavelet" => Error::wrong_usage("--wavelet", error.found, error.allowed),
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
