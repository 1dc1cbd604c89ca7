//! Prefiltered environments, which lobes look up: `brdfc environment`.
//!
//! [`open_image`] reads a latitude-longitude image, [`prefilter`] makes a cube map of it, and [`open`] accepts either.
//! `formats/src/environment/spec.md` describes the layout.

pub use brdfc_environment::facts::EnvironmentFacts;
pub use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader, EnvironmentPack, MAX_SIDE, MIN_SIDE};
pub use brdfc_jobs::environment::default_side;
pub use brdfc_render::scene::Environment;

use crate::inspect::{AnyPack, open_pack};
use crate::{Error, Input, Progress};
use brdfc_jobs::environment::prefilter_image;
use brdfc_source::radiance_image::open_radiance_image;

/// Extensions of images.
const IMAGES: [&str; 2] = ["exr", "hdr"];

/// Reads a latitude-longitude image, .exr or .hdr.
///
/// # Errors
/// Returns an error if the file cannot be read, is of another kind, or has values that are negative or not finite.
pub fn open_image(input: &Input) -> Result<Environment, Error> {
    let extension = input.extension()?;
    if !IMAGES.contains(&extension.as_str()) {
        let text = format!("{input}: found extension .{extension}, expected a latitude-longitude image, .exr or .hdr");
        return Err(Error::input(text));
    }
    let image = open_radiance_image(input)?;
    Ok(Environment { width: image.width, height: image.height, pixels: image.pixels })
}

/// Prefilters an image, on faces of `side` texels, by default as many as retain its detail.
///
/// # Errors
/// Returns an error if the side is not a power of two from 8 to 2048 ([`ErrorKind::Usage`](crate::ErrorKind::Usage)), and if
/// the work was cancelled.
pub fn prefilter(image: &Environment, side: Option<u32>, progress: &dyn Progress) -> Result<EnvironmentPack, Error> {
    prefilter_image(image, side, progress)
}

/// Opens a prefiltered environment (.ktx2), or prefilters an image (.exr, .hdr).
///
/// # Errors
/// Returns the errors of [`open_image`] and [`prefilter`], and an error for other packs.
pub fn open(input: &Input, progress: &dyn Progress) -> Result<EnvironmentPack, Error> {
    if input.extension()? != "ktx2" {
        return prefilter(&open_image(input)?, None, progress);
    }
    match open_pack(input)? {
        AnyPack::Environment(pack) => Ok(pack),
        other => {
            let found = other.kind().summary();
            Err(Error::input(format!("{input}: found {found}, expected a prefiltered environment")))
        }
    }
}
