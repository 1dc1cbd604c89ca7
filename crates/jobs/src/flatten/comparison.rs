//! Compares the decoded values of two flat BTFs of one surface at the same places, views and lights.

use brdfc_flat_btf::probes::{ColourErrors, difference, random_between};
use brdfc_formats::direction::{Vector, from_polar};
use brdfc_render::flat::{FlatForm, FlatMaterial};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Look-ups of each kind.
const LOOK_UPS: usize = 65_536;
const SEED: u64 = 0xf1a7;

/// Differences between two flat BTFs, at random places of the tile, at the finest level, in the full form.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct FlatComparison {
    /// Differences at views and lights of the reference.
    pub at_samples: ColourErrors,
    /// Differences at random views and lights, uniform by solid angle, no steeper than the steepest of the reference.
    pub between_samples: ColourErrors,
    /// Number of look-ups of both kinds where the reference is not black.
    pub lit: usize,
}

/// Measures `other` against `reference`. Returns `None` if the reference has no values for views.
pub fn compare_flat(reference: &FlatMaterial, other: &FlatMaterial) -> Option<FlatComparison> {
    let sampled = reference.decoder().parts().values.directions()?.map(|angles| {
        let unit = |[polar, azimuth]: &[f32; 2]| from_polar(f64::from(*polar), f64::from(*azimuth));
        angles.iter().map(unit).collect::<Vec<Vector>>()
    });
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut look_ups = |choose: &dyn Fn(usize, &mut ChaCha8Rng) -> Vector| -> Vec<([f64; 2], [Vector; 2])> {
        let one = |_| {
            let at = [random.random(), random.random()];
            (at, [choose(0, &mut random), choose(1, &mut random)])
        };
        (0..LOOK_UPS).map(one).collect()
    };
    let at_samples = look_ups(&|kind, random| sampled[kind][random.random_range(0..sampled[kind].len())]);
    let between = look_ups(&|kind, random| random_between(&sampled[kind], random));
    let measured = |look_ups: &[([f64; 2], [Vector; 2])]| {
        let one = |(at, [view, light]): &([f64; 2], [Vector; 2])| {
            let value = |material: &FlatMaterial| material.value(FlatForm::Full, *at, 0.0, *view, *light);
            let (truth, found) = (value(reference), value(other));
            (difference(truth, found), truth != [0.0; 3])
        };
        let (differences, lit): (Vec<f64>, Vec<bool>) = look_ups.par_iter().map(one).unzip();
        (ColourErrors::new(differences), lit.into_iter().filter(|lit| *lit).count())
    };
    let ((at_samples, first), (between_samples, second)) = (measured(&at_samples), measured(&between));
    Some(FlatComparison { at_samples, between_samples, lit: first + second })
}
