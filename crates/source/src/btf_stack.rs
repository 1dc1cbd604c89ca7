//! Folders of images, one per view and light: ordinary BTFs.

use crate::InputError;
use crate::photograph::{CodeValues, Common, Image, common_header};
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::btf_stack::{StackContents, StackIndex};
use std::path::{Path, PathBuf};

/// Number of searched levels of folders: the stack's own folder and its subfolders.
pub const LEVELS: usize = 2;
/// Maximum number of files and folders that are read.
const MAX_ENTRIES: usize = 1 << 20;

/// A complete BTF stack with images of one size. The tile is rectified to the plane z = 0.
///
/// Values are radiance divided by the radiance of a white diffuser that faces the light: white is 1.
pub struct BtfStack {
    folder: PathBuf,
    index: StackIndex,
    common: Box<Common>,
    codes: Option<CodeValues>,
}

impl BtfStack {
    /// Opens a folder, whose images may be in subfolders. Linked folders are skipped.
    ///
    /// Reads the header of every image, and no pixels.
    ///
    /// # Errors
    /// Returns an error for unreadable files, names that [`StackIndex::new`] rejects, files that are not PNG, JPEG or
    /// EXR, and images of different sizes or orientations or with more than [`MAX_SIZE`](crate::photograph::MAX_SIZE)
    /// pixels along a side.
    pub fn open(folder: &Path) -> Result<Self, InputError> {
        Self::open_as(folder, None)
    }

    /// Same as [`Self::open`], with the meaning of code values in spite of what the images state.
    ///
    /// # Errors
    /// Returns the errors of [`Self::open`].
    pub fn open_as(folder: &Path, codes: Option<CodeValues>) -> Result<Self, InputError> {
        let mut paths = Vec::new();
        let mut entries = 0;
        list(folder, "", LEVELS, &mut entries, &mut paths)?;
        let mut index = StackIndex::new(&paths).map_err(|error| InputError::format(folder, error))?;
        (index.views.name, index.lights.name) = ("of the images".to_owned(), "of the images".to_owned());
        let common = common_of(folder, &index.files, codes)?;
        Ok(Self { folder: folder.to_owned(), index, common: Box::new(common), codes })
    }

    /// Directions to the viewer.
    pub fn views(&self) -> &DirectionSet {
        &self.index.views
    }

    /// Directions to the light.
    pub fn lights(&self) -> &DirectionSet {
        &self.index.lights
    }

    /// Width and height of every image, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.common.size
    }

    /// Colour of the code values of the images, and how they are converted.
    pub fn colour(&self) -> &str {
        &self.common.colour
    }

    /// Differences in colour, and other statements of the images that are applied.
    pub fn notes(&self) -> &[String] {
        &self.common.notes
    }

    /// Reads one image, by its indices in [`BtfStack::views`] and [`BtfStack::lights`], without caching it.
    ///
    /// Colours are converted as the file states them; see [`Self::colour`]. Alpha is ignored.
    ///
    /// # Errors
    /// Returns an error for an index out of range, a file that cannot be read or decoded or has changed its size, and
    /// values that are not finite.
    pub fn view(&self, view: usize, light: usize) -> Result<Image, InputError> {
        for (field, index, count) in [("view", view, self.views().len()), ("light", light, self.lights().len())] {
            if index >= count {
                let error = FormatError::whole(field, index.to_string(), format!("less than {count}"));
                return Err(InputError::format(&self.folder, error));
            }
        }
        Image::read(&self.folder.join(self.index.file(view, light)), self.size(), self.codes)
    }
}

/// Lists the images of a folder, complete or not, with what their headers have in common.
///
/// # Errors
/// Returns the errors of [`BtfStack::open`], but accepts folders in which images are missing.
pub fn survey(folder: &Path) -> Result<(StackContents, Common), InputError> {
    let mut paths = Vec::new();
    list(folder, "", LEVELS, &mut 0, &mut paths)?;
    let contents = StackContents::new(&paths).map_err(|error| InputError::format(folder, error))?;
    let common = common_of(folder, &contents.files, None)?;
    Ok((contents, common))
}

/// Files of a folder and of its subfolders, with `/` after the name of a subfolder; empty if the folder cannot be read.
pub(crate) fn files_in(folder: &Path) -> Vec<String> {
    let mut paths = Vec::new();
    if list(folder, "", LEVELS, &mut 0, &mut paths).is_err() {
        paths.clear();
    }
    paths
}

/// Image files of a folder that is an ordinary BTF by its file names, complete or not; empty for other folders.
pub fn images_of(folder: &Path) -> Vec<PathBuf> {
    let contents = StackContents::new(&files_in(folder)).ok();
    contents.map_or_else(Vec::new, |contents| contents.files.iter().map(|file| folder.join(file)).collect())
}

/// Returns true for a folder whose images have the names of several views and several lights.
pub fn has_views_and_lights(folder: &Path) -> bool {
    StackContents::new(&files_in(folder)).is_ok_and(|found| found.views.len() > 1 && found.lights.len() > 1)
}

fn common_of(folder: &Path, files: &[String], codes: Option<CodeValues>) -> Result<Common, InputError> {
    let paths: Vec<PathBuf> = files.iter().map(|file| folder.join(file)).collect();
    common_header(&paths, files.first().map_or("", String::as_str), codes)
}

/// Lists the files below `folder`, with `/` between folders, after `prefix`.
fn list(
    folder: &Path,
    prefix: &str,
    levels: usize,
    entries: &mut usize,
    paths: &mut Vec<String>,
) -> Result<(), InputError> {
    for entry in std::fs::read_dir(folder).map_err(|error| InputError::io(folder, error))? {
        let entry = entry.map_err(|error| InputError::io(folder, error))?;
        *entries += 1;
        if *entries > MAX_ENTRIES {
            let found = format!("more than {MAX_ENTRIES}");
            return Err(InputError::format(
                folder,
                FormatError::whole("files and folders", found, "the folder of one stack of images"),
            ));
        }
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        // Links are not followed, so there are no loops.
        let kind = entry.file_type().map_err(|error| InputError::io(&entry.path(), error))?;
        if kind.is_dir() {
            if levels > 1 {
                list(&entry.path(), &format!("{name}/"), levels - 1, entries, paths)?;
            }
        } else if kind.is_file() || entry.path().is_file() {
            paths.push(name);
        }
    }
    Ok(())
}
