//! Makes the pack of an asset, and measures it.

use super::job::{AssetJob, AssetKind, AssetRecipe};
use super::report::AssetReport;
use crate::environment::Surroundings;
use crate::error::Error;
use crate::pwt::{HoldOut, LightInput, ViewChoice, make as make_tree, recipe_of_map};
use brdfc_core::progress::{Progress, Stage};
use brdfc_environment::facts::EnvironmentFacts;
use brdfc_source::environment::open_environment;
use brdfc_source::{Input, Kind};

/// The source of an asset.
///
/// # Errors
/// Returns an error if it cannot be read or is of another kind.
pub(super) fn checked_input(job: &AssetJob) -> Result<Input, Error> {
    let input = Input::from(job.path.as_path());
    let kind = Kind::of(&input)?;
    if job.kind.accepts(kind) {
        return Ok(input);
    }
    let heading = AssetKind::of(kind).map_or(String::new(), |kind| format!(", or list it under [{}]", kind.heading()));
    Err(kind.found(&input, format!("{}{heading}", job.kind.inputs())).into())
}

/// Makes the pack of an asset from its [`checked_input`]. Returns its bytes.
///
/// # Errors
/// Returns an error if the source cannot be read, or if cancelled.
pub(super) fn make(job: &AssetJob, input: &Input, progress: &dyn Progress) -> Result<(Vec<u8>, AssetReport), Error> {
    match &job.recipe {
        AssetRecipe::Pwt(recipe, codes) => {
            let view = (job.kind == AssetKind::Btf).then_some(ViewChoice::All);
            let photographs = LightInput::open_as(input, view, *codes)?;
            let mut notes: Vec<String> =
                photographs.colour().map(|colour| format!("colour: {colour}")).into_iter().collect();
            notes.extend(photographs.notes());
            let recipe = photographs.basis().map_or(*recipe, |basis| recipe_of_map(*recipe, basis));
            let samples = photographs.into_samples();
            progress.stage(Stage::Fit, 1)?;
            let made = make_tree(&samples, &recipe, HoldOut::default()).map_err(|error| error.prefixed(input))?;
            let errors = &made.encoded.errors;
            let nothing = errors.nothing_shown();
            notes.extend(nothing.iter().map(|nothing| format!("the errors mean nothing: {nothing}")));
            let (pack, header) = (&made.encoded.pack, made.encoded.pack.header());
            let bytes = pack.to_bytes(true);
            let report = AssetReport {
                size: header.size,
                images: header.view_count() as usize * made.lights,
                fetches: Some(header.fetches()),
                bytes_on_disk: bytes.len() as u64,
                bytes_on_gpu: pack.gpu_bytes(),
                psnr: Some(errors.psnr),
                delta_e: nothing.is_none().then_some(errors.delta_e),
                missed: made.missed(recipe.target).map(|missed| missed.to_string()),
                notes,
            };
            Ok((bytes, report))
        }
        AssetRecipe::Environment(side) => {
            let file = open_environment(input)?;
            let notes = file.conversions().to_vec();
            let surroundings = Surroundings::from(file);
            let pack = surroundings.prefilter(*side, progress).map_err(|error| error.prefixed(input))?;
            let (bytes, facts) = (pack.to_bytes(true), EnvironmentFacts::new(&pack));
            let report = AssetReport {
                size: [facts.side; 2],
                images: 6,
                bytes_on_disk: bytes.len() as u64,
                bytes_on_gpu: facts.gpu_bytes,
                notes,
                ..AssetReport::default()
            };
            Ok((bytes, report))
        }
    }
}
