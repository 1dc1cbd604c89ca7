//! Lobes of the materials that an environment lights.

use super::error::JobError;
use crate::encode::{OptionError, Predicted};
use crate::lobes::{encode_lobes, missed, recipe};
use brdfc_core::progress::Progress;
use brdfc_core::{Source, Tally};
use brdfc_lobes::{LobesFacts, LobesRecipe};
use serde::{Deserialize, Serialize};

/// Name of lobes among the parts of a material.
pub const LOBES: &str = crate::lobes::CODEC;

/// Bytes on a GPU of the weights of a look-up, or of a pair of them: isotropic and anisotropic.
const ROW_BYTES: [u64; 2] = [192, 768];

/// The table `lobes` of a material or of the defaults.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LobesLimits {
    /// Largest mean ΔE of renderings.
    pub max_delta_e: Option<f64>,
    /// Largest number of look-ups.
    pub max_fetches: Option<u32>,
}

impl LobesLimits {
    /// Resolves the recipe: limits of `defaults` replace absent ones.
    ///
    /// # Errors
    /// Returns an error if a limit is out of range.
    pub fn resolve(&self, defaults: &Self) -> Result<LobesRecipe, OptionError> {
        recipe(self.max_delta_e.or(defaults.max_delta_e), self.max_fetches.or(defaults.max_fetches))
    }
}

/// Lobes of a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct LobesReport {
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Facts about its contents.
    pub facts: LobesFacts,
    /// The limit that no number of look-ups meets; the lobes are then the closest ones.
    pub missed: Option<String>,
}

impl LobesReport {
    /// The missed limit with its key in a manifest.
    pub fn missed(&self) -> Option<String> {
        self.missed.as_ref().map(|missed| format!("{LOBES}.max_delta_e: {missed}"))
    }
}

/// Fits lobes to a material. Returns the bytes of their file, their report, and the repairs of the source's values.
///
/// # Errors
/// Returns an error if the caller cancels.
pub fn material_lobes(
    source: &dyn Source,
    recipe: &LobesRecipe,
    progress: &dyn Progress,
) -> Result<(Vec<u8>, LobesReport, Tally), JobError> {
    let encoded = encode_lobes(source, recipe, progress)?;
    let best = encoded.best();
    let bytes = best.pack.to_bytes(true);
    let report = LobesReport {
        bytes_on_disk: bytes.len() as u64,
        facts: LobesFacts::new(&best.pack),
        missed: missed(&encoded, recipe),
    };
    Ok((bytes, report, encoded.tally))
}

/// Bounds of the bytes on a GPU.
pub fn predict(recipe: &LobesRecipe) -> Predicted {
    Predicted { least: ROW_BYTES[0], most: ROW_BYTES[1] * recipe.max_fetches as u64 }
}

/// Adds the way to make lobes to the error of a codec of that name: builds make packs for lights.
pub fn with_hint(error: OptionError) -> OptionError {
    if error.field != "codec" || error.found.trim_matches('"') != LOBES {
        return error;
    }
    let allowed = error.allowed.with_text(
        "; builds make lobes, next to packs, where a scene has an environment: --environment IMAGE, or environment in [scene]",
    );
    OptionError { allowed, ..error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_a_material_come_first() {
        let of = |max_delta_e, max_fetches| LobesLimits { max_delta_e, max_fetches };
        let resolved = |own: LobesLimits, defaults: LobesLimits| {
            own.resolve(&defaults).map(|recipe| (recipe.max_delta_e, recipe.max_fetches)).map_err(|e| e.to_string())
        };
        let none = LobesLimits::default();
        assert_eq!(resolved(none, none), Ok((Some(1.0), 16)));
        assert_eq!(resolved(of(None, Some(4)), none), Ok((None, 4)), "the smallest error of 4 look-ups");
        assert_eq!(resolved(of(None, Some(4)), of(Some(2.0), Some(8))), Ok((Some(2.0), 4)));
        assert_eq!(resolved(of(None, Some(33)), none), Err("max_fetches: found 33, expected 1 to 32 for lobes".into()));
        assert_eq!(resolved(of(Some(0.0), None), none), Err("max_delta_e: found 0, expected 1e-6 to 100".into()));
    }

    #[test]
    fn predictions_hold() {
        let recipe = LobesRecipe { max_fetches: 2, max_delta_e: None };
        for (address, least) in [("synth:lambert", ROW_BYTES[0]), ("synth:ward?ay=0.5", ROW_BYTES[1])] {
            let opened = brdfc_source::open::open(address, None).unwrap();
            let (_, report, _) = material_lobes(opened.source.as_ref(), &recipe, &()).unwrap();
            let (found, Predicted { least: bound, most }) = (report.facts.gpu_bytes, predict(&recipe));
            assert!(found.is_multiple_of(least) && (bound..=most).contains(&found), "{address}: {found}");
        }
    }
}
