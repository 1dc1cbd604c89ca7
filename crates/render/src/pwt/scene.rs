//! An image on the ground, seen from above.

use crate::scene::{Camera, PointLight, Scene};
use crate::scenes::Builtin;
use std::f64::consts::PI;

/// Vertical angle of view, degrees.
const FIELD_OF_VIEW: f64 = 30.0;
/// Share of the frame that the image fills.
const FILLED: f64 = 0.98;
/// Distance of the light, in halves of the image's longer side: its direction and brightness are the same everywhere.
const DISTANCE: f64 = 1e4;
/// Direction of the light in the frame of the image: from the upper left.
const LIGHT: [f64; 3] = [-0.48, 0.48, 0.734];

/// [`Builtin::Plane`] in the proportions of an image, its longer side 2, under a camera that sees all of it. The right
/// of the image is +x, its top -z. `frame` is the width and height of the rendering.
pub fn image_scene(size: [usize; 2], frame: [usize; 2]) -> Scene {
    let mut scene = Builtin::Plane.scene();
    let longer = size[0].max(size[1]) as f64;
    let half = size.map(|side| side as f64 / longer);
    for vertex in scene.parts.iter_mut().flat_map(|part| &mut part.mesh.vertices) {
        vertex.position[0] *= half[0] as f32;
        vertex.position[2] *= half[1] as f32;
    }
    let needed = half[1].max(half[0] * frame[1] as f64 / frame[0] as f64);
    let height = needed / (FILLED * (0.5 * FIELD_OF_VIEW.to_radians()).tan());
    scene.camera =
        Camera { eye: [0.0, height, 0.0], target: [0.0; 3], up: [0.0, 0.0, -1.0], field_of_view: FIELD_OF_VIEW };
    scene.lights = vec![distant_light(LIGHT)];
    scene
}

/// A distant light in a direction of the image's frame, under which white has the radiance 1.
pub fn distant_light([x, y, z]: [f64; 3]) -> PointLight {
    let position = [x, z, -y].map(|c| c * DISTANCE);
    PointLight { position, intensity: [PI * DISTANCE * DISTANCE; 3] }
}
