//! Surfaces as a relief covers them: also raised to its highest point, so that its outline shows.

use super::border::border_distances;
use super::shell::sides;
use crate::scene::{Mesh, Scene, Vertex};
use crate::shading_point::ShadingPoint;
use crate::trace::Hit;
use crate::vector::{add_scaled, double, subtract};
use brdfc_formats::PackKind;
use brdfc_formats::direction::{Vector, dot};
use brdfc_formats::flat_btf::{MAX_SLOPE, MacroSurface};

/// WGSL of the surface around a point of a covered mesh, and of the calls of scenes, by the kind of a flat BTF.
pub fn cover_wgsl(kind: PackKind) -> String {
    let calls = match kind {
        PackKind::FlatBtfTrees => include_str!("trees.wgsl"),
        _ => include_str!("factors.wgsl"),
    };
    [include_str!("cover.wgsl"), calls].join("\n")
}

/// Largest difference of normals on a plane.
const MAX_NORMAL_DIFFERENCE: f32 = 1e-4;
/// Least distance, in tiles, of the raised and of the lowered triangles from the surface.
const MIN_DISTANCE: f32 = 1e-4;

/// A scene as it is drawn with `repeat` tiles per unit of uv of a relief between two heights, in tiles.
///
/// A curved mesh has its triangles twice: raised to the highest point of the relief, where rays of sight enter, and lowered
/// to the lowest one, for its back, and for rays that enter at a border. Points beyond an open border are not drawn; a ray
/// that would enter the relief there from the side is taken to pass it. Raised triangles are drawn first, and only their
/// front. A ray through the front of a lowered one has met the relief before, so that no back shows at outlines. A plane
/// has no outline but its border, and stays as it is.
pub fn covered(scene: &Scene, repeat: u32, [low, high]: [f32; 2]) -> Scene {
    let heights = [high.max(MIN_DISTANCE), low.min(-MIN_DISTANCE)];
    let mut scene = scene.clone();
    scene.parts.iter_mut().for_each(|part| part.mesh = cover(&part.mesh, repeat, heights));
    scene
}

/// A mesh at each of two heights, one after the other.
fn cover(mesh: &Mesh, repeat: u32, heights: [f32; 2]) -> Mesh {
    let first = mesh.vertices.first().map_or([0.0; 3], |vertex| vertex.normal);
    let off = |vertex: &Vertex| (0..3).any(|k| (vertex.normal[k] - first[k]).abs() > MAX_NORMAL_DIFFERENCE);
    if !mesh.vertices.iter().any(off) {
        return mesh.clone();
    }
    let sides = sides(mesh, f64::from(repeat));
    let reach = f64::from(MAX_SLOPE * (heights[0] - heights[1])) * sides.iter().copied().fold(0.0, f64::max);
    let borders = border_distances(mesh, reach);
    let raised = |vertex: &Vertex, by: f64, border: f64| {
        let position = add_scaled(double(vertex.position), by, double(vertex.normal)).map(|c| c as f32);
        Vertex { position, raised_by: by as f32, border: border as f32, ..*vertex }
    };
    let numbers = || mesh.vertices.iter().zip(&sides).zip(&borders);
    let at = |height: f32| numbers().map(move |((v, side), border)| raised(v, f64::from(height) * side, *border));
    let count = mesh.vertices.len() as u32;
    let second = mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + count));
    Mesh {
        vertices: heights.into_iter().flat_map(at).collect(),
        triangles: mesh.triangles.iter().copied().chain(second).collect(),
    }
}

/// The surface around a point of a covered mesh.
pub(super) struct CoveredSurface {
    pub(super) flat_btf: MacroSurface,
    /// Side of a tile.
    pub(super) side: f64,
    /// True on raised triangles.
    pub(super) is_raised: bool,
    border: Border,
}

/// The open border around a point.
struct Border {
    /// Distance from it, in world space. 0 on triangles with all corners on it, where it does not change either.
    distance: f64,
    /// Change of the distance along tangent and bitangent.
    gradient: [f64; 2],
}

