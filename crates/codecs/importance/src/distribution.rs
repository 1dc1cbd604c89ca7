//! Inversion of a tabulated cumulative distribution over half vectors.

use super::HalfGrid;
use std::f64::consts::TAU;

/// A density over half vectors that is constant in each cell. Sampling first draws a ring, then a cell of the ring.
#[derive(Debug, Clone)]
pub struct Distribution {
    grid: HalfGrid,
    /// For each ring, the probability of all previous rings, followed by 1.
    rings: Vec<f64>,
    /// For each ring, the conditional probability of the previous cells of each cell given the ring, followed by 1.
    cells: Vec<f64>,
    /// `1 - cos` of the ring borders.
    borders: Vec<f64>,
}

impl Distribution {
    /// Creates the distribution with a positive weight for each cell of `grid`, ring by ring.
    pub fn new(grid: HalfGrid, weights: &[f64]) -> Self {
        let mut rings = Vec::with_capacity(grid.polar + 1);
        let mut cells = Vec::with_capacity(grid.polar * (grid.azimuths + 1));
        rings.push(0.0);
        for ring in weights.chunks_exact(grid.azimuths) {
            let sum = accumulate(ring, &mut cells);
            rings.push(rings.last().copied().unwrap_or(0.0) + sum);
        }
        let total = rings.last().copied().unwrap_or(1.0);
        rings.iter_mut().for_each(|sum| *sum /= total);
        let borders = (0..=grid.polar).map(|ring| grid.border(ring)).collect();
        Self { grid, rings, cells, borders }
    }

    /// Maps a point of the unit square to a half vector and its density per steradian.
    pub fn sample(&self, [u, v]: [f64; 2]) -> [f32; 4] {
        let (ring, across) = invert(&self.rings, u);
        let (cell, along) = invert(self.ring(ring), v);
        let t = self.borders[ring] + across * (self.borders[ring + 1] - self.borders[ring]);
        let phi = (cell as f64 + along) * TAU / self.grid.azimuths as f64;
        let r = (t * (2.0 - t)).sqrt();
        [r * phi.cos(), r * phi.sin(), 1.0 - t, self.density(ring, cell)].map(|c| c as f32)
    }

    /// Density per steradian of half vectors in a cell.
    pub fn density(&self, ring: usize, cell: usize) -> f64 {
        let cells = self.ring(ring);
        let probability = (self.rings[ring + 1] - self.rings[ring]) * (cells[cell + 1] - cells[cell]);
        probability * self.grid.azimuths as f64 / ((self.borders[ring + 1] - self.borders[ring]) * TAU)
    }

    /// Density per steradian at a unit half vector above the horizon.
    pub fn density_at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let ring = self.borders[1..self.grid.polar].partition_point(|border| *border <= 1.0 - z);
        let turn = y.atan2(x).rem_euclid(TAU) / TAU;
        let cell = ((turn * self.grid.azimuths as f64) as usize).min(self.grid.azimuths - 1);
        self.density(ring, cell)
    }

    fn ring(&self, ring: usize) -> &[f64] {
        &self.cells[ring * (self.grid.azimuths + 1)..][..self.grid.azimuths + 1]
    }
}

/// Appends the cumulative distribution of some weights, from 0 to 1, and returns their sum.
fn accumulate(weights: &[f64], cumulative: &mut Vec<f64>) -> f64 {
    let total: f64 = weights.iter().sum();
    let mut sum = 0.0;
    cumulative.push(0.0);
    for weight in weights {
        sum += weight;
        cumulative.push(sum / total);
    }
    if let Some(last) = cumulative.last_mut() {
        *last = 1.0;
    }
    total
}

/// The interval of a cumulative distribution that contains `u`, and the position of `u` in it, 0 to 1.
fn invert(cumulative: &[f64], u: f64) -> (usize, f64) {
    let step = cumulative.partition_point(|sum| *sum <= u).clamp(1, cumulative.len() - 1) - 1;
    let height = cumulative[step + 1] - cumulative[step];
    let inside = if height > 0.0 { (u - cumulative[step]) / height } else { 0.5 };
    (step, inside.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inversion_by_hand() {
        let cumulative = [0.0, 0.25, 0.25, 0.75, 1.0];
        for (u, expected) in [(0.0, (0, 0.0)), (0.125, (0, 0.5)), (0.25, (2, 0.0)), (0.5, (2, 0.5)), (0.875, (3, 0.5))]
        {
            assert_eq!(invert(&cumulative, u), expected);
        }
        assert_eq!(invert(&cumulative, 1.0), (3, 1.0));
    }

    #[test]
    fn equal_weights_per_steradian_are_the_uniform_hemisphere() {
        let grid = HalfGrid { polar: 16, azimuths: 8 };
        let weights: Vec<f64> = (0..grid.cells()).map(|at| grid.solid_angle(at / 8)).collect();
        let distribution = Distribution::new(grid, &weights);
        for (u, v) in [(0.1, 0.3), (0.5, 0.5), (0.9, 0.99)] {
            let [x, y, z, density] = distribution.sample([u, v]);
            let phi = TAU * v;
            let r = (1.0 - (1.0 - u) * (1.0 - u)).sqrt();
            for (found, expected) in
                [x, y, z, density].into_iter().zip([r * phi.cos(), r * phi.sin(), 1.0 - u, 1.0 / TAU])
            {
                assert!((f64::from(found) - expected).abs() < 1e-6, "{found} {expected}");
            }
        }
    }
}
