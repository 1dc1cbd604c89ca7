//! Makes the reflectance of a surface, from its materials or from all its views.

use super::error::EncodeError;
use super::pass::Pass;
use super::prepared::{Prepared, SeenTexels, ValueSource};
use super::recipe::{FlattenRecipe, Reflectance};
use super::scratch::{Scratch, ScratchViews};
use crate::factored::{Factored, FactoredRecipe, FactoredTarget, factor, known};
use crate::interreflection::Bounces;
use crate::light_field::{ComputedField, projected, visible_from_each};
use crate::measured::MeasuredField;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, dot};
use brdfc_formats::flat_btf::VisibilityMask;

/// Blur of texels that are looked up in images of about as many pixels: [`FactoredRecipe::blur`].
const IMAGE_BLUR: f32 = 0.1;

/// All views, in scratch storage.
pub(super) struct StoredViews {
    pub(super) scratched: ScratchViews,
    /// For each view, the texels that it sees.
    pub(super) masks: Vec<Vec<bool>>,
    /// For each light, the texels that it reaches.
    reached: Vec<Vec<bool>>,
    pub(super) seen: SeenTexels,
}

/// Work on a reflectance.
pub(super) struct Work<'a> {
    pub(super) recipe: &'a FlattenRecipe,
    pub(super) prepared: &'a Prepared,
    /// True if values have no shadows: materials are known and light is direct.
    pub(super) unshadowed: bool,
}

