//! Importance sampling of environments.

use super::lobe_sampler::{LobeSampler, low_discrepancy};
use super::scene::Environment;
use super::shading_point::ShadingPoint;
use brdfc_formats::direction::Vector;
use brdfc_metrics::image::luminance;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Samples world-space directions in proportion to the brightness of an environment.
///
/// Draws a texel by cumulative distributions of rows and of columns in each row, by luminance and the sine of its
/// colatitude, and a position around it with the weights of the bilinear look-up. So the density follows the luminance
/// of the look-up, except for the change of the sine within a texel.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentSampler {
    width: usize,
    height: usize,
    /// Cumulative share of the rows.
    rows: Vec<f64>,
    /// Cumulative share of the columns in each row.
    columns: Vec<f64>,
    /// Luminance times the sine of the colatitude, as shares of their sum.
    weights: Vec<f64>,
}

impl EnvironmentSampler {
    /// The sampler of an environment. An environment that is black everywhere is sampled as a white one.
    ///
    /// # Panics
    /// If the environment has no pixels, or if their number does not match its size.
    pub fn new(environment: &Environment) -> Self {
        let (width, height) = (environment.width, environment.height);
        assert!(width > 0 && environment.pixels.len() == width * height && height > 0, "pixels of this size");
        let value = |pixel: &[f32; 3]| Some(luminance(*pixel)).filter(|y| *y > 0.0 && y.is_finite()).unwrap_or(0.0);
        let mut weights: Vec<f64> = environment.pixels.par_iter().map(value).collect();
        if weights.iter().all(|value| *value == 0.0) {
            weights.fill(1.0);
        }
        let sine = |row: usize| (PI * (row as f64 + 0.5) / height as f64).sin();
        weights.par_chunks_mut(width).enumerate().for_each(|(row, weights)| {
            weights.iter_mut().for_each(|weight| *weight *= sine(row));
        });
        let mut columns = weights.clone();
        let mut rows: Vec<f64> = columns.par_chunks_mut(width).map(to_shares).collect();
        let total = to_shares(&mut rows);
        weights.par_iter_mut().for_each(|weight| *weight /= total);
        Self { width, height, rows, columns, weights }
    }

    /// Direction for a point of the unit square, world space, and its density, 1/sr.
    pub fn direction(&self, [u, v]: [f64; 2]) -> (Vector, f64) {
        let (row, down) = place(&self.rows, u);
        let (column, right) = place(&self.columns[row * self.width..(row + 1) * self.width], v);
        let height = self.height as f64;
        // There are no rows beyond the poles: positions there belong to the last row, which the look-up repeats.
        let y = (row as f64 + 0.5 + tent(down)).abs();
        let y = if y > height { 2.0 * height - y } else { y };
        let x = (column as f64 + 0.5 + tent(right)).rem_euclid(self.width as f64);
        let (theta, phi) = (PI * y / height, TAU * x / self.width as f64);
        ([theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()], self.density_at(x, y))
    }

    /// Density of a world-space direction, a unit vector, 1/sr. Infinite at the poles.
    pub fn density(&self, [x, y, z]: Vector) -> f64 {
        let (phi, theta) = (z.atan2(x).rem_euclid(TAU), (x * x + z * z).sqrt().atan2(y));
        self.density_at(phi / TAU * self.width as f64, theta / PI * self.height as f64)
    }

    /// Density at a position in texels from the left and from the top.
    fn density_at(&self, x: f64, y: f64) -> f64 {
        let (last, s, t) = (self.height as f64 - 1.0, x - 0.5, (y - 0.5).clamp(0.0, self.height as f64 - 1.0));
        let column = |step: f64| (s.floor() + step).rem_euclid(self.width as f64) as usize % self.width;
        let row = |step: f64| (t.floor() + step).min(last) as usize * self.width;
        let mix = |a: f64, b: f64, share: f64| a + share * (b - a);
        let across = |row: usize| mix(self.weights[row + column(0.0)], self.weights[row + column(1.0)], s - s.floor());
        let weight = mix(across(row(0.0)), across(row(1.0)), t - t.floor());
        weight / self.jacobian(y)
    }

    /// Steradians per texel at a position in texels from the top: `sin θ` times the angles that a texel spans.
    fn jacobian(&self, y: f64) -> f64 {
        (PI * y / self.height as f64).sin() * (PI / self.height as f64) * (TAU / self.width as f64)
    }
}

/// Maps a uniform number of 0 to 1 to a position of -1 to 1 with the density `1 - |x|`.
fn tent(share: f64) -> f64 {
    if share < 0.5 { (2.0 * share).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - share)).sqrt() }
}

/// Replaces weights by running sums as shares of their total, which is returned. Weights that are all 0 count as equal.
fn to_shares(weights: &mut [f64]) -> f64 {
    let mut sum = 0.0;
    for weight in weights.iter_mut() {
        sum += *weight;
        *weight = sum;
    }
    let count = weights.len() as f64;
    let share = |(index, running): (usize, &mut f64)| {
        *running = if sum > 0.0 { *running / sum } else { (index + 1) as f64 / count };
    };
    weights.iter_mut().enumerate().for_each(share);
    sum
}

/// The step of a cumulative distribution at a share, and the position on the step, 0 to 1.
fn place(cumulative: &[f64], share: f64) -> (usize, f64) {
    let step = cumulative.partition_point(|running| *running <= share).min(cumulative.len() - 1);
    let before = if step == 0 { 0.0 } else { cumulative[step - 1] };
    let length = cumulative[step] - before;
    (step, if length > 0.0 { ((share - before) / length).clamp(0.0, 1.0) } else { 0.5 })
}

