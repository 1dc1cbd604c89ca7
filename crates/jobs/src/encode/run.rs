//! One source to one pack, as a recipe says.

use super::averaged::AveragingCost;
use super::error::PackError;
use super::pack::{EncodedPack, of_table, of_wavelet};
use super::recipe::PackRecipe;
use super::tables::{TableShelf, tabulated};
use super::within::search_within;
use brdfc_core::Source;
use brdfc_core::progress::{Progress, Stage};
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use brdfc_wavelet::encode::encode_tabulated;

/// Makes a pack.
///
/// # Errors
/// Recipes that cannot be followed, cancellation. A budget that nothing meets is none: see [`EncodedPack::missed`].
pub fn encode(source: &dyn Source, recipe: &PackRecipe, progress: &dyn Progress) -> Result<EncodedPack, PackError> {
    encode_with(source, recipe, &(), progress)
}

/// The same; tables of the source come from a shelf where it has them, and are kept there where it has not.
///
/// # Errors
/// As [`encode`].
pub fn encode_with(
    source: &dyn Source,
    recipe: &PackRecipe,
    shelf: &dyn TableShelf,
    progress: &dyn Progress,
) -> Result<EncodedPack, PackError> {
    // A pack that was made for some directions only says nothing of others.
    let (has, needed) = (source.directions(), recipe.directions());
    let common = has.common(needed).ok_or(PackError::OtherDirections { has, needed })?;
    let mut recipe = recipe.clone();
    recipe.limit_directions(common);
    Ok(match &recipe {
        PackRecipe::Auto(recipe) => search_within(source, recipe, progress)?,
        PackRecipe::Table(recipe) => {
            let mut made = of_table(brdfc_table::encode::encode(source, recipe, progress)?);
            if recipe.reciprocal && recipe.measure {
                let reference = Reference::new(source, PairSet::within(recipe.directions));
                made.averaging = Some(AveragingCost::of(source, &reference));
            }
            made
        }
        PackRecipe::Wavelet(recipe) => {
            progress.stage(Stage::Resample, 1)?;
            let table = tabulated(source, recipe.grid(), shelf);
            of_wavelet(encode_tabulated(&table, source, recipe, progress)?, recipe)
        }
    })
}
