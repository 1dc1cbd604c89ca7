//! Encodes a surface with its appearance, or an ordinary BTF, as a flat BTF. Each step has its own file; this one
//! sequences them.

mod check;
mod error;
mod pass;
mod probing;
mod recipe;
mod relief;
mod report;
mod scratch;
#[cfg(test)]
mod tests;

pub use check::MAX_BYTES;
pub use error::EncodeError;
pub use recipe::{FlattenRecipe, Reflectance, ReliefForm, VdimRecipe};
pub use report::{AssetErrors, AssetReport};
pub use scratch::{MemoryScratch, Scratch};

use crate::factored::{Factored, FactoredRecipe, FactoredTarget, factor, known};
use crate::far::{FarLevel, far_materials};
use crate::interreflection::Bounces;
use crate::light_field::{ComputedField, projected, visible_from_each};
use crate::measured::{MeasuredField, ViewImages};
use crate::mesh::{MAX_MATERIALS, PeriodicMesh};
use crate::model::MesoModel;
use crate::parameterise::steps;
use crate::surface::{Appearance, SurfacePoint};
use crate::texels::{TexelSurface, texel_surface};
use crate::weld::WeldReport;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, dot};
use brdfc_formats::flat_btf::factored::MAX_MATERIALS as MAX_BRDF_MATERIALS;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, SampledDirections, VisibilityMask};
use pass::Pass;
use probing::{from_images, from_surface};
use scratch::ScratchViews;

/// Blur of texels that are looked up in images of about as many pixels: [`FactoredRecipe::blur`].
const IMAGE_BLUR: f32 = 0.1;

/// Input of the encoder. `E` is the error type of the images.
pub struct FlatInput<'a, E> {
    /// One tile of the surface, welded and periodic.
    pub mesh: PeriodicMesh,
    /// Repairs of the mesh, copied to the report.
    pub repairs: Option<WeldReport>,
    /// Source of the texel values.
    pub values: ValueSource<'a, E>,
}

/// Source of the texel values.
pub enum ValueSource<'a, E> {
    /// Materials of the surface.
    Computed(&'a Appearance),
    /// Images of an ordinary BTF.
    Measured(&'a dyn ViewImages<Error = E>),
}

/// A flat BTF with its report and intermediate results.
pub struct FlatBtfEncoded {
    /// The flat BTF, decoded.
    pub decoder: FlatBtfDecoder,
    /// Measurements of the encoder: sizes, errors and repairs.
    pub report: AssetReport,
    /// The surface with its parameterisation and ray caster.
    pub model: MesoModel,
}

/// Encodes a surface as a flat BTF. `E` is the error type of the images and of the scratch storage, which takes 4 bytes
/// for each texel, view and light of a factored reflectance.
///
/// Shadows are left to the relief. Where values contain them, in images and with light of one bounce, the factors come with
/// a residual.
///
/// The flat BTF does not depend on the number of threads, which only determines how many views are in memory at once:
/// [`FlattenRecipe::bytes`].
///
/// # Errors
/// Returns an error if the recipe is invalid, if the surface cannot be parameterised, if images or scratch storage
/// fail, or if the work is cancelled.
pub fn encode<E: Send>(
    input: FlatInput<'_, E>,
    recipe: &FlattenRecipe,
    scratch: &dyn Scratch<Error = E>,
    progress: &dyn Progress,
) -> Result<FlatBtfEncoded, EncodeError<E>> {
    recipe.check()?;
    let known_materials = matches!(input.values, ValueSource::Computed(_)) && recipe.bounces == 0;
    check_materials(recipe, &input.values, known_materials)?;
    progress.stage(Stage::Parameterise, steps(FlattenRecipe::ROUNDS))?;
    let model = MesoModel::new(input.mesh, FlattenRecipe::ROUNDS, progress)?;
    recipe.start_relief(progress)?;
    let coordinates = &model.parameterisation.coordinates;
    let shares = |point: &SurfacePoint| match &input.values {
        ValueSource::Computed(appearance) => appearance.shares(point),
        ValueSource::Measured(_) => [[0.0; 3]; MAX_MATERIALS],
    };
    let surface = texel_surface(&model.mesh, coordinates, recipe.flat_texels, shares);
    progress.step()?;
    let (relief, of_layers) = recipe.make_relief(&model, progress)?;

    let work = Work { recipe, model: &model, surface: &surface, known_materials };
    let (made, seen) = work.reflectance(&input.values, scratch, progress)?;
    let reflectance = if seen.is_some() { Reflectance::Factors } else { Reflectance::Brdf };
    let mut decoder = FlatBtfDecoder::new(FlatBtfParts { relief, reflectance: made.asset });
    let directions = SampledDirections::of(decoder.parts())?;
    let mut far: Vec<FarLevel> = Vec::new();
    if let (ValueSource::Computed(appearance), Reflectance::Brdf) = (&input.values, reflectance) {
        progress.stage(Stage::Fit, decoder.parts().reflectance.header().levels as usize - 1)?;
        let (reflectance, levels) = far_materials((&decoder, directions.as_ref()), &model, appearance, progress)?;
        decoder = FlatBtfDecoder::new(FlatBtfParts { reflectance, ..decoder.into_parts() });
        far = levels;
    }
    let decoded = (&decoder, directions.as_ref());
    let mut errors = AssetErrors::default();
    match &input.values {
        ValueSource::Computed(appearance) => errors.from_surface = from_surface(recipe, &model, decoded, appearance),
        ValueSource::Measured(images) => {
            errors.from_images = Some(from_images(recipe, decoded, *images).map_err(EncodeError::Outside)?);
        }
    }
    let report = AssetReport {
        repairs: input.repairs,
        parameterisation: model.parameterisation.report,
        heights: model.mesh.height_range(),
        layers: of_layers,
        reflectance,
        seen: seen.map(|seen| seen.share),
        never_seen: seen.map(|seen| seen.never),
        errors,
        far,
        factored: made.facts,
    };
    Ok(FlatBtfEncoded { decoder, report, model })
}

/// Checks that the reflectance that a recipe requires can have these values.
fn check_materials<E>(
    recipe: &FlattenRecipe,
    values: &ValueSource<'_, E>,
    known_materials: bool,
) -> Result<(), FormatError> {
    if recipe.reflectance != Reflectance::Brdf {
        return Ok(());
    }
    match values {
        ValueSource::Computed(appearance) if known_materials => {
            if appearance.sources.len() > MAX_BRDF_MATERIALS as usize {
                let found = format!("{} materials", appearance.sources.len());
                let allowed = format!("at most {MAX_BRDF_MATERIALS} for the reflectance brdf");
                return Err(FormatError::whole("materials", found, allowed));
            }
            Ok(())
        }
        _ => {
            let allowed = "materials without bounces; images and bounces require factors";
            Err(FormatError::whole("reflectance", "brdf", allowed))
        }
    }
}

/// Texels that views see.
#[derive(Debug, Clone, Copy)]
struct SeenTexels {
    /// Mean share of texels that a view sees.
    share: f64,
    /// Texels that no view sees.
    never: usize,
}

/// Work on a reflectance.
struct Work<'a> {
    recipe: &'a FlattenRecipe,
    model: &'a MesoModel,
    surface: &'a TexelSurface,
    /// True if materials are known and light is direct: values then have no shadows.
    known_materials: bool,
}

