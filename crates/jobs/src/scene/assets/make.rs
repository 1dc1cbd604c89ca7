//! Makes the pack of an asset, and measures it.

use super::{AssetJob, AssetKind, AssetRecipe};
use crate::environment::Surroundings;
use crate::error::Error;
use crate::pwt::{HoldOut, LightInput, ViewChoice, make as make_tree, recipe_of_map};
use crate::report::gate::GateResult;
use brdfc_codec::Budget;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::words::counted;
use brdfc_environment::facts::EnvironmentFacts;
use brdfc_source::environment::open_environment;
use brdfc_source::{Input, Kind};
use serde::{Deserialize, Serialize};

/// Contents of the pack of an asset, and its errors against the source.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AssetReport {
    /// Columns and rows of an image, or texels along the sides of a face.
    pub size: [u32; 2],
    /// Number of images: views times lights, or faces of a cube.
    pub images: usize,
    /// Number of texture fetches of a look-up; absent for environments.
    pub fetches: Option<u32>,
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Bytes on a GPU, including mipmaps.
    pub bytes_on_gpu: u64,
    /// PSNR of sRGB levels against the photographs, dB; absent for environments.
    pub psnr: Option<f64>,
    /// Mean ΔE (CIE76) against the photographs; absent for environments, and if the photographs have nothing to measure.
    pub delta_e: Option<f64>,
    /// The target that no pack meets.
    pub missed: Option<String>,
    /// Statements of the source that were applied, and what was left out.
    pub notes: Vec<String>,
}

impl AssetReport {
    /// Checks the pack against its limits. A limit with nothing to measure fails.
    pub(super) fn check(&self, limits: &Budget) -> Vec<GateResult> {
        let of_delta_e = limits.delta_e.map(|limit| {
            let found = self.delta_e.map_or("no photographs to compare with".to_owned(), |found| {
                format!("a mean of {}", brdfc_core::words::apart(found, limit))
            });
            let passed = self.delta_e.is_some_and(|found| found <= limit);
            GateResult::new("require.max_delta_e", found, format!("a mean of at most {limit}"), passed)
        });
        let of_bytes = limits.bytes.map(|limit| {
            let (found, allowed) = (self.bytes_on_gpu, format!("at most {}", counted(limit as usize, "byte")));
            GateResult::new("require.max_bytes", format!("{found} bytes"), allowed, found <= limit)
        });
        let of_fetches = limits.fetches.map(|limit| {
            let found = self.fetches.map_or("no look-ups of its own".to_owned(), |found| found.to_string());
            let passed = self.fetches.is_some_and(|found| found <= limit);
            GateResult::new("require.max_fetches", found, format!("at most {limit}"), passed)
        });
        of_delta_e.into_iter().chain(of_bytes).chain(of_fetches).collect()
    }
}

/// Makes the pack of an asset. Returns its bytes.
///
/// # Errors
/// Returns an error if the source cannot be read or is of another kind, or if cancelled.
pub(super) fn make(job: &AssetJob, progress: &dyn Progress) -> Result<(Vec<u8>, AssetReport), Error> {
    let input = Input::from(job.path.as_path());
    let kind = Kind::of(&input)?;
    if !job.kind.accepts(kind) {
        return Err(kind.refused(&input, job.kind.inputs()).into());
    }
    progress.stage(Stage::Read, 1)?;
    match &job.recipe {
        AssetRecipe::Pwt(recipe, codes) => {
            let view = (job.kind == AssetKind::Btf).then_some(ViewChoice::All);
            let photographs = LightInput::open_as(&input, view, *codes)?;
            let mut notes: Vec<String> =
                photographs.colour().map(|colour| format!("colour: {colour}")).into_iter().collect();
            notes.extend(photographs.notes());
            let recipe = photographs.basis().map_or(*recipe, |basis| recipe_of_map(*recipe, basis));
            let samples = photographs.into_samples();
            progress.stage(Stage::Fit, 1)?;
            let made = make_tree(&samples, &recipe, HoldOut::default()).map_err(|error| error.prefixed(&input))?;
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
            let file = open_environment(&input)?;
            let notes = file.conversions().to_vec();
            let surroundings = Surroundings::from(file);
            let pack = surroundings.prefilter(*side, progress).map_err(|error| error.prefixed(&input))?;
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
