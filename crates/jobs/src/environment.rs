//! Prefiltered environments: `brdfc environment`.

use crate::Error;
use brdfc_core::progress::Progress;
use brdfc_environment::{PrefilterError, prefilter};
use brdfc_formats::environment::{EnvironmentHeader, EnvironmentPack, MAX_SIDE, MIN_SIDE};
use brdfc_render::scene::Environment;

pub use brdfc_environment::default_side;

/// Prefilters a latitude-longitude image, on faces of `side` texels, by default as many as retain its detail.
///
/// # Errors
/// Returns an error if the side is not a power of two from 8 to 2048, and if the work was cancelled.
pub fn prefilter_image(
    image: &Environment,
    side: Option<u32>,
    progress: &dyn Progress,
) -> Result<EnvironmentPack, Error> {
    let side = side.unwrap_or_else(|| default_side(image.width));
    if !EnvironmentHeader::is_side(side) {
        let text = format!("side: found {side}, expected a power of two, {MIN_SIDE} to {MAX_SIDE}");
        return Err(Error::usage(text));
    }
    Ok(prefiltered(image, side, progress)?)
}

/// Prefilters a latitude-longitude image on faces of `side` texels.
///
/// # Errors
/// Returns an error for a side or a radiance out of range, and if the work was cancelled.
pub(crate) fn prefiltered(
    image: &Environment,
    side: u32,
    progress: &dyn Progress,
) -> Result<EnvironmentPack, PrefilterError> {
    // At least two samples across a pixel of the image, whose look-ups are bilinear.
    let samples = (2 * image.width).div_ceil(4 * side as usize).max(2);
    prefilter(&|direction| image.at(direction), side, samples, progress)
}