impl Work<'_> {
    /// Selects the form of the reflectance: factors only if materials are not enough. Factors come with the texels that
    /// their views see.
    fn reflectance<E: Send>(
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
        let Self { recipe, model, .. } = self;
        let ValueSource::Computed(appearance) = values else { return Ok(None) };
        if !self.known_materials || recipe.reflectance == Reflectance::Factors {
            return Ok(None);
        }
        progress.stage(Stage::Fit, 1)?;
        let counts = projected(&model.texels(recipe.flat_texels), &model.caster);
        let brdf = known(&appearance.sources, self.surface, recipe.flat_texels as u32, &counts)?;
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
        let Self { recipe, model, .. } = self;
        let texels = model.texels(recipe.flat_texels);
        let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
        let seen_from = |directions: &[Vector], stage| {
            progress.stage(stage, directions.len())?;
            visible_from_each(&texels, &model.caster, directions, progress)
        };
        let masks = seen_from(&views, Stage::Visibility)?;
        let scratched = ScratchViews::new(recipe.header(0));
        let pass = Pass { recipe, texels: &texels, views: &views, lights: &lights, masks: &masks };
        let reached = if self.known_materials {
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
        let mask = visibility_mask(recipe.flat_texels as u32, &masks)?;
        let lit = if self.known_materials { None } else { Some(visibility_mask(recipe.flat_texels as u32, &reached)?) };
        let count = masks.iter().flatten().filter(|seen| **seen).count() as f64;
        let share = count / (views.len() * texels.points.len()) as f64;
        let never = (0..texels.points.len()).filter(|texel| !masks.iter().any(|mask| mask[*texel])).count();
        drop((masks, reached, texels));
        let view = |view| scratched.read(view, scratch);
        let blur = if matches!(values, ValueSource::Measured(_)) { IMAGE_BLUR } else { 0.0 };
        let target = FactoredRecipe { blur, ..FactoredRecipe::new(recipe.target) };
        let made = factor(&target, &self.surface.normals, &mask, lit.as_ref(), view, progress)?;
        Ok((made, SeenTexels { share, never }))
    }
}

fn visibility_mask(size: u32, masks: &[Vec<bool>]) -> Result<VisibilityMask, FormatError> {
    let bytes = masks.iter().flatten().map(|seen| if *seen { 255 } else { 0 }).collect();
    VisibilityMask::new(size, masks.len() as u32, bytes)
}
