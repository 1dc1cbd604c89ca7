//! Light of one bounce, by Monte Carlo with a fixed seed.
//!
//! `R_v = ∫ f_r(w, v) B(w) cos θ_w dw ≈ (π / S) Σ f_r(w_s, v) B(w_s)` over `S` directions with density `cos θ / π`, where
//! `B(w)` is the relative radiance that the surface point in direction `w` sends back under direct light.

use super::caster::PeriodicCaster;
use super::flatten::lifted;
use super::mesh::PeriodicMesh;
use super::surface::{Appearance, SurfacePoint};
use super::texels::TexelMap;
use brdfc_formats::direction::{Vector, dot, rotate_from_normal};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rays from each texel, and what comes back along them under each light. The same rays serve all views.
///
/// Memory: 12 bytes for each texel, ray and light.
pub struct Bounces {
    samples: usize,
    lights: usize,
    /// Unit directions, `samples` for each texel; `None` where nothing is met.
    directions: Vec<Option<Vector>>,
    /// Relative radiance that comes from there, `lights` for each ray.
    arriving: Vec<[f32; 3]>,
}

/// Seed of all rays; each texel has a stream of its own.
const SEED: u64 = 0x5eed_b0ce;

impl Bounces {
    /// Casts `samples` rays per texel, and shadow rays for every light where they end.
    pub fn new(
        mesh: &PeriodicMesh,
        texels: &TexelMap,
        caster: &PeriodicCaster,
        appearance: &Appearance,
        lights: &[Vector],
        samples: usize,
    ) -> Self {
        let rays = |(index, point): (usize, &SurfacePoint)| {
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(index as u64);
            let mut directions = Vec::with_capacity(samples);
            let mut arriving = Vec::with_capacity(samples * lights.len());
            for _ in 0..samples {
                let (a, b): (f64, f64) = (random.random(), random.random());
                let radius = a.sqrt();
                let local = [radius * (TAU * b).cos(), radius * (TAU * b).sin(), (1.0 - a).sqrt()];
                let direction = rotate_from_normal(point.normal, local);
                let met = caster
                    .nearest(lifted(point), direction)
                    .map(|hit| SurfacePoint::of_hit(mesh, &hit))
                    .filter(|met| dot(met.geometric_normal, direction) < 0.0);
                directions.push(met.map(|_| direction));
                arriving.extend(lights.iter().map(|light| match &met {
                    Some(met) if caster.sees_sky(met.position, met.geometric_normal, *light) => {
                        appearance.relative_radiance(met, direction.map(|c| -c), *light)
                    }
                    _ => [0.0; 3],
                }));
            }
            (directions, arriving)
        };
        let all: Vec<_> = texels.points.par_iter().enumerate().map(rays).collect();
        let (mut directions, mut arriving) = (Vec::new(), Vec::new());
        arriving.reserve_exact(texels.points.len() * samples * lights.len());
        for (d, a) in all {
            directions.extend(d);
            arriving.extend(a);
        }
        Self { samples, lights: lights.len(), directions, arriving }
    }

    /// `π f_r(w_s, v) / S` for the rays of `texels`, one after the other.
    pub fn shares(&self, appearance: &Appearance, map: &TexelMap, view: Vector, texels: &[u32]) -> Vec<[f32; 3]> {
        let scale = PI / self.samples as f64;
        let of_texel = |texel: &u32| {
            let index = *texel as usize;
            let rays = &self.directions[index * self.samples..][..self.samples];
            rays.iter()
                .map(|ray| match ray {
                    Some(ray) => appearance.reflectance(&map.points[index], view, *ray).map(|f_r| (scale * f_r) as f32),
                    None => [0.0; 3],
                })
                .collect::<Vec<_>>()
        };
        texels.par_iter().flat_map_iter(of_texel).collect()
    }

    /// Relative radiance of a texel under a light: its own rays with their shares, which begin at `nth` texels in.
    pub fn gathered(&self, texel: usize, light: usize, shares: &[[f32; 3]], nth: usize) -> [f32; 3] {
        let mut sum = [0.0f32; 3];
        for sample in 0..self.samples {
            let arriving = self.arriving[(texel * self.samples + sample) * self.lights + light];
            let share = shares[nth * self.samples + sample];
            (0..3).for_each(|k| sum[k] += share[k] * arriving[k]);
        }
        sum
    }
}
