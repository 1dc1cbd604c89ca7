//! The BTFs themselves: words of all views under all lights, one BTF at a time.

use super::lights::Lights;
use brdfc_flat_btf::light_field::{ComputedField, FillGuide, FlattenedView, Holes, from_above, visible};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::rebuild::ViewImage;
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::Vector;
use brdfc_pwt::LightSamples;
use rayon::prelude::*;

/// A BTF whose views and lights are the same directions.
pub(super) struct Asset {
    /// Texels per side.
    pub(super) size: usize,
    /// RGB9E5 words of each view, light by light, each row by row.
    pub(super) words: Vec<Vec<u32>>,
    /// Visible texels of each view; `None` if all are visible.
    pub(super) masks: Option<Vec<Vec<bool>>>,
    /// Surface normal at each texel; for an ordinary BTF, which has none, that of the plane.
    pub(super) normals: Vec<[f32; 3]>,
}

/// A surface that BTFs are made from.
pub(super) struct Surface<'a> {
    pub(super) model: &'a MesoModel,
    pub(super) appearance: &'a Appearance,
    pub(super) directions: &'a [Vector],
    pub(super) size: usize,
}

fn packed(image: Vec<[f32; 3]>) -> Vec<u32> {
    image.into_iter().map(rgb9e5::encode).collect()
}

impl Surface<'_> {
    /// The ordinary BTF: the surface visible through each texel of the reference plane. Calls `view_done` after each
    /// view.
    pub(super) fn classic(&self, view_done: &dyn Fn()) -> Asset {
        let view = |view: &Vector| {
            let seen = ViewImage::new(self.model, *view, self.size, 1);
            let image = |light: &Vector| packed(seen.direct(self.model, self.appearance, *light));
            let images: Vec<Vec<u32>> = self.directions.par_iter().map(image).collect();
            view_done();
            images.concat()
        };
        let normals = vec![[0.0, 0.0, 1.0]; self.size * self.size];
        Asset { size: self.size, words: self.directions.iter().map(view).collect(), masks: None, normals }
    }

    /// The flat BTF, holes filled as by `brdfc flatten`. Calls `view_done` after each view.
    pub(super) fn flat(&self, view_done: &dyn Fn()) -> Asset {
        let (directions, lights) = (self.directions, self.directions.len());
        let texels = self.model.texels(self.size);
        let masks: Vec<Vec<bool>> = directions.iter().map(|view| visible(&texels, &self.model.caster, *view)).collect();
        let field = ComputedField::new(&texels, self.appearance, directions, directions, &masks);
        let Ok(guide) = FillGuide::new(&field, &masks, &from_above(directions), lights);
        let view = |(view, mask): (usize, &Vec<bool>)| {
            let Ok(flattened) = FlattenedView::new(&field, view, mask, Holes::Poisson(&guide));
            let image = |light: usize| {
                let Ok(image) = flattened.image(light);
                packed(image)
            };
            let images: Vec<Vec<u32>> = (0..lights).into_par_iter().map(image).collect();
            view_done();
            images.concat()
        };
        let words = masks.iter().enumerate().map(view).collect();
        let normals = texels.points.iter().map(|point| point.normal.map(|c| c as f32)).collect();
        Asset { size: self.size, words, masks: Some(masks), normals }
    }
}

impl Asset {
    /// Number of views.
    pub(super) fn views(&self) -> usize {
        self.words.len()
    }

    /// Texels of a view under a light.
    pub(super) fn light(&self, view: usize, light: usize) -> &[u32] {
        let texels = self.size * self.size;
        &self.words[view][light * texels..][..texels]
    }

    /// Mask of the texels that a view sees; `None` if it sees all.
    pub(super) fn mask(&self, view: usize) -> Option<&[bool]> {
        self.masks.as_ref().map(|masks| &masks[view][..])
    }

    /// Share of texels that a view sees, mean over the views.
    pub(super) fn seen(&self) -> f64 {
        let Some(masks) = &self.masks else { return 1.0 };
        masks.iter().flatten().filter(|seen| **seen).count() as f64 / (masks.len() * self.size * self.size) as f64
    }

    /// Renderings of a view under all lights, linear RGB.
    pub(super) fn renderings(&self, view: usize, lights: &Lights) -> Vec<Vec<[f32; 3]>> {
        let decoded = |light| self.light(view, light).iter().map(|word| rgb9e5::decode(*word)).collect();
        (0..lights.directions.len()).into_par_iter().map(decoded).collect()
    }

    /// Samples of such renderings at the fitted lights. Texels that the view does not see are undefined. If the view
    /// sees none, all are defined.
    pub(super) fn samples(&self, view: usize, images: &[Vec<[f32; 3]>], lights: &Lights) -> LightSamples {
        LightSamples {
            size: [self.size; 2],
            lights: lights.fitted_directions(),
            images: lights.fitted.iter().map(|light| images[*light].clone().into()).collect(),
            near: None,
            repeats: true,
            views: None,
            defined: self.mask(view).filter(|mask| mask.contains(&true)).map(<[bool]>::to_vec),
        }
    }
}
