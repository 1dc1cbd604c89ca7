//! Factored BTFs: weights of texels times a basis of views and lights.

use super::assets::Asset;
use super::errors::{Errors, Truth};
use super::lights::Lights;
use super::rows::{BtfRow, Tally};
use brdfc_flat_btf::factored::{FactorError, Factored, FactoredRecipe, FactoredTarget, factor};
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::factored::{BASE_LAYERS, FactoredFlatBtf};
use brdfc_formats::flat_btf::{BlendedDirection, FlatHeader, FlatView, ViewWeights, VisibilityMask};
use rayon::prelude::*;
use std::time::Instant;

/// Number of blended pairs of a view and a light.
const PAIRS: f64 = 9.0;
/// Fetches of the base's table.
const BASE_ENTRIES: f64 = 1.0;
/// Number of blended lights, each with its residual of shadows.
const BLENDED_LIGHTS: f64 = 3.0;

/// Factors a BTF and measures it. Calls `view_done` after each measured view.
///
/// # Errors
/// Returns an error for a size or directions that a flat BTF cannot have.
pub(super) fn factored(
    name: &str,
    target: FactoredTarget,
    asset: &Asset,
    (set, lights): (&DirectionSet, &Lights),
    view_done: &dyn Fn(),
) -> Result<BtfRow, FormatError> {
    let start = Instant::now();
    let made = factors(target, asset, (set, &(0..asset.views()).collect::<Vec<_>>()), lights)?;
    let seconds = start.elapsed().as_secs_f64();

    let mut errors = Errors::default();
    for view in 0..asset.views() {
        let truth = Truth::new(&asset.renderings(view, lights), asset.mask(view));
        let direction = single(set.directions()[view]);
        errors.add(truth.errors(&images_of(&made.asset, asset, (view, direction), lights), lights));
        view_done();
    }
    let header = made.asset.header();
    let residual = if made.facts.residual > 0 { BLENDED_LIGHTS } else { 0.0 };
    let loads = 3.0 * f64::from(header.texels_per_colour());
    let of_base = f64::from(BASE_LAYERS) + BASE_ENTRIES;
    let fetches = f64::from(header.groups) + of_base + residual + PAIRS * loads;
    let row = Tally { bytes: made.facts.gpu_bytes, fetches, seconds, errors }.row(name);
    Ok(BtfRow { held_out_texels_delta_e: Some(f64::from(made.facts.errors.seen_mean)), ..row })
}

/// Factors some views of a BTF at the fitted lights. Fewer bytes than those of the smallest asset give that asset.
///
/// # Errors
/// Returns an error for a size or directions that a flat BTF cannot have.
pub(super) fn factors(
    target: FactoredTarget,
    asset: &Asset,
    (set, views): (&DirectionSet, &[usize]),
    lights: &Lights,
) -> Result<Factored, FormatError> {
    let radians = |[polar, azimuth]: &[f64; 2]| {
        // In f32 a full turn is not below the maximum.
        let azimuth = azimuth.to_radians().rem_euclid(std::f64::consts::TAU) as f32;
        [polar.to_radians() as f32, if azimuth < std::f32::consts::TAU { azimuth } else { 0.0 }]
    };
    let header = |view: u32| FlatHeader {
        size: asset.size as u32,
        view,
        views: views.iter().map(|view| radians(&set.angles[*view])).collect(),
        lights: lights.fitted.iter().map(|light| radians(&set.angles[*light])).collect(),
    };
    let view = |view: u32| {
        let words = lights.fitted.iter().flat_map(|light| asset.light(views[view as usize], *light)).copied();
        FlatView::new(header(view), words.collect())
    };
    let texels = asset.size * asset.size;
    let mask = |directions: &[usize]| {
        let byte = |view: usize, texel: usize| if asset.mask(view).is_none_or(|mask| mask[texel]) { 255 } else { 0 };
        let bytes = directions.iter().flat_map(|view| (0..texels).map(move |texel| byte(*view, texel)));
        VisibilityMask::new(asset.size as u32, directions.len() as u32, bytes.collect())
    };
    let seen = mask(views)?;
    let lit = mask(&lights.fitted)?;
    let is_too_small = matches!(target, FactoredTarget::Bytes(_)) && target.check(&header(0)).is_err();
    let smallest = FactoredTarget::Components { components: 1, residual: 1 };
    let target = if is_too_small { smallest } else { target };
    let made = factor(&FactoredRecipe::new(target), &asset.normals, &seen, Some(&lit), view, &());
    made.map_err(|error| match error {
        FactorError::View(error) | FactorError::Format(error) => error,
        FactorError::Cancelled(_) => unreachable!("it is never cancelled"),
    })
}

pub(super) fn single(direction: Vector) -> [f32; 3] {
    direction.map(|c| c as f32)
}

/// Renderings of a view under all lights, which reach the texels that are seen from there. Held-out lights are evaluated as
/// a renderer does for any light.
fn images_of(
    made: &FactoredFlatBtf,
    asset: &Asset,
    (view, direction): (usize, [f32; 3]),
    lights: &Lights,
) -> Vec<Vec<[f32; 3]>> {
    let size = made.header().size;
    let samples = ViewWeights { indices: [view as u32; 3], weights: [1.0, 0.0, 0.0] };
    let towards = BlendedDirection { direction, samples };
    let between: Vec<BlendedDirection> = lights
        .held_out
        .iter()
        .zip(&lights.blends)
        .map(|(light, (indices, weights))| {
            let samples = ViewWeights { indices: *indices, weights: *weights };
            BlendedDirection { direction: lights.directions[*light], samples }
        })
        .collect();
    let of_texel = |at: u32| -> Vec<[f32; 3]> {
        let mut values = vec![[0.0; 3]; lights.directions.len()];
        let texel = made.texel([at % size, at / size]);
        let shadowed = |value: [f32; 3], light: usize, samples: ViewWeights| {
            let lit = asset.mask(light).is_none_or(|mask| mask[at as usize]);
            texel.shadowed(value, samples, f32::from(u8::from(lit)))
        };
        for (stored, light) in lights.fitted.iter().enumerate() {
            let samples = ViewWeights { indices: [stored as u32; 3], weights: [1.0, 0.0, 0.0] };
            values[*light] = shadowed(texel.value(view as u32, stored as u32), *light, samples);
        }
        for (light, between) in lights.held_out.iter().zip(&between) {
            values[*light] = shadowed(texel.blended(towards, *between), *light, between.samples);
        }
        values
    };
    let texels: Vec<Vec<[f32; 3]>> = (0..size * size).into_par_iter().map(of_texel).collect();
    let count = lights.directions.len();
    (0..count).into_par_iter().map(|light| texels.iter().map(|texel| texel[light]).collect()).collect()
}
