//! Invariants of every built-in scene.

use super::*;
use crate::adaptive::repeats::along_uv;
use crate::scene::{Frame, Mesh};
use crate::shading_point::ShadingPoint;
use crate::trace::trace;
use crate::vector::{cross, double, subtract};
use brdfc_formats::direction::{Vector, dot};
use std::collections::BTreeMap;

#[test]
fn meshes_are_sound() {
    for (name, builtin) in Builtin::NAMES {
        assert_eq!(builtin.name(), name);
        let scene = builtin.scene();
        let parts: Vec<&str> = scene.parts.iter().map(|part| part.name).collect();
        assert_eq!(parts, builtin.parts());
        assert!(scene.camera.is_valid());
        let by_environment = [Builtin::BumpyBall, Builtin::RibbedTorus].contains(&builtin);
        assert_eq!(scene.lights.is_empty(), by_environment, "{name}");
        for part in &scene.parts {
            for vertex in &part.mesh.vertices {
                let (n, t) = (double(vertex.normal), double(vertex.tangent));
                assert!((dot(n, n) - 1.0).abs() < 1e-5 && (dot(t, t) - 1.0).abs() < 1e-5, "{name}: {vertex:?}");
                assert!(dot(n, t).abs() < 1e-5, "{name}: {vertex:?}");
                assert!(vertex.position.iter().chain(&vertex.uv).all(|c| c.is_finite()));
            }
            let count = part.mesh.vertices.len();
            assert!(part.mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < count), "{name}");
            for triangle in &part.mesh.triangles {
                let corners = triangle.map(|corner| part.mesh.vertices[corner as usize]);
                let [a, b, c] = corners.map(|corner| double(corner.position));
                let face = cross(subtract(b, a), subtract(c, a));
                if dot(face, face).sqrt() > 1e-9 {
                    assert!(corners.iter().all(|v| dot(face, double(v.normal)) > 0.0), "{name}: {corners:?}");
                }
            }
        }
    }
}

#[test]
fn triangles_are_as_many_as_the_paper_has() {
    let count = |builtin: Builtin| builtin.scene().parts.iter().map(|part| part.mesh.triangles.len()).sum::<usize>();
    assert_eq!(count(Builtin::Cloth), 10_952);
    assert_eq!(count(Builtin::Terrain), 45_000);
}

/// At the usual scale of distances, everything nearer than 6.66 is drawn in full detail.
#[test]
fn objects_are_near_enough_for_full_detail() {
    let frame = Frame { width: 64, height: 64, samples: 1 };
    for builtin in [Builtin::Sphere, Builtin::Cloth, Builtin::Table, Builtin::BumpyBall, Builtin::RibbedTorus] {
        let scene = builtin.scene();
        let hits = trace(&scene, frame);
        assert!(hits.0.iter().flatten().count() > 64 * 64 / 4, "{builtin:?} fills the rendering");
        for hit in hits.0.iter().flatten() {
            let point = ShadingPoint::new(&scene.parts[hit.part as usize], hit, scene.camera.eye);
            assert!(point.distance < 6.5, "{builtin:?}: {}", point.distance);
        }
    }
}

/// The objects in the paper's renderings fill half of them.
#[test]
fn shapes_for_environments_fill_half_the_rendering() {
    for builtin in [Builtin::BumpyBall, Builtin::RibbedTorus] {
        let hits = trace(&builtin.scene(), Frame { width: 64, height: 64, samples: 1 });
        let share = hits.0.iter().flatten().count() as f64 / (64.0 * 64.0);
        assert!((0.45..0.65).contains(&share), "{builtin:?}: {share}");
    }
}

#[test]
fn the_terrain_spans_all_levels_of_detail() {
    let scene = Builtin::Terrain.scene();
    let hits = trace(&scene, Frame { width: 64, height: 36, samples: 1 });
    let distance = |hit| ShadingPoint::new(&scene.parts[0], hit, scene.camera.eye).distance;
    let distances: Vec<f64> = hits.0.iter().flatten().map(distance).collect();
    assert!(distances.iter().any(|d| *d < 20.0) && distances.iter().any(|d| *d > 180.0));
}

#[test]
fn every_part_is_seen() {
    for (name, builtin) in Builtin::NAMES {
        let hits = trace(&builtin.scene(), Frame { width: 96, height: 96, samples: 1 });
        for part in 0..builtin.parts().len() {
            let seen = hits.0.iter().flatten().filter(|hit| hit.part as usize == part).count();
            assert!(seen > 96, "{name}: {} covers {seen} pixels", builtin.parts()[part]);
        }
    }
}

/// Pairs of triangles of a mesh without a common corner where an edge of one passes through the other.
fn crossings(mesh: &Mesh) -> Vec<[usize; 2]> {
    let corners = |triangle: usize| mesh.triangles[triangle].map(|c| double(mesh.vertices[c as usize].position));
    // Triangles by the cells of space that their bounding boxes touch.
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for triangle in 0..mesh.triangles.len() {
        let at = corners(triangle);
        let cell = |k: usize, pick: fn(f64, f64) -> f64| (at.iter().map(|p| p[k]).reduce(pick).unwrap() / 0.05).floor();
        let [low, high] = [f64::min, f64::max].map(|pick| [0, 1, 2].map(|k| cell(k, pick) as i64));
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                (low[2]..=high[2]).for_each(|z| cells.entry([x, y, z]).or_default().push(triangle));
            }
        }
    }
    let apart = |a: usize, b: usize| mesh.triangles[a].iter().all(|corner| !mesh.triangles[b].contains(corner));
    let mut found = Vec::new();
    for inside in cells.values() {
        for a in inside {
            for b in inside {
                let (p, q) = (corners(*a), corners(*b));
                if a != b && apart(*a, *b) && (0..3).any(|k| passes_through(p[k], p[(k + 1) % 3], q)) {
                    found.push([*a, *b]);
                }
            }
        }
    }
    found
}

