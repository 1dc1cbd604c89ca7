//! Images of an ordinary BTF: reads them for the encoder, and writes computed ones.

use crate::btf_stack::{StackFormat, write_image};
use crate::error::Error;
use crate::exposure::{Exposure, Exposures};
use crate::outputs::Failed;
use brdfc_core::progress::{Progress, Stage};
use brdfc_flat_btf::encode::FlattenRecipe;
use brdfc_flat_btf::measured::ViewImages;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::rebuild::ViewImage;
use brdfc_flat_btf::surface::Appearance;
use brdfc_flat_btf::tile_image::TileImage;
use brdfc_readers::btf_stack::ImageAngles;
use brdfc_source::ordinary_btf::OrdinaryBtf;
use rayon::prelude::*;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Rays per texel and axis of computed images.
const RAYS: usize = 2;

/// Images from a folder, or decoded from a file's matrices.
pub(super) struct StackImages<'a> {
    btf: &'a OrdinaryBtf,
    exposures: Mutex<Exposures>,
}

impl<'a> StackImages<'a> {
    pub(super) fn new(btf: &'a OrdinaryBtf) -> Self {
        Self { btf, exposures: Mutex::default() }
    }

    /// Exposures of the images that were read.
    pub(super) fn exposures(&self) -> MutexGuard<'_, Exposures> {
        self.exposures.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl ViewImages for StackImages<'_> {
    type Error = Error;

    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, Error> {
        let image = self.btf.image(view, light)?;
        if !self.exposures().has([view, light]) {
            let exposure = Exposure::of(image.pixels.iter().copied());
            self.exposures().add([view, light], exposure);
        }
        Ok(TileImage { width: image.width, height: image.height, pixels: image.pixels })
    }
}

/// Computes the images of the ordinary BTF directly and writes them, at the resolution of the reference plane.
pub(super) fn write_images(
    model: &MesoModel,
    appearance: &Appearance,
    recipe: &FlattenRecipe,
    (folder, format, failed): (&Path, StackFormat, Failed<'_>),
    progress: &dyn Progress,
) -> Result<(), Error> {
    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    progress.stage(Stage::Images, views.len())?;
    let size = recipe.texels as usize;
    for (view, direction) in views.iter().enumerate() {
        let seen = ViewImage::new(model, *direction, size, RAYS);
        let write = |light: usize| {
            let image = seen.direct(model, appearance, lights[light]);
            // Row 0 of an image is its top.
            let rows: Vec<[f32; 3]> = image.chunks_exact(size).rev().flatten().copied().collect();
            let angles = ImageAngles { light: recipe.lights.angles[light], view: recipe.views.angles[view] };
            write_image(folder, light * views.len() + view, angles, &rows, [size; 2], format).map_err(failed)
        };
        (0..lights.len()).into_par_iter().try_for_each(|light| write(light).map(drop))?;
        progress.step()?;
    }
    Ok(())
}
