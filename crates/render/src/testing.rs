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
    };
    Mesh {
        vertices: vec![vertex(-1.0, -1.0), vertex(1.0, -1.0), vertex(1.0, 1.0), vertex(-1.0, 1.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
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
