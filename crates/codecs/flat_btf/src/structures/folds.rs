//! Cloth in folds that lean over, woven of two yarns.

use super::noise::{gradient_noise, lattice, mix, periodic_fractal, smooth_step};
use super::relief::{HEIGHT, RESOLUTION, Relief, SEED, Sample, StructureInfo};
use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;
use brdfc_formats::direction::Vector;
use std::f64::consts::TAU;

pub(super) const INFO: StructureInfo = StructureInfo {
    name: "folds",
    meaning: "striped cloth in folds that lean over; two materials",
    parameters: &[
        RESOLUTION,
        HEIGHT,
        SEED,
        Parameter::integer("count", [1.0, 8.0], 3.0, "folds along the tile"),
        Parameter::number("lean", [0.0, 1.5], 1.0, "how far folds lean over; 0: a height field"),
    ],
    materials: &["synth:velvet?kd=0.4&ks=0.25&sx=0.5&sy=0.5", "synth:lewis?kd=0.5&ks=0.18&n=25"],
    build: |values| Box::new(Folds { seed: values[2] as u64, count: values[3], lean: values[4] }),
};

/// Height of a fold from valley to ridge at its strongest, in distances between folds.
const RELIEF: f64 = 0.5;
/// Points of a line at which lengths are tabulated, per fold.
const STEPS: usize = 128;

struct Folds {
    seed: u64,
    count: f64,
    lean: f64,
}

impl Folds {
    fn noise(&self, x: f64, y: f64, cells: [i64; 2], salt: u64) -> f64 {
        gradient_noise(x * cells[0] as f64, y * cells[1] as f64, self.seed ^ salt, Some(cells))
    }

    /// The upright cloth: a height field, in distances between folds.
    fn relief(&self, x: f64, y: f64) -> f64 {
        // Ridges wander and run obliquely in places.
        let wander = 0.08 * (TAU * y).sin() + 0.11 * self.noise(x, y, [2, 2], 0x11);
        let phase = TAU * (self.count * x + self.count.min(3.0) * wander);
        // Narrow ridges, wide valleys.
        let wave = 0.5 + 0.5 * (phase.cos() + 0.22 * (2.0 * phase).cos()) / 1.22;
        let strength = 0.86 + 0.3 * self.noise(x, y, [self.count as i64, 2], 0x22);
        let slack = 0.03 * periodic_fractal(x, y, self.seed ^ 0x33, [3, 4], 2, 0.5);
        RELIEF * strength * wave + slack
    }

    /// Displaces a point of the height field along x, so that the cloth leans over. For a given `y` and `z`, `x` still
    /// increases, so that the surface cannot meet itself.
    fn leant(&self, x: f64, y: f64, z: f64) -> f64 {
        let direction = 0.8 + 0.35 * self.noise(0.0, y, [1, 3], 0x44) + 0.12 * (TAU * x).sin();
        // The displacement grows towards the ridge, which rolls over.
        x + self.lean * direction * (0.55 * z + 1.0 * z * z) / self.count
    }

    fn point(&self, x: f64, y: f64) -> Vector {
        let z = self.relief(x, y);
        [self.leant(x, y, z), y, z / self.count]
    }

    /// Material at a point of the cloth: satin stripes on a matte ground, yarn by yarn.
    fn material(&self, u: f64, v: f64) -> VertexMaterial {
        const YARNS: i64 = 96;
        let yarn =
            |t: f64, salt: u64| lattice(((t * YARNS as f64).floor() as i64).rem_euclid(YARNS), 0, self.seed ^ salt);
        // Distance from the middle of the nearest of n stripes, in stripes.
        let from_stripe = |t: f64, n: f64, at: f64| (t * n - at - (t * n - at).round()).abs();
        let band = 1.0 - smooth_step(0.22, 0.25, from_stripe(v, 3.0, 0.5));
        let line = 1.0 - smooth_step(0.10, 0.13, from_stripe(v, 3.0, 0.0));
        let cross = 1.0 - smooth_step(0.12, 0.15, from_stripe(u, 6.0, 0.5));
        let satin = (line + 0.5 * cross * (1.0 - line)).min(1.0);
        let heather = 1.0 - 0.06 * yarn(u, 0x55) - 0.14 * yarn(v, 0x66);
        let [ground, dyed, thread] = [[0.62, 0.58, 0.5], [0.12, 0.2, 0.42], [0.95, 0.66, 0.25]];
        let tint = std::array::from_fn(|c| {
            let cloth: f64 = mix(ground[c], dyed[c], band);
            (mix(cloth, thread[c], satin) * heather) as f32
        });
        let satin = satin as f32;
        VertexMaterial { weights: [1.0 - satin, satin, 0.0, 0.0], tint }
    }
}

impl Relief for Folds {
    /// Parameters of the cloth are arc lengths along a line, so that steep places get their share of vertices and
    /// stripes keep their width.
    fn line(&self, v: f64) -> Box<dyn Fn(f64) -> Sample + '_> {
        let steps = STEPS * self.count as usize;
        let at = |k: usize| k as f64 / steps as f64;
        let mut spent = vec![0.0];
        let mut before = self.point(0.0, v);
        for k in 1..=steps {
            let here = self.point(at(k), v);
            spent.push(spent[k - 1] + (here[0] - before[0]).hypot(here[2] - before[2]));
            before = here;
        }
        Box::new(move |u| {
            let tile = u.floor();
            let sought = (u - tile) * spent[steps];
            let k = spent.partition_point(|spent| *spent <= sought).clamp(1, steps) - 1;
            let within = (sought - spent[k]) / (spent[k + 1] - spent[k]);
            (self.point(tile + (k as f64 + within) / steps as f64, v), self.material(u, v))
        })
    }
}
