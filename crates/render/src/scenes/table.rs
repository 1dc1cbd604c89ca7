//! A still life: table top, cloth, vase and ball.

use super::drape::Drape;
use super::grid_mesh::{surface, through};
use super::sky;
use super::sphere::ball;
use crate::scene::{Camera, HeightMap, Mesh, Part, PointLight, Scene, Surface};
use brdfc_flat_btf::structures::noise::value_noise;
use brdfc_formats::direction::Vector;
use std::f64::consts::{PI, TAU};

/// Texels per side of the table top's bump map.
const GRAIN_SIZE: usize = 256;
/// Share of the mirrored environment in the ball.
const MIRROR: f32 = 0.22;

/// A cloth over a drum; its corners lie on the table.
const CLOTH: Drape =
    Drape { side: 1.5, quads: 74, offset: [0.02, 0.01], radius: 0.36, rim: 0.08, floor: -0.5, seed: 11 };

pub(super) fn scene() -> Scene {
    let part = |name, mesh, surface| Part { name, mesh, surface };
    Scene {
        parts: vec![
            part("top", top(), Surface { bump: Some(grain()), mirror: 0.0 }),
            part(
                "cloth",
                moved(through(&CLOTH.fall(), CLOTH.quads), [-0.72, 0.006 - CLOTH.floor, -0.3]),
                Surface::default(),
            ),
            part("vase", vase(), Surface::default()),
            part("ball", ball(0.27, [0.2, 0.27, 0.7], 96, 48), Surface { bump: None, mirror: MIRROR }),
        ],
        camera: Camera { eye: [0.25, 1.75, 3.9], target: [0.02, 0.38, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 31.0 },
        lights: vec![
            PointLight { position: [-2.8, 2.9, 2.2], intensity: [1.0, 0.95, 0.86].map(|c| PI * 24.0 * c) },
            PointLight { position: [3.2, 2.0, 1.5], intensity: [0.8, 0.9, 1.0].map(|c| PI * 8.0 * c) },
        ],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}

/// A square top with uv along the grain.
fn top() -> Mesh {
    surface(16, 16, |u, v| [5.2 * (u - 0.5), 0.0, 4.0 * (0.5 - v) + 0.3])
}

/// Wood: long fibres along u with rings that wander. Periodic.
fn grain() -> HeightMap {
    let height = |index: usize| {
        let u = (index % GRAIN_SIZE) as f64 / GRAIN_SIZE as f64;
        let v = (index / GRAIN_SIZE) as f64 / GRAIN_SIZE as f64;
        let wander = 0.05 * (TAU * u).sin() + 0.03 * (2.0 * TAU * u + 1.0).cos();
        let rings = (TAU * (9.0 * (v + wander))).sin();
        let fibres = value_noise(6.0 * u, 64.0 * v, 5, Some([6, 64]));
        (0.0035 * rings + 0.002 * fibres) as f32
    };
    HeightMap { size: GRAIN_SIZE, heights: (0..GRAIN_SIZE * GRAIN_SIZE).map(height).collect() }
}

/// A surface of revolution; tangents run around it.
fn vase() -> Mesh {
    let radius = |t: f64| {
        let belly = 0.27 * (-((t - 0.36) / 0.26).powi(2)).exp();
        let lip = 0.09 * ((t - 0.86) / 0.14).max(0.0).powi(2);
        0.13 + belly + lip - 0.02 * t
    };
    moved(
        surface(96, 64, |u, v| {
            let phi = -TAU * u;
            let r = radius(v);
            [r * phi.cos(), 1.05 * v, r * phi.sin()]
        }),
        [0.82, 0.0, -0.35],
    )
}

fn moved(mut mesh: Mesh, by: Vector) -> Mesh {
    for vertex in &mut mesh.vertices {
        (0..3).for_each(|k| vertex.position[k] += by[k] as f32);
    }
    mesh
}
