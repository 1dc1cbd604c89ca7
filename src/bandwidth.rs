//! Bandwidth maps of materials, environments and textures: `brdfc bandwidth`.
//!
//! A map states how fast its input varies, so that renderers can choose where and how finely to shade;
//! `formats/src/bandwidth/spec.md` describes the layout. `epsilon` is the threshold, as a fraction of the largest coefficient,
//! below which a sum of coefficients is ignored; its range is [`EPSILON_RANGE`].

pub use brdfc_bandwidth::facts::BandwidthFacts;
pub use brdfc_bandwidth::resolution::{RESOLUTIONS, Resolution};
pub use brdfc_bandwidth::texture::Placement;
pub use brdfc_bandwidth::{DEFAULT_EPSILON, EPSILON_RANGE};
pub use brdfc_formats::bandwidth::BandwidthMap;
pub use brdfc_source::tile_image::FileImage;

use crate::environment::{Environment, open_image};
use crate::{Error, Input, Material, Reading, Tally};
use brdfc_bandwidth::map::{brdf_map, environment_map, texture_map};
use brdfc_render::rendering::{bandwidth_panel, rgb_png};
use brdfc_source::radiance_image::open_radiance_image;
use brdfc_source::tile_image::open_colours;

/// Kind of input for a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The lobes of a material, read with settings and each transformed at a resolution.
    Material(Resolution, Reading),
    /// A latitude-longitude image of radiance, or a cube map or a prefiltered environment.
    Environment,
    /// An image on a surface.
    Texture(Placement),
}

/// An opened input, of which [`Subject::map`] makes a map.
pub enum Subject {
    /// A material, and the resolution of its lobes.
    Material(Material, Resolution),
    /// A latitude-longitude image of radiance.
    Environment(Environment),
    /// An image on a surface, and its placement there.
    Texture(FileImage<3>, Placement),
}

impl Subject {
    /// Opens an input. Images contain radiance (.exr, .hdr) or colours (.png, .jpg).
    ///
    /// # Errors
    /// Returns an error if the input cannot be read or is of another kind.
    pub fn open(input: &Input, kind: Kind) -> Result<Self, Error> {
        let radiance = holds_radiance(input)?;
        let image = || -> Result<FileImage<3>, Error> {
            Ok(if radiance == Some(true) { open_radiance_image(input)? } else { open_colours(input)? })
        };
        Ok(match kind {
            Kind::Material(resolution, reading) => Self::Material(crate::open_with(input, reading)?, resolution),
            Kind::Environment if radiance == Some(false) => {
                let FileImage { width, height, pixels, .. } = image()?;
                Self::Environment(Environment { width, height, pixels })
            }
            Kind::Environment => Self::Environment(open_image(input)?),
            Kind::Texture(placement) => Self::Texture(image()?, placement),
        })
    }

    /// Computes the map, and counts repairs of a material's values.
    ///
    /// # Errors
    /// Returns an error if `epsilon` is out of range or a side of the texture is not positive.
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

/// Returns true if the extension says radiance (.exr, .hdr), false if it says colours (.png, .jpg), `None` for other files.
///
/// # Errors
/// Returns an error if a stream cannot be read.
pub fn holds_radiance(input: &Input) -> Result<Option<bool>, Error> {
    Ok(match input.extension()?.as_str() {
        "exr" | "hdr" => Some(true),
        "png" | "jpg" | "jpeg" => Some(false),
        _ => None,
    })
}

/// Encodes a map as a PNG, from dark (at most 1/256 of the largest value) to pale yellow.
pub fn rendering(map: &BandwidthMap) -> Vec<u8> {
    rgb_png(&bandwidth_panel(map))
}
