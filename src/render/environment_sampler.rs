//! Importance sampling of environments.

use super::lobe_sampler::{LobeSampler, low_discrepancy};
use super::scene::Environment;
use super::surface_point::SurfacePoint;
use crate::metrics::image::luminance;
use brdfc_formats::direction::Vector;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// World-space directions as dense as an environment is bright there, by cumulative distributions of rows and of columns
/// in each row.
///
/// The density is constant over the solid angle of a texel, and follows the mean luminance of the bilinear look-up over
/// it: wherever that is not 0 samples go.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentSampler {
    width: usize,
    height: usize,
    /// Share of the rows up to and including each.
    rows: Vec<f64>,
    /// In each row, share of the columns up to and including each.
    columns: Vec<f64>,
    /// Per texel, 1/sr.
    density: Vec<f64>,
}

impl EnvironmentSampler {
    /// The sampler of an environment. One that is black everywhere is sampled evenly.
    ///
    /// # Panics
    /// If the environment has no pixels, or not as many as its size says.
    pub fn new(environment: &Environment) -> Self {
        let (width, height) = (environment.width, environment.height);
        assert!(width > 0 && environment.pixels.len() == width * height && height > 0, "pixels of this size");
        let mut density = mean_luminance(environment);
        if density.iter().all(|value| *value == 0.0) {
            density.fill(1.0);
        }
        let mut columns = density.clone();
        let sums: Vec<f64> = columns.par_chunks_mut(width).map(to_shares).collect();
        let mut rows: Vec<f64> =
            sums.iter().enumerate().map(|(row, sum)| sum * texel_solid_angle(row, width, height)).collect();
        let total = to_shares(&mut rows);
        density.par_iter_mut().for_each(|value| *value /= total);
        Self { width, height, rows, columns, density }
    }

    /// The direction at a point of the unit square, world space, and its density, 1/sr.
    pub fn direction(&self, [u, v]: [f64; 2]) -> (Vector, f64) {
        let (row, down) = place(&self.rows, u);
        let (column, right) = place(&self.columns[row * self.width..(row + 1) * self.width], v);
        // Even in solid angle: in the cosine of the colatitude, and in azimuth.
        let [above, below] = [row, row + 1].map(|edge| (PI * edge as f64 / self.height as f64).cos());
        let y = above + down * (below - above);
        let azimuth = TAU * (column as f64 + right) / self.width as f64;
        let sine = (1.0 - y * y).max(0.0).sqrt();
        ([sine * azimuth.cos(), y, sine * azimuth.sin()], self.density[row * self.width + column])
    }

    /// Density of a world-space direction, a unit vector, 1/sr.
    pub fn density(&self, direction: Vector) -> f64 {
        let [x, y, z] = direction;
        let azimuth = z.atan2(x).rem_euclid(TAU);
        let texel = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
        let row = texel(y.clamp(-1.0, 1.0).acos() / PI, self.height);
        self.density[row * self.width + texel(azimuth / TAU, self.width)]
    }
}

/// Luminance of the bilinear look-up, mean over each texel: 6/8 of its own in each direction, 1/8 of either neighbour's.
fn mean_luminance(environment: &Environment) -> Vec<f64> {
    let (width, height) = (environment.width, environment.height);
    let at = |row: usize, column: usize| {
        let value = luminance(environment.pixels[row * width + column]);
        if value.is_finite() { value.max(0.0) } else { 0.0 }
    };
    let along_row = |row: usize, column: usize| {
        0.75 * at(row, column) + 0.125 * (at(row, (column + width - 1) % width) + at(row, (column + 1) % width))
    };
    let texel = |index: usize| {
        let (row, column) = (index / width, index % width);
        let (above, below) = (row.saturating_sub(1), (row + 1).min(height - 1));
        0.75 * along_row(row, column) + 0.125 * (along_row(above, column) + along_row(below, column))
    };
    (0..width * height).into_par_iter().map(texel).collect()
}

/// Solid angle of each texel of a row, sr.
pub(super) fn texel_solid_angle(row: usize, width: usize, height: usize) -> f64 {
    let [above, below] = [row, row + 1].map(|edge| (PI * edge as f64 / height as f64).cos());
    (above - below) * TAU / width as f64
}

/// Weights to running sums as shares of their total, which is returned. Without any weight all are alike.
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

/// The step of a cumulative distribution that a share falls on, and where on the step, 0 to 1.
fn place(cumulative: &[f64], share: f64) -> (usize, f64) {
    let step = cumulative.partition_point(|running| *running <= share).min(cumulative.len() - 1);
    let before = if step == 0 { 0.0 } else { cumulative[step - 1] };
    let length = cumulative[step] - before;
    (step, if length > 0.0 { ((share - before) / length).clamp(0.0, 1.0) } else { 0.5 })
}

