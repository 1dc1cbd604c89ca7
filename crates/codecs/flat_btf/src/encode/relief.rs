//! The form of relief that a recipe requires.

use super::EncodeError;
use super::check::angles;
use super::recipe::{FlattenRecipe, ReliefForm, VdimRecipe};
use crate::compact::texels_of_block;
use crate::layers::{LayerReport, layers};
use crate::light_field::{projected, visible_from_each};
use crate::model::MesoModel;
use crate::vdim::{indirection, shadow_map, steps};
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_formats::flat_btf::{Relief, VdimHeader};

impl VdimRecipe {
    /// Header of a map of `texels` per side, with `lights` sampled lights if there are shadows. The map has all levels of
    /// detail that are whole.
    pub fn header(&self, texels: u32, lights: usize) -> VdimHeader {
        let Self { polar_angles, azimuth_rows, largest_angle, shadows, compact, .. } = *self;
        let block = if compact { texels_of_block(texels) } else { 1 };
        VdimHeader {
            size: texels,
            block,
            polar_angles,
            azimuth_rows,
            largest_angle: largest_angle.to_radians() as f32,
            levels: (texels / block).trailing_zeros() + 1,
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

    /// Starts the stage of the relief, with a step for the texels of the surface in addition.
    pub(super) fn start_relief(&self, progress: &dyn Progress) -> Result<(), Cancelled> {
        match self.vdim_header() {
            None => progress.stage(Stage::Layers, 2),
            Some(header) => progress.stage(Stage::Indirections, steps(&header) + 1),
        }
    }

    /// Makes the relief, with a report of layers.
    pub(super) fn make_relief<E>(
        &self,
        model: &MesoModel,
        progress: &dyn Progress,
    ) -> Result<(Relief, Option<LayerReport>), EncodeError<E>> {
        match &self.relief {
            ReliefForm::Layers => {
                let (layers, report) = layers(&model.mesh, &model.parameterisation.coordinates, self.texels)?;
                progress.step()?;
                Ok((layers.into(), Some(report)))
            }
            ReliefForm::Vdim(vdim) => Ok((self.indirections(vdim, model, progress)?, None)),
        }
    }

    /// Measures an indirection map and shadows.
    fn indirections<E>(
        &self,
        vdim: &VdimRecipe,
        model: &MesoModel,
        progress: &dyn Progress,
    ) -> Result<Relief, EncodeError<E>> {
        let header = vdim.header(self.texels, self.lights.len());
        let map = indirection::<EncodeError<E>>(model, header, vdim.oversampling as usize, vdim.compact, progress)?;
        let shadows = if vdim.shadows {
            let (texels, lights) = (model.texels(self.flat_texels), self.lights.directions());
            progress.stage(Stage::Shadows, lights.len())?;
            let reached = visible_from_each(&texels, &model.caster, &lights, progress)?;
            let counts = projected(&texels, &model.caster);
            // As many levels as the reflectance has.
            let levels = self.flat_texels.ilog2() + 1;
            Some(shadow_map(angles(&self.lights), &reached, &counts, levels)?)
        } else {
            None
        };
        Ok(Relief::sampled(map, shadows)?)
    }
}
