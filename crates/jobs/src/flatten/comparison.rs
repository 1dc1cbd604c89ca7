//! Compares the decoded values of two flat BTFs of one surface at the same places, views and lights.

use brdfc_flat_btf::probes::{ColourErrors, difference, random_between};
use brdfc_formats::direction_set::DirectionSet;
use brdfc_render::flat::FlatMaterial;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const LOOK_UPS: usize = 65_536;
const SEED: u64 = 0xf1a7;

/// Differences between two flat BTFs, at random places of the tile, at the finest level.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FlatComparison {
    /// Differences at random views and lights up to 75 degrees from the normal, uniform by solid angle.
    pub errors: ColourErrors,
    /// Number of look-ups at which the reference is not black.
    pub lit: usize,
}

/// Measures `other` against `reference`.
pub fn compare_flat(reference: &FlatMaterial, other: &FlatMaterial) -> FlatComparison {
    let directions = DirectionSet::ubo2003().directions();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let look_up = |_| {
        let at = [random.random(), random.random()];
        (at, [random_between(&directions, &mut random), random_between(&directions, &mut random)])
    };
    let look_ups: Vec<([f64; 2], _)> = (0..LOOK_UPS).map(look_up).collect();
    let one = |(at, [view, light]): &([f64; 2], [_; 2])| {
        let value = |material: &FlatMaterial| material.value(at.map(|c| c as f32), 0.0, *view, *light);
        let (truth, found) = (value(reference), value(other));
        (difference(truth, found), truth != [0.0; 3])
    };
    let (differences, lit): (Vec<f64>, Vec<bool>) = look_ups.par_iter().map(one).unzip();
    FlatComparison { errors: ColourErrors::new(differences), lit: lit.into_iter().filter(|lit| *lit).count() }
}
