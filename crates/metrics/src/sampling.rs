//! Fixed sets of directions to compare at: the same on every run and machine.

use brdfc_formats::direction::{DirectionPair, Vector, from_polar};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// `count` direction pairs, both directions uniform over the hemisphere's solid angle, from a seeded generator.
pub fn random_pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    let mut direction = || {
        let z: f64 = 1.0 - generator.random::<f64>();
        let r = (1.0 - z * z).max(0.0).sqrt();
        let phi = TAU * generator.random::<f64>();
        [r * phi.cos(), r * phi.sin(), z]
    };
    (0..count).map(|_| DirectionPair::new(direction(), direction())).collect()
}

/// `side²` directions with cosine density: the mean of `f` over them times π is the albedo.
pub fn cosine_directions(side: usize) -> Vec<Vector> {
    let step = 1.0 / side as f64;
    let mut directions = Vec::with_capacity(side * side);
    for a in 0..side {
        for b in 0..side {
            let r = ((a as f64 + 0.5) * step).sqrt();
            let phi = (b as f64 + 0.5) * step * TAU;
            directions.push([r * phi.cos(), r * phi.sin(), (1.0 - r * r).sqrt()]);
        }
    }
    directions
}

/// Incoming directions for albedo curves: 0 to 85 degrees in steps of 5, at the azimuths 0 and, for anisotropic
/// materials, 90 degrees.
pub fn albedo_directions(isotropic: bool) -> Vec<([f64; 2], Vector)> {
    let azimuths: &[f64] = if isotropic { &[0.0] } else { &[0.0, 90.0] };
    let mut directions = Vec::new();
    for phi in azimuths {
        for step in 0..18 {
            let theta = 5.0 * f64::from(step);
            directions.push(([theta, *phi], from_polar(theta.to_radians(), phi.to_radians())));
        }
    }
    directions
}
