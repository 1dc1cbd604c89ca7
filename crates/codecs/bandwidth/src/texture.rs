//! Bandwidth of textures over the surface, in cycles per metre.

use super::daubechies::Image;
use super::image::{Axis, channels, resample};
use super::local::{Border, MIN_BOUNDED_SIDE, block_frequencies, doublings};

/// Maximum values per axis of a map.
pub const MAX_SIDE: usize = 512;

/// Placement of a texture on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Width and height in metres, positive.
    pub metres: [f64; 2],
    /// True if the texture repeats.
    pub tiles: bool,
}

/// A map of the largest frequencies, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct BandwidthImage {
    /// Values per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Cycles per radian or per metre, finite and not negative.
    pub values: Vec<f32>,
    /// Pixels per row and rows of the transformed image.
    pub transformed: [usize; 2],
}

/// Local bandwidth of a texture of `width` pixels per row, in cycles per metre: the maximum over the channels, reduced
/// by maximum to at most [`MAX_SIDE`] values per axis. Sizes that are not powers of two are resampled bilinearly to the
/// next one.
///
/// The Jacobian of a texture is diagonal, one image per width and per height, so that `|J^T k|` of the frequencies
/// along both axes requires no singular value.
///
/// # Panics
/// Panics if the number of pixels is not a positive multiple of `width`.
pub fn texture_bandwidth(pixels: &[[f32; 3]], width: usize, placement: Placement, epsilon: f64) -> BandwidthImage {
    assert!(width > 0 && !pixels.is_empty() && pixels.len().is_multiple_of(width), "a texture has whole rows");
    let from = [width, pixels.len() / width];
    let (border, least) = match placement.tiles {
        true => (Border::Periodic, 1),
        false => (Border::Bounded, MIN_BOUNDED_SIDE),
    };
    let size = from.map(|side| side.next_power_of_two().max(least));
    let axis = |k: usize| Axis { from: from[k], to: size[k], wraps: placement.tiles };
    // Cycles per metre for one cycle per pixel.
    let density = [0, 1].map(|k| (size[k] as f64 / placement.metres[k]) as f32);
    let doublings = size.map(|side| doublings(side, MAX_SIDE));
    let mut map = BandwidthImage { width: 0, height: 0, values: Vec::new(), transformed: size };
    for channel in channels(pixels) {
        let image = resample(channel, axis(0), axis(1));
        let image = Image::plain(&image, size[0], size[1]);
        let found = block_frequencies(image, size[1], border, epsilon, doublings, f32::max);
        (map.width, map.height) = (found.width, found.height);
        map.values.resize(found.u.len(), 0.0);
        for ((value, u), v) in map.values.iter_mut().zip(&found.u).zip(&found.v) {
            *value = value.max((u * density[0]).hypot(v * density[1]));
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(width: usize, height: usize, cycles: [f64; 2]) -> Vec<[f32; 3]> {
        let at = |i: usize, size: usize| (i as f64 + 0.5) / size as f64;
        let value = |i: usize| {
            let phase = TAU * (cycles[0] * at(i % width, width) + cycles[1] * at(i / width, height));
            0.5 + 0.4 * phase.sin() as f32
        };
        (0..width * height).map(|i| [0.3, value(i), 0.3]).collect()
    }

    fn range(map: &BandwidthImage) -> [f32; 2] {
        map.values.iter().fold([f32::INFINITY, 0.0], |[low, high], v| [low.min(*v), high.max(*v)])
    }

    #[test]
    fn waves_in_cycles_per_metre() {
        let placement = Placement { metres: [0.5, 2.0], tiles: true };
        // 24 cycles in half a metre, 7 in two, both at once.
        for (cycles, expected) in [([24.0, 0.0], 48.0), ([0.0, 7.0], 3.5), ([24.0, 28.0], 50.0)] {
            let map = texture_bandwidth(&wave(128, 256, cycles), 128, placement, 0.01);
            let [low, high] = range(&map).map(|value| value / expected);
            assert!(low > 1.2 && high < 1.45, "{cycles:?}: {low} {high}");
            // The negative control: the size of the other axis is the wrong Jacobian.
            let turned = Placement { metres: [2.0, 0.5], ..placement };
            let [low, high] =
                range(&texture_bandwidth(&wave(128, 256, cycles), 128, turned, 0.01)).map(|v| v / expected);
            assert!(low < 1.2 || high > 1.45, "{low} {high}");
        }
    }

    /// Also for resampled images.
    #[test]
    fn the_border_only_counts_if_the_texture_repeats() {
        let fading = wave(200, 100, [3.5, 0.0]);
        let map = |tiles| range(&texture_bandwidth(&fading, 200, Placement { metres: [1.0, 1.0], tiles }, 0.01));
        assert!(map(true)[1] > 8.0, "{:?}", map(true));
        assert!(map(false)[1] < 6.0 && map(false)[0] > 3.5, "{:?}", map(false));
    }

    #[test]
    fn constants_are_0_and_large_maps_are_reduced() {
        let placement = Placement { metres: [1.0, 1.0], tiles: false };
        for (width, height) in [(1, 1), (3, 7), (64, 64)] {
            let map = texture_bandwidth(&vec![[0.2, 0.5, 0.1]; width * height], width, placement, 0.01);
            assert_eq!(range(&map), [0.0; 2]);
        }
        let mut dot = vec![[0.0; 3]; 2048 * 1024];
        dot[700 * 2048 + 900] = [1.0; 3];
        let map = texture_bandwidth(&dot, 2048, Placement { tiles: true, ..placement }, 0.01);
        assert_eq!((map.width, map.height, map.transformed), (512, 512, [2048, 1024]));
        // A maximum preserves one pixel in sixteen; a mean would not.
        assert!(map.values[350 * 512 + 225] > 600.0, "{}", map.values[350 * 512 + 225]);
    }
}
