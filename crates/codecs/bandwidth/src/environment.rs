//! Bandwidth of environments over the sphere of directions, in cycles per radian.
//!
//! A latitude-longitude image is continued over its poles, so that both axes are periodic and span 2π. A wave with the
//! frequencies `(k_u, k_v)` in cycles per radian of the two angles has `|J^T k| = hypot(k_u / sin θ, k_v)` cycles per
//! radian on the sphere, θ being the angle to the pole.
//!
//! Near a pole `1 / sin θ` grows without bound, while frequencies along the azimuth come from wavelets that extend to
//! larger θ: `m` cycles around the pole are a wave of `b` cycles per radian only for `θ ≥ m / 2πb`. Therefore `sin θ`
//! is evaluated one wavelength away from the pole, at the middle of the wavelets that measured the frequency. Within a
//! wavelength of the pole, every direction is the elevation of some azimuth, and `k_v` counts for both axes.
//!
//! As a result, the peak bandwidth of a round spot varies by at most a factor 1.65 over the sphere, and the bandwidth
//! of a wave by at most 2 (bounds of the tests). With `1 / sin θ` alone the error is a factor of a hundred.

use super::daubechies::Image;
use super::image::{Axis, channels, resample};
use super::local::{Border, Join, block_frequencies, doublings};
use super::texture::BandwidthImage;
use rayon::prelude::*;
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::{PI, TAU};

/// Maximum values per row and maximum rows of a map.
pub const MAX_SIZE: [usize; 2] = [512, 256];
/// Smallest transformed size.
const MIN_SIZE: [usize; 2] = [4, 2];

/// Local bandwidth of a latitude-longitude image (row 0 up, linear RGB), in cycles per radian: the maximum over the
/// channels, for at most [`MAX_SIZE`] blocks of pixels. Sizes that are not powers of two are resampled bilinearly to
/// the next one.
///
/// # Panics
/// Panics if the number of pixels is not a positive multiple of `width`.
pub fn environment_bandwidth(pixels: &[[f32; 3]], width: usize, epsilon: f64) -> BandwidthImage {
    map_by(pixels, width, epsilon, jacobian, f32::max)
}

/// Square roots of radiance, which approximate displayed values; negative values become 0.
///
/// The rule compares detail with the strongest coefficient around it, and a window may be a thousand times brighter
/// than the room. Without the square root, the room would count as nothing next to the window, although reflections of
/// the room show it.
pub fn sqrt_radiance(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    pixels.par_iter().map(|pixel| pixel.map(|c| c.max(0.0).sqrt())).collect()
}

/// Variant of [`environment_bandwidth`] with a given Jacobian and join. The Jacobian receives the angle to the nearer
/// pole and frequencies in cycles per radian of azimuth and of elevation; `join` merges blocks.
fn map_by(
    pixels: &[[f32; 3]],
    width: usize,
    epsilon: f64,
    jacobian: impl Fn(f32, [f32; 2]) -> f32 + Sync,
    join: impl Join,
) -> BandwidthImage {
    assert!(width > 0 && !pixels.is_empty() && pixels.len().is_multiple_of(width), "an environment has whole rows");
    let from = [width, pixels.len() / width];
    let size = [0, 1].map(|k| from[k].next_power_of_two().max(MIN_SIZE[k]));
    let [across, down] = [0, 1].map(|k| Axis { from: from[k], to: size[k], wraps: k == 0 });
    // Cycles per radian of the two angles for one cycle per pixel.
    let density = [size[0] as f64 / TAU, size[1] as f64 / PI].map(|density| density as f32);
    let doublings = [0, 1].map(|k| doublings(size[k], MAX_SIZE[k]));
    // Pixels per block.
    let step = (2usize << doublings[1]) as f64;
    let mut map = BandwidthImage { width: 0, height: 0, values: Vec::new(), transformed: size };
    for channel in channels(pixels) {
        let values = resample(channel, across, down);
        let torus = Image { values: &values, width: size[0], height: 2 * size[1], over_poles: true };
        let found = block_frequencies(torus, size[1], Border::Periodic, epsilon, doublings, join);
        (map.width, map.height) = (found.width, found.height);
        map.values.resize(found.u.len(), 0.0);
        map.values.par_chunks_exact_mut(found.width).enumerate().for_each(|(row, target)| {
            // Angle between the nearer pole and the closest row of the block.
            let row_below = (row + 1) as f64 * step;
            let theta = (row as f64 * step + 0.5).min(size[1] as f64 + 0.5 - row_below) * PI / size[1] as f64;
            let theta = theta as f32;
            let steepest = 1.0 / theta.sin();
            let at = row * found.width;
            for (k, value) in target.iter_mut().enumerate() {
                let [u, v] = [found.u[at + k] * density[0], found.v[at + k] * density[1]];
                // Upper bound, which skips most of the evaluations because channels are similar.
                let most = (u * steepest).max(v);
                if most * most + v * v > *value * *value {
                    *value = value.max(jacobian(theta, [u, v]));
                }
            }
        });
    }
    map
}

