//! Bandwidth maps as packs: the last step of [`super::lobe`], [`super::environment`] and [`super::texture`].

use super::environment::{environment_bandwidth, sqrt_radiance};
use super::lobe::{SIDE, lobe_bandwidth};
use super::resolution::Resolution;
use super::texture::{BandwidthImage, Placement, texture_bandwidth};
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};

/// Computes the map of a material and the repairs of its evaluation; see [`lobe_bandwidth`] and [`Resolution`].
///
/// # Errors
/// Returns an error if the layout cannot hold `epsilon`.
///
/// # Panics
/// Panics as [`lobe_bandwidth`] does.
pub fn brdf_map(
    source: &dyn Source,
    resolution: Resolution,
    epsilon: f64,
) -> Result<(BandwidthMap, Tally), FormatError> {
    let mut steps = resolution.steps().peekable();
    loop {
        let side = steps.next().expect("the last step ends the loop");
        let found = lobe_bandwidth(source, side, epsilon);
        let header =
            BandwidthHeader { kind: BandwidthKind::Brdf, epsilon: epsilon as f32, transformed: [side as u32; 2] };
        let map = BandwidthMap::new(header, [SIDE as u32; 2], &found.values)?;
        if steps.peek().is_none() || !found.narrow {
            return Ok((map, found.tally));
        }
    }
}

/// Computes the map of a latitude-longitude image of radiance, after [`sqrt_radiance`]; see [`environment_bandwidth`].
///
/// # Errors
/// Returns the errors of [`brdf_map`].
///
/// # Panics
/// Panics as [`environment_bandwidth`] does.
pub fn environment_map(pixels: &[[f32; 3]], width: usize, epsilon: f64) -> Result<BandwidthMap, FormatError> {
    image_map(BandwidthKind::Environment, &environment_bandwidth(&sqrt_radiance(pixels), width, epsilon), epsilon)
}

/// Computes the map of a texture; see [`texture_bandwidth`].
///
/// # Errors
/// Returns the errors of [`brdf_map`], and an error if sides in metres are not positive.
///
/// # Panics
/// Panics as [`texture_bandwidth`] does.
pub fn texture_map(
    pixels: &[[f32; 3]],
    width: usize,
    placement: Placement,
    epsilon: f64,
) -> Result<BandwidthMap, FormatError> {
    let metres = placement.metres.map(|side| side as f32);
    let found = texture_bandwidth(pixels, width, placement, epsilon);
    image_map(BandwidthKind::Texture { metres, tiles: placement.tiles }, &found, epsilon)
}

fn image_map(kind: BandwidthKind, found: &BandwidthImage, epsilon: f64) -> Result<BandwidthMap, FormatError> {
    let transformed = found.transformed.map(|side| side as u32);
    let header = BandwidthHeader { kind, epsilon: epsilon as f32, transformed };
    BandwidthMap::new(header, [found.width as u32, found.height as u32], &found.values)
}
