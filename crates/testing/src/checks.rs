//! Worst violations of the laws of reflectance, for any source. Every check is itself tested on a source that violates
//! it.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, from_polar};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// `f_r` at a pair, without a tally.
pub fn value(source: &dyn Source, pair: DirectionPair) -> [f64; 3] {
    source.eval(pair, &mut Tally::default())
}

/// Pairs uniform in polar angle (to 1.5 rad) and azimuth, the same on every run.
pub fn random_pairs(count: usize) -> Vec<DirectionPair> {
    let mut generator = ChaCha8Rng::seed_from_u64(7);
    let mut uniform = move || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    (0..count)
        .map(|_| DirectionPair::from_angles(1.5 * uniform(), TAU * uniform(), 1.5 * uniform(), TAU * uniform()))
        .collect()
}

/// Largest relative difference between a source at pairs and at their images.
fn worst_change(source: &dyn Source, images: impl Fn(DirectionPair) -> Vec<DirectionPair>) -> f64 {
    let mut worst: f64 = 0.0;
    for pair in random_pairs(2000) {
        let here = value(source, pair);
        for image in images(pair) {
            let there = value(source, image);
            for c in 0..3 {
                assert!(here[c].is_finite() && there[c].is_finite(), "{pair:?}");
                let scale = here[c].abs().max(there[c].abs());
                worst = worst.max(if scale > 0.0 { (here[c] - there[c]).abs() / scale } else { 0.0 });
            }
        }
    }
    worst
}

/// Worst relative violation of reciprocity.
pub fn reciprocity(source: &dyn Source) -> f64 {
    worst_change(source, |p| vec![p.exchanged()])
}

/// Worst relative violation of mirror symmetry in `x = 0` and in `y = 0`.
pub fn mirror(source: &dyn Source) -> f64 {
    worst_change(source, |p| {
        let flipped = |k: usize| {
            let flip = |mut v: Vector| {
                v[k] = -v[k];
                v
            };
            DirectionPair::new(flip(p.incoming), flip(p.outgoing))
        };
        vec![flipped(0), flipped(1)]
    })
}

/// Worst relative violation of isotropy.
pub fn isotropy(source: &dyn Source) -> f64 {
    worst_change(source, |p| {
        let turned = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let turn = |v: Vector| [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
            DirectionPair::new(turn(p.incoming), turn(p.outgoing))
        };
        vec![turned(0.3), turned(1.9)]
    })
}

/// Directional albedo `∫ f_r cos θo dωo`, per channel, by the midpoint rule on `steps` x `4 steps` polar angles and azimuths.
pub fn albedo(source: &dyn Source, incoming: Vector, steps: usize) -> [f64; 3] {
    let (d_theta, d_phi) = (FRAC_PI_2 / steps as f64, TAU / (4 * steps) as f64);
    let mut sum = [0.0; 3];
    for row in 0..steps {
        let theta = (row as f64 + 0.5) * d_theta;
        // The exact integral of sin θ cos θ over the row, so that a constant has no error.
        let solid = 0.5 * ((theta + 0.5 * d_theta).sin().powi(2) - (theta - 0.5 * d_theta).sin().powi(2)) * d_phi;
        for column in 0..4 * steps {
            let outgoing = from_polar(theta, (column as f64 + 0.5) * d_phi - PI);
            let f = value(source, DirectionPair::new(incoming, outgoing));
            for c in 0..3 {
                sum[c] += f[c] * solid;
            }
        }
    }
    sum
}

/// Largest albedo of any channel over a spread of incoming directions.
pub fn largest_albedo(source: &dyn Source, steps: usize) -> f64 {
    let mut largest: f64 = 0.0;
    for theta in [0.0, 0.4, 0.8, 1.1, 1.3, 1.45] {
        for phi in [0.0, 0.8, FRAC_PI_2] {
            largest = albedo(source, from_polar(theta, phi), steps).into_iter().fold(largest, f64::max);
        }
    }
    largest
}
