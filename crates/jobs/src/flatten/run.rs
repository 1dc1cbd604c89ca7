//! Makes a flat BTF and puts its file in place.

use super::asset::{AssetFile, FlatAsset, Settings};
use super::error::FlattenError;
use super::images::{StackImages, write_images};
use super::input::Geometry;
use super::scratch::FolderScratch;
use crate::btf_stack::StackFormat;
use crate::store::{Staging, placing};
use crate::write::write_atomic;
use brdfc_core::progress::Progress;
use brdfc_flat_btf::encode::{FlatInput, FlattenRecipe, ValueSource, encode};
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile};
use brdfc_source::ordinary_btf::OrdinaryBtf;
use std::path::Path;

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
    /// The folder of its file.
    pub folder: &'a Path,
    /// How it is made.
    pub recipe: &'a FlattenRecipe,
    /// Whether images are compressed with Zstandard.
    pub supercompress: bool,
    /// The surface.
    pub geometry: Geometry,
    /// The materials' sources.
    pub materials: Vec<String>,
    /// Where values come from.
    pub values: Values,
    /// Folder and kind of the images of an ordinary BTF to write besides, computed directly.
    pub images: Option<(&'a Path, StackFormat)>,
}

/// Makes a flat BTF and writes `NAME.ktx2`. Values of views are kept in the folder on the way.
///
/// # Errors
/// A recipe that cannot be followed, a surface that cannot be laid flat, images that cannot be read, files that cannot be
/// written. A file of that name in the folder stays as it was.
pub fn run(job: FlattenJob<'_>, progress: &dyn Progress) -> Result<FlatAsset, FlattenError> {
    let Geometry { mesh, weld, name: source, .. } = job.geometry;
    let staging = Staging::new(job.folder).map_err(|error| FlattenError::write(job.folder, error))?;
    let scratch = FolderScratch::new(staging.path().to_owned(), job.folder);
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
    let about = AssetFile {
        version: 2,
        name: job.name.to_owned(),
        source,
        materials: job.materials,
        images_over_the_tile: match &job.values {
            Values::Computed(appearance) => appearance.colour.is_some() || appearance.weights.is_some(),
            Values::Measured(_) => false,
        },
        settings: Settings::new(job.recipe, job.supercompress),
        report: encoded.report,
    };
    let mut file = FlatBtfFile::new(FlatBtfDecoder::new(encoded.parts)?, Some(encoded.mask))?;
    file.report = serde_json::to_string(&about).expect("plain data");
    let bytes = file.to_bytes(job.supercompress);
    let _placing = placing();
    progress.check()?;
    let path = job.folder.join(format!("{}.ktx2", job.name));
    write_atomic(&path, &bytes).map_err(|error| FlattenError::write(&path, error))?;
    Ok(FlatAsset::new(about, &file, bytes.len() as u64))
}
