//! Makes a flat BTF and writes its file.

use super::asset::{AssetFile, FlatAsset, Settings};
use super::flat_images::write_flat;
use super::images::{StackImages, write_images};
use super::input::{Geometry, Surface, Values};
use super::scratch::FolderScratch;
use super::trees::fit;
use crate::btf_stack::StackFormat;
use crate::error::Error;
use crate::outputs::fill_folder;
use crate::store::{Staging, placing};
use crate::write::write_atomic;
use brdfc_core::progress::Progress;
use brdfc_flat_btf::encode::{EncodeError, FlatInput, FlattenRecipe, Reflectance, ValueSource, encode, encode_trees};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_pwt::PwtFacts;
use std::path::Path;

/// A flat BTF to make.
pub struct FlattenJob<'a> {
    /// Name of the flat BTF, from which its file is named.
    pub name: &'a str,
    /// The folder for its file.
    pub folder: &'a Path,
    /// Settings of the encoder.
    pub recipe: &'a FlattenRecipe,
    /// True to compress the file with Zstandard.
    pub supercompress: bool,
    /// The surface and the values of its texels.
    pub surface: Surface,
    /// Folder and format for directly computed images of the ordinary BTF; `None` to write none.
    pub images: Option<(&'a Path, StackFormat)>,
    /// Folder for the raw flat BTF as EXR files; `None` to write none.
    pub raw: Option<&'a Path>,
}

impl FlattenJob<'_> {
    /// Checks the recipe, and that the images of a raw flat BTF fit into memory.
    ///
    /// # Errors
    /// Returns the first value that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        self.recipe.check()?;
        if self.raw.is_some() { self.recipe.check_images() } else { Ok(()) }
    }
}

/// Makes a flat BTF and writes `NAME.ktx2`. Stores values of views temporarily in the folder.
///
/// # Errors
/// Returns an error if the recipe is invalid, the surface cannot be flattened, or a file cannot be read or written. An existing
/// file of that name then stays unchanged.
pub fn run(job: FlattenJob<'_>, progress: &dyn Progress) -> Result<FlatAsset, Error> {
    job.check().map_err(Error::usage)?;
    let Surface { geometry, materials, values: texels, .. } = job.surface;
    let Geometry { mesh, weld, name: source, input, .. } = geometry;
    let staging = Staging::new(job.folder).map_err(|error| Error::write(job.folder, &error))?;
    let scratch = FolderScratch::new(staging.path().to_owned(), job.folder);
    let mut images = None;
    let values = match &texels {
        Values::Computed(appearance) => ValueSource::Computed(appearance),
        Values::Measured(stack) => ValueSource::Measured(images.insert(StackImages::new(stack))),
    };
    let flat = FlatInput { mesh, repairs: weld, values };
    let encoded = if job.recipe.reflectance == Reflectance::Pwt {
        encode_trees(flat, job.recipe, &scratch, |views| fit(views, job.recipe, progress), progress)
    } else {
        encode(flat, job.recipe, &scratch, progress)
    };
    let encoded = encoded.map_err(|error| match error {
        EncodeError::Parameterise(error) => Error::input(error).prefixed(input),
        EncodeError::Format(error) => Error::input(error),
        EncodeError::Outside(error) => error,
        EncodeError::Cancelled(cancelled) => cancelled.into(),
    })?;
    if let (Values::Computed(appearance), Some(images)) = (&texels, job.images) {
        let (folder, format) = images;
        fill_folder(folder, |whole, failed| {
            write_images(&encoded.model, appearance, job.recipe, (whole, format, failed), progress)
        })?;
    }
    if let Some(folder) = job.raw {
        fill_folder(folder, |whole, failed| {
            write_flat(&encoded.model, &texels, job.recipe, (whole, failed), progress)
        })?;
    }
    let about = AssetFile {
        version: 5,
        name: job.name.to_owned(),
        source,
        materials,
        images_over_the_tile: match &texels {
            Values::Computed(appearance) => appearance.colour.is_some() || appearance.weights.is_some(),
            Values::Measured(_) => false,
        },
        settings: Settings::new(job.recipe, job.supercompress),
        report: encoded.report,
        exposure: images.as_ref().map(|images| images.exposures().facts()).filter(|facts| !facts.notes().is_empty()),
        trees: encoded.decoder.parts().reflectance.trees().map(|trees| PwtFacts::new(trees.pack())),
    };
    let mut file = FlatBtfFile::new(encoded.decoder).map_err(Error::input)?;
    file.report = serde_json::to_string(&about).expect("plain data");
    let bytes = file.to_bytes(job.supercompress);
    let _placing = placing();
    progress.check()?;
    let path = job.folder.join(format!("{}.ktx2", job.name));
    write_atomic(&path, &bytes).map_err(|error| Error::write(&path, &error))?;
    Ok(FlatAsset::new(about, &file, bytes.len() as u64))
}