/// An environment's sampler as seen from a surface: its directions in the local frame. Some are below the horizon.
#[derive(Debug, Clone, Copy)]
pub struct FramedEnvironmentSampler<'a> {
    /// In world space.
    pub environment: &'a EnvironmentSampler,
    /// Whose frame.
    pub point: &'a SurfacePoint,
    /// Moves the sequence, see [`low_discrepancy`].
    pub shift: [f64; 2],
}

impl LobeSampler for FramedEnvironmentSampler<'_> {
    fn sample(&self, _: Vector, index: usize) -> (Vector, f64) {
        let (direction, density) = self.environment.direction(low_discrepancy(index, self.shift));
        (self.point.local(direction), if density > 0.0 { 1.0 / density } else { 0.0 })
    }

    fn pdf(&self, _: Vector, incoming: Vector) -> f64 {
        self.environment.density(self.point.world(incoming))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dark, with a few bright texels, one beside a pole and one at the seam.
    fn spots() -> Environment {
        let (width, height) = (24, 12);
        let mut pixels = vec![[0.01; 3]; width * height];
        for (row, column, value) in [(0, 5, 30.0), (6, 23, 50.0), (8, 11, 90.0)] {
            pixels[row * width + column] = [value, 0.5 * value, 0.1 * value];
        }
        Environment { width, height, pixels }
    }

    #[test]
    fn densities_sum_to_1_and_follow_the_light() {
        let environment = spots();
        let sampler = EnvironmentSampler::new(&environment);
        let sum: f64 = (0..24 * 12).map(|i| sampler.density[i] * texel_solid_angle(i / 24, 24, 12)).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        let total: f64 = (0..12).map(|row| 24.0 * texel_solid_angle(row, 24, 12)).sum();
        assert!((total - 4.0 * PI).abs() < 1e-12);
        // The bilinear look-up reaches the neighbours, and across the seam.
        let density = |row: usize, column: usize| sampler.density[row * 24 + column];
        assert!((density(8, 11) / density(8, 12) - 6.0).abs() < 0.1);
        assert!(density(6, 0) > 100.0 * density(6, 2));
    }

    #[test]
    fn directions_have_their_density() {
        let sampler = EnvironmentSampler::new(&spots());
        let mut counts = vec![0usize; 24 * 12];
        let samples = 1 << 16;
        for index in 0..samples {
            let (direction, density) = sampler.direction(low_discrepancy(index, [0.0; 2]));
            assert!((direction.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
            let texel = sampler.density.iter().position(|value| *value == density).unwrap();
            assert!((sampler.density(direction) - density).abs() < 1e-9 || index % 64 == 0, "texel {texel}");
            let azimuth = direction[2].atan2(direction[0]).rem_euclid(TAU);
            let (row, column) = (direction[1].acos() / PI * 12.0, azimuth / TAU * 24.0);
            counts[row as usize * 24 + column as usize] += 1;
        }
        for (texel, count) in counts.iter().enumerate() {
            let expected = sampler.density[texel] * texel_solid_angle(texel / 24, 24, 12);
            let found = *count as f64 / samples as f64;
            assert!((found - expected).abs() < 0.03 * expected + 2e-4, "{texel}: {found} {expected}");
        }
    }

    /// The integral of luminance, which even sampling of the sphere misses by far.
    #[test]
    fn few_samples_find_small_sources() {
        let environment = spots();
        let sampler = EnvironmentSampler::new(&environment);
        let look_up = |d: Vector| {
            let [r, g, b] = environment.at(d);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let fine = |index: usize| {
            let (row, column) = (index / 960, index % 960);
            let (theta, phi) = (PI * (row as f64 + 0.5) / 480.0, TAU * (column as f64 + 0.5) / 960.0);
            let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
            look_up(d) * texel_solid_angle(row, 960, 480)
        };
        let exact: f64 = (0..960 * 480).map(fine).sum();
        let samples = 512;
        let by_light = |index| {
            let (d, density) = sampler.direction(low_discrepancy(index, [0.0; 2]));
            look_up(d) / density
        };
        let found = (0..samples).map(by_light).sum::<f64>() / samples as f64;
        assert!((found / exact - 1.0).abs() < 0.03, "{found} {exact}");
        let even = EnvironmentSampler::new(&Environment { pixels: vec![[1.0; 3]; 24 * 12], ..environment.clone() });
        let evenly = |index| {
            let (d, density) = even.direction(low_discrepancy(index, [0.0; 2]));
            look_up(d) / density
        };
        let found = (0..samples).map(evenly).sum::<f64>() / samples as f64;
        assert!((found / exact - 1.0).abs() > 0.03, "{found} {exact}");
    }

    #[test]
    fn black_environments_are_sampled_evenly() {
        let black = Environment { width: 3, height: 2, pixels: vec![[0.0; 3]; 6] };
        let sampler = EnvironmentSampler::new(&black);
        for index in 0..20 {
            let (direction, density) = sampler.direction(low_discrepancy(index, [0.0; 2]));
            assert!((density * 4.0 * PI - 1.0).abs() < 1e-12 && direction.iter().all(|c| c.is_finite()));
        }
    }
}
