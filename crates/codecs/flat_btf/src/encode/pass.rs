//! The pass over all views, a few of which are in memory at a time.

use super::error::EncodeError;
use super::recipe::FlattenRecipe;
use super::scratch::{Scratch, ScratchViews};
use crate::fill::FillMethod;
use crate::light_field::{FillGuide, FlattenedView, Holes, LightField, from_above};
use crate::texels::TexelMap;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::Vector;
use rayon::prelude::*;

/// Context of a pass over all views.
pub(super) struct Pass<'a> {
    pub(super) recipe: &'a FlattenRecipe,
    pub(super) texels: &'a TexelMap,
    pub(super) views: &'a [Vector],
    pub(super) lights: &'a [Vector],
    pub(super) masks: &'a [Vec<bool>],
}

impl Pass<'_> {
    /// Computes the views a few at a time, and writes them to scratch storage. `outside` converts the field's error
    /// into the caller's.
    pub(super) fn run<F: LightField, E: Send>(
        &self,
        (field, outside): (&F, fn(F::Error) -> E),
        (scratched, scratch): (&ScratchViews, &dyn Scratch<Error = E>),
        progress: &dyn Progress,
    ) -> Result<(), EncodeError<E>> {
        let of_field = |error| EncodeError::Outside(outside(error));
        let guide = match self.recipe.fill {
            FillMethod::Poisson => {
                progress.stage(Stage::Guide, 1)?;
                let guide = FillGuide::new(field, self.masks, &from_above(self.views), self.lights.len());
                Some(guide.map_err(of_field)?)
            }
            FillMethod::PushPull => None,
        };
        progress.stage(Stage::Views, self.views.len())?;
        for batch in (0..self.views.len()).collect::<Vec<_>>().chunks(self.recipe.views_at_once()) {
            let make = |view: &usize| {
                let texels = self.texels_of(field, *view, guide.as_ref()).map_err(of_field)?;
                let made = scratched.view(*view as u32, texels)?;
                scratched.write(&made, scratch).map_err(EncodeError::Outside)
            };
            batch.par_iter().map(make).collect::<Result<Vec<()>, _>>()?;
            batch.iter().try_for_each(|_| progress.step())?;
        }
        Ok(())
    }

    /// Packed texels of one view, light by light.
    fn texels_of<F: LightField>(
        &self,
        field: &F,
        view: usize,
        guide: Option<&FillGuide>,
    ) -> Result<Vec<u32>, F::Error> {
        let holes = guide.map_or(Holes::PushPull, Holes::Poisson);
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
