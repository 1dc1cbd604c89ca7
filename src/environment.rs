//! Prefiltered environments, which lobes look up: `brdfc environment`.
//!
//! [`open_surroundings`] reads a latitude-longitude image or a cube map, [`Surroundings::prefilter`] makes a pack of it, and
//! [`open`] does both, or opens a pack.
//! `formats/src/environment/spec.md` describes the layout.

pub use brdfc_environment::default_side;
pub use brdfc_environment::facts::EnvironmentFacts;
pub use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentHeader, EnvironmentPack, MAX_SIDE, MIN_SIDE};
pub use brdfc_jobs::environment::Surroundings;
pub use brdfc_render::scene::Environment;

use crate::{Error, Input, Progress};
use brdfc_jobs::environment::prefilter_image;
use brdfc_source::environment::{EnvironmentFile, open_environment};

/// Reads the radiance of a latitude-longitude image (.exr, .hdr), a cube map or a prefiltered environment (.ktx2). A prefiltered
/// environment counts as its finest level.
///
/// # Errors
/// Returns an error if the file cannot be read, is of another kind, or has values that are negative or not finite.
pub fn open_surroundings(input: &Input) -> Result<Surroundings, Error> {
    Ok(open_environment(input)?.into())
}

/// Same as [`open_surroundings`], with what an image states about its pixels, such as its exposure, and what was done.
///
/// # Errors
/// Same as [`open_surroundings`].
pub fn open_surroundings_with_conversions(input: &Input) -> Result<(Surroundings, Vec<String>), Error> {
    let file = open_environment(input)?;
    let conversions = file.conversions().to_vec();
    Ok((file.into(), conversions))
}

/// Same as [`open_surroundings`], as a latitude-longitude image; of a cube map, four faces wide.
///
/// # Errors
/// Same as [`open_surroundings`].
pub fn open_image(input: &Input) -> Result<Environment, Error> {
    Ok(open_surroundings(input)?.into_image())
}

/// Same as [`open`], next to the radiance that was prefiltered, as a latitude-longitude image; of a cube map, four faces wide.
///
/// # Errors
/// Same as [`open`].
pub fn open_with_image(input: &Input, progress: &dyn Progress) -> Result<(EnvironmentPack, Environment), Error> {
    match open_environment(input)? {
        EnvironmentFile::Pack(pack) => {
            let image = Surroundings::from(&pack).into_image();
            Ok((pack, image))
        }
        other => {
            let surroundings = Surroundings::from(other);
            let pack = surroundings.prefilter(None, progress).map_err(|error| error.prefixed(input))?;
            Ok((pack, surroundings.into_image()))
        }
    }
}

/// Prefilters an image, on faces of `side` texels, by default as many as retain its detail.
///
/// # Errors
/// Returns an error if the side is not a power of two from 8 to 2048 ([`ErrorKind::Usage`](crate::ErrorKind::Usage)), and if
/// the work was cancelled.
pub fn prefilter(image: &Environment, side: Option<u32>, progress: &dyn Progress) -> Result<EnvironmentPack, Error> {
    prefilter_image(image, side, progress)
}

/// Opens a prefiltered environment, or prefilters a latitude-longitude image or a cube map.
///
/// # Errors
/// Returns the errors of [`open_surroundings`] and [`prefilter`].
pub fn open(input: &Input, progress: &dyn Progress) -> Result<EnvironmentPack, Error> {
    match open_environment(input)? {
        EnvironmentFile::Pack(pack) => Ok(pack),
        other => Surroundings::from(other).prefilter(None, progress).map_err(|error| error.prefixed(input)),
    }
}
