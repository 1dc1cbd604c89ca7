//! Steps before and after the reflectance: parameterises the surface and makes its relief; measures and reports the asset.

use super::error::EncodeError;
use super::probing::{from_images, from_surface};
use super::recipe::{FlattenRecipe, Reflectance};
use super::report::{AssetErrors, AssetReport};
use crate::factored::FactoredFacts;
use crate::far::FarLevel;
use crate::layers::LayerReport;
use crate::measured::ViewImages;
use crate::mesh::{MAX_MATERIALS, PeriodicMesh};
use crate::model::MesoModel;
use crate::parameterise::steps;
use crate::surface::{Appearance, SurfacePoint};
use crate::texels::{TexelSurface, texel_surface};
use crate::weld::WeldReport;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::flat_btf::{FlatBtfDecoder, Relief, SampledDirections};

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

/// A surface before its reflectance is made.
pub(super) struct Prepared {
    pub(super) model: MesoModel,
    pub(super) surface: TexelSurface,
    layers: Option<LayerReport>,
    repairs: Option<WeldReport>,
}

/// Texels that views see.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenTexels {
    /// Mean share of texels that a view sees.
    pub(super) share: f64,
    /// Texels that no view sees.
    pub(super) never: usize,
}

/// Facts about a reflectance for the report.
pub(super) struct ReflectanceFacts {
    pub(super) form: Reflectance,
    pub(super) seen: Option<SeenTexels>,
    pub(super) far: Vec<FarLevel>,
    pub(super) factored: Option<FactoredFacts>,
}

impl Prepared {
    /// Parameterises a surface, and makes its texels and its relief.
    pub(super) fn new<E>(
        (mesh, repairs): (PeriodicMesh, Option<WeldReport>),
        values: &ValueSource<'_, E>,
        recipe: &FlattenRecipe,
        progress: &dyn Progress,
    ) -> Result<(Self, Relief), EncodeError<E>> {
        progress.stage(Stage::Parameterise, steps(FlattenRecipe::ROUNDS))?;
        let model = MesoModel::new(mesh, FlattenRecipe::ROUNDS, progress)?;
        recipe.start_relief(progress)?;
        let shares = |point: &SurfacePoint| match values {
            ValueSource::Computed(appearance) => appearance.shares(point),
            ValueSource::Measured(_) => [[0.0; 3]; MAX_MATERIALS],
        };
        let surface = texel_surface(&model.mesh, &model.parameterisation.coordinates, recipe.flat_texels, shares);
        progress.step()?;
        let (relief, layers) = recipe.make_relief(&model, progress)?;
        Ok((Self { model, surface, layers, repairs }, relief))
    }

    /// Measures the errors of the asset, and reports it.
    pub(super) fn finished<E: Send>(
        self,
        values: &ValueSource<'_, E>,
        recipe: &FlattenRecipe,
        decoder: FlatBtfDecoder,
        directions: Option<&SampledDirections>,
        facts: ReflectanceFacts,
    ) -> Result<FlatBtfEncoded, EncodeError<E>> {
        let Self { model, layers, repairs, .. } = self;
        let decoded = (&decoder, directions);
        let mut errors = AssetErrors::default();
        match values {
            ValueSource::Computed(appearance) => {
                errors.from_surface = from_surface(recipe, &model, decoded, appearance)
            }
            ValueSource::Measured(images) => {
                errors.from_images = Some(from_images(recipe, decoded, *images).map_err(EncodeError::Outside)?);
            }
        }
        let report = AssetReport {
            repairs,
            parameterisation: model.parameterisation.report,
            heights: model.mesh.height_range(),
            layers,
            reflectance: facts.form,
            seen: facts.seen.map(|seen| seen.share),
            never_seen: facts.seen.map(|seen| seen.never),
            errors,
            far: facts.far,
            factored: facts.factored,
        };
        Ok(FlatBtfEncoded { decoder, report, model })
    }
}
