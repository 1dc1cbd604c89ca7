//! Makes a flat BTF and puts its files in place.

use super::asset::{AssetFile, Settings};
use super::error::FlattenError;
use super::images::{StackImages, write_images};
use super::input::Geometry;
use super::parts::Parts;
use super::store::add_parts;
use crate::btf_stack::StackFormat;
use brdfc_core::progress::Progress;
use brdfc_flat_btf::encode::{FlatInput, FlattenRecipe, ValueSource, encode};
use brdfc_flat_btf::surface::Appearance;
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
    /// Whether files are compressed with Zstandard.
    pub supercompress: bool,
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

/// Makes all parts and puts them in place, `NAME.json` last. Values of views are kept in the folder on the way.
///
/// # Errors
/// A recipe that cannot be followed, a surface that cannot be laid flat, images that cannot be read, files that cannot be
/// written. An asset of that name that stands in the folder stays as it was.
pub fn run(job: FlattenJob<'_>, progress: &dyn Progress) -> Result<AssetFile, FlattenError> {
    let Geometry { mesh, weld, name: source, .. } = job.geometry;
    let mut parts = Parts::new(job.name, job.folder)?;
    let scratch = parts.scratch()?;
    let images;
    let values = match &job.values {
        Values::Computed(appearance) => ValueSource::Computed(appearance),
        Values::Measured(stack) => {
            images = StackImages(stack);
            ValueSource::Measured(&images)
        }
    };
    let encoded = encode(FlatInput { mesh, repairs: weld, values }, job.recipe, &scratch, progress)?;
    if let (Values::Computed(appearance), Some(images)) = (&job.values, job.images) {
        write_images(&encoded.model, appearance, job.recipe, images, progress)?;
    }
    add_parts(&encoded, &scratch, job.supercompress, &mut parts, progress)?;
    let asset = AssetFile {
        version: 1,
        name: job.name.to_owned(),
        source,
        materials: job.materials,
        images_over_the_tile: match &job.values {
            Values::Computed(appearance) => appearance.colour.is_some() || appearance.weights.is_some(),
            Values::Measured(_) => false,
        },
        settings: Settings::new(job.recipe, job.supercompress),
        parts: parts.files().clone(),
        report: encoded.report,
    };
    let _placing = job.placing.lock().unwrap_or_else(PoisonError::into_inner);
    progress.check()?;
    parts.commit(&(serde_json::to_string_pretty(&asset).expect("plain data") + "\n"))?;
    Ok(asset)
}
