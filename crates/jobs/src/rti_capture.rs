//! Writes RTI captures. Layout: `crates/readers/src/rti_capture.md`.

use super::btf_stack::{StackFormat, write_pixels};
use super::write::write_atomic;
use brdfc_readers::rti_capture::LightPositions;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Name of the list of lights.
pub const LIST: &str = "dirs.lp";

/// Writes a stack into `folder`, images `0000.png` and so on, and at the end [`LIST`], whose path it returns. The folder is
/// made where there is none.
///
/// `lights` point to the lights, z > 0, of any length but 0. `image` gives the pixels of a light: linear RGB (Rec. 709
/// primaries), 1 = full scale of codes, row by row from the top, left to right. `size` is pixels per row, and rows.
///
/// # Errors
/// What cannot be written; what [`LightPositions::parse`] refuses of the lights; a number of pixels other than `size` says, or
/// 0; values that are NaN or infinite.
pub fn write_rti_capture(
    folder: &Path,
    lights: &[[f32; 3]],
    size: [usize; 2],
    format: StackFormat,
    mut image: impl FnMut(usize) -> Vec<[f32; 3]>,
) -> std::io::Result<PathBuf> {
    let names: Vec<String> = (0..lights.len()).map(|light| format!("{light:04}.{}", format.extension())).collect();
    let text = LightPositions::to_text(&names, lights);
    LightPositions::parse(&text).map_err(|error| Error::new(ErrorKind::InvalidInput, error))?;
    for (light, name) in names.iter().enumerate() {
        write_pixels(&folder.join(name), &image(light), size, format)?;
    }
    let list = folder.join(LIST);
    write_atomic(&list, text.as_bytes())?;
    Ok(list)
}