/// An environment's sampler as seen from a surface: its directions in the local frame. Some are below the horizon.
#[derive(Debug, Clone, Copy)]
pub struct FramedEnvironmentSampler<'a> {
    /// Sampler in world space.
    pub environment: &'a EnvironmentSampler,
    /// Point with the local frame.
    pub point: &'a ShadingPoint,
    /// Shift of the sequence, see [`low_discrepancy`].
    pub shift: [f64; 2],
}

impl LobeSampler for FramedEnvironmentSampler<'_> {
    fn sample(&self, _: Vector, index: usize) -> (Vector, f64) {
        let (direction, density) = self.environment.direction(low_discrepancy(index, self.shift));
        // At a pole the density is infinite, and the light of a single direction is 0.
        (self.point.local(direction), if density > 0.0 { 1.0 / density } else { 0.0 })
    }

    fn density(&self, _: Vector, incoming: Vector) -> f64 {
        self.environment.density(self.point.world(incoming))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment_light::texel_solid_angle;
    use crate::lobe_sampler::shift_of;

    /// Dark, with a few bright texels, one next to a pole and one at the seam.
    fn spots() -> Environment {
        let (width, height) = (24, 12);
        let mut pixels = vec![[0.01; 3]; width * height];
        for (row, column, value) in [(0, 5, 30.0), (6, 23, 50.0), (8, 11, 90.0)] {
            pixels[row * width + column] = [value, 0.5 * value, 0.1 * value];
        }
        Environment { width, height, pixels }
    }

    /// Cells of the sphere for sums: direction and solid angle.
    fn cells() -> impl Iterator<Item = (Vector, f64)> {
        (0..960 * 480).map(|index| {
            let (row, column) = (index / 960, index % 960);
            let (theta, phi) = (PI * (row as f64 + 0.5) / 480.0, TAU * (column as f64 + 0.5) / 960.0);
            let direction = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            (direction, texel_solid_angle(row, 960, 480))
        })
    }

    fn look_up(environment: &Environment, direction: Vector) -> f64 {
        luminance(environment.at(direction).map(|c| c as f32))
    }

    #[test]
    fn densities_sum_to_1_and_follow_the_light() {
        let environment = spots();
        let sampler = EnvironmentSampler::new(&environment);
        let sum: f64 = cells().map(|(direction, solid_angle)| sampler.density(direction) * solid_angle).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        let spheres: f64 = cells().map(|(_, solid_angle)| solid_angle).sum();
        assert!((spheres - 4.0 * PI).abs() < 1e-9);
        let ratios: Vec<f64> = cells()
            .filter(|(direction, _)| direction[1].abs() < 0.5)
            .map(|(direction, _)| sampler.density(direction) / look_up(&environment, direction))
            .collect();
        let [low, high] = [f64::min, f64::max].map(|pick| ratios.iter().copied().reduce(pick).unwrap());
        // The light itself varies by thousands.
        assert!(high < 1.3 * low, "{low} {high}");
    }

    #[test]
    fn directions_have_their_density() {
        let sampler = EnvironmentSampler::new(&spots());
        let texel = |direction: Vector| {
            let azimuth = direction[2].atan2(direction[0]).rem_euclid(TAU);
            (direction[1].acos() / PI * 12.0) as usize * 24 + (azimuth / TAU * 24.0) as usize
        };
        let (mut found, mut expected) = (vec![0.0; 24 * 12], vec![0.0; 24 * 12]);
        let samples = 1 << 15;
        for index in 0..samples {
            let (direction, density) = sampler.direction(low_discrepancy(index, [0.0; 2]));
            assert!((direction.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!((sampler.density(direction) / density - 1.0).abs() < 1e-6);
            found[texel(direction)] += 1.0 / samples as f64;
        }
        cells().for_each(|(direction, solid_angle)| {
            expected[texel(direction)] += sampler.density(direction) * solid_angle
        });
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 0.03 * expected + 3e-4, "{found} {expected}");
        }
    }

    /// The integral of luminance, which uniform sampling of the sphere misses by far.
    #[test]
    fn few_samples_find_small_sources() {
        let environment = spots();
        let sampler = EnvironmentSampler::new(&environment);
        let exact: f64 = cells().map(|(direction, solid_angle)| look_up(&environment, direction) * solid_angle).sum();
        // Root mean square of the relative error over 16 shifts of 512 samples.
        let error = |sampler: &EnvironmentSampler| {
            let of = |shift: usize| {
                let term = |index| {
                    let (direction, density) = sampler.direction(low_discrepancy(index, shift_of(shift)));
                    look_up(&environment, direction) / density
                };
                ((0..512).map(term).sum::<f64>() / 512.0 / exact - 1.0).powi(2)
            };
            ((0..16).map(of).sum::<f64>() / 16.0).sqrt()
        };
        let even = EnvironmentSampler::new(&Environment { pixels: vec![[1.0; 3]; 24 * 12], ..environment.clone() });
        let [by_light, evenly] = [&sampler, &even].map(error);
        assert!(by_light < 0.02 && evenly > 5.0 * by_light, "{by_light} {evenly}");
    }

    #[test]
    fn black_environments_are_sampled_as_white_ones() {
        let [black, white] = [0.0, 1.0]
            .map(|value| EnvironmentSampler::new(&Environment { width: 3, height: 2, pixels: vec![[value; 3]; 6] }));
        for index in 0..20 {
            let (direction, density) = black.direction(low_discrepancy(index, [0.1; 2]));
            assert!(density > 0.0 && direction.iter().all(|c| c.is_finite()));
            assert_eq!((direction, density), white.direction(low_discrepancy(index, [0.1; 2])));
        }
    }
}
