//! Errors of the finished asset.

use super::recipe::FlattenRecipe;
use crate::measured::ViewImages;
use crate::model::MesoModel;
use crate::probes::{ColourErrors, Place, Probes, direct_radiance};
use crate::surface::Appearance;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};

/// Probes of a computed BTF.
const PROBES: usize = 8192;
/// Probes of a measured BTF, each of which reads an image.
const IMAGE_PROBES: usize = 512;

/// Errors against the surface itself at random points, views and lights. `None` for light of one bounce, which the
/// reference does not contain.
pub(super) fn from_surface(
    recipe: &FlattenRecipe,
    model: &MesoModel,
    decoder: &FlatBtfDecoder,
    appearance: &Appearance,
) -> Result<Option<ColourErrors>, FormatError> {
    if recipe.bounces > 0 {
        return Ok(None);
    }
    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let probes = Probes::between(PROBES, &views, &lights);
    let directions = SampledDirections::of(&decoder.parts().reflectance)?;
    let truth = |place: &Place| direct_radiance(model, appearance, place.at, place.view, place.light);
    Ok(Some(probes.errors(decoder, directions.as_ref(), truth)))
}

/// Errors against the images of a measured BTF. The outer error is the images' own.
pub(super) fn from_images<E: Send>(
    recipe: &FlattenRecipe,
    decoder: &FlatBtfDecoder,
    images: &dyn ViewImages<Error = E>,
) -> Result<Result<ColourErrors, FormatError>, E> {
    let (views, lights): (Vec<Vector>, Vec<Vector>) = (recipe.views.directions(), recipe.lights.directions());
    let directions = match SampledDirections::of(&decoder.parts().reflectance) {
        Ok(directions) => directions,
        Err(error) => return Ok(Err(error)),
    };
    let (probes, pairs) = Probes::at_samples(IMAGE_PROBES, &views, &lights);
    let mut truths = Vec::with_capacity(pairs.len());
    for (place, [view, light]) in probes.places().zip(pairs) {
        truths.push(images.image(view, light)?.at(place.at[0], place.at[1]));
    }
    Ok(Ok(probes.errors_from(decoder, directions.as_ref(), &truths)))
}
