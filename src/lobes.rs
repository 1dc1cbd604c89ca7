//! Lobes: the light that a material reflects from an environment, by a few look-ups in prefiltered light.
//!
//! [`encode`] fits them to a material; [`environment`](crate::environment) prefilters light. `formats/src/lobes/spec.md`
//! describes the layout.

pub use brdfc_formats::lobes::{LobesPack, MAX_LOBES};
pub use brdfc_jobs::lobes::{CODEC, missed, recipe};
pub use brdfc_lobes::{
    DEFAULT_DELTA_E, DEFAULT_FETCHES, EncodedLobes, LobesFacts, LobesRecipe, LobesTrial, RenderingError,
};

use crate::{Error, Progress, Source};
use brdfc_jobs::lobes::encode_lobes;

/// Fits lobes to a material. If no number of look-ups meets the limit, the one with the smallest error is selected; see
/// [`LobesTrial::meets`].
///
/// # Errors
/// Returns an error for a recipe out of range ([`ErrorKind::Usage`](crate::ErrorKind::Usage)), and
/// if the work was cancelled.
pub fn encode(source: &dyn Source, recipe: &LobesRecipe, progress: &dyn Progress) -> Result<EncodedLobes, Error> {
    recipe.check().map_err(Error::usage)?;
    Ok(encode_lobes(source, recipe, progress)?)
}
