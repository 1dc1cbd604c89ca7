//! The environment as predictions look it up.

use crate::environment_light::texel_solid_angle;
use crate::scene::Environment;
use brdfc_formats::bandwidth::BandwidthMap;
use brdfc_formats::bandwidth::propagation::{BRIGHTEST, DirectedLight};
use std::f32::consts::PI;

/// Bandwidth and radiance of distant light: a pyramid over the texels of its bandwidth map.
///
/// In a prediction, a few directions represent a whole lobe. Each looks up the mean over the solid angle that it
/// represents, not the light from exactly that direction (as "Filtered importance sampling", Křivánek and Colbert 2008, does
/// for radiance). Otherwise a few directions would miss small bright sources.
#[derive(Debug, Clone, PartialEq)]
pub struct DistantLight {
    bandwidth: BandwidthMap,
    levels: Vec<LightLevel>,
}

/// One level of a [`DistantLight`], row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct LightLevel {
    /// Texels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Means over the solid angle of each texel.
    pub texels: Vec<DirectedLight>,
}

impl DistantLight {
    /// Makes the pyramid of an environment and its map. The bandwidth is 0 everywhere if the map is not an
    /// environment's.
    ///
    /// # Panics
    /// If the environment has no pixels, or if their number does not match its size.
    pub fn new(environment: &Environment, bandwidth: BandwidthMap) -> Self {
        let [width, height] = bandwidth.size().map(|side| side as usize);
        let moments = environment.moments_over([width, height], f64::from(BRIGHTEST));
        let texel =
            |(bandwidth, [mean, squares]): (f32, [f64; 2])| DirectedLight::of(mean as f32, squares as f32, bandwidth);
        let texels = bandwidth.environment_values().into_iter().zip(moments).map(texel).collect();
        let mut levels = vec![LightLevel { width, height, texels }];
        let mut solid_angles: Vec<f64> = (0..height).map(|row| texel_solid_angle(row, width, height)).collect();
        while let Some(last) = levels.last().filter(|last| last.width * last.height > 1) {
            let next = last.halved(&solid_angles);
            solid_angles =
                (0..next.height).map(|row| covered(row, last.height).map(|r| solid_angles[r]).sum()).collect();
            levels.push(next);
        }
        Self { bandwidth, levels }
    }

    /// The bandwidth map.
    pub fn bandwidth(&self) -> &BandwidthMap {
        &self.bandwidth
    }

    /// All levels, from the finest, which has the size of the map. Each next level is half as large along both axes,
    /// rounded down, but at least 1.
    pub fn levels(&self) -> &[LightLevel] {
        &self.levels
    }

    /// Mean around the direction of a [`BandwidthMap::environment_texel`], over approximately this solid angle, sr.
    /// Uses the level whose texels at the equator are at most as large as the solid angle, and larger than a quarter of
    /// it while both sides can be halved. Texels near the poles are smaller.
    pub fn at(&self, texel: [u32; 2], solid_angle: f32) -> DirectedLight {
        let texels = self.bandwidth.size().into_iter().product::<u32>() as f32;
        let covered = solid_angle * texels / (2.0 * PI * PI);
        // Half the exponent is the logarithm of base 4, rounded down.
        let level = (((covered.to_bits() >> 23) as i32 - 127) >> 1).clamp(0, self.levels.len() as i32 - 1) as usize;
        let LightLevel { width, height, texels } = &self.levels[level];
        let [column, row] = texel.map(|at| at as usize >> level);
        texels[row.min(height - 1) * width + column.min(width - 1)]
    }
}

impl LightLevel {
    /// Halves the number of texels along each axis. Each row has its solid angle per texel.
    fn halved(&self, solid_angles: &[f64]) -> Self {
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let texel = |at: usize| {
            let (mut sums, mut weight) = ([0.0f64; 4], 0.0);
            for row in covered(at / width, self.height) {
                for column in covered(at % width, self.width) {
                    let texel = self.texels[row * self.width + column];
                    sums.iter_mut().zip(texel.moments()).for_each(|(sum, m)| *sum += solid_angles[row] * f64::from(m));
                    weight += solid_angles[row];
                }
            }
            DirectedLight::from_moments(sums.map(|sum| (sum / weight) as f32))
        };
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }
}

