//! The rays of the study and the surface around them, for other programs.

use super::ray::{CHUNK, StudyRay};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::triangle_tree::TriangleTree;
use glam::Vec3A;
use rayon::prelude::*;

/// Maximum number of triangles of a repeated mesh.
const MAX_TRIANGLES: usize = 6_000_000;

/// A mesh that no ray leaves, the rays, and our answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Dump {
    /// Vertices, in tiles.
    pub vertices: Vec<[f32; 3]>,
    /// Triangles of the tile, repeated as often as required.
    pub triangles: Vec<[u32; 3]>,
    /// Rays that search for the nearest hit.
    pub nearest: Vec<StudyRay>,
    /// Rays that search for any hit.
    pub any: Vec<StudyRay>,
    /// Our answers: distances, infinite without a hit; then 1 or 0 for each ray that searches for any hit.
    pub answers: Vec<f32>,
}

/// The mesh would be too large.
#[derive(Debug, thiserror::Error)]
#[error("triangles of the repeated mesh: found {0}, expected at most {MAX_TRIANGLES}; lower the resolution")]
pub struct DumpError(usize);

impl Dump {
    /// Repeats the surface over the extent of the rays.
    ///
    /// # Errors
    /// Returns an error if that takes too many triangles.
    pub(super) fn new(model: &MesoModel, nearest: &[StudyRay], any: &[StudyRay]) -> Result<Self, DumpError> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for ray in nearest.iter().chain(any) {
            let (origin, direction) = ray.vectors();
            for k in 0..2 {
                let ends = [origin[k], origin[k] + f64::from(ray.end) * direction[k]];
                low[k] = low[k].min(ends[0]).min(ends[1]);
                high[k] = high[k].max(ends[0]).max(ends[1]);
            }
        }
        let mesh = &model.mesh;
        // Repetition `t` of a vertex is at the vertex plus `t`. Each is one vertex of the repeated mesh.
        let mut corners = Vec::new();
        for (index, triangle) in mesh.triangles.iter().enumerate() {
            let at = mesh.corners(index);
            let range = |k: usize| {
                let c = at.map(|corner| corner[k]);
                let (least, most) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
                (low[k] - most).floor() as i32..=(high[k] - least).ceil() as i32
            };
            for y in range(1) {
                for x in range(0) {
                    corners.push(triangle.map(|c| (c.tile[1] + y, c.tile[0] + x, c.vertex)));
                }
            }
            if corners.len() > MAX_TRIANGLES {
                return Err(DumpError(corners.len() * mesh.triangles.len() / (index + 1)));
            }
        }
        let mut distinct: Vec<_> = corners.iter().flatten().copied().collect();
        distinct.par_sort_unstable();
        distinct.dedup();
        let number =
            |corner: &(i32, i32, u32)| distinct.binary_search(corner).expect("each corner is among them") as u32;
        let triangles = corners.par_iter().map(|c| [number(&c[0]), number(&c[1]), number(&c[2])]).collect();
        let vertex = |(y, x, vertex): &(i32, i32, u32)| {
            let p = mesh.positions[*vertex as usize];
            [p[0] + f64::from(*x), p[1] + f64::from(*y), p[2]].map(|c| c as f32)
        };
        let vertices = distinct.iter().map(vertex).collect();
        let caster = &model.caster;
        let mut answers: Vec<f32> = nearest.par_iter().with_min_len(CHUNK).map(|r| r.nearest(caster)).collect();
        let blocked = |ray: &StudyRay| f32::from(u8::from(ray.is_blocked(caster)));
        answers.par_extend(any.par_iter().with_min_len(CHUNK).map(blocked));
        Ok(Self { vertices, triangles, nearest: nearest.to_vec(), any: any.to_vec(), answers })
    }

    /// A tree of the repeated mesh.
    pub(super) fn tree(&self) -> TriangleTree {
        let corner = |vertex: u32| Vec3A::from_array(self.vertices[vertex as usize]);
        let corners: Vec<_> = self.triangles.iter().map(|triangle| triangle.map(corner)).collect();
        TriangleTree::new(&corners)
    }

    /// The mesh as binary PLY: `x`, `y`, `z` in single precision, and lists of three corners.
    pub fn ply(&self) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
            self.vertices.len(),
            self.triangles.len()
        )
        .into_bytes();
        bytes.reserve(12 * self.vertices.len() + 13 * self.triangles.len());
        bytes.extend(self.vertices.iter().flatten().flat_map(|c| c.to_le_bytes()));
        for triangle in &self.triangles {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|corner| corner.to_le_bytes()));
        }
        bytes
    }

    /// The rays, little-endian: numbers of rays for the nearest and for any hit (`u32` each); for each ray, nearest
    /// first, origin, direction and end (`f32`, 7 in all); for each ray, our answer (`f32`).
    pub fn rays(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(8 + 32 * self.answers.len());
        for rays in [&self.nearest, &self.any] {
            bytes.extend((rays.len() as u32).to_le_bytes());
        }
        for ray in self.nearest.iter().chain(&self.any) {
            let numbers = ray.origin.into_iter().chain(ray.direction).chain([ray.end]);
            bytes.extend(numbers.flat_map(f32::to_le_bytes));
        }
        bytes.extend(self.answers.iter().flat_map(|answer| answer.to_le_bytes()));
        bytes
    }
}
