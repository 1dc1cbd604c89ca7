//! Makes the packs of a flat BTF.

use super::asset::{AssetFile, AssetReport};
use super::error::FlattenError;
use super::factors::add_factors;
use super::input::Geometry;
use super::parts::Parts;
use super::pass::Pass;
use super::probing::{computed_probes, measured_probes};
use super::recipe::{FlattenRecipe, Form};
use super::stack::StackImages;
use crate::btf_stack::StackFormat;
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::displacement::{coarser, displacements};
use brdfc_flat_btf::indirection::indirection;
use brdfc_flat_btf::interreflection::Bounces;
use brdfc_flat_btf::light_field::{ComputedField, visible_from_each};
use brdfc_flat_btf::measured::MeasuredField;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::parameterise::steps;
use brdfc_flat_btf::surface::Appearance;
use brdfc_flat_btf::texels::TexelMap;
use brdfc_formats::container::Extent;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatPart, FlatValues, Indirection, IndirectionMap, NormalMap,
    PositionMap, ReferenceMap, SampledDirections, VisibilityMask,
};
use brdfc_source::ordinary_btf::OrdinaryBtf;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Where the values of texels come from.
pub enum Values {
    /// Materials of the surface.
    Computed(Appearance),
    /// Images of an ordinary BTF.
    Measured(OrdinaryBtf),
}

/// What is made, and where.
pub struct FlattenJob<'a> {
    /// The asset's name.
    pub name: &'a str,
    /// The folder of its files.
    pub folder: &'a Path,
    /// How it is made.
    pub recipe: &'a FlattenRecipe,
    /// The surface.
    pub geometry: Geometry,
    /// The materials' sources.
    pub materials: Vec<String>,
    /// Where values come from.
    pub values: Values,
    /// Folder and kind of the images of an ordinary BTF to write besides, computed directly.
    pub images: Option<(&'a Path, StackFormat)>,
    /// Held while finished files change places.
    pub placing: &'a Mutex<()>,
}