/// Texels that a texel of the next level covers: two, and the last one the rest.
fn covered(at: usize, count: usize) -> std::ops::Range<usize> {
    let end = if at + 1 >= count / 2 { count } else { 2 * at + 2 };
    2 * at..end
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_bandwidth::map::environment_map;
    use std::f64::consts::TAU;

    fn light(width: usize, height: usize, pixel: impl Fn(usize) -> [f32; 3]) -> DistantLight {
        let environment = Environment { width, height, pixels: (0..width * height).map(pixel).collect() };
        let map = environment_map(&environment.pixels, width, 0.01).unwrap();
        DistantLight::new(&environment, map)
    }

    #[test]
    fn texels_have_the_mean_of_the_light_that_they_cover() {
        let light = light(8, 4, |i| [(i % 8 / 2) as f32, (i % 3) as f32, (i / 16) as f32]);
        assert_eq!(light.bandwidth().size(), [4, 2]);
        for (azimuth, column) in [(0.4f32, 0), (2.0, 1), (3.5, 2), (6.0, 3)] {
            for (y, row) in [(0.5, 0), (-0.5, 1)] {
                let direction = [azimuth.cos(), y, azimuth.sin()];
                let weight = |below: usize| texel_solid_angle(2 * row + below, 8, 4);
                let green = |k: usize| ((16 * row + 2 * column + 8 * (k / 2) + k % 2) % 3) as f64;
                let sum: f64 = (0..4).map(|k| weight(k / 2) * green(k)).sum();
                let green = (sum / (2.0 * (weight(0) + weight(1)))) as f32;
                let expected = 0.2126 * column as f32 + 0.7152 * green + 0.0722 * row as f32;
                let found = light.at(light.bandwidth().environment_texel(direction), 0.0);
                assert!((found.radiance - expected).abs() < 1e-6, "{found:?} {expected}");
                assert_eq!(found.bandwidth, light.bandwidth().environment(direction));
            }
        }
    }

    /// Coarser levels of a whole sphere, compared with sums over the finest texels.
    #[test]
    fn coarser_levels_have_the_mean_over_their_solid_angle() {
        for (width, height) in [(64, 32), (100, 38), (96, 3), (512, 1)] {
            let light = light(width, height, |i| [(1 + i * i % 97) as f32; 3]);
            let finest = &light.levels()[0];
            assert!(light.levels().len() > 3);
            let whole = light.at([3, 1], 1e6);
            let (mut sum, mut squares, mut all) = (0.0, 0.0, 0.0);
            for (at, texel) in finest.texels.iter().enumerate() {
                let weight = texel_solid_angle(at / finest.width, finest.width, finest.height);
                sum += weight * f64::from(texel.radiance);
                squares += weight * f64::from(texel.squares);
                all += weight;
            }
            assert!((f64::from(whole.radiance) * all / sum - 1.0).abs() < 1e-5, "{whole:?}");
            assert!((f64::from(whole.squares) * all / squares - 1.0).abs() < 1e-5, "{whole:?}");
            // Bandwidth is weighted by light, and never above the maximum of the finest level.
            let most = finest.texels.iter().map(|texel| texel.bandwidth).fold(0.0, f32::max);
            assert!(
                light.levels().iter().flat_map(|level| &level.texels).all(|texel| texel.bandwidth <= 1.0001 * most)
            );
        }
    }

    #[test]
    fn a_solid_angle_has_the_level_whose_texels_are_no_larger() {
        let light = light(64, 32, |i| [(1 + i % 7) as f32; 3]);
        let finest = (TAU * std::f64::consts::PI / f64::from(32 * 16)) as f32;
        for (solid_angle, level) in
            [(0.0, 0), (0.9 * finest, 0), (3.9 * finest, 0), (4.1 * finest, 1), (17.0 * finest, 2), (1e6, 5)]
        {
            let found = light.at([0, 15], solid_angle);
            let expected = &light.levels()[level];
            let row = (15 >> level).min(expected.height - 1);
            assert_eq!(found, expected.texels[row * expected.width], "{level}");
        }
    }
}
