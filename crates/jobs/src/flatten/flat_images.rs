//! Writes a raw flat BTF for other compressors: its images, the texels that views see, and the parameters behind the texels
//! of the reference plane (section 3 of Hadim et al. 2009).

use super::images::StackImages;
use super::input::Values;
use crate::btf_stack::{StackFormat, write_channels, write_image};
use crate::error::Error;
use crate::outputs::Failed;
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::encode::{FlattenRecipe, ReliefForm};
use brdfc_flat_btf::fill::FillMethod;
use brdfc_flat_btf::light_field::{
    ComputedField, FillGuide, FlattenedView, Holes, LightField, from_above, visible_from_each,
};
use brdfc_flat_btf::measured::MeasuredField;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::vdim::{OVERSAMPLING, seen_through_texels};
use brdfc_formats::direction::Vector;
use brdfc_readers::btf_stack::{ImageAngles, image_name};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Writes `flat/`, images of all views and lights with filled holes; `masks/`, 1 where a view sees a texel and 0 elsewhere;
/// `reference.exr`, the parameters R that the view along the normal sees; and `displacements/`, `Δ_v` of each view. All are
/// EXR files: images of 16-bit floats, all others of 32-bit floats. Row 0 is the top, `y = 1`.
pub(super) fn write_flat(
    model: &MesoModel,
    values: &Values,
    recipe: &FlattenRecipe,
    (folder, failed): (&Path, Failed<'_>),
    progress: &dyn Progress,
) -> Result<(), Error> {
    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let texels = model.texels(recipe.flat_texels);
    let seen_from = |directions: &[Vector], stage| {
        progress.stage(stage, directions.len())?;
        visible_from_each(&texels, &model.caster, directions, progress)
    };
    let masks = seen_from(&views, Stage::Visibility)?;
    let files = FlatFiles { folder, failed, recipe, masks: &masks };
    match values {
        Values::Computed(appearance) => {
            let reached = seen_from(&lights, Stage::Shadows)?;
            let field = ComputedField::new(&texels, appearance, &views, &lights, &reached);
            files.write_images(&field, |never| match never {}, progress)?;
        }
        Values::Measured(stack) => {
            let images = StackImages::new(stack);
            let field = MeasuredField { images: &images, texels: &texels, views: &views };
            files.write_images(&field, |error| error, progress)?;
        }
    }
    for (view, mask) in masks.iter().enumerate() {
        let values: Vec<[f32; 1]> = mask.iter().map(|seen| [f32::from(u8::from(*seen))]).collect();
        files.write(&files.of_view("masks", view), ["Y"], &values)?;
    }
    files.write_parameters(model, &views, progress)
}

/// Files of a raw flat BTF.
struct FlatFiles<'a> {
    folder: &'a Path,
    failed: Failed<'a>,
    recipe: &'a FlattenRecipe,
    /// For each view, the texels that it sees.
    masks: &'a [Vec<bool>],
}

impl FlatFiles<'_> {
    fn angles(&self, view: usize, light: usize) -> ImageAngles {
        ImageAngles { light: self.recipe.lights.angles[light], view: self.recipe.views.angles[view] }
    }

    /// File of a view, named by its angles as folders of images are.
    fn of_view(&self, kind: &str, view: usize) -> PathBuf {
        let name = image_name(0, self.angles(view, 0), "exr");
        let (name, _) = name.split_once('/').expect("a folder for each view");
        self.folder.join(kind).join(format!("{name}.exr"))
    }

    /// Writes the images of all views and lights.
    fn write_images<F: LightField>(
        &self,
        field: &F,
        outside: fn(F::Error) -> Error,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let (recipe, folder) = (self.recipe, self.folder.join("flat"));
        let [views, lights] = [recipe.views.len(), recipe.lights.len()];
        let guide = match recipe.fill {
            FillMethod::Poisson => {
                let order = from_above(&recipe.views.directions());
                Some(FillGuide::new(field, self.masks, &order, lights).map_err(outside)?)
            }
            FillMethod::PushPull => None,
        };
        progress.stage(Stage::Images, views)?;
        for view in 0..views {
            let holes = guide.as_ref().map_or(Holes::PushPull, Holes::Poisson);
            let flattened = FlattenedView::new(field, view, &self.masks[view], holes).map_err(outside)?;
            (0..lights).into_par_iter().try_for_each(|light| {
                let size = recipe.flat_texels;
                let rows = from_the_top(&flattened.image(light).map_err(outside)?, size);
                let (number, angles) = (light * views + view, self.angles(view, light));
                write_image(&folder, number, angles, &rows, [size; 2], StackFormat::Exr).map(drop).map_err(self.failed)
            })?;
            progress.step()?;
        }
        Ok(())
    }

    /// Writes R and `Δ_v` (equation 2), in tiles, not wrapped.
    fn write_parameters(&self, model: &MesoModel, views: &[Vector], progress: &dyn Progress) -> Result<(), Error> {
        let size = self.recipe.texels as usize;
        let rays = match &self.recipe.relief {
            ReliefForm::Vdim(vdim) => vdim.oversampling as usize,
            ReliefForm::Layers => OVERSAMPLING,
        };
        progress.stage(Stage::Indirections, views.len() + 1)?;
        let reference = seen_through_texels(model, [0.0, 0.0, 1.0], size, rays);
        self.write(&self.folder.join("reference.exr"), ["u", "v"], &reference)?;
        progress.step()?;
        for (view, direction) in views.iter().enumerate() {
            let mut moved = seen_through_texels(model, *direction, size, rays);
            moved.iter_mut().zip(&reference).for_each(|(seen, r)| *seen = [seen[0] - r[0], seen[1] - r[1]]);
            self.write(&self.of_view("displacements", view), ["u", "v"], &moved)?;
            progress.step()?;
        }
        Ok(())
    }

    /// Writes a square of texels, of which the first row is the lowest.
    fn write<const N: usize>(&self, path: &Path, channels: [&str; N], texels: &[[f32; N]]) -> Result<(), Error> {
        let size = texels.len().isqrt();
        write_channels(path, channels, &from_the_top(texels, size), [size; 2]).map_err(self.failed)
    }
}

/// Rows in the order of image files, the highest first.
fn from_the_top<T: Copy>(texels: &[T], size: usize) -> Vec<T> {
    texels.chunks_exact(size).rev().flatten().copied().collect()
}
