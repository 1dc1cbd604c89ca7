//! Errors of the decoded asset against the surface, measured with random probes of the finished packs.
//!
//! Views of the flat BTF are added one by one, so that memory never holds all of them.

use super::model::MesoModel;
use super::rebuild::periodic_bilinear;
use super::surface::Appearance;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::{Vector, dot, from_polar};
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::{BlendedDirection, FlatBtfDecoder, FlatView, ViewWeights};
use brdfc_metrics::lab::{distance_squared, lab};
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
}

impl ColourErrors {
    /// Summarises differences; all zero if there are none.
    pub fn new(mut differences: Vec<f64>) -> Self {
        differences.sort_by(f64::total_cmp);
        let samples = differences.len();
        let at = |share: f64| differences.get(((samples as f64 * share) as usize).min(samples.max(1) - 1));
        let mean = differences.iter().sum::<f64>() / samples.max(1) as f64;
        Self { samples, mean, p95: at(0.95).copied().unwrap_or(0.0), max: differences.last().copied().unwrap_or(0.0) }
    }
}

/// One probe.
#[derive(Debug, Clone)]
struct Probe {
    at: [f32; 2],
    view: [f32; 3],
    light: [f32; 3],
    views: ([u32; 3], [f32; 3]),
    lights: ([u32; 3], [f32; 3]),
    /// Parameters according to the indirection map.
    parameters: [f32; 2],
    truth: [f32; 3],
    rebuilt: [f32; 3],
}

/// Probes at random points of the reference plane.
pub struct Probes(Vec<Probe>);

/// Seed of the probes.
const SEED: u64 = 0xb7f0;

/// Sampled directions and a mesh for blending between them.
pub struct Directions<'a> {
    /// All sampled directions, unit vectors.
    pub all: &'a [Vector],
    /// Triangulation of the directions.
    pub mesh: &'a DirectionMesh,
}

impl Directions<'_> {
    fn random(&self, random: &mut ChaCha8Rng) -> Vector {
        random_between(self.all, random)
    }
}

/// Returns a random direction, uniform by solid angle and at most as steep as the steepest of `all`.
pub fn random_between(all: &[Vector], random: &mut ChaCha8Rng) -> Vector {
    let lowest = all.iter().map(|d| d[2]).fold(1.0, f64::min);
    let z = lowest + (1.0 - lowest) * random.random::<f64>();
    from_polar(z.acos(), TAU * random.random::<f64>())
}

impl Probes {
    /// Creates `count` probes at sampled views and lights; `truth(view, light, at)` is the reference value.
    ///
    /// # Errors
    /// Returns the errors of `truth`.
    pub fn at_samples<E: Send>(
        count: usize,
        decoder: &FlatBtfDecoder,
        views: &[Vector],
        lights: &[Vector],
        truth: impl Fn(usize, usize, [f64; 2]) -> Result<[f32; 3], E> + Sync,
    ) -> Result<Self, E> {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        let chosen: Vec<([f64; 2], usize, usize)> = (0..count)
            .map(|k| {
                let at = [random.random(), random.random()];
                // Every view equally often.
                (at, k * views.len() / count, random.random_range(0..lights.len()))
            })
            .collect();
        let probe = |(at, view, light): &([f64; 2], usize, usize)| {
            let only = |index: usize| ([index as u32; 3], [1.0, 0.0, 0.0]);
            let truth = truth(*view, *light, *at)?;
            Ok(Probe::new(decoder, *at, (views[*view], only(*view)), (lights[*light], only(*light)), truth))
        };
        Ok(Self(chosen.par_iter().map(probe).collect::<Result<_, _>>()?))
    }

