//! Files of viewers for reflectance transformation imaging as inputs: a function of the light for each pixel.

use crate::{Input, InputError, Kind, ptm, rti};
use brdfc_readers::viewer_file::ViewerFile;

/// Reads a file of an RTI viewer; `None` for inputs of other kinds.
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout.
pub fn open_viewer_file(input: &Input) -> Result<Option<Box<dyn ViewerFile>>, InputError> {
    Ok(match Kind::of(input)? {
        Kind::Ptm => Some(Box::new(ptm::open_ptm(input)?)),
        Kind::Rti => Some(Box::new(rti::open_rti(input)?)),
        _ => None,
    })
}