impl CoveredSurface {
    /// The surface around `point`, which a ray hit.
    pub(super) fn new(mesh: &Mesh, hit: &Hit, point: &ShadingPoint, repeat: u32) -> Self {
        let corners = mesh.triangles[hit.triangle as usize].map(|corner| &mesh.vertices[corner as usize]);
        let [u, v] = hit.barycentric.map(f64::from);
        let weights = [1.0 - u - v, u, v];
        let normals = corners.map(|corner| double(corner.normal));
        let mean: Vector = [0, 1, 2].map(|k| (0..3).map(|corner| weights[corner] * normals[corner][k]).sum());
        let raised_by: f64 = (0..3).map(|corner| weights[corner] * f64::from(corners[corner].raised_by)).sum();
        // On back faces the normal is turned, and v is negated.
        let sign = if dot(mean, point.normal) < 0.0 { -1.0 } else { 1.0 };
        let length = sign * dot(mean, mean).sqrt();
        let along = |v| [dot(v, point.tangent), dot(v, point.bitangent)];
        let base = corners
            .map(|corner| add_scaled(double(corner.position), -f64::from(corner.raised_by), double(corner.normal)));
        let tiles = corners.map(|corner| [0, 1].map(|k| f64::from(corner.uv[k]) * f64::from(repeat) * [1.0, sign][k]));
        let edges = [1, 2].map(|k| along(subtract(base[k], base[0])));
        let turns = [1, 2].map(|k| along(subtract(normals[k], normals[0])).map(|c| c / length));
        let tile_edges = [1, 2].map(|k| [0, 1].map(|axis| tiles[k][axis] - tiles[0][axis]));
        let side = (determinant(edges).abs() / determinant(tile_edges).abs().max(1e-20)).sqrt();
        let curvature = curvature(edges, turns).map(|c| (c * side) as f32);
        let height = if side > 0.0 { (sign * raised_by / side) as f32 } else { 0.0 };
        let stretch = stretch(edges, tile_edges, side);
        let borders = corners.map(|corner| f64::from(corner.border));
        let [along, across] = gradients(edges, [1, 2].map(|k| [borders[k] - borders[0], 0.0])).unwrap_or_default();
        // A distance does not change faster than the position.
        let shortened = along[0].hypot(across[0]).max(1.0);
        let distance = (0..3).map(|corner| weights[corner] * borders[corner]).sum();
        let border = Border { distance, gradient: [along[0], across[0]].map(|c| c / shortened) };
        Self { flat_btf: MacroSurface { curvature, height, stretch }, side, is_raised: raised_by > 0.0, border }
    }

    /// True if a point is beyond the border, where no surface carries it. `moved` is its distance along tangent and
    /// bitangent, in sides of a tile.
    pub(super) fn is_outside(&self, moved: [f32; 2]) -> bool {
        let Border { distance, gradient } = self.border;
        let [x, y] = moved.map(f64::from);
        distance + self.side * (gradient[0] * x + gradient[1] * y) < 0.0
    }
}

