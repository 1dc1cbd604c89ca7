//! Rays per second of the periodic caster, for the rays that making a flat BTF casts.

mod dump;

pub use dump::{Dump, DumpError};

use crate::btf::caster::{LIFT, PeriodicCaster};
use crate::btf::model::MesoModel;
use crate::btf::parameterise::ParameteriseError;
use crate::btf::structures::Structure;
use crate::source::address::AddressError;
use brdfc_formats::direction::{Vector, add_scaled, dot, from_polar};
use brdfc_formats::direction_set::DirectionSet;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Views per axis, polar angle and azimuth.
const VIEWS: usize = 16;
/// Largest polar angle of a view, in degrees.
const STEEPEST: f64 = 80.0;
/// Rounds of stretch-reducing reweighting: where texels are matters little here.
const ROUNDS: usize = 2;
/// Runs, of which the fastest counts.
const RUNS: usize = 3;
/// Rays that a thread takes at once.
const CHUNK: usize = 1 << 12;

/// Rates of one structure.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RayStudy {
    /// The structure's address with all parameters.
    pub model: String,
    /// Triangles of the tile.
    pub triangles: usize,
    /// Texels per side.
    pub texels: usize,
    /// Threads of the rates on all threads.
    pub threads: usize,
    /// Rays of the eye, then rays to the sky.
    pub rows: Vec<RayRate>,
}

/// Rays per second of one kind of rays.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RayRate {
    /// `nearest`: what 16 x 16 views up to 80 degrees see behind each texel of the reference plane. `any`: whether the
    /// sky is seen from each texel of the surface towards those of 81 directions that it faces.
    pub query: &'static str,
    /// Rays cast.
    pub rays: usize,
    /// Share of them that meet the surface.
    pub hits: f64,
    /// Tiles that a ray goes through until it ends, mean.
    pub tiles: f64,
    /// Rays per second on one thread.
    pub one: f64,
    /// Rays per second on all threads.
    pub all: f64,
}

/// Why there are no rates.
#[derive(Debug, thiserror::Error)]
pub enum RayStudyError {
    /// The address is not one of a structure.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The structure cannot be laid flat.
    #[error(transparent)]
    Parameterise(#[from] ParameteriseError),
}

/// A ray as other programs get it: numbers in single precision, which we cast too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyRay {
    /// Where it begins, in tiles.
    pub origin: [f32; 3],
    /// Unit vector.
    pub direction: [f32; 3],
    /// Distance at which it has left the heights of the surface, in tiles.
    pub end: f32,
}

impl StudyRay {
    fn new(origin: Vector, direction: Vector, [low, high]: [f64; 2]) -> Self {
        let border = if direction[2] > 0.0 { high } else { low };
        let end = (border - origin[2]) / direction[2];
        let single = |v: Vector| v.map(|c| c as f32);
        Self { origin: single(origin), direction: single(direction), end: end as f32 }
    }

    fn vectors(&self) -> (Vector, Vector) {
        (self.origin.map(f64::from), self.direction.map(f64::from))
    }

    /// Distance to what it meets first; infinite where it meets nothing.
    fn nearest(&self, caster: &PeriodicCaster) -> f32 {
        let (origin, direction) = self.vectors();
        caster.nearest(origin, direction).map_or(f32::INFINITY, |hit| hit.distance as f32)
    }

    fn is_blocked(&self, caster: &PeriodicCaster) -> bool {
        let (origin, direction) = self.vectors();
        caster.is_blocked(origin, direction)
    }

    fn tiles(&self, caster: &PeriodicCaster) -> usize {
        let (origin, direction) = self.vectors();
        caster.tiles(origin, direction, f64::from(self.nearest(caster)))
    }
}

/// A structure, and the rays that are cast against it.
pub struct RayScene {
    address: String,
    model: MesoModel,
    texels: usize,
    nearest: Vec<StudyRay>,
    any: Vec<StudyRay>,
}

impl RayScene {
    /// The structure at an address without its prefix, and rays of `texels` x `texels` texels.
    ///
    /// # Errors
    /// As [`Structure::parse`] and [`MesoModel::new`].
    pub fn new(address: &str, texels: usize) -> Result<Self, RayStudyError> {
        let structure = Structure::parse(address)?;
        let model = MesoModel::new(structure.mesh(), ROUNDS)?;
        let nearest = eye_rays(&model, texels);
        let any = sky_rays(&model, texels);
        Ok(Self { address: structure.canonical(), model, texels, nearest, any })
    }

