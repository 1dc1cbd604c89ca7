//! The form of relief that a recipe requires.

use super::check::angles;
use super::recipe::{FlattenRecipe, ReliefForm, VdimRecipe};
use super::{EncodeError, Work};
use crate::layers::{LayerReport, layers};
use crate::light_field::{projected, visible_from_each};
use crate::model::MesoModel;
use crate::vdim::{indirection, shadow_map, steps};
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::flat_btf::{LayerMap, Relief, VdimHeader};

impl VdimRecipe {
    /// Header of a map of `texels` per side, with `lights` sampled lights if there are shadows. The map has all levels of
    /// detail that are whole.
    pub fn header(&self, texels: u32, lights: usize) -> VdimHeader {
        let Self { polar_angles, azimuth_rows, largest_angle, shadows, .. } = *self;
        VdimHeader {
            size: texels,
            polar_angles,
            azimuth_rows,
            largest_angle: largest_angle.to_radians() as f32,
            levels: texels.trailing_zeros() + 1,
            lights: if shadows { lights as u32 } else { 0 },
        }
    }
}

impl FlattenRecipe {
    /// Header of the indirection map; `None` with layers.
    pub fn vdim_header(&self) -> Option<VdimHeader> {
        match &self.relief {
            ReliefForm::Layers => None,
            ReliefForm::Vdim(vdim) => Some(vdim.header(self.texels, self.lights.len())),
        }
    }

    /// Makes the layers, if the recipe requires them. `progress` receives a step.
    pub(super) fn layers<E>(
        &self,
        model: &MesoModel,
        progress: &dyn Progress,
    ) -> Result<Option<(LayerMap, LayerReport)>, EncodeError<E>> {
        let made = match self.relief {
            ReliefForm::Layers => Some(layers(&model.mesh, &model.parameterisation.coordinates, self.texels)?),
            ReliefForm::Vdim(_) => None,
        };
        progress.step()?;
        Ok(made)
    }
}

impl Work<'_> {
    /// Measures an indirection map, and shadows with `levels` mipmap levels.
    pub(super) fn indirections<E>(
        &self,
        vdim: &VdimRecipe,
        levels: u32,
        progress: &dyn Progress,
    ) -> Result<Relief, EncodeError<E>> {
        let Self { recipe, model, .. } = self;
        let header = vdim.header(recipe.texels, recipe.lights.len());
        progress.stage(Stage::Indirections, steps(&header))?;
        let map = indirection::<EncodeError<E>>(model, header, vdim.oversampling as usize, progress)?;
        let shadows = if vdim.shadows {
            let (texels, lights) = (model.texels(recipe.flat_texels), recipe.lights.directions());
            progress.stage(Stage::Shadows, lights.len())?;
            let reached = visible_from_each(&texels, &model.caster, &lights, progress)?;
            let counts = projected(&texels, &model.caster);
            Some(shadow_map(angles(&recipe.lights), &reached, &counts, levels)?)
        } else {
            None
        };
        Ok(Relief::sampled(map, shadows)?)
    }
}
