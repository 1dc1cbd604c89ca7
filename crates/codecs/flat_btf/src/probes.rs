//! Errors of a decoded asset at random points of the reference plane.

use super::model::MesoModel;
use super::surface::Appearance;
use brdfc_formats::direction::{Vector, dot, from_polar};
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};
use brdfc_metrics::lab::{distance_squared, lab};
use brdfc_metrics::shown::{Shown, needed};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Differences in L*a*b* (ΔE of 1976); 1 is just visible side by side.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct ColourErrors {
    /// Number of probes that were compared.
    pub samples: usize,
    /// Mean ΔE over the probes.
    pub mean: f64,
    /// 95th percentile of the differences.
    pub p95: f64,
    /// Largest ΔE over the probes.
    pub max: f64,
    /// Number of probes at which the reference is neither black nor white.
    pub shown: usize,
}

impl ColourErrors {
    /// Summarises pairs of reference and decoded colour; all zero if there are none.
    pub fn new(pairs: &[([f32; 3], [f32; 3])]) -> Self {
        let mut differences: Vec<f64> = pairs.par_iter().map(|(truth, found)| difference(*truth, *found)).collect();
        differences.sort_by(f64::total_cmp);
        let mut shown = Shown::default();
        for (truth, _) in pairs {
            shown.add(truth.map(f64::from));
        }
        let samples = differences.len();
        let at = |share: f64| differences.get(((samples as f64 * share) as usize).min(samples.max(1) - 1));
        let mean = differences.iter().sum::<f64>() / samples.max(1) as f64;
        Self {
            samples,
            mean,
            p95: at(0.95).copied().unwrap_or(0.0),
            max: differences.last().copied().unwrap_or(0.0),
            shown: shown.count,
        }
    }

    /// Returns true if too few probes show anything for an error.
    pub fn show_nothing(&self) -> bool {
        self.shown < needed(self.samples)
    }
}

/// A point of the reference plane in tiles, with unit vectors to the viewer and to the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Point of the plane, in tiles.
    pub at: [f64; 2],
    /// Direction to the viewer.
    pub view: Vector,
    /// Direction to the light.
    pub light: Vector,
}

/// Random places at which an asset is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Probes(Vec<Place>);

/// Seed of the probes.
const SEED: u64 = 0xb7f0;

impl Probes {
    /// Places with random directions, uniform by solid angle, each at most as steep as the steepest sampled one.
    pub fn between(count: usize, views: &[Vector], lights: &[Vector]) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 1);
        let place = |_| Place {
            at: [random.random(), random.random()],
            view: random_between(views, &mut random),
            light: random_between(lights, &mut random),
        };
        Self((0..count).map(place).collect())
    }

    /// Places with random sampled directions, and the indices of view and light of each.
    pub fn at_samples(count: usize, views: &[Vector], lights: &[Vector]) -> (Self, Vec<[usize; 2]>) {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let place = |_| {
            let at = [random.random(), random.random()];
            let pair = [random.random_range(0..views.len()), random.random_range(0..lights.len())];
            (Place { at, view: views[pair[0]], light: lights[pair[1]] }, pair)
        };
        let (places, pairs) = (0..count).map(place).unzip();
        (Self(places), pairs)
    }

    /// The places, in their order.
    pub fn places(&self) -> &[Place] {
        &self.0
    }

    /// Differences of the decoded values, at the finest level, from one value for each place. `directions` are those of
    /// the decoder's reflectance.
    ///
    /// # Panics
    /// Panics if there are fewer values than places.
    pub fn errors(
        &self,
        decoder: &FlatBtfDecoder,
        directions: Option<&SampledDirections>,
        truths: &[[f32; 3]],
    ) -> ColourErrors {
        let single = |v: Vector| v.map(|c| c as f32);
        let pair = |(at, place): (usize, &Place)| {
            let uv = place.at.map(|c| c as f32);
            (truths[at], decoder.shaded(directions, uv, 0.0, single(place.view), single(place.light)))
        };
        ColourErrors::new(&self.0.par_iter().enumerate().map(pair).collect::<Vec<_>>())
    }
}

/// Returns a random direction, uniform by solid angle and at most as steep as the steepest of `all`.
pub fn random_between(all: &[Vector], random: &mut ChaCha8Rng) -> Vector {
    let lowest = all.iter().map(|d| d[2]).fold(1.0, f64::min);
    let z = lowest + (1.0 - lowest) * random.random::<f64>();
    from_polar(z.acos(), TAU * random.random::<f64>())
}

/// Relative radiance of the surface behind a point of the reference plane under direct light, with cast shadows or without:
/// then all parts that face the light are lit.
pub fn direct_radiance(
    model: &MesoModel,
    appearance: &Appearance,
    Place { at, view, light }: Place,
    shadows: bool,
) -> [f32; 3] {
    let point = model.point(&model.seen(at, view).hit);
    if dot(point.normal, light) > 0.0 && (!shadows || model.caster.sees_sky(&point, light)) {
        appearance.relative_radiance(&point, view, light)
    } else {
        [0.0; 3]
    }
}

/// ΔE (CIE76) of two linear colours.
pub fn difference(a: [f32; 3], b: [f32; 3]) -> f64 {
    f64::from(distance_squared(lab(a), lab(b))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values above 1 look white, however they differ.
    #[test]
    fn black_and_white_probes_show_nothing() {
        let errors = |truth: fn(usize) -> f32| {
            let pairs: Vec<_> = (0..2000).map(|probe| ([truth(probe); 3], [0.5; 3])).collect();
            ColourErrors::new(&pairs)
        };
        assert!(errors(|probe| 1.5 + 0.01 * probe as f32).show_nothing());
        assert!(errors(|probe| if probe == 0 { 0.5 } else { 0.0 }).show_nothing());
        assert!(!errors(|probe| if probe < 2 { 0.5 } else { 0.0 }).show_nothing());
        assert!(ColourErrors::new(&[]).show_nothing());
    }
}