/// Makes all parts and puts them in place, `NAME.json` last.
///
/// # Errors
/// A recipe that cannot be followed, a surface that cannot be laid flat, images that cannot be read, files that cannot be
/// written. An asset of that name that stands in the folder stays as it was.
pub fn run(job: FlattenJob<'_>, progress: &dyn Progress) -> Result<AssetFile, FlattenError> {
    let recipe = job.recipe;
    recipe.check()?;
    let mut parts = Parts::new(job.name, job.folder)?;
    let zip = recipe.supercompress;

    progress.stage(Stage::Parameterise, steps(recipe.rounds))?;
    let model = MesoModel::watched(job.geometry.mesh, recipe.rounds, progress)?;
    let texels = model.texels(recipe.flat_texels);
    let size = recipe.flat_texels as u32;
    let flat = Extent::D2([size, size]);
    let single = |v: Vector| v.map(|c| c as f32);
    let position = PositionMap::new(size, texels.points.iter().map(|p| single(p.position)).collect())?;
    parts.add("position", &position.to_bytes(zip), flat, 1)?;
    let normal = NormalMap::new(size, texels.points.iter().map(|p| single(p.normal)).collect())?;
    parts.add("normal", &normal.to_bytes(zip), flat, 1)?;

    let header = recipe.indirection;
    progress.stage(Stage::Indirection, header.size as usize)?;
    let found = indirection(&model, header, recipe.oversampling, progress)?;
    let reference = ReferenceMap::new(header.size, found.reference.clone())?;
    let factored = recipe.factor.filter(|_| recipe.form == Form::Full);
    let (indirection, reference): (Indirection, _) = if recipe.compact {
        let moved = |texel, k, a| found.displacement(texel, k, a);
        let (compact, reference) = displacements(header, &reference, moved, coarser(header.size))?;
        parts.add_sized(FlatPart::Displacement.name(), &compact.to_bytes(zip), compact.gpu_bytes())?;
        (compact.into(), reference)
    } else {
        let mut moved = found.displacements.into_iter();
        let map = IndirectionMap::from_displacements(header, |_, _, _| moved.next().expect("one for each view"))?;
        parts.add(FlatPart::Indirection.name(), &map.to_bytes(zip), Extent::D2(header.extent()), 1)?;
        (map.into(), reference)
    };
    parts.add("reference", &reference.to_bytes(zip), Extent::D2([header.size, header.size]), 1)?;
    // Colours come last; the decoder is asked for indirections before.
    let black = DiffuseMap::new(size, vec![0; texels.points.len()])?;
    let decoder =
        FlatBtfDecoder::new(FlatBtfParts { reference, indirection, normal, diffuse: black, values: FlatValues::None })?;

    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let masks = seen_from(&texels, &model, &views, Stage::Visibility, progress)?;
    let bytes = masks.iter().flatten().map(|seen| if *seen { 255 } else { 0 }).collect();
    let mask = VisibilityMask::new(size, views.len() as u32, bytes)?;
    parts.add("mask", &mask.to_bytes(zip), Extent::D2Array([size, size, views.len() as u32]), 1)?;

    let lit = seen_from(&texels, &model, &lights, Stage::Shadows, progress)?;
    let pass =
        Pass { recipe, model: &model, texels: &texels, views: &views, lights: &lights, masks: &masks, lit: &lit };
    let (diffuse, errors) = match &job.values {
        Values::Computed(appearance) => {
            let mut field = ComputedField::new(&texels, appearance, &views, &lights, &lit);
            if recipe.bounces > 0 {
                progress.stage(Stage::Bounces, Bounces::steps(texels.points.len()))?;
                let (mesh, caster) = (&model.mesh, &model.caster);
                let bounces = Bounces::new(mesh, &texels, caster, appearance, &lights, recipe.bounces, progress);
                field = field.with_bounces(bounces?);
            }
            let mut probes = computed_probes(&pass, &decoder, appearance)?;
            let diffuse = pass.run(&field, &mut probes.each(), &mut parts, progress)?;
            if let Some((folder, format)) = job.images {
                pass.write_images(appearance, folder, format, progress)?;
            }
            (diffuse, probes)
        }
        Values::Measured(stack) => {
            let images = StackImages(stack);
            let field = MeasuredField { images: &images, texels: &texels, views: &views };
            let mut probes = measured_probes(&pass, &decoder, &images)?;
            let diffuse = pass.run(&field, &mut probes.each(), &mut parts, progress)?;
            (diffuse, probes)
        }
    };
    parts.add("diffuse", &diffuse.to_bytes(zip), flat, 1)?;
    if recipe.form == Form::Full {
        let header = recipe.header(0);
        let directions = SampledDirections::new(&header.views, &header.lights)?;
        let extent = Extent::D2(directions.extent());
        parts.add(FlatPart::Directions.name(), &directions.to_bytes(zip), extent, 1)?;
    }
    let factored = match factored {
        Some(target) => Some(add_factors(target, (&decoder.parts().normal, &mask), &mut parts, zip, progress)?),
        None => None,
    };
    let decoder = FlatBtfDecoder::new(FlatBtfParts { diffuse, ..decoder.into_parts() })?;

    let seen = masks.iter().flatten().filter(|seen| **seen).count() as f64;
    let never_seen = (0..texels.points.len()).filter(|texel| !masks.iter().any(|mask| mask[*texel])).count();
    let report = AssetReport {
        repairs: job.geometry.weld,
        parameterisation: model.parameterisation.report,
        heights: model.mesh.height_range(),
        seen: seen / (views.len() * texels.points.len()) as f64,
        never_seen,
        errors: errors.measure(&decoder, recipe.form, factored.as_ref().map(|made| &made.asset)),
        factored: factored.map(|made| made.facts),
    };
    let asset = AssetFile {
        version: 1,
        name: job.name.to_owned(),
        source: job.geometry.name,
        materials: job.materials,
        images_over_the_tile: match &job.values {
            Values::Computed(appearance) => appearance.colour.is_some() || appearance.weights.is_some(),
            Values::Measured(_) => false,
        },
        settings: recipe.settings(),
        parts: parts.files().clone(),
        report,
    };
    let _placing = job.placing.lock().unwrap_or_else(PoisonError::into_inner);
    progress.check()?;
    parts.commit(&(serde_json::to_string_pretty(&asset).expect("plain data") + "\n"))?;
    Ok(asset)
}

/// Which texels each direction sees.
fn seen_from(
    texels: &TexelMap,
    model: &MesoModel,
    directions: &[Vector],
    stage: Stage,
    progress: &dyn Progress,
) -> Result<Vec<Vec<bool>>, FlattenError> {
    progress.stage(stage, directions.len())?;
    Ok(visible_from_each(texels, &model.caster, directions, progress)?)
}
