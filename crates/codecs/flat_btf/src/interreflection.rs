//! Light of one bounce, by Monte Carlo with a fixed seed.
//!
//! `R_v = ∫ f_r(w, v) B(w) cos θ_w dw ≈ (π / S) Σ f_r(w_s, v) B(w_s)` over `S` directions with density `cos θ / π`, where
//! `B(w)` is the relative radiance that the surface point in direction `w` sends back under direct light.

use super::caster::PeriodicCaster;
use super::mesh::PeriodicMesh;
use super::surface::{Appearance, SurfacePoint};
use super::texels::TexelMap;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::{Vector, dot, rotate_from_normal};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rays from each texel, and the radiance that returns along them under each light. All views share these rays.
///
/// Memory: [`Bounces::bytes`].
pub struct Bounces {
    samples: usize,
    lights: usize,
    /// Unit directions, `samples` for each texel; `None` if the ray misses the surface.
    directions: Vec<Option<[f32; 3]>>,
    /// Relative radiance that arrives along each ray, `lights` for each ray, encoded as [`rgb9e5`].
    arriving: Vec<u32>,
}

/// Seed of all rays; each texel has its own stream.
const SEED: u64 = 0x5eed_b0ce;
/// Texels per progress step.
const STEP: usize = 1024;

impl Bounces {
    /// Memory in bytes for this many texels, rays per texel, and lights.
    pub fn bytes(texels: usize, samples: usize, lights: usize) -> u64 {
        (texels * samples) as u64 * (size_of::<Option<[f32; 3]>>() + size_of::<u32>() * lights) as u64
    }

    /// Number of progress steps for this many texels.
    pub fn steps(texels: usize) -> usize {
        texels.div_ceil(STEP)
    }

    /// Casts `samples` rays per texel, and shadow rays towards every light from their ends.
    ///
    /// # Errors
    /// Returns an error if `progress` cancels.
    pub fn new(
        mesh: &PeriodicMesh,
        texels: &TexelMap,
        caster: &PeriodicCaster,
        appearance: &Appearance,
        lights: &[Vector],
        samples: usize,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let rays = texels.points.len() * samples;
        let (mut directions, mut arriving) = (vec![None; rays], vec![0; rays * lights.len()]);
        let each = directions.par_chunks_mut(samples).zip(arriving.par_chunks_mut(samples * lights.len()));
        each.enumerate().try_for_each(|(index, (directions, arriving))| {
            let point = &texels.points[index];
            let mut random = ChaCha8Rng::seed_from_u64(SEED);
            random.set_stream(index as u64);
            for (stored, arriving) in directions.iter_mut().zip(arriving.chunks_exact_mut(lights.len())) {
                let (a, b): (f64, f64) = (random.random(), random.random());
                let radius = a.sqrt();
                let local = [radius * (TAU * b).cos(), radius * (TAU * b).sin(), (1.0 - a).sqrt()];
                let direction = rotate_from_normal(point.normal, local);
                let met = caster
                    .nearest(point.ray_origin(), direction)
                    .map(|hit| SurfacePoint::of_hit(mesh, &hit))
                    .filter(|met| dot(met.geometric_normal, direction) < 0.0);
                let Some(met) = met else { continue };
                *stored = Some(direction.map(|c| c as f32));
                for (value, light) in arriving.iter_mut().zip(lights) {
                    if caster.sees_sky(&met, *light) {
                        let back = direction.map(|c| -c);
                        *value = rgb9e5::encode(appearance.relative_radiance(&met, back, *light));
                    }
                }
            }
            if index % STEP == STEP - 1 || index + 1 == texels.points.len() { progress.step() } else { Ok(()) }
        })?;
        Ok(Self { samples, lights: lights.len(), directions, arriving })
    }

    /// `π f_r(w_s, v) / S` for the rays of `texels`, texel by texel.
    pub fn shares(&self, appearance: &Appearance, map: &TexelMap, view: Vector, texels: &[u32]) -> Vec<[f32; 3]> {
        let scale = PI / self.samples as f64;
        let of_texel = |texel: &u32| {
            let index = *texel as usize;
            let rays = &self.directions[index * self.samples..][..self.samples];
            rays.iter()
                .map(|ray| match ray {
                    Some(ray) => appearance
                        .reflectance(&map.points[index], view, ray.map(f64::from))
                        .map(|f_r| (scale * f_r) as f32),
                    None => [0.0; 3],
                })
                .collect::<Vec<_>>()
        };
        texels.par_iter().flat_map_iter(of_texel).collect()
    }

    /// Relative radiance of a texel under a light, gathered along its rays. `shares` starts with the rays of the first
    /// texel of the view, and `nth` is the place of this texel in it.
    pub fn gathered(&self, texel: usize, light: usize, shares: &[[f32; 3]], nth: usize) -> [f32; 3] {
        let mut sum = [0.0f32; 3];
        for sample in 0..self.samples {
            let arriving = rgb9e5::decode(self.arriving[(texel * self.samples + sample) * self.lights + light]);
            let share = shares[nth * self.samples + sample];
            (0..3).for_each(|k| sum[k] += share[k] * arriving[k]);
        }
        sum
    }
}
