//! Footprints of pixels in the coordinates of a surface.

use crate::scene::{Frame, Mesh, Scene};
use crate::trace::Hit;
use crate::vector::{cross, double, subtract};
use brdfc_formats::direction::{Vector, dot};

/// Change of uv to the pixel on the right and to the pixel below, on the plane of the triangle that is hit at `[x, y]`.
/// Infinite if a neighbour does not see that plane.
pub(crate) fn footprint(scene: &Scene, frame: Frame, hit: &Hit, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    let mesh = &scene.parts[hit.part as usize].mesh;
    let camera = &scene.camera;
    let seen = |x: f64, y: f64| plane_coordinates(mesh, hit.triangle, camera.eye, camera.ray(frame, x, y));
    let here = seen(x, y);
    let step = |there: Option<[f64; 2]>| match (here, there) {
        (Some([u, v]), Some([s, t])) => [s - u, t - v],
        _ => [f64::INFINITY; 2],
    };
    [step(seen(x + 1.0, y)), step(seen(x, y + 1.0))]
}

/// Extrapolated coordinates where a ray meets the plane of a triangle.
fn plane_coordinates(mesh: &Mesh, triangle: u32, eye: Vector, ray: Vector) -> Option<[f64; 2]> {
    let corners = mesh.triangles[triangle as usize].map(|corner| &mesh.vertices[corner as usize]);
    let [a, b, c] = corners.map(|corner| double(corner.position));
    let (along, across) = (subtract(b, a), subtract(c, a));
    let normal = cross(along, across);
    let distance = dot(normal, subtract(a, eye)) / dot(normal, ray);
    if !(distance > 0.0 && distance.is_finite()) {
        return None;
    }
    let p = subtract([0, 1, 2].map(|k| eye[k] + distance * ray[k]), a);
    let area = dot(normal, normal);
    let weights = [dot(normal, cross(p, across)) / area, dot(normal, cross(along, p)) / area];
    Some([0, 1].map(|k| {
        let [first, second, third] = corners.map(|corner| f64::from(corner.uv[k]));
        first + weights[0] * (second - first) + weights[1] * (third - first)
    }))
}

/// Mipmap level of a pixel, from the change of uv to its neighbours, on `size` texels that repeat `repeat` times per
/// unit of uv: the twin of `pwt_mipmap_level`.
pub(crate) fn mipmap_level([right, below]: [[f64; 2]; 2], repeat: u32, size: [usize; 2]) -> f32 {
    let texels = |axis: usize| f64::from(repeat) * size[axis] as f64;
    let squared = |step: [f64; 2]| (0..2).map(|axis| (step[axis] * texels(axis)).powi(2)).sum::<f64>();
    (0.5 * squared(right).max(squared(below)).max(1e-20).log2()).max(0.0) as f32
}

/// Mipmap level of one of `samples²` samples of a pixel: half the mean, in octaves, of both sides of its footprint. The
/// longer side alone would blur detail across it, and mix neighbours with hidden texels on a flat BTF; half of it keeps
/// the shadows of the relief. The twin of `factored_mipmap_level`, less the octaves of `samples`.
pub(crate) fn sample_level([right, below]: [[f64; 2]; 2], repeat: u32, size: usize, samples: usize) -> f32 {
    let texels = f64::from(repeat) * size as f64;
    let squared = |step: [f64; 2]| (0..2).map(|axis| (step[axis] * texels).powi(2)).sum::<f64>();
    let of_pixel = 0.25 * (squared(right) * squared(below)).max(1e-20).log2();
    (of_pixel - 1.0 - (samples as f64).log2()) as f32
}

/// Returns true if a triangle is seen from behind.
pub(crate) fn from_behind(mesh: &Mesh, triangle: u32, to_viewer: Vector) -> bool {
    let corners = mesh.triangles[triangle as usize];
    let [a, b, c] = corners.map(|corner| double(mesh.vertices[corner as usize].position));
    dot(cross(subtract(b, a), subtract(c, a)), to_viewer) < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_0_is_a_texel_per_pixel() {
        let level = |right: [f64; 2], below: [f64; 2]| mipmap_level([right, below], 1, [40, 20]);
        assert_eq!(level([1.0 / 40.0, 0.0], [0.0, 1.0 / 20.0]), 0.0);
        assert_eq!(level([4.0 / 40.0, 0.0], [0.0, 1.0 / 20.0]), 2.0);
        assert_eq!(level([0.1 / 40.0, 0.0], [0.0, 0.1 / 20.0]), 0.0);
        assert_eq!(level([f64::INFINITY, 0.0], [0.0, 0.1]), f32::INFINITY);
        assert_eq!(mipmap_level([[1.0 / 40.0, 0.0], [0.0, 1.0 / 20.0]], 2, [40, 20]), 1.0);
        // Eight texels across and two down: between them, four, and half of that; of a sample of four, half as many
        // per side.
        let [right, below] = [[8.0 / 40.0, 0.0], [0.0, 2.0 / 40.0]];
        assert_eq!([1, 2, 8].map(|samples| sample_level([right, below], 1, 40, samples)), [1.0, 0.0, -2.0]);
        assert_eq!(sample_level([right, below], 2, 40, 1), 2.0);
        assert_eq!(sample_level([[f64::INFINITY, 0.0], below], 1, 40, 1), f32::INFINITY);
    }
}
