//! One source to one pack, as a recipe says.

use super::auto::search;
use super::averaged::AveragingCost;
use super::error::PackError;
use super::pack::{EncodedPack, of_table, of_wavelet};
use super::recipe::PackRecipe;
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use brdfc_source::Source;
use brdfc_source::progress::Progress;

/// Makes a pack.
///
/// # Errors
/// Recipes that cannot be followed, cancellation. A budget that nothing meets is none: see [`EncodedPack::missed`].
pub fn encode(source: &dyn Source, recipe: &PackRecipe, progress: &dyn Progress) -> Result<EncodedPack, PackError> {
    Ok(match recipe {
        PackRecipe::Auto(recipe) => search(source, recipe, progress)?,
        PackRecipe::Table(recipe) => {
            let mut made = of_table(brdfc_table::encode::encode(source, recipe, progress)?);
            if recipe.reciprocal && recipe.measure {
                let reference = Reference::new(source, PairSet::within(recipe.directions));
                made.averaging = Some(AveragingCost::of(source, &reference));
            }
            made
        }
        PackRecipe::Wavelet(recipe) => of_wavelet(brdfc_wavelet::encode::encode(source, recipe, progress)?, recipe),
    })
}
