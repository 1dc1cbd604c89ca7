//! Fits polynomial wavelet trees to the views of a flat BTF.

use crate::error::Error;
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::encode::{EncodeError, FlattenRecipe, SampledViews};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_formats::FormatError;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf_trees::FlatTrees;
use brdfc_pwt::{LightSamples, PwtRecipe, Target, Views, encode};

/// Fits trees to all views. All their values are in memory.
pub(super) fn fit(
    views: &SampledViews<'_, Error>,
    recipe: &FlattenRecipe,
    progress: &dyn Progress,
) -> Result<FlatTrees, EncodeError<Error>> {
    let samples = samples(views, recipe)?;
    progress.stage(Stage::Fit, 1)?;
    let target = match recipe.target {
        FactoredTarget::Bytes(bytes) => Target::Bytes(bytes),
        FactoredTarget::Error(delta_e) => Target::DeltaE(delta_e),
        FactoredTarget::Components { .. } => {
            return Err(FormatError::whole("target", "components", "bytes or an error for trees").problem().into());
        }
    };
    let encoded = encode(&samples, &PwtRecipe { target, ..PwtRecipe::default() })?;
    progress.step()?;
    if let (false, FactoredTarget::Bytes(most)) = (encoded.met, recipe.target) {
        let allowed = format!("{} or more, the bytes of the smallest trees", encoded.pack.gpu_bytes());
        return Err(EncodeError::Outside(Error::check(format!("--max-bytes: found {most}, expected {allowed}"))));
    }
    let lowest_light = samples.lights.iter().map(|light| light[2]).fold(1.0, f32::min);
    Ok(FlatTrees::new(encoded.pack, views.has_shadows, lowest_light)?)
}

/// The views as images, one above the other. Rows of flat BTFs stay in their order, so that images have the parameters of the
/// flat BTF as coordinates, and its views and lights as directions.
fn samples(views: &SampledViews<'_, Error>, recipe: &FlattenRecipe) -> Result<LightSamples, EncodeError<Error>> {
    let (side, count) = (recipe.flat_texels, recipe.views.len());
    let lights: Vec<[f32; 3]> = recipe.lights.directions().into_iter().map(|light| light.map(|c| c as f32)).collect();
    let mut images = vec![Vec::with_capacity(side * side * count); lights.len()];
    for view in 0..count {
        let flat = views.view(view as u32)?;
        for (light, image) in images.iter_mut().enumerate() {
            image.extend(flat.light(light as u32).iter().map(|texel| rgb9e5::decode(*texel)));
        }
    }
    let several = (count > 1).then(|| Views::new(recipe.views.clone())).transpose()?;
    Ok(LightSamples {
        repeats: true,
        views: several,
        defined: Some(views.masks.concat()),
        ..LightSamples::new([side, side * count], lights, images)
    })
}
