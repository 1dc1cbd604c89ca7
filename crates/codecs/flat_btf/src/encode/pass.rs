//! The pass over all views, a few of which are in memory at a time.

use super::error::EncodeError;
use super::recipe::FlattenRecipe;
use super::scratch::{Scratch, ScratchViews};
use crate::diffuse::DiffuseFit;
use crate::fill::{FillMethod, PushPull};
use crate::light_field::{FillGuide, FlattenedView, Holes, LightField, from_above};
use crate::model::MesoModel;
use crate::probes::Probes;
use crate::texels::TexelMap;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::DiffuseMap;
use rayon::prelude::*;

/// Context of a pass over all views.
pub(super) struct Pass<'a> {
    pub(super) recipe: &'a FlattenRecipe,
    pub(super) model: &'a MesoModel,
    pub(super) texels: &'a TexelMap,
    pub(super) views: &'a [Vector],
    pub(super) lights: &'a [Vector],
    pub(super) masks: &'a [Vec<bool>],
    pub(super) lit: &'a [Vec<bool>],
}

impl Pass<'_> {
    /// Computes the views a few at a time, writes the views of the full form to scratch storage, and accumulates the
    /// fit of the diffuse colours. `outside` converts the field's error into the caller's.
    pub(super) fn run<F: LightField, E: Send>(
        &self,
        (field, outside): (&F, fn(F::Error) -> E),
        probes: &mut [&mut Probes],
        (scratched, scratch): (&ScratchViews, &dyn Scratch<Error = E>),
        progress: &dyn Progress,
    ) -> Result<DiffuseMap, EncodeError<E>> {
        let full = self.recipe.factored.is_some();
        let of_field = |error| EncodeError::Outside(outside(error));
        let guide = match self.recipe.fill {
            FillMethod::Poisson if full => {
                progress.stage(Stage::Guide, 1)?;
                let guide = FillGuide::new(field, self.masks, &from_above(self.views), self.lights.len());
                Some(guide.map_err(of_field)?)
            }
            _ => None,
        };
        progress.stage(Stage::Views, self.views.len())?;
        let mut fit = DiffuseFit::new(self.texels.points.len());
        for batch in (0..self.views.len()).collect::<Vec<_>>().chunks(self.recipe.views_at_once()) {
            let make = |view: &usize| {
                let texels = self.texels_of(field, *view, guide.as_ref()).map_err(of_field)?;
                let made = scratched.view(*view as u32, texels)?;
                if full {
                    scratched.write(&made, scratch).map_err(EncodeError::Outside)?;
                }
                Ok::<_, EncodeError<E>>(made)
            };
            let made: Vec<_> = batch.par_iter().map(make).collect::<Result<_, _>>()?;
            for (view, made) in batch.iter().zip(made) {
                let value = |light: usize, texel: usize| rgb9e5::decode(made.light(light as u32)[texel]);
                let lit = |light: usize, texel: usize| self.lit[light][texel];
                fit.add_view(self.texels, &self.masks[*view], self.lights, lit, value);
                if full {
                    probes.iter_mut().for_each(|probes| probes.add_view(&made));
                }
                progress.step()?;
            }
        }
        let found = fit.reflectances();
        let known: Vec<bool> = found.iter().map(Option::is_some).collect();
        let mut colours: Vec<[f32; 3]> = found.into_iter().map(Option::unwrap_or_default).collect();
        PushPull::new(&known).fill(&mut colours);
        Ok(DiffuseMap::from_colours(self.recipe.flat_texels as u32, &colours)?)
    }

    /// Packed texels of one view, light by light.
    fn texels_of<F: LightField>(
        &self,
        field: &F,
        view: usize,
        guide: Option<&FillGuide>,
    ) -> Result<Vec<u32>, F::Error> {
        let holes = match (self.recipe.factored, guide) {
            (None, _) => Holes::Black,
            (Some(_), Some(guide)) => Holes::Poisson(guide),
            (Some(_), None) => Holes::PushPull,
        };
        let flattened = FlattenedView::new(field, view, &self.masks[view], holes)?;
        let mut texels = vec![0; self.lights.len() * self.texels.points.len()];
        texels.par_chunks_mut(self.texels.points.len()).enumerate().try_for_each(|(light, layer)| {
            let image = flattened.image(light)?;
            layer.iter_mut().zip(image).for_each(|(texel, value)| *texel = rgb9e5::encode(value));
            Ok(())
        })?;
        Ok(texels)
    }
}
