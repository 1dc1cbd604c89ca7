//! Numbers of repetitions of a texture on a mesh, from its size in metres.

use crate::scene::{Mesh, Vertex};
use crate::vector::{cross, double, subtract};
use brdfc_formats::direction::{Vector, dot};

/// Maximum repetitions per unit of a texture coordinate: single precision leaves 4096 steps for each.
pub const MAX_REPEATS: f64 = 4096.0;

/// Repetitions of a texture of this size in metres per unit of u and v, whole numbers of 1 to 4096. Texture
/// coordinates of closed surfaces then meet without a seam.
///
/// # Errors
/// Returns the smallest and the largest size if this size is not between them: the largest is twice that of the surface.
pub fn repeats(mesh: &Mesh, metres: [f64; 2]) -> Result<[f32; 2], [[f64; 2]; 2]> {
    let surface = metres_per_unit(mesh);
    let counts = [0, 1].map(|k| (surface[k] / metres[k]).round());
    match counts.iter().all(|count| (1.0..=MAX_REPEATS).contains(count)) {
        true => Ok(counts.map(|count| count as f32)),
        false => Err([surface.map(|side| side / MAX_REPEATS), surface.map(|side| 2.0 * side)]),
    }
}

/// Metres of the surface per unit of u and v: means over its area. 0 without coordinates.
pub fn metres_per_unit(mesh: &Mesh) -> [f64; 2] {
    let (mut sums, mut all) = ([0.0; 2], 0.0);
    for triangle in &mesh.triangles {
        let Some([along_u, along_v]) = along_uv(mesh, triangle) else { continue };
        let [a, b, c] = triangle.map(|corner| double(mesh.vertices[corner as usize].position));
        let normal = cross(subtract(b, a), subtract(c, a));
        let area = dot(normal, normal).sqrt();
        for (sum, along) in sums.iter_mut().zip([along_u, along_v]) {
            *sum += area * dot(along, along).sqrt();
        }
        all += area;
    }
    if all > 0.0 { sums.map(|sum| sum / all) } else { [0.0; 2] }
}

/// Change of a triangle's position with u and with v; `None` if its coordinates do not span a triangle.
pub(crate) fn along_uv(mesh: &Mesh, triangle: &[u32; 3]) -> Option<[Vector; 2]> {
    let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize]);
    let edge = |end: Vertex| subtract(double(end.position), double(a.position));
    let step = |end: Vertex| [0, 1].map(|k| f64::from(end.uv[k] - a.uv[k]));
    let ([e, f], [g, h]) = (step(b), step(c));
    let determinant = e * h - f * g;
    let solve = |s: f64, t: f64| [0, 1, 2].map(|k| (s * edge(b)[k] + t * edge(c)[k]) / determinant);
    (determinant.abs() > 1e-12).then(|| [solve(h, -f), solve(-g, e)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::Builtin;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_size_gives_whole_numbers_of_repetitions() {
        let mesh = &Builtin::Sphere.scene().parts[0].mesh;
        let [x, y, z] = double(mesh.vertices[0].position);
        let radius = x.hypot(y).hypot(z);
        // Over the area of a sphere, the mean of the sine of the polar angle is π/4.
        let [around, down] = metres_per_unit(mesh);
        assert!((around / (TAU * radius * PI / 4.0) - 1.0).abs() < 0.01, "{around}");
        assert!((down / (PI * radius) - 1.0).abs() < 0.01, "{down}");
        assert_eq!(repeats(mesh, [around / 7.2, down / 2.9]), Ok([7.0, 3.0]));
        for wrong in [[around / 1e5, down], [around, 2.1 * down]] {
            assert_eq!(
                repeats(mesh, wrong),
                Err([[around / MAX_REPEATS, down / MAX_REPEATS], [2.0 * around, 2.0 * down]])
            );
        }
    }
}
