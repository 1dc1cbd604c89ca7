//! How fast a material, an environment or a texture varies, as a map: `brdfc bandwidth`.
//!
//! Renderers shade only where, and as finely as, such maps ask for; `formats/src/bandwidth/spec.md` has the layout. `epsilon` is
//! the share of the largest coefficient below which a sum of coefficients does not count, in [`EPSILON_RANGE`].

pub use brdfc_bandwidth::facts::BandwidthFacts;
pub use brdfc_bandwidth::resolution::{RESOLUTIONS, Resolution};
pub use brdfc_bandwidth::texture::Placement;
pub use brdfc_bandwidth::{DEFAULT_EPSILON, EPSILON_RANGE};
pub use brdfc_formats::bandwidth::BandwidthMap;
pub use brdfc_source::tile_image::FileImage;

use crate::{Error, FormatError, Input, Material, Tally};
use brdfc_bandwidth::map::{brdf_map, environment_map, texture_map};
use brdfc_render::picture::{bandwidth_panel, rgb_png};
use brdfc_source::radiance_image::open_radiance_image;
use brdfc_source::tile_image::open_colours;

/// Maps the lobes of a material, each transformed at `resolution`, and counts repairs of its values.
///
/// # Errors
/// `epsilon` out of range.
pub fn of_material(material: &Material, resolution: Resolution, epsilon: f64) -> Result<(BandwidthMap, Tally), Error> {
    made(epsilon, || brdf_map(material.source(), resolution, epsilon))
}

/// Maps a latitude-longitude image of radiance.
///
/// # Errors
/// `epsilon` out of range.
pub fn of_environment(image: &FileImage<3>, epsilon: f64) -> Result<BandwidthMap, Error> {
    made(epsilon, || environment_map(&image.pixels, image.width, epsilon))
}

/// Maps an image on a surface.
///
/// # Errors
/// `epsilon` out of range; sides that are not positive.
pub fn of_texture(image: &FileImage<3>, placement: Placement, epsilon: f64) -> Result<BandwidthMap, Error> {
    made(epsilon, || texture_map(&image.pixels, image.width, placement, epsilon))
}

fn made<T>(epsilon: f64, map: impl FnOnce() -> Result<T, FormatError>) -> Result<T, Error> {
    let [least, most] = EPSILON_RANGE;
    if !(least..=most).contains(&epsilon) {
        return Err(Error::usage(format!("invalid epsilon {epsilon}: expected {least} to {most}")));
    }
    map().map_err(Error::own_layout)
}

/// Whether an image file holds radiance (.exr, .hdr), not colours (.png, .jpg), by its extension; nothing of other files.
///
/// # Errors
/// A stream that cannot be read.
pub fn holds_radiance(input: &Input) -> Result<Option<bool>, Error> {
    Ok(match input.extension()?.as_str() {
        "exr" | "hdr" => Some(true),
        "png" | "jpg" | "jpeg" => Some(false),
        _ => None,
    })
}

/// Reads an image of radiance or of colours: linear RGB.
///
/// # Errors
/// Files that cannot be read or are no image.
pub fn open_image(input: &Input) -> Result<FileImage<3>, Error> {
    let radiance = holds_radiance(input)? == Some(true);
    Ok(if radiance { open_radiance_image(input)? } else { open_colours(input)? })
}

/// A map as a PNG: from dark (1/256 of the largest value and less) to pale yellow.
pub fn picture(map: &BandwidthMap) -> Vec<u8> {
    rgb_png(&bandwidth_panel(map))
}