    /// Casts all rays.
    pub fn measure(&self) -> RayStudy {
        let caster = &self.model.caster;
        let row = |query, rays: &[StudyRay], cast: &(dyn Fn(&StudyRay) -> bool + Sync)| {
            let count = |rays: &[StudyRay]| rays.iter().filter(|ray| cast(ray)).count();
            let all = || rays.par_chunks(CHUNK).map(count).sum::<usize>();
            let tiles: usize = rays.par_chunks(CHUNK).map(|c| c.iter().map(|r| r.tiles(caster)).sum::<usize>()).sum();
            RayRate {
                query,
                rays: rays.len(),
                hits: all() as f64 / rays.len() as f64,
                tiles: tiles as f64 / rays.len() as f64,
                one: rays.len() as f64 / best_of(|| count(rays)),
                all: rays.len() as f64 / best_of(all),
            }
        };
        RayStudy {
            model: self.address.clone(),
            triangles: self.model.mesh.triangles.len(),
            texels: self.texels,
            threads: rayon::current_num_threads(),
            rows: vec![
                row("nearest", &self.nearest, &|ray| ray.nearest(caster).is_finite()),
                row("any", &self.any, &|ray| ray.is_blocked(caster)),
            ],
        }
    }
}

/// Measures the structure at an address without its prefix `synth:`, with rays of `texels` x `texels` texels.
///
/// # Errors
/// As [`RayScene::new`].
pub fn ray_study(address: &str, texels: usize) -> Result<RayStudy, RayStudyError> {
    Ok(RayScene::new(address, texels)?.measure())
}

/// Rays down to the texels of the reference plane, in the order of an indirection map.
fn eye_rays(model: &MesoModel, texels: usize) -> Vec<StudyRay> {
    let heights = model.caster.heights();
    let mut rays = Vec::with_capacity(texels * texels * VIEWS * VIEWS);
    for row in 0..texels {
        for azimuth in 0..VIEWS {
            for column in 0..texels {
                for polar in 0..VIEWS {
                    let theta = STEEPEST.to_radians() * polar as f64 / (VIEWS - 1) as f64;
                    let view = from_polar(theta, std::f64::consts::TAU * azimuth as f64 / VIEWS as f64);
                    let at = [column, row].map(|k| (k as f64 + 0.5) / texels as f64);
                    let origin = add_scaled([at[0], at[1], 0.0], heights[1] / view[2], view);
                    rays.push(StudyRay::new(origin, view.map(|c| -c), heights));
                }
            }
        }
    }
    rays
}

/// Rays from the texels of the surface to the sky, direction by direction.
fn sky_rays(model: &MesoModel, texels: usize) -> Vec<StudyRay> {
    let points = model.texels(texels).points;
    let mut rays = Vec::new();
    for direction in DirectionSet::ubo2003().directions() {
        let facing =
            points.iter().filter(|p| dot(p.normal, direction) > 0.0 && dot(p.geometric_normal, direction) > 0.0);
        rays.extend(facing.map(|point| {
            let origin = add_scaled(point.position, LIFT, point.geometric_normal);
            StudyRay::new(origin, direction, model.caster.heights())
        }));
    }
    rays
}

fn best_of<T>(run: impl Fn() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        black_box(run());
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_eye_ray_meets_the_surface_and_only_some_of_the_sky_rays_do() {
        let study = ray_study("button?resolution=32", 4).unwrap();
        let [nearest, any] = &study.rows[..] else { panic!("{study:?}") };
        assert_eq!((nearest.rays, nearest.hits), (4 * 4 * VIEWS * VIEWS, 1.0));
        assert!(any.rays < 4 * 4 * 81 && any.hits > 0.02 && any.hits < 0.5, "{any:?}");
        assert!(nearest.tiles > 1.0 && nearest.tiles < 5.0 && any.tiles >= 1.0, "{study:?}");
        assert!(study.rows.iter().all(|row| row.one > 0.0 && row.all > 0.0));
        // Nothing stands in the way of a plane.
        let plane = ray_study("button?resolution=16&height=0", 4).unwrap();
        assert_eq!((plane.rows[0].hits, plane.rows[1].hits, plane.rows[1].rays), (1.0, 0.0, 4 * 4 * 81));
        assert!(ray_study("buton", 4).unwrap_err().to_string().contains("did you mean `button`?"));
    }
}
