//! A landscape of ridges, seen from just above.

use super::grid_mesh::through;
use super::sky;
use crate::scene::{Camera, Part, PointLight, Scene, Surface};
use brdfc_flat_btf::structures::noise::{fractal, value_noise};
use brdfc_formats::direction::Vector;
use std::f64::consts::PI;

/// Quads per side: 45,000 triangles.
const QUADS: usize = 150;
/// Length of a side.
const EXTENT: f64 = 300.0;
/// Height of the eye above the ground.
const EYE_HEIGHT: f64 = 9.0;

/// Height over the plane: mountains on both sides and in the distance, and rough ground everywhere.
fn height(x: f64, z: f64) -> f64 {
    let hills = 12.0 * value_noise(x / 90.0 + 3.1, z / 90.0 + 8.7, 1, None);
    // Sharp at sign changes of the noise; squared, so that ridges are narrow and valleys are wide.
    let ridged = |n: f64| (1.0 - n.abs()).powi(2) - 0.35;
    let ridges = 40.0 * fractal(x / 70.0 + 0.3, z / 70.0, 11, 4, 0.36, ridged);
    // Quads far from the eye are too large for the roughness.
    let near = (0.5 + z / EXTENT).clamp(0.0, 1.0);
    let distance_squared = x * x + (0.5 * EXTENT - z) * (0.5 * EXTENT - z);
    let rough = 1.2 / (1.0 + distance_squared / 11000.0);
    let bumps = rough * fractal(x / 5.5, z / 5.5, 29, 4, 0.62, |n| n);
    // A valley along the camera's line of sight, which bends and ends at the mountains.
    let bend = 14.0 * (z / 45.0).sin();
    let aside = ((x - bend) / 75.0).powi(2).min(1.0);
    hills * (0.3 + 0.7 * aside)
        + ridges * (0.1 + 0.5 * aside * (1.0 - near.powi(4)) + 0.4 * (1.0 - near).powi(3))
        + bumps
}

/// Position in the plane, with small quads near the eye: in the middle of the near side.
fn ground(u: f64, v: f64) -> [f64; 2] {
    let s = 2.0 * u - 1.0;
    let across = s * (0.4 + 0.6 * s * s);
    let along = v * (0.25 + 0.75 * v);
    [0.5 * EXTENT * across, EXTENT * (0.5 - along)]
}

pub(super) fn scene() -> Scene {
    let share = |index: usize| index as f64 / QUADS as f64;
    let point = |index: usize| {
        let [x, z] = ground(share(index % (QUADS + 1)), share(index / (QUADS + 1)));
        [x, height(x, z), z]
    };
    let points: Vec<Vector> = (0..(QUADS + 1) * (QUADS + 1)).map(point).collect();
    // Normals of the mesh itself, since some of the relief is finer than the far quads.
    let mesh = through(&points, QUADS);
    let eye_z = 0.5 * EXTENT - 2.0;
    let eye = [0.0, height(0.0, eye_z) + EYE_HEIGHT, eye_z];
    let light = |position, radiance: f64, colour: [f64; 3]| PointLight {
        position,
        intensity: colour.map(|c| PI * radiance * c),
    };
    Scene {
        parts: vec![Part { name: "terrain", mesh, surface: Surface::default() }],
        camera: Camera { eye, target: [0.0, eye[1] - 26.0, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 42.0 },
        // Low and opposite, so that glossy slopes glitter. A weak light behind the eye stands for the sky.
        lights: vec![
            light([-230.0, 230.0, -520.0], 4e5, [1.0, 0.9, 0.74]),
            light([260.0, 260.0, 330.0], 6e4, [0.6, 0.78, 1.0]),
        ],
        environment: sky::environment(),
        background: [0.42, 0.55, 0.72],
    }
}
