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

use crate::{Error, Input, Material, Tally};
use brdfc_bandwidth::map::{brdf_map, environment_map, texture_map};
use brdfc_render::rendering::{bandwidth_panel, rgb_png};
use brdfc_source::radiance_image::open_radiance_image;
use brdfc_source::tile_image::open_colours;

/// What a map is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The lobes of a material, each transformed at a resolution.
    Material(Resolution),
    /// A latitude-longitude image of radiance.
    Environment,
    /// An image on a surface.
    Texture(Placement),
}

/// An input that was read.
pub enum Subject {
    /// A material.
    Material(Material, Resolution),
    /// A latitude-longitude image.
    Environment(FileImage<3>),
    /// An image on a surface.
    Texture(FileImage<3>, Placement),
}

impl Subject {
    /// Reads an input; images are of radiance (.exr, .hdr) or of colours (.png, .jpg).
    ///
    /// # Errors
    /// What cannot be read or is of another kind.
    pub fn open(input: &Input, kind: Kind) -> Result<Self, Error> {
        let image = || -> Result<FileImage<3>, Error> {
            let radiance = holds_radiance(input)? == Some(true);
            Ok(if radiance { open_radiance_image(input)? } else { open_colours(input)? })
        };
        Ok(match kind {
            Kind::Material(resolution) => Self::Material(crate::open(input)?, resolution),
            Kind::Environment => Self::Environment(image()?),
            Kind::Texture(placement) => Self::Texture(image()?, placement),
        })
    }

    /// The map, with repairs of a material's values.
    ///
    /// # Errors
    /// `epsilon` out of range; sides of a texture that are not positive.
    pub fn map(&self, epsilon: f64) -> Result<(BandwidthMap, Option<Tally>), Error> {
        let [least, most] = EPSILON_RANGE;
        if !(least..=most).contains(&epsilon) {
            return Err(Error::usage(format!("epsilon: found {epsilon}, expected {least} to {most}")));
        }
        if let Self::Texture(_, Placement { metres, .. }) = self
            && !metres.iter().all(|side| side.is_finite() && *side > 0.0)
        {
            return Err(Error::usage(format!("sides of the texture: found {metres:?} m, expected positive numbers")));
        }
        let map = match self {
            Self::Material(material, resolution) => {
                brdf_map(material.source(), *resolution, epsilon).map(|(map, repairs)| (map, Some(repairs)))
            }
            Self::Environment(image) => environment_map(&image.pixels, image.width, epsilon).map(|map| (map, None)),
            Self::Texture(image, placement) => {
                texture_map(&image.pixels, image.width, *placement, epsilon).map(|map| (map, None))
            }
        };
        map.map_err(Error::own_layout)
    }
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

/// A map as a PNG: from dark (1/256 of the largest value and less) to pale yellow.
pub fn rendering(map: &BandwidthMap) -> Vec<u8> {
    rgb_png(&bandwidth_panel(map))
}
