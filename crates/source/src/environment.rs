//! Files of environments: latitude-longitude images, cube maps and prefiltered environments.

use crate::InputError;
use crate::input::{Input, InputFile};
use crate::radiance_image::{RadianceImage, from_exr, from_hdr};
use crate::read::{ReadListener, extension_of};
use brdfc_formats::environment::EnvironmentPack;
use brdfc_formats::{FormatError, Pack};
use brdfc_readers::cube_map::{CubeMap, is_pack};
use std::path::Path;

/// Kinds of files, for messages.
pub const KINDS: &str = "a latitude-longitude image (.exr, .hdr), a cube map or a prefiltered environment (.ktx2)";

/// Contents of a file of an environment.
#[derive(Debug, Clone)]
pub enum EnvironmentFile {
    /// A latitude-longitude image: twice as wide as high, up to a pixel.
    Image(RadianceImage),
    /// A cube map of another writer.
    Cube(CubeMap),
    /// A prefiltered environment.
    Pack(EnvironmentPack),
}

impl EnvironmentFile {
    /// Colour and other statements of an image, such as its exposure, and what was done; empty for other files.
    pub fn conversions(&self) -> &[String] {
        if let Self::Image(image) = self { &image.conversions } else { &[] }
    }
}

/// Opens an environment.
///
/// # Errors
/// Returns an error for files that cannot be read or violate their layout, for images of another shape, and for other kinds of files.
pub fn open_environment(input: &Input) -> Result<EnvironmentFile, InputError> {
    parse(InputFile::of(input, &mut ())?, &input.extension()?)
}

/// Same as [`open_environment`] for a file, with an observer of the bytes.
///
/// # Errors
/// Same as [`open_environment`].
pub fn open_environment_observed(path: &Path, listener: &mut dyn ReadListener) -> Result<EnvironmentFile, InputError> {
    parse(InputFile::at(path, listener)?, &extension_of(path))
}

fn parse(file: InputFile<'_>, extension: &str) -> Result<EnvironmentFile, InputError> {
    file.parse(|bytes| match extension {
        "exr" => from_exr(bytes).and_then(image),
        "hdr" => from_hdr(bytes).and_then(image),
        "ktx2" if !is_pack(bytes) => CubeMap::from_bytes(bytes).map(EnvironmentFile::Cube),
        "ktx2" => match Pack::from_bytes(bytes)? {
            Pack::Environment(pack) => Ok(EnvironmentFile::Pack(pack)),
            other => Err(FormatError::whole("environment", other.kind().summary(), KINDS)),
        },
        _ => {
            let found =
                if extension.is_empty() { "no extension".to_owned() } else { format!("extension .{extension}") };
            Err(FormatError::whole("environment", found, KINDS))
        }
    })
}

/// Checks the shape: crosses, strips and light probes have others, and would become nonsense.
fn image(image: RadianceImage) -> Result<EnvironmentFile, FormatError> {
    let RadianceImage { width, height, .. } = image;
    if width.abs_diff(2 * height) > 1 {
        let found = format!("{width} x {height} pixels");
        return Err(FormatError::whole("environment", found, "a latitude-longitude image, twice as wide as high"));
    }
    Ok(EnvironmentFile::Image(image))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_twice_as_wide_as_high() {
        let shape = |width, height| {
            let pixels = vec![[1.0; 3]; width * height];
            image(RadianceImage::new([width, height], pixels)).map(drop).map_err(|error| error.to_string())
        };
        for (width, height) in [(64, 32), (63, 32), (65, 32), (1, 1), (2, 1)] {
            assert_eq!(shape(width, height), Ok(()));
        }
        for (width, height) in [(64, 64), (96, 128), (32, 64), (62, 32), (384, 64)] {
            let expected = format!(
                "environment: found {width} x {height} pixels, expected a latitude-longitude image, twice as wide as high"
            );
            assert_eq!(shape(width, height), Err(expected));
        }
    }
}
