//! Radiance that a surface reflects from an environment, without visibility: equation 1 of Bagher et al. 2012,
//! "Interactive rendering of acquired materials on dynamic geometry using bandwidth prediction".

use super::lobe_sampler::LobeSampler;
use super::scene::Environment;
use super::shade::Reflectance;
use super::shading_point::ShadingPoint;
use brdfc_formats::direction::{DirectionPair, Vector};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Number of runs of samples whose spread gives the error.
const RUNS: usize = 16;

/// A Monte Carlo estimate of an integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Linear RGB, W/(m² sr).
    pub radiance: Vector,
    /// Standard error of each channel, from the spread of 16 runs of the sampler's sequence. Runs of a sequence that
    /// fills space evenly compensate for each other's gaps, so their mean is better than this.
    pub error: Vector,
    /// Number of samples.
    pub samples: usize,
}

/// `L(ω) f_r(ω, ω_o) cos θ` for a direction of the local frame; 0 at the horizon and below.
pub fn integrand(
    point: &ShadingPoint,
    environment: &Environment,
    material: &dyn Reflectance,
    incoming: Vector,
) -> Vector {
    if incoming[2] <= 0.0 || incoming[2].is_nan() {
        return [0.0; 3];
    }
    let f_r = material.eval(DirectionPair::new(incoming, point.outgoing), point.distance);
    let light = environment.at(point.world(incoming));
    [0, 1, 2].map(|k| f_r[k] * light[k] * incoming[2])
}

/// Mean over the first `samples` directions of a sampler, rounded up to 16 runs of the same length.
///
/// The sampler must reach every direction that reflects light.
pub fn reflected(
    point: &ShadingPoint,
    environment: &Environment,
    material: &dyn Reflectance,
    sampler: &dyn LobeSampler,
    samples: usize,
) -> Estimate {
    let length = samples.div_ceil(RUNS).max(1);
    let run = |run: usize| {
        let mut sum = [0.0; 3];
        for index in run * length..(run + 1) * length {
            let (incoming, inverse_density) = sampler.sample(point.outgoing, index);
            if inverse_density > 0.0 {
                let value = integrand(point, environment, material, incoming);
                (0..3).for_each(|k| sum[k] += value[k] * inverse_density);
            }
        }
        sum.map(|s| s / length as f64)
    };
    let runs: Vec<Vector> = (0..RUNS).map(run).collect();
    let radiance = [0, 1, 2].map(|k| runs.iter().map(|run| run[k]).sum::<f64>() / RUNS as f64);
    let error = [0, 1, 2].map(|k| {
        let squares: f64 = runs.iter().map(|run| (run[k] - radiance[k]).powi(2)).sum();
        (squares / (RUNS * (RUNS - 1)) as f64).sqrt()
    });
    Estimate { radiance, error, samples: length * RUNS }
}

/// The integral as a sum over all texels, each divided into `per_side²` equal solid angles: slow, and independent of
/// samplers. Its error is proportional to `1 / per_side²` if lobe and environment are smooth.
pub fn quadrature(
    point: &ShadingPoint,
    environment: &Environment,
    material: &dyn Reflectance,
    per_side: usize,
) -> Vector {
    let (width, height) = (environment.width, environment.height);
    let middle = |step: usize| (step as f64 + 0.5) / per_side as f64;
    let row = |row: usize| {
        let [above, below] = [row, row + 1].map(|edge| (PI * edge as f64 / height as f64).cos());
        let mut sum = [0.0; 3];
        for down in 0..per_side {
            let y = above + middle(down) * (below - above);
            let sine = (1.0 - y * y).sqrt();
            for (column, right) in (0..width).flat_map(|column| (0..per_side).map(move |right| (column, right))) {
                let azimuth = TAU * (column as f64 + middle(right)) / width as f64;
                let direction = [sine * azimuth.cos(), y, sine * azimuth.sin()];
                let value = integrand(point, environment, material, point.local(direction));
                (0..3).for_each(|k| sum[k] += value[k]);
            }
        }
        let each = texel_solid_angle(row, width, height) / (per_side * per_side) as f64;
        sum.map(|s| s * each)
    };
    let rows: Vec<Vector> = (0..height).into_par_iter().map(row).collect();
    [0, 1, 2].map(|k| rows.iter().map(|row| row[k]).sum())
}

/// Solid angle of each texel of a row, sr.
pub(crate) fn texel_solid_angle(row: usize, width: usize, height: usize) -> f64 {
    let [above, below] = [row, row + 1].map(|edge| (PI * edge as f64 / height as f64).cos());
    (above - below) * TAU / width as f64
}

#[cfg(test)]
mod tests;