/// `|J^T k|` in cycles per radian on the sphere, for frequencies `k` in cycles per radian of azimuth and of elevation,
/// at the angle `theta` to the nearer pole. `1 / sin θ` is evaluated one wavelength away from the pole.
fn jacobian(theta: f32, [u, v]: [f32; 2]) -> f32 {
    // A wavelength along the azimuth is 1 / u.
    let around = if u > 0.0 { u / (theta + 1.0 / u).min(FRAC_PI_2).sin() } else { 0.0 };
    let around = around.max(v * (1.0 - theta * v).max(0.0));
    (around * around + v * v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::{Vector, dot, normalize};

    fn environment(width: usize, value: impl Fn(Vector) -> f64) -> Vec<[f32; 3]> {
        let height = width / 2;
        let texel = |i: usize| {
            let theta = PI * ((i / width) as f64 + 0.5) / height as f64;
            let phi = TAU * ((i % width) as f64 + 0.5) / width as f64;
            [value([theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()]) as f32; 3]
        };
        (0..width * height).map(texel).collect()
    }

    fn at_latitude(degrees: f64, azimuth: f64) -> Vector {
        let (s, c) = degrees.to_radians().sin_cos();
        [c * azimuth.cos(), s, c * azimuth.sin()]
    }

    fn value(map: &BandwidthImage, d: Vector) -> f32 {
        let row = (d[1].acos() / PI * map.height as f64) as usize;
        let column = (d[2].atan2(d[0]).rem_euclid(TAU) / TAU * map.width as f64) as usize;
        map.values[row.min(map.height - 1) * map.width + column.min(map.width - 1)]
    }

    fn peak(map: &BandwidthImage) -> f32 {
        map.values.iter().copied().fold(0.0, f32::max)
    }

    const LATITUDES: [f64; 7] = [0.0, 20.0, 45.0, 70.0, 80.0, 88.0, 89.9];

    /// Ratio of the largest to the smallest peak.
    fn spread(peaks: &[f32]) -> f32 {
        let (low, high) = peaks.iter().fold((f32::INFINITY, 0.0f32), |(l, h), p| (l.min(*p), h.max(*p)));
        high / low
    }

    /// Peak bandwidth of round spots, and bandwidth at their centres, at [`LATITUDES`].
    fn spots(sharpness: f64, jacobian: impl Fn(f32, [f32; 2]) -> f32 + Sync + Copy) -> Vec<(f32, f32)> {
        let spot = |latitude: f64| {
            let centre = at_latitude(latitude, 2.0);
            let image = environment(256, |d| (sharpness * (dot(d, centre) - 1.0)).exp());
            let map = map_by(&image, 256, 0.01, jacobian, f32::max);
            (peak(&map), value(&map, centre))
        };
        LATITUDES.into_iter().map(spot).collect()
    }

    #[test]
    fn a_spot_has_its_bandwidth_anywhere() {
        for sharpness in [50.0, 200.0] {
            let found = spots(sharpness, jacobian);
            let peaks: Vec<f32> = found.iter().map(|(peak, _)| *peak).collect();
            assert!(spread(&peaks) < 1.65, "{sharpness}: {peaks:?}");
            assert!(found.iter().all(|(peak, centre)| centre / peak > 0.8), "{found:?}");
            // Frequency in cycles per radian at which the spectrum of the spot has fallen to 1 %.
            let expected = ((2.0 * sharpness * 100f64.ln()).sqrt() / TAU) as f32;
            assert!(peaks.iter().all(|peak| (0.6..1.3).contains(&(peak / expected))), "{expected}: {peaks:?}");
            // The negative controls: the Jacobian of the texel itself, and the Jacobian of a cylinder.
            for wrong in [|theta: f32, [u, v]: [f32; 2]| (u / theta.sin()).hypot(v), |_, [u, v]: [f32; 2]| u.hypot(v)] {
                let peaks: Vec<f32> = spots(sharpness, wrong).iter().map(|(peak, _)| *peak).collect();
                assert!(spread(&peaks) > 1.65, "{sharpness}: {peaks:?}");
            }
        }
    }

    /// Small lights under a bright sky; the negative control replaces the maximum over the blocks by the mean.
    #[test]
    fn a_block_has_its_largest_bandwidth() {
        let mut sky: Vec<f32> = environment(2048, |d| 1.0 + d[1]).iter().map(|pixel| pixel[0]).collect();
        for light in 0..300 {
            sky[(331 * light + 7) % 1024 * 2048 + (1237 * light) % 2048] += 200.0;
        }
        let torus = Image { values: &sky, width: 2048, height: 2048, over_poles: true };
        let fine = block_frequencies(torus, 1024, Border::Periodic, 0.01, [0; 2], f32::max);
        let pixels: Vec<[f32; 3]> = sky.iter().map(|value| [*value; 3]).collect();
        let flat = |_: f32, [u, v]: [f32; 2]| u.hypot(v);
        // Number of blocks of the map that are too low for one of the four blocks of 2 x 2 pixels in them.
        let low = |join: fn(f32, f32) -> f32| {
            let map = map_by(&pixels, 2048, 0.01, flat, join);
            assert_eq!([map.width, map.height], MAX_SIZE);
            let is_low = |at: &usize| {
                let (column, row) = (2 * (at % 512), 2 * (at / 512));
                let inside = [0, 1, 1024, 1025].map(|step| row * 1024 + column + step);
                let most = inside.map(|k| fine.u[k].hypot(fine.v[k])).into_iter().fold(0.0, f32::max);
                map.values[*at] < 0.95 * most * (2048.0 / TAU) as f32
            };
            (0..map.values.len()).filter(is_low).count()
        };
        let wrong = low(|a, b| 0.5 * (a + b));
        assert!(low(f32::max) == 0 && wrong > 300, "{} {wrong}", low(f32::max));
    }

    #[test]
    fn a_wave_has_its_bandwidth_anywhere() {
        let b = 6.0;
        let mut peaks = Vec::new();
        for axis in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], normalize([1.0, 1.0, 0.3])] {
            let map = environment_bandwidth(&environment(256, |d| (TAU * b * dot(d, axis)).cos()), 256, 0.01);
            peaks.push(peak(&map));
            for latitude in LATITUDES {
                for step in 0..16 {
                    let d = at_latitude(latitude, f64::from(step) * 0.4);
                    let expected = b * (1.0 - dot(d, axis).powi(2)).sqrt();
                    let found = f64::from(value(&map, d));
                    assert!(found > 0.9 * expected && found < 2.0 * b, "{axis:?} {d:?}: {found} {expected}");
                }
            }
        }
        assert!(spread(&peaks) < 2.0, "{peaks:?}");
    }

    /// The negative control: the Jacobian of the texel itself, near a pole.
    #[test]
    fn the_jacobian_at_the_pole_itself_is_wrong() {
        let (u, theta) = (2.0, 0.01f32);
        assert!(jacobian(theta, [u, 0.0]) < 5.0 && u / theta.sin() > 100.0);
        assert!((jacobian(FRAC_PI_2, [u, 0.0]) - u).abs() < 1e-6);
        assert!((jacobian(1.0, [20.0, 5.0]) - (20.0 / 1.05f32.sin()).hypot(5.0)).abs() < 1e-5);
    }

    /// Stripes in a dim room next to a bright window; the negative control uses radiance directly.
    #[test]
    fn a_window_does_not_hide_the_room() {
        let (window, wall) = (at_latitude(10.0, 1.0), at_latitude(0.0, 1.5));
        let room = environment(256, |d| {
            let stripes = 0.2 + 0.15 * (TAU * 12.0 * d[1]).cos();
            stripes + if dot(d, window) > 0.98 { 20.0 } else { 0.0 }
        });
        let found = |pixels: &[[f32; 3]]| value(&environment_bandwidth(pixels, 256, 0.01), wall);
        let (rooted, linear) = (found(&sqrt_radiance(&room)), found(&room));
        // Next to brighter parts, detail is underestimated: less so with square roots.
        assert!(rooted < 24.0 && rooted > 1.2 * linear, "{rooted} {linear}");
    }

    #[test]
    fn turning_by_a_period_changes_nothing() {
        let value = |phi: f64, theta: f64| 2.0 + (8.0 * phi).sin() * theta.sin() + (24.0 * phi + 3.0 * theta).cos();
        let turned = |columns: usize| -> Vec<[f32; 3]> {
            let texel = |i: usize| {
                let phi = TAU * ((i % 128 + columns) as f64 + 0.5) / 128.0;
                [value(phi, PI * ((i / 128) as f64 + 0.5) / 64.0) as f32, 1.0, 0.5]
            };
            (0..128 * 64).map(texel).collect()
        };
        let map = |columns| environment_bandwidth(&turned(columns), 128, 0.01);
        let (still, period, other) = (map(0), map(16), map(5));
        let difference = |a: &BandwidthImage, b: &BandwidthImage| {
            a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(difference(&still, &period) < 1e-3 * peak(&still), "{}", difference(&still, &period));
        assert!(difference(&still, &other) > 0.01 * peak(&still));
    }

    #[test]
    fn constants_any_size_and_channels() {
        for (width, height) in [(1, 1), (2, 1), (7, 3), (100, 50), (64, 64)] {
            let map = environment_bandwidth(&vec![[0.3, 0.2, 7.0]; width * height], width, 0.01);
            assert!(map.values.iter().all(|value| *value == 0.0), "{width} x {height}");
            assert_eq!(map.values.len(), map.width * map.height);
        }
        let grey = environment(64, |d| 1.0 + d[0]);
        let mut blue = grey.clone();
        for (i, pixel) in blue.iter_mut().enumerate() {
            pixel[2] = (i % 64 / 2 % 2) as f32;
        }
        let (a, b) = (environment_bandwidth(&grey, 64, 0.01), environment_bandwidth(&blue, 64, 0.01));
        assert!(a.values.iter().zip(&b.values).all(|(a, b)| a <= b) && peak(&b) > 3.0 * peak(&a));
    }
}
