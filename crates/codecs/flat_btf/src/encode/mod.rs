//! Encodes a surface with its appearance, or an ordinary BTF, as a flat BTF. Each step has its own file; this one
//! sequences them.

mod check;
mod error;
mod pass;
mod prepared;
mod probing;
mod recipe;
mod relief;
mod report;
mod scratch;
#[cfg(test)]
mod tests;
mod trees;
mod work;

pub use check::MAX_BYTES;
pub use error::EncodeError;
pub use prepared::{FlatBtfEncoded, FlatInput, ValueSource};
pub use recipe::{FlattenRecipe, Reflectance, ReliefForm, VdimRecipe};
pub use report::{AssetErrors, AssetReport};
pub use scratch::{MemoryScratch, Scratch};
pub use trees::{SampledViews, encode_trees};

use crate::far::{FarLevel, far_materials};
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::MAX_MATERIALS as MAX_BRDF_MATERIALS;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, SampledDirections};
use prepared::{Prepared, ReflectanceFacts};
use work::Work;

/// Encodes a surface as a flat BTF. `E` is the error type of the images and of the scratch storage, which takes 4 bytes
/// for each texel, view and light of a factored reflectance.
///
/// Shadows are left to the relief. Where values contain them, in images and with light of one bounce, the factors come with
/// a residual.
///
/// The flat BTF does not depend on the number of threads, which only determines how many views are in memory at once:
/// [`FlattenRecipe::bytes`].
///
/// # Errors
/// Returns an error if the recipe is invalid or requires trees, if the surface cannot be parameterised, if images or scratch storage
/// fail, or if the work is cancelled.
pub fn encode<E: Send>(
    input: FlatInput<'_, E>,
    recipe: &FlattenRecipe,
    scratch: &dyn Scratch<Error = E>,
    progress: &dyn Progress,
) -> Result<FlatBtfEncoded, EncodeError<E>> {
    recipe.check()?;
    let FlatInput { mesh, repairs, values } = input;
    let known_materials = matches!(values, ValueSource::Computed(_)) && recipe.bounces == 0;
    check_materials(recipe, &values, known_materials)?;
    let (prepared, relief) = Prepared::new((mesh, repairs), &values, recipe, progress)?;
    let work = Work { recipe, prepared: &prepared, unshadowed: known_materials };
    let (made, seen) = work.reflectance(&values, scratch, progress)?;
    let form = if seen.is_some() { Reflectance::Factors } else { Reflectance::Brdf };
    let levels = made.asset.header().levels;
    let mut decoder = FlatBtfDecoder::new(FlatBtfParts::new(relief, made.asset));
    let directions = SampledDirections::of(decoder.parts())?;
    let mut far: Vec<FarLevel> = Vec::new();
    if let (ValueSource::Computed(appearance), Reflectance::Brdf) = (&values, form) {
        progress.stage(Stage::Fit, levels as usize - 1)?;
        let of_asset = (&decoder, directions.as_ref());
        let (reflectance, levels) = far_materials(of_asset, &prepared.model, appearance, progress)?;
        decoder = FlatBtfDecoder::new(FlatBtfParts::new(decoder.into_parts().relief, reflectance));
        far = levels;
    }
    let facts = ReflectanceFacts { form, seen, far, factored: Some(made.facts) };
    prepared.finished(&values, recipe, decoder, directions.as_ref(), facts)
}

/// Checks that the reflectance that a recipe requires can have these values.
fn check_materials<E>(
    recipe: &FlattenRecipe,
    values: &ValueSource<'_, E>,
    known_materials: bool,
) -> Result<(), FormatError> {
    match recipe.reflectance {
        Reflectance::Auto | Reflectance::Factors => return Ok(()),
        Reflectance::Brdf => {}
        Reflectance::Pwt => return Err(FormatError::whole("reflectance", "pwt", "brdf or factors").problem()),
    }
    match values {
        ValueSource::Computed(appearance) if known_materials => {
            if appearance.sources.len() > MAX_BRDF_MATERIALS as usize {
                let found = format!("{} materials", appearance.sources.len());
                let allowed = format!("at most {MAX_BRDF_MATERIALS} for the reflectance brdf");
                return Err(FormatError::whole("materials", found, allowed));
            }
            Ok(())
        }
        _ => {
            let allowed = "materials without bounces; images and bounces require factors";
            Err(FormatError::whole("reflectance", "brdf", allowed))
        }
    }
}
