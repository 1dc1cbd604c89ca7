//! Surfaces of revolution and tubes, with square tiles.

use super::grid_mesh::{quads, surface, vertex};
use crate::scene::Mesh;
use crate::vector::{add_scaled, cross, subtract};
use brdfc_formats::direction::{Vector, dot, normalize};
use std::f64::consts::TAU;

/// Steps per row of a mesh, for the length of a curve.
const STEPS: usize = 16;

/// A surface of revolution around the y axis; `profile` is radius and height, t from 0 to 1 upwards. Tangents run
/// around. u goes once around in `turns` tiles, v along the profile at the scale of u there: tiles are square, and
/// smaller at smaller radii.
pub(super) fn revolution(columns: usize, rows: usize, turns: u32, profile: impl Fn(f64) -> [f64; 2]) -> Mesh {
    let mut mesh = surface(columns, rows, |u, t| {
        let (phi, [r, y]) = (-TAU * u, profile(t));
        [r * phi.cos(), y, r * phi.sin()]
    });
    let tiles = conformal(rows, f64::from(turns), |t| {
        let [r, y] = profile(t);
        ([r, y, 0.0], r)
    });
    set_tiles(&mut mesh, columns, turns, &tiles);
    mesh
}

/// A tube around a curve in the plane z = 0, t from 0 to 1; `curve` returns a point and the radius there. Tiles are
/// as in [`revolution`]; tangents run around.
pub(super) fn tube(columns: usize, rows: usize, turns: u32, curve: impl Fn(f64) -> (Vector, f64)) -> Mesh {
    const STEP: f64 = 1e-4;
    let mut mesh = surface(columns, rows, |u, t| {
        let (centre, r) = curve(t);
        let along = normalize(subtract(curve(t + STEP).0, curve(t - STEP).0));
        let side = cross([0.0, 0.0, 1.0], along);
        let phi = TAU * u;
        add_scaled(add_scaled(centre, r * phi.cos(), side), r * phi.sin(), [0.0, 0.0, 1.0])
    });
    let tiles = conformal(rows, f64::from(turns), curve);
    set_tiles(&mut mesh, columns, turns, &tiles);
    mesh
}

/// A round cap around the y axis, `profile` from the pole (radius 0) outwards. uv are as on a disc: straight from
/// the pole at the length of the profile, so that tiles do not shrink there. `unit` is the length of a tile.
pub(super) fn cap(columns: usize, rows: usize, unit: f64, profile: impl Fn(f64) -> [f64; 2]) -> Mesh {
    const STEP: f64 = 1e-4;
    let lengths = lengths(rows, |t| {
        let [r, y] = profile(t);
        [r, y, 0.0]
    });
    let mut mesh = Mesh::default();
    for (row, length) in lengths.iter().enumerate() {
        let t = row as f64 / rows as f64;
        let ([r, y], [r0, y0], [r1, y1]) = (profile(t), profile(t - STEP), profile(t + STEP));
        for column in 0..=columns {
            let phi = TAU * column as f64 / columns as f64;
            let (outwards, around) = ([phi.cos(), 0.0, phi.sin()], [-phi.sin(), 0.0, phi.cos()]);
            let along = normalize(add_scaled([0.0, y1 - y0, 0.0], r1 - r0, outwards));
            let normal = cross(around, along);
            let tangent = add_scaled(along.map(|c| c * phi.cos()), -phi.sin(), around);
            let uv = [length * phi.cos() / unit, -length * phi.sin() / unit];
            mesh.vertices.push(vertex(add_scaled([0.0, y, 0.0], r, outwards), normal, tangent, uv));
        }
    }
    mesh.triangles = quads(columns, rows);
    without_slivers(&mut mesh);
    mesh
}

/// Removes triangles without area, such as triangles at a pole.
fn without_slivers(mesh: &mut Mesh) {
    let at = |corner: u32| mesh.vertices[corner as usize].position.map(f64::from);
    mesh.triangles.retain(|[a, b, c]| {
        let face = cross(subtract(at(*b), at(*a)), subtract(at(*c), at(*a)));
        dot(face, face) > 1e-18
    });
}

/// Length of a curve up to each row.
fn lengths(rows: usize, point: impl Fn(f64) -> Vector) -> Vec<f64> {
    sums(rows, |a, b| {
        let step = subtract(point(b), point(a));
        dot(step, step).sqrt()
    })
}

/// Tiles up to each row if tiles are square, with `turns` of them around the circumference.
fn conformal(rows: usize, turns: f64, curve: impl Fn(f64) -> (Vector, f64)) -> Vec<f64> {
    sums(rows, |a, b| {
        let (step, radius) = (subtract(curve(b).0, curve(a).0), curve(0.5 * (a + b)).1);
        turns * dot(step, step).sqrt() / (TAU * radius)
    })
}

/// Running sums of a value over small steps from 0 to 1, row by row.
fn sums(rows: usize, value: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let last = rows * STEPS;
    let mut sum = 0.0;
    let mut sums = vec![0.0];
    for step in 0..last {
        sum += value(step as f64 / last as f64, (step + 1) as f64 / last as f64);
        if (step + 1).is_multiple_of(STEPS) {
            sums.push(sum);
        }
    }
    sums
}

fn set_tiles(mesh: &mut Mesh, columns: usize, turns: u32, rows: &[f64]) {
    for (row, vertices) in mesh.vertices.chunks_exact_mut(columns + 1).enumerate() {
        for vertex in vertices {
            vertex.uv = [vertex.uv[0] * turns as f32, rows[row] as f32];
        }
    }
}