impl Work<'_> {
    /// Selects the form of the reflectance: factors only if materials are not enough. Factors come with the texels that
    /// their views see.
    pub(super) fn reflectance<E: Send>(
        &self,
        values: &ValueSource<'_, E>,
        scratch: &dyn Scratch<Error = E>,
        progress: &dyn Progress,
    ) -> Result<(Factored, Option<SeenTexels>), EncodeError<E>> {
        let brdf = match self.brdf(values, progress)? {
            Some(made) if self.is_enough(&made) => return Ok((made, None)),
            other => other,
        };
        self.recipe.target.check(&self.recipe.header(0))?;
        let (mut factors, seen) = self.factors(values, scratch, progress)?;
        match brdf {
            // Factors must be better for the bytes that they take.
            Some(mut brdf) if brdf.facts.errors.seen_mean <= factors.facts.errors.seen_mean => {
                brdf.facts.tried.append(&mut factors.facts.tried);
                Ok((brdf, None))
            }
            brdf => {
                let first = brdf.map_or(Vec::new(), |brdf| brdf.facts.tried);
                factors.facts.tried.splice(0..0, first);
                Ok((factors, Some(seen)))
            }
        }
    }

    /// Fits known materials. `None` if factors are required, or if the materials do not fit into the bytes.
    fn brdf<E: Send>(
        &self,
        values: &ValueSource<'_, E>,
        progress: &dyn Progress,
    ) -> Result<Option<Factored>, EncodeError<E>> {
        let Self { recipe, prepared: Prepared { model, surface, .. }, .. } = self;
        let ValueSource::Computed(appearance) = values else { return Ok(None) };
        if !self.unshadowed || recipe.reflectance == Reflectance::Factors {
            return Ok(None);
        }
        progress.stage(Stage::Fit, 1)?;
        let counts = projected(&model.texels(recipe.flat_texels), &model.caster);
        let brdf = known(&appearance.sources, surface, recipe.flat_texels as u32, &counts)?;
        progress.step()?;
        let too_large = |made: &Factored| match recipe.target {
            FactoredTarget::Bytes(most) => recipe.reflectance == Reflectance::Auto && made.facts.gpu_bytes > most,
            _ => false,
        };
        Ok(brdf.filter(|made| !too_large(made)))
    }

    /// True if known materials need no comparison with factors.
    fn is_enough(&self, brdf: &Factored) -> bool {
        let Self { recipe, .. } = self;
        let meets_the_error =
            matches!(recipe.target, FactoredTarget::Error(most) if f64::from(brdf.facts.errors.seen_mean) <= most);
        let too_large_as_factors = recipe.target.check(&recipe.header(0)).is_err();
        recipe.reflectance == Reflectance::Brdf || meets_the_error || too_large_as_factors
    }

    /// Computes all views, and factors them.
    fn factors<E: Send>(
        &self,
        values: &ValueSource<'_, E>,
        scratch: &dyn Scratch<Error = E>,
        progress: &dyn Progress,
    ) -> Result<(Factored, SeenTexels), EncodeError<E>> {
        let Self { recipe, prepared, .. } = self;
        let StoredViews { scratched, masks, reached, seen } = self.views(values, scratch, progress)?;
        let mask = visibility_mask(recipe.flat_texels as u32, &masks)?;
        let lit = if self.unshadowed { None } else { Some(visibility_mask(recipe.flat_texels as u32, &reached)?) };
        drop((masks, reached));
        let view = |view| scratched.read(view, scratch);
        let blur = if matches!(values, ValueSource::Measured(_)) { IMAGE_BLUR } else { 0.0 };
        let target = FactoredRecipe { blur, ..FactoredRecipe::new(recipe.target) };
        let made = factor(&target, &prepared.surface.normals, &mask, lit.as_ref(), view, progress)?;
        Ok((made, seen))
    }

    /// Computes all views, and writes them to scratch storage.
    pub(super) fn views<E: Send>(
        &self,
        values: &ValueSource<'_, E>,
        scratch: &dyn Scratch<Error = E>,
        progress: &dyn Progress,
    ) -> Result<StoredViews, EncodeError<E>> {
        let Self { recipe, prepared: Prepared { model, .. }, .. } = self;
        let texels = model.texels(recipe.flat_texels);
        let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
        let seen_from = |directions: &[Vector], stage| {
            progress.stage(stage, directions.len())?;
            visible_from_each(&texels, &model.caster, directions, progress)
        };
        let masks = seen_from(&views, Stage::Visibility)?;
        let scratched = ScratchViews::new(recipe.header(0));
        let pass = Pass { recipe, texels: &texels, views: &views, lights: &lights, masks: &masks };
        let reached = if self.unshadowed {
            let faces = |light: &Vector| texels.points.iter().map(|p| dot(p.normal, *light) > 0.0).collect();
            lights.iter().map(faces).collect()
        } else {
            seen_from(&lights, Stage::Shadows)?
        };
        match values {
            ValueSource::Computed(appearance) => {
                let mut field = ComputedField::new(&texels, appearance, &views, &lights, &reached);
                if recipe.bounces > 0 {
                    progress.stage(Stage::Bounces, Bounces::steps(texels.points.len()))?;
                    let (mesh, caster) = (&model.mesh, &model.caster);
                    let bounces = Bounces::new(mesh, &texels, caster, appearance, &lights, recipe.bounces, progress);
                    field = field.with_bounces(bounces?);
                }
                pass.run((&field, |never| match never {}), (&scratched, scratch), progress)?;
            }
            ValueSource::Measured(images) => {
                let field = MeasuredField { images: *images, texels: &texels, views: &views };
                pass.run((&field, |error| error), (&scratched, scratch), progress)?;
            }
        }
        let count = masks.iter().flatten().filter(|seen| **seen).count() as f64;
        let share = count / (views.len() * texels.points.len()) as f64;
        let never = (0..texels.points.len()).filter(|texel| !masks.iter().any(|mask| mask[*texel])).count();
        Ok(StoredViews { scratched, masks, reached, seen: SeenTexels { share, never } })
    }
}

pub(super) fn visibility_mask(size: u32, masks: &[Vec<bool>]) -> Result<VisibilityMask, FormatError> {
    let bytes = masks.iter().flatten().map(|seen| if *seen { 255 } else { 0 }).collect();
    VisibilityMask::new(size, masks.len() as u32, bytes)
}
