//! Converts a mesh as stored in a file, or a height map, to a surface that closes over the tile.

mod error;
mod identify;
mod sliver;
mod topology;

pub use error::{Hint, MAX_EXTENT, MAX_HEIGHT, MesoError};
pub use identify::TOLERANCE;

use super::mesh::{Corner, MAX_MATERIALS, PeriodicMesh, VertexMaterial};
use brdfc_formats::direction::Vector;
use brdfc_readers::meso::TriangleMesh;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sliver::in_first_tile;
use topology::EdgeError;

/// Maximum coordinate along any axis, in tiles.
const MAX_TILES: f64 = 1e6;

/// Limit of the tiles that all triangles overlap in total: per triangle, plus a constant.
const MAX_SPREAD: [u64; 2] = [16, 1 << 20];

/// Statistics and repairs of a mesh.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct WeldReport {
    /// Vertices in the mesh.
    pub vertices_in: usize,
    /// Triangles in the mesh.
    pub triangles_in: usize,
    /// Vertices of the surface.
    pub vertices: usize,
    /// Triangles of the surface.
    pub triangles: usize,
    /// Vertices merged with an earlier one, in the same tile or another.
    pub merged_vertices: usize,
    /// Vertices dropped because no triangle uses them.
    pub unreferenced_vertices: usize,
    /// Triangles dropped because two corners coincide.
    pub degenerate_triangles: usize,
    /// Triangles dropped because they duplicate an earlier one, in the same tile or another.
    pub duplicate_triangles: usize,
    /// Triangles whose orientation was reversed.
    pub turned_triangles: usize,
    /// Triangles with collinear corners, repaired by flipping the longest edge.
    pub exchanged_edges: usize,
}

/// Welds a mesh with period `tile`, in the file's unit, along x and y.
///
/// Triangles are oriented so that the outside is up. The surface has the materials of the mesh, in the same order.
///
/// # Errors
/// Returns a [`MesoError`] if the mesh is no sheet over the tile: holes, borders that do not match, edges of more than
/// two triangles, parts that are disconnected or only touch, handles.
pub fn weld(mesh: &TriangleMesh, tile: f64) -> Result<(PeriodicMesh, WeldReport), MesoError> {
    if !(tile.is_finite() && tile > 0.0) {
        return Err(MesoError::Tile(tile));
    }
    mesh.check()?;
    if mesh.materials.len() > MAX_MATERIALS {
        return Err(MesoError::Materials(mesh.materials.clone()));
    }
    let mut welder = Welder::new(mesh, tile)?;
    welder.close()?;
    welder.repair_slivers()?;
    check_extent(&welder.surface).map_err(|error| match error {
        MesoError::Wide { triangle, found } => MesoError::Wide { triangle: welder.triangles[triangle] as usize, found },
        other => other,
    })?;
    Ok(welder.finish())
}

/// Checks that ray casting against the repeated surface takes reasonable time and memory, and that single precision
/// suffices.
fn check_extent(surface: &PeriodicMesh) -> Result<(), MesoError> {
    let heights = surface.height_range();
    if heights.iter().any(|z| z.abs() > MAX_HEIGHT) {
        return Err(MesoError::Tall(heights));
    }
    let mut spread = 0;
    for triangle in 0..surface.triangles.len() {
        let corners = surface.corners(triangle);
        let extent = |axis: usize| {
            let c = corners.map(|corner| corner[axis]);
            c[0].max(c[1]).max(c[2]) - c[0].min(c[1]).min(c[2])
        };
        let [x, y] = [extent(0), extent(1)];
        if x.max(y) > MAX_EXTENT {
            return Err(MesoError::Wide { triangle, found: x.max(y) });
        }
        spread += (x as u64 + 1) * (y as u64 + 1);
    }
    let allowed = MAX_SPREAD[0] * surface.triangles.len() as u64 + MAX_SPREAD[1];
    if spread > allowed { Err(MesoError::Spread { found: spread, allowed }) } else { Ok(()) }
}

struct Welder<'a> {
    mesh: &'a TriangleMesh,
    tile: f64,
    surface: PeriodicMesh,
    /// For each vertex of the surface, its index in the mesh.
    vertices: Vec<u32>,
    /// For each triangle of the surface, its index in the mesh.
    triangles: Vec<u32>,
    report: WeldReport,
}

