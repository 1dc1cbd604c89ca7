//! Writes RTI captures. Layout: `crates/readers/src/rti_capture.md`.

use super::btf_stack::{StackFormat, write_pixels};
use super::write::write_atomic;
use brdfc_readers::rti_capture::{LightPositions, is_above};
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Name of the list of lights.
pub const LIST: &str = "dirs.lp";

/// Writes a capture into `folder`: images `0000.png` and so on, then [`LIST`], whose path it returns. Creates the folder if it is
/// missing.
///
/// `lights` point to the lights, z > 0, of any length but 0. `image` gives the pixels of a light: linear RGB (Rec. 709
/// primaries), 1 = the largest level, row by row from the top, left to right. `size` is pixels per row, and rows.
///
/// # Errors
/// Returns an error if a file cannot be written, [`LightPositions::parse`] rejects the lights, the number of pixels is 0 or does
/// not match `size`, or a value is NaN or infinite.
pub fn write_rti_capture(
    folder: &Path,
    lights: &[[f32; 3]],
    size: [usize; 2],
    format: StackFormat,
    mut image: impl FnMut(usize) -> Vec<[f32; 3]>,
) -> std::io::Result<PathBuf> {
    let names: Vec<String> = (0..lights.len()).map(|light| format!("{light:04}.{}", format.extension())).collect();
    let text = LightPositions::to_text(&names, lights);
    let list = LightPositions::parse(&text).map_err(|error| Error::new(ErrorKind::InvalidInput, error))?;
    if let Some(light) = lights.iter().position(|light| !light.iter().all(|c| c.is_finite())) {
        let text = format!("light {light}: {:?}; expected finite numbers", lights[light]);
        return Err(Error::new(ErrorKind::InvalidInput, text));
    }
    if let Some(light) = list.directions.iter().position(|direction| !is_above(direction)) {
        let text = format!("light {light}: {:?} is at or below the horizon; expected z greater than 0", lights[light]);
        return Err(Error::new(ErrorKind::InvalidInput, text));
    }
    for (light, name) in names.iter().enumerate() {
        write_pixels(&folder.join(name), &image(light), size, format)?;
    }
    let list = folder.join(LIST);
    write_atomic(&list, text.as_bytes())?;
    Ok(list)
}
