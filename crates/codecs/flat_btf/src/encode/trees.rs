//! Encodes flat BTFs whose reflectance is polynomial wavelet trees. The encoder of trees is that of the caller.

use super::error::EncodeError;
use super::prepared::{FlatBtfEncoded, FlatInput, Prepared, ReflectanceFacts, ValueSource};
use super::recipe::{FlattenRecipe, Reflectance, ReliefForm, VdimRecipe};
use super::scratch::Scratch;
use super::work::Work;
use brdfc_core::progress::Progress;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, FlatView};
use brdfc_formats::flat_btf_trees::FlatTrees;

/// All views of a flat BTF, to which trees are fitted.
pub struct SampledViews<'a, E> {
    /// For each view, the texels that it sees; values of the others are filled.
    pub masks: &'a [Vec<bool>],
    /// True if values include the shadows of the relief.
    pub has_shadows: bool,
    read: &'a (dyn Fn(u32) -> Result<FlatView, EncodeError<E>> + Sync),
}

impl<E> SampledViews<'_, E> {
    /// Reads a view.
    ///
    /// # Errors
    /// Returns an error if scratch storage fails.
    pub fn view(&self, view: u32) -> Result<FlatView, EncodeError<E>> {
        (self.read)(view)
    }
}

/// Encodes a surface like [`encode`](super::encode), with trees that `fit` fits to its views.
///
/// Over layers, and where shadows are left out, values of known materials are without shadows. Others include them: those
/// of images and with light of one bounce, and over an indirection map, because trees have no sampled shadows.
///
/// # Errors
/// Returns the errors of `encode`, and those of `fit`.
pub fn encode_trees<E: Send + Sync>(
    input: FlatInput<'_, E>,
    recipe: &FlattenRecipe,
    scratch: &dyn Scratch<Error = E>,
    fit: impl FnOnce(&SampledViews<'_, E>) -> Result<FlatTrees, EncodeError<E>>,
    progress: &dyn Progress,
) -> Result<FlatBtfEncoded, EncodeError<E>> {
    recipe.check()?;
    let FlatInput { mesh, repairs, values } = input;
    let known_materials = matches!(values, ValueSource::Computed(_)) && recipe.bounces == 0;
    let sampled_shadows = matches!(recipe.relief, ReliefForm::Vdim(VdimRecipe { shadows: true, .. }));
    let has_shadows = !known_materials || sampled_shadows;
    let recipe = &without_sampled_shadows(recipe);
    let (prepared, relief) = Prepared::new((mesh, repairs), &values, recipe, progress)?;
    let work = Work { recipe, prepared: &prepared, unshadowed: !has_shadows };
    let views = work.views(&values, scratch, progress)?;
    let read = |view| views.scratched.read(view, scratch);
    let trees = fit(&SampledViews { masks: &views.masks, has_shadows, read: &read })?;
    let decoder = FlatBtfDecoder::new(FlatBtfParts::new(relief, trees));
    let facts = ReflectanceFacts { form: Reflectance::Pwt, seen: Some(views.seen), far: Vec::new(), factored: None };
    prepared.finished(&values, recipe, decoder, None, facts)
}

/// The recipe with an indirection map without sampled shadows.
fn without_sampled_shadows(recipe: &FlattenRecipe) -> FlattenRecipe {
    let relief = match recipe.relief {
        ReliefForm::Vdim(vdim) => ReliefForm::Vdim(VdimRecipe { shadows: false, ..vdim }),
        ReliefForm::Layers => ReliefForm::Layers,
    };
    FlattenRecipe { relief, ..recipe.clone() }
}