impl<'a> Welder<'a> {
    /// Identifies vertices and drops degenerate triangles.
    fn new(mesh: &'a TriangleMesh, tile: f64) -> Result<Self, MesoError> {
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.iter().flatten().for_each(|vertex| used[*vertex as usize] = true);
        let listed: Vec<u32> = (0..used.len() as u32).filter(|vertex| used[*vertex as usize]).collect();
        let mut place = vec![0; used.len()];
        for (at, vertex) in listed.iter().enumerate() {
            place[*vertex as usize] = at;
            let position = mesh.positions[*vertex as usize];
            let found = position.iter().fold(0.0, |far: f64, c| far.max((c / tile).abs()));
            if found > MAX_TILES {
                return Err(MesoError::Far { vertex: *vertex as usize, position, found });
            }
        }
        let identified = identify::identify(listed.iter().map(|v| mesh.positions[*v as usize].map(|c| c / tile)));
        let mut report = WeldReport {
            vertices_in: used.len(),
            triangles_in: mesh.triangles.len(),
            merged_vertices: listed.len() - identified.positions.len(),
            unreferenced_vertices: used.len() - listed.len(),
            ..WeldReport::default()
        };
        let mut surface = PeriodicMesh { positions: identified.positions, ..PeriodicMesh::default() };
        let mut triangles = Vec::new();
        for (index, vertices) in mesh.triangles.iter().enumerate() {
            let corners = in_first_tile(vertices.map(|v| identified.corners[place[v as usize]]));
            if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
                report.degenerate_triangles += 1;
                continue;
            }
            surface.triangles.push(corners);
            triangles.push(index as u32);
        }
        let duplicate = duplicates(&surface.triangles);
        report.duplicate_triangles = duplicate.iter().filter(|duplicate| **duplicate).count();
        let is_unique = |index: usize| !duplicate[index];
        let (mut at, mut index) = (0.., 0..);
        surface.triangles.retain(|_| at.next().is_some_and(is_unique));
        triangles.retain(|_| index.next().is_some_and(is_unique));
        let vertices = identified.first.iter().map(|at| listed[*at as usize]).collect();
        let mut welder = Self { mesh, tile, surface, vertices, triangles, report };
        if welder.surface.triangles.is_empty() {
            return Err(MesoError::Empty { triangles: mesh.triangles.len(), hint: welder.hint() });
        }
        welder.drop_unused_vertices();
        Ok(welder)
    }

    /// Drops vertices that only degenerate triangles use.
    fn drop_unused_vertices(&mut self) {
        let mut used = vec![false; self.surface.positions.len()];
        self.surface.triangles.iter().flatten().for_each(|corner| used[corner.vertex as usize] = true);
        let mut count = 0;
        let mut index = vec![0; used.len()];
        for old in 0..used.len() {
            index[old] = count as u32;
            if used[old] {
                self.surface.positions[count] = self.surface.positions[old];
                self.vertices[count] = self.vertices[old];
                count += 1;
            }
        }
        self.surface.positions.truncate(count);
        self.vertices.truncate(count);
        self.report.unreferenced_vertices += used.len() - count;
        let corners = self.surface.triangles.iter_mut().flatten();
        corners.for_each(|corner| corner.vertex = index[corner.vertex as usize]);
    }

    /// Orients the triangles of the surface with the outside up, and checks that they form one sheet.
    fn close(&mut self) -> Result<(), MesoError> {
        let partners = topology::partners(&self.surface.triangles).map_err(|error| self.edge_error(error))?;
        let orientation = topology::orient(&self.surface.triangles, &partners);
        if let Some(second) = orientation.pieces.get(1) {
            let [position, ..] = self.corners_in_file(*second);
            let (count, triangle) = (orientation.pieces.len(), self.triangles[*second] as usize);
            return Err(MesoError::Pieces { count, triangle, position });
        }
        if let Some(conflict) = orientation.conflict {
            let [position, ..] = self.corners_in_file(conflict);
            return Err(MesoError::NotOrientable { triangle: self.triangles[conflict] as usize, position });
        }
        let mut turn = orientation.turn;
        self.turn(&turn);
        // The projected area is checked after the topology: a closed body covers nothing.
        if self.surface.projected_area() < 0.0 {
            self.turn(&vec![true; turn.len()]);
            turn.iter_mut().for_each(|turn| *turn = !*turn);
        }
        self.report.turned_triangles = turn.iter().filter(|turn| **turn).count();

        let partners = topology::turned(&partners, &turn);
        let (vertices, triangles) = (self.surface.positions.len(), self.surface.triangles.len());
        if let Some(vertex) = topology::touching_vertex(&self.surface.triangles, &partners, vertices) {
            let vertex = self.vertices[vertex as usize] as usize;
            return Err(MesoError::Touching { vertex, position: self.mesh.positions[vertex] });
        }
        let edges = triangles / 2 * 3;
        let characteristic = vertices as i64 - edges as i64 + triangles as i64;
        if characteristic != 0 {
            return Err(MesoError::Topology { vertices, edges, triangles, characteristic });
        }
        // A whole number, up to rounding, for any closed surface.
        let found = self.surface.projected_area();
        if found.round() != 1.0 {
            return Err(MesoError::Cover { found, hint: self.hint() });
        }
        Ok(())
    }

    fn turn(&mut self, turn: &[bool]) {
        self.surface.triangles.iter_mut().zip(turn).filter(|(_, turn)| **turn).for_each(|(t, _)| t.swap(1, 2));
    }

    fn repair_slivers(&mut self) -> Result<(), MesoError> {
        self.report.exchanged_edges = sliver::repair(&mut self.surface);
        match (0..self.surface.triangles.len()).find(|t| sliver::is_flat(self.surface.corners(*t))) {
            Some(flat) => {
                Err(MesoError::Flat { triangle: self.triangles[flat] as usize, corners: self.corners_in_file(flat) })
            }
            None => Ok(()),
        }
    }

    fn finish(mut self) -> (PeriodicMesh, WeldReport) {
        self.surface.materials = self.materials();
        self.surface.normals = self.surface.smooth_normals();
        self.report.vertices = self.surface.positions.len();
        self.report.triangles = self.surface.triangles.len();
        (self.surface, self.report)
    }

    /// Material shares of the triangles at each vertex, and its colour.
    fn materials(&self) -> Vec<VertexMaterial> {
        let mut counts = vec![[0u32; MAX_MATERIALS]; self.surface.positions.len()];
        for (corners, index) in self.surface.triangles.iter().zip(&self.triangles) {
            let material = self.mesh.triangle_materials.get(*index as usize).map_or(0, |material| *material as usize);
            corners.iter().for_each(|corner| counts[corner.vertex as usize][material] += 1);
        }
        let tint = |vertex: u32| self.mesh.colours.get(vertex as usize).copied().unwrap_or([1.0; 3]);
        let share = |counts: [u32; MAX_MATERIALS]| counts.map(|n| n as f32 / counts.iter().sum::<u32>() as f32);
        counts
            .into_iter()
            .zip(&self.vertices)
            .map(|(counts, vertex)| VertexMaterial { weights: share(counts), tint: tint(*vertex) })
            .collect()
    }

    fn edge_error(&self, error: EdgeError) -> MesoError {
        let (EdgeError::Open(bad) | EdgeError::NonManifold(bad)) = error;
        let corners = self.corners_in_file(bad.triangle);
        let edge = [corners[bad.side], corners[(bad.side + 1) % 3]];
        let triangle = self.triangles[bad.triangle] as usize;
        let (count, triangles, hint) = (bad.count, bad.triangles, self.hint());
        match error {
            EdgeError::Open(_) => MesoError::Open { count, triangle, edge, hint },
            EdgeError::NonManifold(_) => MesoError::NonManifold { count, triangle, triangles, edge, hint },
        }
    }

    /// Corners, in the file's unit, of the input triangle that corresponds to a triangle of the surface.
    fn corners_in_file(&self, triangle: usize) -> [Vector; 3] {
        self.mesh.triangles[self.triangles[triangle] as usize].map(|vertex| self.mesh.positions[vertex as usize])
    }

    /// The bounding box of all triangles, in the file's unit.
    fn hint(&self) -> Hint {
        let extent = [0, 1].map(|axis| {
            let along = self.mesh.triangles.iter().flatten().map(|vertex| self.mesh.positions[*vertex as usize][axis]);
            let [low, high] =
                along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
            high - low
        });
        Hint { extent, tile: self.tile }
    }
}

