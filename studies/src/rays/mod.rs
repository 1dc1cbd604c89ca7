//! Rays per second of the periodic caster, for the rays of making a flat BTF.

mod dump;
mod ray;

pub use dump::{Dump, DumpError};
pub use ray::StudyRay;

use crate::timing::best_of;
use brdfc_core::address::AddressError;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::parameterise::ParameteriseError;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::RAY_OFFSET;
use brdfc_formats::direction::{add_scaled, dot, from_polar};
use brdfc_formats::direction_set::DirectionSet;
use ray::CHUNK;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Views per axis, polar angle and azimuth.
const VIEWS: usize = 16;
/// Largest polar angle of a view, in degrees.
const STEEPEST: f64 = 80.0;
/// Rounds of stretch-reducing reweighting. The positions of texels matter little here.
const ROUNDS: usize = 2;
/// Number of runs, of which the fastest counts.
const RUNS: usize = 5;

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
    /// `nearest`: rays of 16 x 16 views up to 80 degrees through each texel of the reference plane to the surface.
    /// `any`: shadow rays from each texel of the surface to those of 81 directions that it faces.
    pub query: &'static str,
    /// Rays cast.
    pub rays: usize,
    /// Share of the rays that hit the surface.
    pub hits: f64,
    /// Mean number of tiles that a ray passes.
    pub tiles: f64,
    /// Rays per second on one thread.
    pub one: f64,
    /// Rays per second on all threads.
    pub all: f64,
    /// Rays per second on one thread through a tree of the dump's repeated mesh, which avoids traversal of tiles.
    pub repeated_one: Option<f64>,
    /// Rays per second through the same tree on all threads.
    pub repeated_all: Option<f64>,
}

/// Errors of the study.
#[derive(Debug, thiserror::Error)]
pub enum RayStudyError {
    /// The address does not name a structure.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The surface cannot be parameterised.
    #[error(transparent)]
    Parameterise(#[from] ParameteriseError),
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
    /// Surface and rays for other programs: the surface repeated over the extent of the rays.
    ///
    /// # Errors
    /// Returns an error if that takes too many triangles.
    pub fn dump(&self) -> Result<Dump, DumpError> {
        Dump::new(&self.model, &self.nearest, &self.any)
    }

    /// The structure at an address without its prefix, and rays of `texels` x `texels` texels.
    ///
    /// # Errors
    /// Returns the errors of [`Structure::parse`] and [`MesoModel::new`].
    pub fn new(address: &str, texels: usize) -> Result<Self, RayStudyError> {
        let structure = Structure::parse(address)?;
        let model = MesoModel::new(structure.mesh(), ROUNDS, &())?;
        let nearest = eye_rays(&model, texels);
        let any = sky_rays(&model, texels);
        Ok(Self { address: structure.canonical(), model, texels, nearest, any })
    }

    /// Casts all rays; with a dump also against its repeated mesh.
    pub fn measure(&self, dump: Option<&Dump>) -> RayStudy {
        let caster = &self.model.caster;
        let repeated = dump.map(Dump::tree);
        let repeated = repeated.as_ref();
        let nearest = repeated.map(|tree| move |ray: &StudyRay| tree.nearest(&ray.segment()).is_some());
        let any = repeated.map(|tree| move |ray: &StudyRay| tree.is_blocked(&ray.segment()));
        RayStudy {
            model: self.address.clone(),
            triangles: self.model.mesh.triangles.len(),
            texels: self.texels,
            threads: rayon::current_num_threads(),
            rows: vec![
                self.row("nearest", &self.nearest, |ray| ray.nearest(caster).is_finite(), nearest),
                self.row("any", &self.any, |ray| ray.is_blocked(caster), any),
            ],
        }
    }

    fn row(
        &self,
        query: &'static str,
        rays: &[StudyRay],
        cast: impl Fn(&StudyRay) -> bool + Sync,
        repeated: Option<impl Fn(&StudyRay) -> bool + Sync>,
    ) -> RayRate {
        let caster = &self.model.caster;
        let tiles = |rays: &[StudyRay]| rays.iter().map(|ray| ray.tiles(caster)).sum::<usize>();
        let mean = |sum: usize| sum as f64 / rays.len() as f64;
        RayRate {
            query,
            rays: rays.len(),
            hits: mean(count_all(rays, &cast)),
            tiles: mean(rays.par_chunks(CHUNK).map(tiles).sum()),
            one: rays.len() as f64 / best_of(RUNS, || count(rays, &cast)),
            all: rays.len() as f64 / best_of(RUNS, || count_all(rays, &cast)),
            repeated_one: repeated.as_ref().map(|cast| rays.len() as f64 / best_of(RUNS, || count(rays, cast))),
            repeated_all: repeated.as_ref().map(|cast| rays.len() as f64 / best_of(RUNS, || count_all(rays, cast))),
        }
    }
}

fn count(rays: &[StudyRay], cast: impl Fn(&StudyRay) -> bool) -> usize {
    rays.iter().filter(|ray| cast(ray)).count()
}

fn count_all(rays: &[StudyRay], cast: impl Fn(&StudyRay) -> bool + Sync) -> usize {
    rays.par_chunks(CHUNK).map(|rays| count(rays, &cast)).sum()
}

/// Measures the structure at an address without its prefix `synth:`, with rays of `texels` x `texels` texels.
///
/// # Errors
/// Returns the errors of [`RayScene::new`].
pub fn ray_study(address: &str, texels: usize) -> Result<RayStudy, RayStudyError> {
    Ok(RayScene::new(address, texels)?.measure(None))
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
            let origin = add_scaled(point.position, RAY_OFFSET, point.geometric_normal);
            StudyRay::new(origin, direction, model.caster.heights())
        }));
    }
    rays
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
        // A plane has no occluders.
        let plane = ray_study("button?resolution=16&height=0", 4).unwrap();
        assert_eq!((plane.rows[0].hits, plane.rows[1].hits, plane.rows[1].rays), (1.0, 0.0, 4 * 4 * 81));
        assert_eq!(plane.rows[0].repeated_one, None);
        assert!(ray_study("buton", 4).unwrap_err().to_string().contains("did you mean button?"));
    }

    #[test]
    fn the_dumped_mesh_gives_the_same_answers() {
        let scene = RayScene::new("button?resolution=32", 6).unwrap();
        let dump = scene.dump().unwrap();
        let tree = dump.tree();
        for (k, ray) in dump.nearest.iter().enumerate() {
            let found = tree.nearest(&ray.segment()).map_or(f32::INFINITY, |hit| hit.distance);
            assert!((found - dump.answers[k]).abs() < 1e-4, "{k}: {found} {}", dump.answers[k]);
        }
        let differ = dump.any.iter().zip(&dump.answers[dump.nearest.len()..]);
        let differ = differ.filter(|(ray, answer)| f32::from(u8::from(tree.is_blocked(&ray.segment()))) != **answer);
        assert!(differ.count() <= dump.any.len() / 500);
        let rays = dump.rays();
        assert_eq!(rays.len(), 8 + 32 * dump.answers.len());
        assert_eq!(rays[8..12], dump.nearest[0].origin[0].to_le_bytes());
        let ply = brdfc_readers::meso::ply::from_bytes(&dump.ply()).unwrap();
        assert_eq!((ply.positions.len(), ply.triangles.len()), (dump.vertices.len(), dump.triangles.len()));
        assert!(scene.measure(Some(&dump)).rows.iter().all(|row| row.repeated_one > Some(0.0)));
    }
}
