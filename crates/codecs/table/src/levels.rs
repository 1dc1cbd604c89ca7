//! Levels of detail of a factored pack: rows of its curve, each for a surface with bumps twice as steep as in the row
//! before. The bumps are too small for single pixels.
//!
//! A bumpy surface spreads half vectors. Its average over a pixel is the same material with a blurred distribution over
//! `θ_h` (the idea of Toksvig 2005 and of LEAN mapping, Olano and Baker 2010). Blurred logarithms would darken. This module
//! blurs the values instead, by diffusion, which preserves their sum and leaves matte materials unchanged.

use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::Angles;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Maximum number of levels below the finest.
pub const MAX_LEVELS: u32 = 6;
/// Standard deviation of the half vector's `x` and `y` at the level next to the finest; each further level doubles it.
const FINEST_SPREAD: f64 = 1.0 / 64.0;
/// Number of rings of half vectors, in equal steps of the angle's square root.
const RINGS: usize = 256;
/// Number of sampled positions of `θ_d`, `φ_d` and `φ_h` on each ring.
const PLACES: [usize; 3] = [12, 16, 4];
/// Steps of the diffusion from one level to the next.
const STEPS: usize = 16;

/// Contribution of each level to the logarithm at nodes of a curve: `[level][node]`, the finest first, whose row is 0.
///
/// `value` is `f + μ ε` of the finest level.
pub fn rows(value: impl Fn(DirectionPair) -> [f64; 3] + Sync, levels: u32, nodes: usize) -> Vec<Vec<[f64; 3]>> {
    let rings = Rings::new(&value);
    let mut rows = vec![vec![[0.0; 3]; nodes]];
    let mut spread = rings.values.clone();
    let mut variance = 0.0;
    for level in 1..=levels {
        let target = (FINEST_SPREAD * f64::from(1u32 << (level - 1))).powi(2);
        spread = rings.diffused(spread, 0.5 * (target - variance));
        variance = target;
        let added: Vec<[f64; 3]> = spread
            .iter()
            .zip(&rings.values)
            .map(|(after, before)| {
                std::array::from_fn(
                    |c| if before[c] > 0.0 && after[c] > 0.0 { (after[c] / before[c]).ln() } else { 0.0 },
                )
            })
            .collect();
        rows.push((0..nodes).map(|node| along(&added, node as f64 / (nodes - 1) as f64)).collect());
    }
    rows
}

/// Values of the rings at a share of the square root of the largest angle, linear between the rings' middles.
fn along(rings: &[[f64; 3]], share: f64) -> [f64; 3] {
    let at = (share * RINGS as f64 - 0.5).clamp(0.0, (RINGS - 1) as f64);
    let lower = (at as usize).min(RINGS - 2);
    let weight = at - lower as f64;
    std::array::from_fn(|c| rings[lower][c] + weight * (rings[lower + 1][c] - rings[lower][c]))
}

/// Means over rings of half vectors.
struct Rings {
    /// Mean value of each ring.
    values: Vec<[f64; 3]>,
    /// Weight of each ring in the light that a surface reflects under uniform illumination.
    masses: Vec<f64>,
    /// Conductance between a ring and the next one.
    passes: Vec<f64>,
}

impl Rings {
    fn new(value: &(impl Fn(DirectionPair) -> [f64; 3] + Sync)) -> Self {
        let theta = |ring: f64| (ring / RINGS as f64).powi(2) * FRAC_PI_2;
        let means: Vec<([f64; 3], f64)> =
            (0..RINGS).into_par_iter().map(|ring| mean(value, ring, theta(ring as f64 + 0.5))).collect();
        let radius = |ring: usize| theta(ring as f64).sin();
        let areas: Vec<f64> = (0..RINGS).map(|ring| 0.5 * (radius(ring + 1).powi(2) - radius(ring).powi(2))).collect();
        let masses: Vec<f64> = means.iter().zip(&areas).map(|((_, weight), area)| weight * area).collect();
        let middle = |ring: usize| theta(ring as f64 + 0.5).sin();
        let pass = |ring: usize| {
            let density = 0.5 * (means[ring].1 + means[ring + 1].1);
            density * radius(ring + 1) / (middle(ring + 1) - middle(ring))
        };
        let passes = (0..RINGS - 1).map(pass).collect();
        Self { values: means.into_iter().map(|(value, _)| value).collect(), masses, passes }
    }

    /// Values after diffusion for a time, in implicit steps. Each preserves `Σ mass value` and leaves constants
    /// unchanged.
    fn diffused(&self, mut values: Vec<[f64; 3]>, time: f64) -> Vec<[f64; 3]> {
        let step = time / STEPS as f64;
        for _ in 0..STEPS {
            for channel in 0..3 {
                let mut diagonal = self.masses.clone();
                for (ring, pass) in self.passes.iter().enumerate() {
                    diagonal[ring] += step * pass;
                    diagonal[ring + 1] += step * pass;
                }
                let mut right: Vec<f64> = values.iter().zip(&self.masses).map(|(v, mass)| v[channel] * mass).collect();
                for (ring, pass) in self.passes.iter().enumerate() {
                    let share = step * pass / diagonal[ring];
                    diagonal[ring + 1] -= share * step * pass;
                    right[ring + 1] += share * right[ring];
                }
                let mut next = 0.0;
                for ring in (0..RINGS).rev() {
                    let pass = self.passes.get(ring).map_or(0.0, |pass| step * pass * next);
                    next = (right[ring] + pass) / diagonal[ring];
                    values[ring][channel] = next;
                }
            }
        }
        values
    }
}

/// The weighted mean of a ring at `θ_h`, and the mean weight of its pairs in the light that a surface reflects under
/// uniform illumination, per area of the half vector's disc.
fn mean(value: &impl Fn(DirectionPair) -> [f64; 3], ring: usize, theta_half: f64) -> ([f64; 3], f64) {
    let [differences, azimuths, turns] = PLACES;
    let mut sum = [0.0; 3];
    let mut weights = 0.0;
    for place in 0..differences * azimuths * turns {
        let (d, a, t) = (place % differences, place / differences % azimuths, place / differences / azimuths);
        // Positions of neighbouring rings are interleaved.
        let shifted = |k: usize, count: usize, by: f64| (k as f64 + (0.5 + by * ring as f64).fract()) / count as f64;
        let ratio = (d as f64 + 0.5) / differences as f64;
        let phi_difference = TAU * shifted(a, azimuths, 0.618_034);
        let phi_half = TAU * shifted(t, turns, 0.754_878);
        let largest = theta_half.cos().atan2(theta_half.sin() * phi_difference.cos().abs());
        let angles = Angles {
            theta_half: theta_half as f32,
            phi_half: phi_half as f32,
            ratio: ratio as f32,
            phi_difference: phi_difference as f32,
        };
        let pair = angles.pair();
        let theta_difference = ratio * largest;
        // dω_i dω_o = 4 cos θ_d dω_h dω_d, and dω_h is the disc's area over cos θ_h.
        let solid_angle = theta_difference.cos() * theta_difference.sin() * largest / theta_half.cos();
        let weight = (pair.incoming[2] * pair.outgoing[2]).max(0.0) * solid_angle;
        let found = value(pair);
        (0..3).for_each(|c| sum[c] += weight * found[c]);
        weights += weight;
    }
    let mean = if weights > 0.0 { sum.map(|s| s / weights) } else { sum };
    (mean, weights / (differences * azimuths * turns) as f64)
}
