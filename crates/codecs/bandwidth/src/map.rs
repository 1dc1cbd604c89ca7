//! Maps as packs hold them: the last step of [`super::lobe`], [`super::environment`] and [`super::texture`].

use super::environment::{as_shown, environment_bandwidth};
use super::lobe::{SIDE, lobe_bandwidth};
use super::resolution::Resolution;
use super::texture::{BandwidthImage, Placement, texture_bandwidth};
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};

/// The map of a material, with what its evaluation had to repair; see [`lobe_bandwidth`] and [`Resolution`].
///
/// # Errors
/// An `epsilon` that the layout has no place for.
///
/// # Panics
/// As [`lobe_bandwidth`].
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

/// The map of a latitude-longitude image of radiance, [`as_shown`]; see [`environment_bandwidth`].
///
/// # Errors
/// As [`brdf_map`].
///
/// # Panics
/// As [`environment_bandwidth`].
pub fn environment_map(pixels: &[[f32; 3]], width: usize, epsilon: f64) -> Result<BandwidthMap, FormatError> {
    image_map(BandwidthKind::Environment, &environment_bandwidth(&as_shown(pixels), width, epsilon), epsilon)
}

/// The map of a texture; see [`texture_bandwidth`].
///
/// # Errors
/// As [`brdf_map`]; sides in metres that are not positive.
///
/// # Panics
/// As [`texture_bandwidth`].
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
