//! The search within a range of directions: it looks at the pack of all directions, too, which may do.

use super::auto::{Within, excess, of_table, search, smallest_tried};
use super::recipe::AutoRecipe;
use super::{CodecReport, EncodedPack};
use brdfc_codec::EncodeError;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::{PackSource, Source};
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{Crop, DirectionRange};
use brdfc_metrics::compare::Reference;
use brdfc_table::TableReport;
use brdfc_table::crop::window;
use brdfc_table::encode::{Encoded, measured};

/// The smallest pack that meets a budget within the range of the recipe's directions.
///
/// Tables are fitted to the range and measured in it, so that a limit may be harder to meet than over all directions: a
/// highlight may be all that is left. Unless what meets it is as small as tables come, the search is done without the range as
/// well, up to as many nodes as were found. What that makes, cropped, is kept where it meets the limit within the range and
/// is smaller. So above the smallest tables a range costs no bytes where that of all directions would do.
pub(super) fn search_within(
    source: &dyn Source,
    recipe: &AutoRecipe,
    progress: &dyn Progress,
) -> Result<EncodedPack, EncodeError> {
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

/// What was made within a range, or what was made of all directions, cropped, where that meets the limits there and is smaller.
/// The reference is that of the range.
fn smaller(reference: &Reference, recipe: &AutoRecipe, mut made: EncodedPack, whole: &EncodedPack) -> EncodedPack {
    let directions = recipe.table.directions;
    made.of_all_directions = Some(whole.pack.gpu_bytes());
    let (BrdfPack::Table(pack), CodecReport::Table(TableReport { asymmetry, .. })) = (&whole.pack, &whole.codec) else {
        return made;
    };
    let crop = Crop { directions, window: window(pack.header(), directions) };
    let mut pack = pack.cropped(crop).expect("a window is within the table that it was found for");
    if made.missed.is_none() && pack.gpu_bytes() >= made.pack.gpu_bytes() {
        return made;
    }
    let off_grid = reference.compare(&PackSource::new(&pack, None));
    measured(&mut pack, &off_grid);
    let over = excess(&recipe.budget, &off_grid);
    let bytes = pack.to_bytes(recipe.table.supercompress);
    let cropped = of_table(Encoded { pack, bytes, asymmetry: *asymmetry, off_grid, tally: whole.tally });
    made.tried.push(cropped.trial(&*cropped.codec, over <= 1.0));
    if over > 1.0 {
        return made;
    }
    let EncodedPack { of_all_directions, averaging, tried, .. } = made;
    EncodedPack { of_all_directions, averaging, tried, ..cropped }
}

/// What the same limits ask for over all directions, among tables that would be no larger than what was made, were it not
/// cropped; none where no such table meets them.
fn of_all_directions(
    source: &dyn Source,
    recipe: &AutoRecipe,
    made: &EncodedPack,
    progress: &dyn Progress,
) -> Result<Option<EncodedPack>, EncodeError> {
    let mut recipe = recipe.clone();
    recipe.table.directions = DirectionRange::ALL;
    if made.missed.is_none() {
        // A step of the search, so that what is tried is what would be tried without a range.
        let most = uncropped(made).next_power_of_two();
        recipe.budget.bytes = Some(recipe.budget.bytes.map_or(most, |bytes| bytes.min(most)));
    }
    progress.stage(Stage::Try, 1)?;
    match search(source, &recipe, &Within(progress)) {
        Ok((whole, _)) => Ok(Some(whole).filter(|whole| whole.missed.is_none())),
        // Limits may have no meaning over all directions; the range has its pack all the same.
        Err(EncodeError::Cancelled(cancelled)) => Err(EncodeError::Cancelled(cancelled)),
        Err(_) => Ok(None),
    }
}

/// Bytes on a GPU with what was cropped.
fn uncropped(made: &EncodedPack) -> u64 {
    made.pack.gpu_bytes() + made.cropped_bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_codec::Budget;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::crop::Elevations;
    use brdfc_metrics::sampling::PairSet;

    fn recipe(directions: DirectionRange, delta_e: f64) -> AutoRecipe {
        let budget = Budget { delta_e: Some(delta_e), ..Budget::default() };
        let mut recipe = AutoRecipe { budget, ..AutoRecipe::default() };
        recipe.table.directions = directions;
        recipe
    }

    fn range(light: [f32; 2], view: [f32; 2]) -> DirectionRange {
        let [light, view] = [light, view].map(|[from, to]| Elevations { from, to });
        DirectionRange { light, view }
    }

    const RANGES: [([f32; 2], [f32; 2]); 5] = [
        ([85.0, 90.0], [0.0, 90.0]),
        ([0.0, 10.0], [0.0, 90.0]),
        ([0.0, 90.0], [0.0, 20.0]),
        ([60.0, 90.0], [60.0, 90.0]),
        ([20.0, 90.0], [35.0, 90.0]),
    ];

    /// The pack of all directions, cropped, and how far over the budget it is within the range.
    fn whole_within(source: &dyn Source, recipe: &AutoRecipe) -> (u64, f64) {
        let directions = recipe.table.directions;
        let mut everywhere = recipe.clone();
        everywhere.table.directions = DirectionRange::ALL;
        let whole = search(source, &everywhere, &()).expect("a pack").0.pack;
        let BrdfPack::Table(pack) = whole else { panic!("only tables are tried") };
        let window = window(pack.header(), directions);
        let pack = pack.cropped(Crop { directions, window }).expect("within the table");
        let error = Reference::new(source, PairSet::within(directions)).compare(&PackSource::new(&pack, None));
        (pack.gpu_bytes(), excess(&recipe.budget, &error))
    }

    #[test]
    fn a_range_costs_no_bytes_where_the_pack_of_all_directions_would_do() {
        let mut did = 0;
        for address in ["synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.15", "synth:ggx?kd=0.1,0.2,0.3&f0=0.04&alpha=0.4"] {
            let source = parse_synth(address).expect("an address");
            for (light, view) in RANGES {
                let recipe = recipe(range(light, view), 0.5);
                let made = search_within(source.as_ref(), &recipe, &()).expect("a pack");
                let (bytes, over) = whole_within(source.as_ref(), &recipe);
                // The smallest that are tried differ by what is left of 1 KiB.
                let bytes = bytes.max(smallest_tried(source.as_ref(), &recipe));
                assert!(over > 1.0 || made.pack.gpu_bytes() <= bytes, "{address} {light:?} {view:?}: {:?}", made.tried);
                did += usize::from(over <= 1.0);
                assert!(made.missed.is_some() || excess(&recipe.budget, &made.off_grid) <= 1.0);
            }
        }
        assert!(did >= 2, "{did}");
    }

    /// A pack that is larger than it needs to be gives way to that of all directions, but only where that meets the limits.
    #[test]
    fn the_pack_of_all_directions_is_taken_where_it_does() {
        let source = parse_synth("synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.3").expect("an address");
        let directions = range([20.0, 90.0], [35.0, 90.0]);
        let large = || search(source.as_ref(), &recipe(directions, 0.05), &()).expect("a pack");
        let (whole, _) = search(source.as_ref(), &recipe(DirectionRange::ALL, 0.5), &()).expect("a pack");
        let of_limit = |delta_e: f64| {
            let (made, reference) = large();
            smaller(&reference, &recipe(directions, delta_e), made, &whole)
        };
        let (taken, kept, before) = (of_limit(2.0), of_limit(0.05), large().0);
        assert!(taken.pack.gpu_bytes() < before.pack.gpu_bytes() && taken.pack.directions() == directions);
        assert!(taken.off_grid.picture.delta_e.mean <= 2.0 && taken.tried.len() == before.tried.len() + 1);
        let [bytes, _] = [&taken, &kept].map(|made| made.of_all_directions);
        assert_eq!(bytes, Some(whole.pack.gpu_bytes()));
        assert!(kept.bytes == before.bytes && kept.tried.last().is_some_and(|trial| !trial.meets));
    }
}
