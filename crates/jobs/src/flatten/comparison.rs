//! Compares the decoded values of two flat BTFs of one surface at the same places, views and lights.

use brdfc_flat_btf::probes::{ColourErrors, random_between};
use brdfc_formats::direction_set::DirectionSet;
use brdfc_render::flat::FlatMaterial;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const LOOK_UPS: usize = 65_536;
const SEED: u64 = 0xf1a7;

/// Measures `other` against `reference`, at random places of the tile at the finest level, and at random views and lights up to
/// 75 degrees from the normal, uniform by solid angle.
pub fn compare_flat(reference: &FlatMaterial, other: &FlatMaterial) -> ColourErrors {
    let directions = DirectionSet::ubo2003().directions();
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let look_up = |_| {
        let at = [random.random(), random.random()];
        (at, [random_between(&directions, &mut random), random_between(&directions, &mut random)])
    };
    let look_ups: Vec<([f64; 2], _)> = (0..LOOK_UPS).map(look_up).collect();
    let one = |(at, [view, light]): &([f64; 2], [_; 2])| {
        let value = |material: &FlatMaterial| material.value(at.map(|c| c as f32), 0.0, *view, *light);
        (value(reference), value(other))
    };
    ColourErrors::new(&look_ups.par_iter().map(one).collect::<Vec<_>>())
}
