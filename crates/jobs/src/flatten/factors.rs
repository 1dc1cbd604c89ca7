//! Three small parts in place of all views.

use super::error::FlattenError;
use super::parts::Parts;
use brdfc_core::progress::Progress;
use brdfc_flat_btf::factored::{FactorError, Factored, FactoredRecipe, FactoredTarget, factor};
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::{FlatPart, FlatView, NormalMap, VisibilityMask, view_part};

/// Factors the views that were kept aside, and adds the parts of the product.
///
/// # Errors
/// A target that nothing can meet; files that cannot be read or written; when the work is stopped.
pub(super) fn add_factors(
    target: FactoredTarget,
    (normals, mask): (&NormalMap, &VisibilityMask),
    parts: &mut Parts<'_>,
    supercompress: bool,
    progress: &dyn Progress,
) -> Result<Factored, FlattenError> {
    let kept: &Parts<'_> = parts;
    let view = |view: u32| -> Result<FlatView, FlattenError> {
        Ok(FlatView::from_bytes(&kept.kept(&view_part(view, mask.views()))?)?)
    };
    let made = factor(&FactoredRecipe::new(target), normals, mask, view, progress).map_err(|error| match error {
        FactorError::View(error) => error,
        FactorError::Format(error) => error.into(),
        FactorError::Cancelled(cancelled) => cancelled.into(),
    })?;
    let (asset, header) = (&made.asset, made.asset.header());
    let basis = Extent::D2(header.basis_extent());
    parts.add(FlatPart::Basis.name(), &asset.basis().to_bytes(supercompress), basis, 1)?;
    let weights = asset.weights().to_bytes(supercompress);
    parts.add(FlatPart::Weights.name(), &weights, header.weights_extent(), header.levels)?;
    if let Some(shadow) = asset.shadow() {
        let bytes = shadow.to_bytes(supercompress);
        parts.add(FlatPart::Shadow.name(), &bytes, header.shadow_extent(), header.levels)?;
    }
    Ok(made)
}
