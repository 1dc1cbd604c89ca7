//! The pass over all views, a few of which are in memory at a time.

use super::error::FlattenError;
use super::parts::Parts;
use super::recipe::{FlattenRecipe, Form};
use crate::btf_stack::{StackFormat, write_image};
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::diffuse::DiffuseFit;
use brdfc_flat_btf::fill::{FillMethod, PushPull};
use brdfc_flat_btf::light_field::{FillGuide, FlattenedView, Holes, LightField, from_above};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::probes::Probes;
use brdfc_flat_btf::rebuild::ViewImage;
use brdfc_flat_btf::surface::Appearance;
use brdfc_flat_btf::texels::TexelMap;
use brdfc_formats::container::{Extent, rgb9e5};
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::{DiffuseMap, FlatView, view_part};
use brdfc_readers::btf_stack::ImageAngles;
use rayon::prelude::*;
use std::path::Path;

/// What a pass over all views needs.
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
    /// Makes and writes the views, a few at a time, and fits the diffuse colours on the way.
    pub(super) fn run<F: LightField>(
        &self,
        field: &F,
        probes: &mut [&mut Probes],
        parts: &mut Parts<'_>,
        progress: &dyn Progress,
    ) -> Result<DiffuseMap, FlattenError>
    where
        FlattenError: From<F::Error>,
    {
        let full = self.recipe.form == Form::Full;
        let guide = match self.recipe.fill {
            FillMethod::Poisson if full => {
                progress.stage(Stage::Guide, 1)?;
                Some(FillGuide::new(field, self.masks, &from_above(self.views), self.lights.len())?)
            }
            _ => None,
        };
        progress.stage(Stage::Views, self.views.len())?;
        // On the way to factors they are always compressed.
        let supercompress = self.recipe.supercompress || self.recipe.factor.is_some();
        let mut fit = DiffuseFit::new(self.texels.points.len());
        let at_once = self.recipe.views_at_once();
        let count = self.views.len() as u32;
        let size = self.recipe.flat_texels as u32;
        let extent = Extent::D2Array([size, size, self.lights.len() as u32]);
        for batch in (0..self.views.len()).collect::<Vec<_>>().chunks(at_once) {
            let made: Vec<_> = batch
                .par_iter()
                .map(|view| {
                    let pack = self.view(field, *view, guide.as_ref())?;
                    let bytes = full.then(|| pack.to_bytes(supercompress));
                    Ok::<_, FlattenError>((pack, bytes))
                })
                .collect::<Result<_, _>>()?;
            for (view, (pack, bytes)) in batch.iter().zip(made) {
                let value = |light: usize, texel: usize| rgb9e5::decode(pack.light(light as u32)[texel]);
                let lit = |light: usize, texel: usize| self.lit[light][texel];
                fit.add_view(self.texels, &self.masks[*view], self.lights, lit, value);
                if let Some(bytes) = bytes {
                    probes.iter_mut().for_each(|probes| probes.add_view(&pack));
                    let part = view_part(*view as u32, count);
                    match self.recipe.factor {
                        Some(_) => parts.keep(&part, &bytes)?,
                        None => parts.add(&part, &bytes, extent, 1)?,
                    }
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

    /// One view with all its lights.
    fn view<F: LightField>(&self, field: &F, view: usize, guide: Option<&FillGuide>) -> Result<FlatView, FlattenError>
    where
        FlattenError: From<F::Error>,
    {
        let holes = match (self.recipe.form, guide) {
            (Form::Light, _) => Holes::Black,
            (Form::Full, Some(guide)) => Holes::Poisson(guide),
            (Form::Full, None) => Holes::PushPull,
        };
        let flattened = FlattenedView::new(field, view, &self.masks[view], holes)?;
        let mut texels = vec![0; self.lights.len() * self.texels.points.len()];
        texels.par_chunks_mut(self.texels.points.len()).enumerate().try_for_each(|(light, layer)| {
            let image = flattened.image(light)?;
            layer.iter_mut().zip(image).for_each(|(texel, value)| *texel = rgb9e5::encode(value));
            Ok::<_, F::Error>(())
        })?;
        Ok(FlatView::new(self.recipe.header(view as u32), texels)?)
    }
}

impl Pass<'_> {
    /// Writes the images of the ordinary BTF, as many texels per side as the reference plane has.
    pub(super) fn write_images(
        &self,
        appearance: &Appearance,
        folder: &Path,
        format: StackFormat,
        progress: &dyn Progress,
    ) -> Result<(), FlattenError> {
        progress.stage(Stage::Images, self.views.len())?;
        let size = self.recipe.indirection.size as usize;
        for (view, direction) in self.views.iter().enumerate() {
            let seen = ViewImage::new(self.model, *direction, size, self.recipe.oversampling);
            let write = |light: usize| {
                let image = seen.direct(self.model, appearance, self.lights[light]);
                // Row 0 of a picture is its top.
                let rows: Vec<[f32; 3]> = image.chunks_exact(size).rev().flatten().copied().collect();
                let angles =
                    ImageAngles { light: self.recipe.lights.angles[light], view: self.recipe.views.angles[view] };
                write_image(folder, light * self.views.len() + view, angles, &rows, [size; 2], format)
                    .map_err(|error| FlattenError::write(folder, error))
            };
            (0..self.lights.len()).into_par_iter().try_for_each(|light| write(light).map(drop))?;
            progress.step()?;
        }
        Ok(())
    }
}