/// Returns true if the line from `a` to `b` passes through a triangle (Möller and Trumbore 1997).
fn passes_through(a: Vector, b: Vector, [p, q, r]: [Vector; 3]) -> bool {
    let (along, e1, e2, from) = (subtract(b, a), subtract(q, p), subtract(r, p), subtract(a, p));
    let normal = cross(along, e2);
    let determinant = dot(e1, normal);
    if determinant.abs() < 1e-15 {
        return false;
    }
    let other = cross(from, e1);
    let [u, v, t] = [dot(from, normal), dot(along, other), dot(e2, other)].map(|value| value / determinant);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

#[test]
fn cloths_do_not_pass_through_themselves() {
    for builtin in [Builtin::Cloth, Builtin::Table] {
        let scene = builtin.scene();
        let part = scene.parts.iter().find(|part| part.name == "cloth").unwrap();
        let found = crossings(&part.mesh);
        assert!(found.is_empty(), "{builtin:?}: {} crossings, {:?}", found.len(), &found[..found.len().min(9)]);
        // The control: two sheets that do intersect.
        let mut folded = part.mesh.clone();
        for vertex in &mut folded.vertices {
            vertex.position[1] = if vertex.position[0] < 0.0 { 0.3 * vertex.position[0] } else { vertex.position[1] };
        }
        let second = part.mesh.vertices.len() as u32;
        folded.vertices.extend(part.mesh.vertices.iter().copied());
        folded.triangles.extend(part.mesh.triangles.iter().map(|t| t.map(|corner| corner + second)));
        assert!(!crossings(&folded).is_empty());
    }
}

/// All objects rest on the table: none floats or sinks in.
#[test]
fn objects_rest_on_the_table() {
    let scene = Builtin::Table.scene();
    for part in &scene.parts[1..] {
        let lowest = part.mesh.vertices.iter().map(|vertex| vertex.position[1]).fold(f32::INFINITY, f32::min);
        assert!((-1e-6..0.01).contains(&lowest), "{}: {lowest}", part.name);
    }
    let all = |name: &str| scene.parts.iter().find(|part| part.name == name).unwrap().mesh.vertices.clone();
    for [a, b] in [["cloth", "ball"], ["cloth", "vase"], ["vase", "ball"]] {
        let others = all(b);
        let nearest = all(a)
            .iter()
            .flat_map(|p| {
                others
                    .iter()
                    .map(|q| {
                        let off = subtract(double(p.position), double(q.position));
                        dot(off, off)
                    })
                    .reduce(f64::min)
            })
            .fold(f64::INFINITY, f64::min)
            .sqrt();
        assert!(nearest > 0.03, "{a} and {b}: {nearest}");
    }
}

/// Orientation of textures: relief is lit and shifted by directions in the frame of the vertices.
#[test]
fn frames_follow_the_coordinates_of_textures() {
    let balls = [Builtin::Sphere, Builtin::BumpyBall];
    let others = [Builtin::Plane, Builtin::Bottle, Builtin::Vase, Builtin::Teapot, Builtin::RibbedTorus];
    for builtin in balls.into_iter().chain(others) {
        let mesh = builtin.scene().parts.remove(0).mesh;
        for triangle in 0..mesh.triangles.len() {
            let Some([along_u, along_v]) = along_uv(&mesh, &mesh.triangles[triangle]) else { continue };
            for corner in mesh.triangles[triangle] {
                let vertex = mesh.vertices[corner as usize];
                let (t, n) = (double(vertex.tangent), double(vertex.normal));
                let cosine = |a: Vector, b: Vector| dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
                let found = [cosine(along_u, t), cosine(along_v, cross(n, t))];
                // Shear at the poles of balls, and on the knob of the lid.
                let least = if balls.contains(&builtin) { 0.0 } else { 0.7 };
                assert!(found.iter().all(|c| *c > least), "{builtin:?}: {found:?} at {:?}", vertex.position);
            }
        }
    }
}

/// The number of tiles is also whole, so that a texture meets itself without a seam.
#[test]
fn tiles_are_square_and_close_all_around() {
    for (builtin, around) in [(Builtin::Plane, None), (Builtin::Bottle, Some(2.0)), (Builtin::Vase, Some(3.0))] {
        let mesh = builtin.scene().parts.remove(0).mesh;
        for triangle in 0..mesh.triangles.len() {
            let [u, v] = along_uv(&mesh, &mesh.triangles[triangle]).unwrap().map(|along| dot(along, along).sqrt());
            assert!((0.9..1.1).contains(&(u / v)), "{builtin:?}: {u} {v}");
        }
        let range = |k: usize| {
            let all = mesh.vertices.iter().map(|vertex| vertex.uv[k]);
            all.clone().fold(f32::MAX, f32::min)..=all.fold(f32::MIN, f32::max)
        };
        assert_eq!((*range(0).start(), *range(0).end()), (0.0, around.unwrap_or(1.0)), "{builtin:?}");
    }
}
