//! Stretch of parameterisations (Sander et al. 2001, "Texture mapping progressive meshes"): how unevenly texels are
//! distributed over the surface.

use super::mesh::{PeriodicMesh, corner_coordinates, twice_area};
use brdfc_formats::direction::{Vector, cross, dot, subtract};

/// Stretch of a whole surface. Lengths are relative to an area-preserving map: 1 everywhere is ideal.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Stretch {
    /// Root mean square over the surface of the stretch in all directions; 1 or more.
    pub l2: f64,
    /// Largest stretch in any direction at any point.
    pub largest: f64,
    /// Area of the surface, in tiles.
    pub area: f64,
    /// Smallest share of parameter area that a piece of surface has, relative to an even share.
    pub smallest_share: f64,
}

/// For one triangle: the squared singular values of its map from parameters to space, larger first, its area in space,
/// and its area in parameters.
struct Local {
    singular_squared: [f64; 2],
    area: f64,
    parameter_area: f64,
}

fn local(mesh: &PeriodicMesh, coordinates: &[[f64; 2]], triangle: usize) -> Local {
    let [p, q, r] = mesh.corners(triangle);
    let c = corner_coordinates(mesh, coordinates, triangle);
    let twice = twice_area(c);
    let combine = |k: usize, sign: f64| -> Vector {
        let [a, b, d] = [c[1][k] - c[2][k], c[2][k] - c[0][k], c[0][k] - c[1][k]];
        [0, 1, 2].map(|axis| sign * (p[axis] * a + q[axis] * b + r[axis] * d) / twice)
    };
    let (along_u, along_v) = (combine(1, 1.0), combine(0, -1.0));
    let (a, b, d) = (dot(along_u, along_u), dot(along_u, along_v), dot(along_v, along_v));
    let root = ((a - d).powi(2) + 4.0 * b * b).sqrt();
    let normal = cross(subtract(q, p), subtract(r, p));
    Local {
        singular_squared: [0.5 * (a + d + root), (0.5 * (a + d - root)).max(0.0)],
        area: 0.5 * dot(normal, normal).sqrt(),
        parameter_area: 0.5 * twice,
    }
}

/// Stretch of the whole mesh.
pub fn measure(mesh: &PeriodicMesh, coordinates: &[[f64; 2]]) -> Stretch {
    let (mut sum, mut area, mut largest, mut smallest) = (0.0, 0.0, 0.0f64, f64::INFINITY);
    for triangle in 0..mesh.triangles.len() {
        let local = local(mesh, coordinates, triangle);
        let [large, small] = local.singular_squared;
        sum += 0.5 * (large + small) * local.area;
        area += local.area;
        largest = largest.max(large);
        if local.area > 0.0 {
            smallest = smallest.min(local.parameter_area / local.area);
        }
    }
    // An even map of a surface of this area onto the unit square stretches by the root of the area.
    Stretch { l2: (sum / area / area).sqrt(), largest: (largest / area).sqrt(), area, smallest_share: smallest * area }
}

/// Stretch at each vertex: root mean square over the adjacent triangles, weighted by area.
pub fn vertex_stretch(mesh: &PeriodicMesh, coordinates: &[[f64; 2]]) -> Vec<f64> {
    let mut sums = vec![[0.0f64; 2]; mesh.positions.len()];
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let local = local(mesh, coordinates, index);
        let [large, small] = local.singular_squared;
        for corner in triangle {
            let sum = &mut sums[corner.vertex as usize];
            sum[0] += 0.5 * (large + small) * local.area;
            sum[1] += local.area;
        }
    }
    sums.into_iter().map(|[stretch, area]| if area > 0.0 { (stretch / area).sqrt().max(1e-6) } else { 1.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::height_field;

    #[test]
    fn a_slope_has_the_stretch_of_its_slope() {
        let slope = 0.75f64;
        // A roof, up and down so that it closes. Parameterised straight down.
        let mesh = height_field(8, |x, _| slope * (0.5 - (x - 0.5).abs()));
        let flat: Vec<[f64; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
        let stretch = measure(&mesh, &flat);
        let length = (1.0 + slope * slope).sqrt();
        assert!((stretch.area - length).abs() < 1e-12);
        let expected = ((length * length + 1.0) / 2.0 / length).sqrt();
        assert!((stretch.l2 - expected).abs() < 1e-12, "{} {expected}", stretch.l2);
        assert!((stretch.largest - (length * length / length).sqrt()).abs() < 1e-12);
        assert!((stretch.smallest_share - 1.0).abs() < 1e-12);
        assert!(vertex_stretch(&mesh, &flat).iter().all(|s| (s - expected * length.sqrt()).abs() < 1e-9));
    }
}
