//! Search within a range of directions. It also tries the pack for all directions, which may be smaller.

use super::recipe::SearchRecipe;
use super::{CancelOnly, EncodedTable, Excess, search, smallest_tried};
use crate::crop::window;
use crate::encode::{Encoded, measured};
use brdfc_codec::EncodeError;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::{PackSource, Source};
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{Crop, DirectionRange};
use brdfc_metrics::compare::Reference;

/// Finds the smallest pack that meets a budget within the range of the recipe's directions.
///
/// Tables are fitted to the range and measured in it, so that a limit may be harder to meet than over all directions:
/// the range may contain little but the highlight. Unless the result is as small as tables come, the search runs
/// without the range as well, up to as many nodes as the result has. The cropped result of that search is used if it
/// meets the limit within the range and is smaller. So above the smallest tables a range costs no bytes if the pack for
/// all directions suffices.
pub fn search_within(
    source: &dyn Source,
    recipe: &SearchRecipe,
    progress: &dyn Progress,
) -> Result<EncodedTable, EncodeError> {
    let directions = recipe.table.directions;
    let (made, reference) = search(source, recipe, progress)?;
    if directions.is_all() || !source.directions().is_all() || !recipe.budget.limits_error() {
        return Ok(made);
    }
    if made.missed.is_none() && uncropped(&made) <= smallest_tried(source, recipe) {
        return Ok(made);
    }
    match of_all_directions(source, recipe, &made, progress)? {
        Some(whole) => {
            progress.check()?;
            Ok(smaller(&reference, recipe, made, &whole))
        }
        None => Ok(made),
    }
}

/// Selects the pack for the range or, if it meets the limits there and is smaller, the cropped pack for all directions.
/// `reference` covers the range.
#[doc(hidden)]
pub fn smaller(
    reference: &Reference,
    recipe: &SearchRecipe,
    mut made: EncodedTable,
    whole: &EncodedTable,
) -> EncodedTable {
    let directions = recipe.table.directions;
    made.of_all_directions = Some(whole.pack.gpu_bytes());
    let BrdfPack::Table(pack) = &whole.pack else { return made };
    let crop = Crop { directions, window: window(pack.header(), directions) };
    let mut pack = pack.cropped(crop).expect("a window is within its own table");
    if made.missed.is_none() && pack.gpu_bytes() >= made.pack.gpu_bytes() {
        return made;
    }
    let off_grid = reference.compare(&PackSource::new(&pack, None));
    measured(&mut pack, &off_grid);
    let is_met = Excess::of(&recipe.budget, &off_grid).is_met();
    let bytes = pack.to_bytes(recipe.table.supercompress);
    let cropped =
        EncodedTable::from(Encoded { pack, bytes, asymmetry: whole.codec.asymmetry, off_grid, tally: whole.tally });
    made.tried.push(cropped.trial(&cropped.codec, is_met));
    if !is_met {
        return made;
    }
    let EncodedTable { of_all_directions, averaging, tried, .. } = made;
    EncodedTable { of_all_directions, averaging, tried, ..cropped }
}

/// Searches for the same limits over all directions, among tables no larger than the uncropped result; `None` if no
/// such table meets them.
fn of_all_directions(
    source: &dyn Source,
    recipe: &SearchRecipe,
    made: &EncodedTable,
    progress: &dyn Progress,
) -> Result<Option<EncodedTable>, EncodeError> {
    let mut recipe = recipe.clone();
    recipe.table.directions = DirectionRange::ALL;
    if made.missed.is_none() {
        // A size of the search, so that the tried sizes are the same as without a range.
        let most = uncropped(made).next_power_of_two();
        recipe.budget.bytes = Some(recipe.budget.bytes.map_or(most, |bytes| bytes.min(most)));
    }
    progress.stage(Stage::Try, 1)?;
    match search(source, &recipe, &CancelOnly(progress)) {
        Ok((whole, _)) => Ok(Some(whole).filter(|whole| whole.missed.is_none())),
        // Limits may have no meaning over all directions; the pack for the range is still valid.
        Err(EncodeError::Cancelled(cancelled)) => Err(EncodeError::Cancelled(cancelled)),
        Err(_) => Ok(None),
    }
}

/// Bytes on a GPU without cropping.
fn uncropped(made: &EncodedTable) -> u64 {
    made.pack.gpu_bytes() + made.cropped_bytes
}
