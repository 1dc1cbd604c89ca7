//! Small scenes for tests.

use super::scene::{Camera, Environment, Mesh, Part, Scene, Surface, Vertex};

/// A square in the plane `z`, seen from +z; tangent x, uv 0 to 1.
pub(crate) fn quad(side: f32, z: f32) -> Mesh {
    let h = 0.5 * side;
    let vertex = |x: f32, y: f32| Vertex {
        position: [x * h, y * h, z],
        normal: [0.0, 0.0, 1.0],
        tangent: [1.0, 0.0, 0.0],
        uv: [0.5 + 0.5 * x, 0.5 + 0.5 * y],
        raised_by: 0.0,
        border: 0.0,
    };
    Mesh {
        vertices: vec![vertex(-1.0, -1.0), vertex(1.0, -1.0), vertex(1.0, 1.0), vertex(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A cylinder around the y axis, from -1 to 1, seen from outside. u goes around once, v along it at the same scale.
pub(crate) fn ring(radius: f64) -> Mesh {
    const COLUMNS: u32 = 128;
    let vertex = |row: f64, column: u32| {
        let turn = f64::from(column) / f64::from(COLUMNS);
        let (sine, cosine) = (-std::f64::consts::TAU * turn).sin_cos();
        let single = |v: [f64; 3]| v.map(|c| c as f32);
        Vertex {
            position: single([radius * cosine, row, radius * sine]),
            normal: single([cosine, 0.0, sine]),
            tangent: single([sine, 0.0, -cosine]),
            uv: [turn as f32, (row / (std::f64::consts::TAU * radius)) as f32],
            raised_by: 0.0,
            border: 0.0,
        }
    };
    let [a, b] = [0, COLUMNS + 1];
    let quad = |k: u32| [[a + k, a + k + 1, b + k], [a + k + 1, b + k + 1, b + k]];
    Mesh {
        vertices: [-1.0, 1.0].into_iter().flat_map(|row| (0..=COLUMNS).map(move |k| vertex(row, k))).collect(),
        triangles: (0..COLUMNS).flat_map(quad).collect(),
    }
}

/// One part without lights.
pub(crate) fn plain_scene(mesh: Mesh, camera: Camera) -> Scene {
    Scene {
        parts: vec![Part { name: "part", mesh, surface: Surface::default() }],
        camera,
        lights: Vec::new(),
        environment: Environment { width: 1, height: 1, pixels: vec![[1.0; 3]] },
        background: [0.25, 0.5, 0.75],
    }
}
