//! Encodes a surface with its appearance, or an ordinary BTF, as a flat BTF. Each step has its own file; this one
//! sequences them.

mod check;
mod error;
mod pass;
mod probing;
mod recipe;
mod report;
mod scratch;
#[cfg(test)]
mod tests;

pub use check::MAX_BYTES;
pub use error::EncodeError;
pub use recipe::{FlattenRecipe, Form};
pub use report::{AssetErrors, AssetReport};
pub use scratch::{MemoryScratch, Scratch};

use crate::displacement::{coarser, displacements};
use crate::factored::{FactoredRecipe, factor};
use crate::indirection::indirection;
use crate::interreflection::Bounces;
use crate::light_field::{ComputedField, visible_from_each};
use crate::measured::{MeasuredField, ViewImages};
use crate::mesh::PeriodicMesh;
use crate::model::MesoModel;
use crate::parameterise::steps;
use crate::surface::Appearance;
use crate::weld::WeldReport;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{
    DiffuseMap, DisplacementMap, FlatBtfDecoder, FlatBtfParts, FlatValues, NormalMap, ReferenceMap, VisibilityMask,
};
use pass::Pass;
use probing::{computed_probes, measured_probes};
use scratch::ScratchViews;

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
    /// Parts that a decoder reads. The light form has no values.
    pub parts: FlatBtfParts,
    /// Texels that each view sees.
    pub mask: VisibilityMask,
    /// Measurements of the encoder: sizes, errors and repairs.
    pub report: AssetReport,
    /// The surface with its parameterisation and ray caster.
    pub model: MesoModel,
}

/// Encodes a surface as a flat BTF. `E` is the error type of the images and of the scratch storage. The scratch storage
/// takes 4 bytes for each texel, view and light; the light form needs none.
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
    progress.stage(Stage::Parameterise, steps(recipe.rounds))?;
    let model = MesoModel::new(input.mesh, recipe.rounds, progress)?;
    let texels = model.texels(recipe.flat_texels);
    let size = recipe.flat_texels as u32;
    let single = |v: Vector| v.map(|c| c as f32);
    let normal = NormalMap::new(size, texels.points.iter().map(|p| single(p.normal)).collect())?;
    let (displacements, reference) = indirection_maps(&model, recipe, progress)?;
    // The decoder is used for indirections before colours exist.
    let black = DiffuseMap::new(size, vec![0; texels.points.len()])?;
    let parts =
        FlatBtfParts { reference, indirection: displacements.into(), normal, diffuse: black, values: FlatValues::None };
    let decoder = FlatBtfDecoder::new(parts)?;

    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let seen_from = |directions: &[Vector], stage| {
        progress.stage(stage, directions.len())?;
        visible_from_each(&texels, &model.caster, directions, progress)
    };
    let masks = seen_from(&views, Stage::Visibility)?;
    let lit = seen_from(&lights, Stage::Shadows)?;
    let scratched = ScratchViews::new(recipe.header(0));
    let storage = (&scratched, scratch);
    let pass =
        Pass { recipe, model: &model, texels: &texels, views: &views, lights: &lights, masks: &masks, lit: &lit };
    let (diffuse, probes) = match input.values {
        ValueSource::Computed(appearance) => {
            let mut field = ComputedField::new(&texels, appearance, &views, &lights, &lit);
            if recipe.bounces > 0 {
                progress.stage(Stage::Bounces, Bounces::steps(texels.points.len()))?;
                let (mesh, caster) = (&model.mesh, &model.caster);
                let bounces = Bounces::new(mesh, &texels, caster, appearance, &lights, recipe.bounces, progress);
                field = field.with_bounces(bounces?);
            }
            let mut probes = computed_probes(&pass, &decoder, appearance)?;
            let diffuse = pass.run((&field, |never| match never {}), &mut probes.each(), storage, progress)?;
            (diffuse, probes)
        }
        ValueSource::Measured(images) => {
            let field = MeasuredField { images, texels: &texels, views: &views };
            let mut probes = measured_probes(&pass, &decoder, images).map_err(EncodeError::Outside)?;
            let diffuse = pass.run((&field, |error| error), &mut probes.each(), storage, progress)?;
            (diffuse, probes)
        }
    };
    drop(lit);
    let mask = visibility_mask(size, &masks)?;
    let seen = masks.iter().flatten().filter(|seen| **seen).count() as f64;
    let seen = seen / (views.len() * texels.points.len()) as f64;
    let never_seen = (0..texels.points.len()).filter(|texel| !masks.iter().any(|mask| mask[*texel])).count();
    drop((masks, texels));

    let mut parts = decoder.into_parts();
    parts.diffuse = diffuse;
    let mut facts = None;
    if let Some(target) = recipe.factored {
        let view = |view| scratched.read(view, scratch);
        let made = factor(&FactoredRecipe::new(target), &parts.normal, &mask, view, progress)?;
        parts.values = FlatValues::Factored(Box::new(made.asset));
        facts = Some(made.facts);
    }
    let decoder = FlatBtfDecoder::new(parts)?;
    let report = AssetReport {
        repairs: input.repairs,
        parameterisation: model.parameterisation.report,
        heights: model.mesh.height_range(),
        seen,
        never_seen,
        errors: probes.measure(&decoder),
        factored: facts,
    };
    Ok(FlatBtfEncoded { parts: decoder.into_parts(), mask, report, model })
}

/// Measures the surface points that each view sees through the reference plane, as displacements from the view along
/// the normal.
fn indirection_maps<E>(
    model: &MesoModel,
    recipe: &FlattenRecipe,
    progress: &dyn Progress,
) -> Result<(DisplacementMap, ReferenceMap), EncodeError<E>> {
    let header = recipe.indirection;
    progress.stage(Stage::Indirection, header.size as usize)?;
    let found = indirection(model, header, recipe.oversampling, progress)?;
    let reference = ReferenceMap::new(header.size, found.reference.clone())?;
    let moved = |texel, k, a| found.displacement(texel, k, a);
    Ok(displacements(header, &reference, moved, coarser(header.size))?)
}

fn visibility_mask(size: u32, masks: &[Vec<bool>]) -> Result<VisibilityMask, FormatError> {
    let bytes = masks.iter().flatten().map(|seen| if *seen { 255 } else { 0 }).collect();
    VisibilityMask::new(size, masks.len() as u32, bytes)
}