/// For each triangle, true if it has the corners of an earlier one, in any order.
fn duplicates(triangles: &[[Corner; 3]]) -> Vec<bool> {
    let key = |index: usize| {
        let mut corners = triangles[index].map(|corner| (corner.vertex, corner.tile));
        corners.sort_unstable();
        (corners, index)
    };
    let mut keys: Vec<_> = (0..triangles.len()).into_par_iter().map(key).collect();
    keys.par_sort_unstable();
    let mut duplicate = vec![false; triangles.len()];
    let pairs = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    pairs.for_each(|pair| duplicate[pair[1].1] = true);
    duplicate
}

/// Converts a height map to a surface with one vertex in the middle of each pixel.
///
/// Heights are in rows from the top, `y = 1`; a pixel of height `h` is at `z = scale h + offset`, in tiles.
///
/// # Errors
/// Returns an error for fewer than 3 columns or rows, for another number of heights, and for heights that are not
/// finite.
pub fn from_heights(
    width: usize,
    height: usize,
    heights: &[f32],
    scale: f64,
    offset: f64,
) -> Result<PeriodicMesh, MesoError> {
    if width < 3 || height < 3 || width.checked_mul(height) != Some(heights.len()) {
        let found = format!("{width} x {height} pixels with {} heights", heights.len());
        return Err(MesoError::Heights { found, allowed: "at least 3 pixels per side and one height per pixel" });
    }
    let mut points = Vec::with_capacity(heights.len());
    for row in 0..height {
        let line = height - 1 - row;
        for (column, value) in heights[line * width..][..width].iter().enumerate() {
            let z = scale * f64::from(*value) + offset;
            if !z.is_finite() || z.abs() > MAX_TILES {
                let found = format!("{scale} x {value} + {offset} at pixel ({column}, {line})");
                return Err(MesoError::Heights { found, allowed: "finite heights of at most 1e6 tiles" });
            }
            points.push([(column as f64 + 0.5) / width as f64, (row as f64 + 0.5) / height as f64, z]);
        }
    }
    let materials = vec![VertexMaterial::default(); points.len()];
    let surface = PeriodicMesh::from_grid(width, height, points, materials);
    check_extent(&surface)?;
    Ok(surface)
}

#[cfg(test)]
mod tests;
