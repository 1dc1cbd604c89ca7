//! Files of viewers for reflectance transformation imaging as inputs: a function of the light for each pixel.

use crate::{Input, InputError, ptm, rti};
use brdfc_readers::viewer_file::ViewerFile;

/// Extensions of the files.
pub const EXTENSIONS: [&str; 2] = [ptm::EXTENSION, rti::EXTENSION];

/// Reads a file; `None` if its extension is none of [`EXTENSIONS`].
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout.
pub fn open_viewer_file(input: &Input) -> Result<Option<Box<dyn ViewerFile>>, InputError> {
    Ok(match input.extension()?.as_str() {
        ptm::EXTENSION => Some(Box::new(ptm::open_ptm(input)?)),
        rti::EXTENSION => Some(Box::new(rti::open_rti(input)?)),
        _ => None,
    })
}
