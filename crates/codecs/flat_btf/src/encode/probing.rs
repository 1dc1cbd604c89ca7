//! Errors of the finished asset.

use super::recipe::FlattenRecipe;
use crate::measured::ViewImages;
use crate::model::MesoModel;
use crate::probes::{ColourErrors, Place, Probes, direct_radiance};
use crate::surface::Appearance;
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};
use rayon::prelude::*;

/// Probes of a computed BTF.
const PROBES: usize = 8192;
/// Probes of a measured BTF, each of which reads an image.
const IMAGE_PROBES: usize = 512;

/// Errors against the surface itself at random points, views and lights. `None` for light of one bounce, which the
/// reference does not contain.
pub(super) fn from_surface(
    recipe: &FlattenRecipe,
    model: &MesoModel,
    (decoder, directions): (&FlatBtfDecoder, Option<&SampledDirections>),
    appearance: &Appearance,
) -> Option<ColourErrors> {
    if recipe.bounces > 0 {
        return None;
    }
    let probes = Probes::between(PROBES, &recipe.views.directions(), &recipe.lights.directions());
    let truth = |place: &Place| direct_radiance(model, appearance, *place, true);
    let truths: Vec<[f32; 3]> = probes.places().par_iter().map(truth).collect();
    Some(probes.errors(decoder, directions, &truths))
}

/// Errors against the images of a measured BTF.
pub(super) fn from_images<E: Send>(
    recipe: &FlattenRecipe,
    (decoder, directions): (&FlatBtfDecoder, Option<&SampledDirections>),
    images: &dyn ViewImages<Error = E>,
) -> Result<ColourErrors, E> {
    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let (probes, pairs) = Probes::at_samples(IMAGE_PROBES, &views, &lights);
    let mut truths = Vec::with_capacity(pairs.len());
    for (place, [view, light]) in probes.places().iter().zip(pairs) {
        truths.push(images.image(view, light)?.at(place.at[0], place.at[1]));
    }
    Ok(probes.errors(decoder, directions, &truths))
}