    /// Creates `count` probes at random views and lights between the samples, with the surface itself as reference.
    pub fn between_samples(
        count: usize,
        decoder: &FlatBtfDecoder,
        views: &Directions<'_>,
        lights: &Directions<'_>,
        model: &MesoModel,
        appearance: &Appearance,
    ) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(SEED + 1);
        let chosen: Vec<([f64; 2], Vector, Vector)> = (0..count)
            .map(|_| {
                let at = [random.random(), random.random()];
                (at, views.random(&mut random), lights.random(&mut random))
            })
            .collect();
        let single = |v: Vector| v.map(|c| c as f32);
        let probe = |(at, view, light): &([f64; 2], Vector, Vector)| {
            let truth = direct_radiance(model, appearance, *at, *view, *light);
            let (near_views, near_lights) = (views.mesh.weights(single(*view)), lights.mesh.weights(single(*light)));
            Probe::new(decoder, *at, (*view, near_views), (*light, near_lights), truth)
        };
        Self(chosen.par_iter().map(probe).collect())
    }

    /// Adds the contribution of a view.
    pub fn add_view(&mut self, view: &FlatView) {
        let index = view.header().view;
        let size = view.header().size as usize;
        self.0.par_iter_mut().for_each(|probe| {
            let share: f32 = (0..3).filter(|k| probe.views.0[*k] == index).map(|k| probe.views.1[k]).sum();
            if share > 0.0 {
                for (light, weight) in probe.lights.0.into_iter().zip(probe.lights.1).filter(|(_, w)| *w > 0.0) {
                    let texels = view.light(light);
                    let value = periodic_bilinear(size, probe.parameters, |texel| rgb9e5::decode(texels[texel]));
                    (0..3).for_each(|k| probe.rebuilt[k] += share * weight * value[k]);
                }
            }
        });
    }

    /// Errors of equation 1, after all views were added.
    pub fn full(&self) -> ColourErrors {
        ColourErrors::new(self.0.iter().map(|probe| difference(probe.truth, probe.rebuilt)).collect())
    }

    /// Errors of the factors that replace all views, at the finest level.
    pub fn factored(&self, asset: &FactoredFlatBtf) -> ColourErrors {
        let error = |probe: &Probe| {
            let [view, light] = [(probe.view, probe.views), (probe.light, probe.lights)].map(|(direction, samples)| {
                let (indices, weights) = samples;
                BlendedDirection { direction, samples: ViewWeights { indices, weights } }
            });
            difference(probe.truth, asset.value(probe.parameters, 0.0, view, light))
        };
        ColourErrors::new(self.0.par_iter().map(error).collect())
    }

    /// Errors of the light form: normal map and diffuse colour.
    pub fn light_form(&self, decoder: &FlatBtfDecoder) -> ColourErrors {
        let error = |probe: &Probe| difference(probe.truth, decoder.light_form(probe.at, probe.view, probe.light));
        ColourErrors::new(self.0.iter().map(error).collect())
    }
}

impl Probe {
    fn new(
        decoder: &FlatBtfDecoder,
        at: [f64; 2],
        (view, views): (Vector, ([u32; 3], [f32; 3])),
        (light, lights): (Vector, ([u32; 3], [f32; 3])),
        truth: [f32; 3],
    ) -> Self {
        let (at, view, light) = (at.map(|c| c as f32), view.map(|c| c as f32), light.map(|c| c as f32));
        let [u, v, _] = decoder.indirection(at, view);
        Self { at, view, light, views, lights, parameters: [u, v], truth, rebuilt: [0.0; 3] }
    }
}

/// Relative radiance of the surface behind a point of the reference plane: direct light with cast shadows.
pub fn direct_radiance(
    model: &MesoModel,
    appearance: &Appearance,
    at: [f64; 2],
    view: Vector,
    light: Vector,
) -> [f32; 3] {
    let point = model.point(&model.seen(at, view).hit);
    if dot(point.normal, light) > 0.0 && model.caster.sees_sky(&point, light) {
        appearance.relative_radiance(&point, view, light)
    } else {
        [0.0; 3]
    }
}

/// ΔE (CIE76) of two linear colours.
pub fn difference(a: [f32; 3], b: [f32; 3]) -> f64 {
    f64::from(distance_squared(lab(a), lab(b))).sqrt()
}