fn determinant([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    a * d - b * c
}

/// Change of two numbers with steps along tangent and bitangent, from their changes `p` and `q` along two edges. `None`
/// where the edges span nothing, relative to their lengths.
fn gradients(edges: [[f64; 2]; 2], [p, q]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let (area, [[a, b], [c, d]]) = (determinant(edges), edges);
    let along_tangent = [0, 1].map(|k| (p[k] * d - q[k] * b) / area);
    let along_bitangent = [0, 1].map(|k| (q[k] * a - p[k] * c) / area);
    (area.abs() > 1e-6 * (a * a + b * b + c * c + d * d)).then_some([along_tangent, along_bitangent])
}

/// The symmetric matrix that turns steps along a surface into changes of the normal: uu, uv, vv. Edge-on there is no
/// curvature.
fn curvature(edges: [[f64; 2]; 2], turns: [[f64; 2]; 2]) -> [f64; 3] {
    gradients(edges, turns).map_or([0.0; 3], |[[uu, uv], [vu, vv]]| [uu, 0.5 * (uv + vu), vv])
}

/// Changes of the coordinates in tiles over one side of a tile.
fn stretch(edges: [[f64; 2]; 2], tile_edges: [[f64; 2]; 2], side: f64) -> [f32; 4] {
    let most = MacroSurface::MAX_STRETCH;
    match gradients(edges, tile_edges).filter(|_| determinant(tile_edges).abs() > 1e-20) {
        Some([[ut, vt], [ub, vb]]) => [ut, ub, vt, vb].map(|c| ((c * side) as f32).clamp(-most, most)),
        None => MacroSurface::SQUARE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{quad, ring};

    #[test]
    fn a_plane_stays_as_it_is() {
        let plane = quad(2.0, 0.5);
        assert_eq!(cover(&plane, 4, [0.3, -0.1]), plane);
    }

    /// Around goes one unit of uv, in four tiles; so a side is a quarter of the circumference.
    const RADIUS: f64 = 2.0;
    const SIDE: f64 = 0.25 * std::f64::consts::TAU * RADIUS;

    #[test]
    fn a_curved_mesh_is_raised_and_lowered() {
        let mesh = ring(RADIUS);
        let count = mesh.vertices.len();
        let covered = cover(&mesh, 4, [0.25, -0.125]);
        assert_eq!((covered.vertices.len(), covered.triangles.len()), (2 * count, 2 * mesh.triangles.len()));
        for (index, vertex) in covered.vertices.iter().enumerate() {
            let by = SIDE * if index < count { 0.25 } else { -0.125 };
            let [x, _, z] = double(vertex.position);
            assert!((x.hypot(z) - RADIUS - by).abs() < 2e-3 * SIDE, "{vertex:?}");
            assert!((f64::from(vertex.raised_by) - by).abs() < 2e-3 * SIDE, "{vertex:?}");
            assert_eq!(vertex.uv, mesh.vertices[index % count].uv);
        }
        // A relief on one side of its surface, too, has triangles on both sides.
        for heights in [[0.1, 0.3], [-0.3, -0.1]] {
            let scene = crate::testing::plain_scene(mesh.clone(), crate::scenes::Builtin::Vase.scene().camera);
            let raised: Vec<f32> = covered_by(&scene, heights);
            assert!(raised[..count].iter().all(|by| *by > 0.0) && raised[count..].iter().all(|by| *by < 0.0));
        }
    }

    fn covered_by(scene: &Scene, heights: [f32; 2]) -> Vec<f32> {
        super::covered(scene, 4, heights).parts[0].mesh.vertices.iter().map(|vertex| vertex.raised_by).collect()
    }

    #[test]
    fn a_cylinder_has_the_curvature_of_its_radius() {
        let mesh = cover(&ring(RADIUS), 4, [0.25, -0.125]);
        let part = crate::scene::Part { name: "ring", mesh, surface: Default::default() };
        let second = part.mesh.triangles.len() as u32 / 2;
        // The raised triangles, the lowered ones, and those from inside, where the surface is concave.
        for (triangle, eye, height, sign) in [
            (0, [9.0, 0.0, 0.1], 0.25, 1.0),
            (second, [9.0, 0.0, 0.1], -0.125, 1.0),
            (second, [0.1, 0.0, 0.0], 0.125, -1.0),
        ] {
            let hit = Hit { part: 0, triangle, barycentric: [0.3, 0.3] };
            let point = ShadingPoint::without_bump(&part, &hit, eye);
            let surface = CoveredSurface::new(&part.mesh, &hit, &point, 4);
            let [uu, uv, vv] = surface.flat_btf.curvature.map(f64::from);
            assert!((uu - sign * SIDE / RADIUS).abs() < 0.01 && uv.abs() < 0.01 && vv.abs() < 0.01, "{uu} {uv} {vv}");
            assert!((surface.side / SIDE - 1.0).abs() < 0.01, "{}", surface.side);
            assert!((f64::from(surface.flat_btf.height) - height).abs() < 0.01, "{:?}", surface.flat_btf);
            assert_eq!(surface.is_raised, triangle == 0);
            let square = surface.flat_btf.stretch.iter().zip(MacroSurface::SQUARE).all(|(a, b)| (a - b).abs() < 0.01);
            assert!(square, "{:?}", surface.flat_btf);
        }
    }

    /// Half a tile below the lower end of a bottle there is none. The control: no open border.
    #[test]
    fn surfaces_end_at_their_open_border() {
        use crate::scenes::Builtin;
        for (builtin, ends) in [(Builtin::Bottle, true), (Builtin::Sphere, false)] {
            let mut part = builtin.scene().parts.remove(0);
            part.mesh = cover(&part.mesh, 4, [0.125, -0.125]);
            let low = part.mesh.vertices.iter().map(|vertex| vertex.uv[1]).fold(f32::MAX, f32::min);
            let at_end = |triangle: &usize| {
                let rows = part.mesh.triangles[*triangle].map(|corner| part.mesh.vertices[corner as usize].uv[1]);
                rows.contains(&low)
            };
            let triangle = (0..part.mesh.triangles.len()).find(at_end).unwrap() as u32;
            let hit = Hit { part: 0, triangle, barycentric: [0.3, 0.3] };
            let corner = &part.mesh.vertices[part.mesh.triangles[triangle as usize][0] as usize];
            let eye = add_scaled(double(corner.position), 2.0, double(corner.normal));
            let point = ShadingPoint::without_bump(&part, &hit, eye);
            let surface = CoveredSurface::new(&part.mesh, &hit, &point, 4);
            let outside = [[0.0, -0.5], [0.0, 0.5], [0.5, 0.0]].map(|moved| surface.is_outside(moved));
            assert_eq!(outside, [ends, false, false], "{builtin:?}");
        }
    }

    #[test]
    fn stretch_is_that_of_the_coordinates() {
        let hit = Hit { part: 0, triangle: 1, barycentric: [0.3, 0.3] };
        // Twice as many tiles along one axis; sheared; mirrored; seen from below, where v is negated and the bitangent
        // turned; and no area.
        for ([ut, ub, vt, vb], z, expected) in [
            ([1.0, 0.0, 0.0, 4.0], 5.0, [0.5, 0.0, 0.0, 2.0]),
            ([1.0, 1.0, 0.0, 1.0], 5.0, [1.0, 1.0, 0.0, 1.0]),
            ([-1.0, 0.0, 0.0, 1.0], 5.0, [-1.0, 0.0, 0.0, 1.0]),
            ([1.0, 0.0, 0.0, 4.0], -5.0, [0.5, 0.0, 0.0, 2.0]),
            ([1.0, 0.0, 1.0, 0.0], 5.0, MacroSurface::SQUARE),
        ] {
            let mut mesh = quad(1.0, 0.0);
            mesh.vertices.iter_mut().for_each(|vertex| {
                let [x, y, _] = vertex.position;
                vertex.uv = [ut * x + ub * y, vt * x + vb * y];
            });
            let part = crate::scene::Part { name: "square", mesh, surface: Default::default() };
            let point = ShadingPoint::without_bump(&part, &hit, [0.1, 0.2, z]);
            let found = CoveredSurface::new(&part.mesh, &hit, &point, 3).flat_btf.stretch;
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
        }
    }
}
