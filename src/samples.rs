//! Importance samples of a material's lobes, as a pack: `brdfc samples`.
//!
//! `formats/src/importance/spec.md` describes the layout.

pub use brdfc_formats::importance::ImportancePack;
pub use brdfc_importance::{HalfGrid, ImportanceFacts, ImportanceRecipe};

use crate::{Error, Material, Tally};
use brdfc_importance::importance_samples;

/// Draws half vectors for each outgoing direction, and counts repairs of the material's values.
///
/// # Errors
/// Returns an error if a number of the recipe is out of range, see [`ImportanceRecipe::check`].
pub fn draw(material: &Material, recipe: &ImportanceRecipe) -> Result<(ImportancePack, Tally), Error> {
    let source = material.source();
    recipe.check(source.symmetry().isotropic).map_err(|error| Error::usage(error.to_string()))?;
    importance_samples(source, recipe).map_err(Error::own_layout)
}
