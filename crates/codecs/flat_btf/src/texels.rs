//! Surface points of the texels of a flat BTF: position and normal map (section 3.3 of Hadim et al. 2009).

use super::mesh::{MAX_MATERIALS, PeriodicMesh, corner_coordinates, twice_area};
use super::project::project;
use super::surface::SurfacePoint;

/// Surface points of a square of texels, row by row; texel `(column, row)` has parameters
/// `((column + ½) / size, (row + ½) / size)`.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelMap {
    /// Texels per side.
    pub size: usize,
    /// One point for each texel.
    pub points: Vec<SurfacePoint>,
}

/// Tolerance, in barycentric coordinates, for texel centres outside a triangle: covers rounding.
const EDGE: f64 = 1e-9;

/// Finds the surface point of each texel. A centre on an edge belongs to the triangle that comes first.
///
/// # Panics
/// Panics if the parameters do not cover the square: they are no parameterisation of this mesh.
pub fn texel_map(mesh: &PeriodicMesh, coordinates: &[[f64; 2]], size: usize) -> TexelMap {
    let mut points: Vec<Option<SurfacePoint>> = vec![None; size * size];
    let scale = size as f64;
    for triangle in 0..mesh.triangles.len() {
        let corners = corner_coordinates(mesh, coordinates, triangle).map(|c| c.map(|c| c * scale - 0.5));
        let whole = twice_area(corners);
        let range = |k: usize| {
            let c = corners.map(|corner| corner[k]);
            let (low, high) = (c[0].min(c[1]).min(c[2]), c[0].max(c[1]).max(c[2]));
            (low - EDGE).ceil() as i64..=(high + EDGE).floor() as i64
        };
        for row in range(1) {
            for column in range(0) {
                let at = [column as f64, row as f64];
                let u = twice_area([corners[0], at, corners[2]]) / whole;
                let v = twice_area([corners[0], corners[1], at]) / whole;
                if u < -EDGE || v < -EDGE || u + v > 1.0 + EDGE {
                    continue;
                }
                let n = size as i64;
                let texel = (row.rem_euclid(n) * n + column.rem_euclid(n)) as usize;
                if points[texel].is_none() {
                    let tile = [-column.div_euclid(n) as i32, -row.div_euclid(n) as i32];
                    points[texel] = Some(SurfacePoint::new(mesh, triangle, [u, v], tile));
                }
            }
        }
    }
    let points = points.into_iter().map(|point| point.expect("parameters cover the square")).collect();
    TexelMap { size, points }
}

/// Reflectance of texels: the fields of the surface that bilinear interpolation of texels approximates best.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelSurface {
    /// Unit shading normals.
    pub normals: Vec<[f32; 3]>,
    /// Share of each source in the reflectance, for each channel, not negative.
    pub shares: Vec<[[f32; 3]; MAX_MATERIALS]>,
}

/// Points of the surface per texel and axis.
const FINER: usize = 2;
const NUMBERS: usize = 3 + 3 * MAX_MATERIALS;

/// Projects normals and materials of a surface onto `size x size` texels. `shares` are [`Appearance::shares`].
///
/// [`Appearance::shares`]: super::surface::Appearance::shares
///
/// # Panics
/// Panics if the parameters do not cover the square.
pub fn texel_surface(
    mesh: &PeriodicMesh,
    coordinates: &[[f64; 2]],
    size: usize,
    shares: impl Fn(&SurfacePoint) -> [[f32; 3]; MAX_MATERIALS] + Sync,
) -> TexelSurface {
    let fine = texel_map(mesh, coordinates, size * FINER);
    let numbers = |at: usize| -> [f32; NUMBERS] {
        let point = &fine.points[at];
        let shares = shares(point);
        std::array::from_fn(|k| if k < 3 { point.normal[k] as f32 } else { shares[(k - 3) / 3][k % 3] })
    };
    let texels = project(size, FINER, numbers);
    let normal = |numbers: &[f32; NUMBERS]| {
        let [x, y, z] = [0, 1, 2].map(|k: usize| f64::from(numbers[k]));
        let length = (x * x + y * y + z * z).sqrt();
        // Opposite normals cancel only in folds thinner than a texel.
        if length > 1e-3 { [x, y, z].map(|c| (c / length) as f32) } else { [0.0, 0.0, 1.0] }
    };
    let shares =
        |numbers: &[f32; NUMBERS]| std::array::from_fn(|m| std::array::from_fn(|c| numbers[3 + 3 * m + c].max(0.0)));
    TexelSurface { normals: texels.iter().map(normal).collect(), shares: texels.iter().map(shares).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameterise::parameterise;
    use crate::testing::{height_field, overhang};

    #[test]
    fn texels_of_a_plane_have_its_positions() {
        let mesh = height_field(7, |_, _| 0.25);
        let found = parameterise(&mesh, 0, &()).unwrap();
        let map = texel_map(&mesh, &found.coordinates, 16);
        for (index, point) in map.points.iter().enumerate() {
            let expected = [(index % 16) as f64 / 16.0 + 1.0 / 32.0, (index / 16) as f64 / 16.0 + 1.0 / 32.0, 0.25];
            assert!((0..3).all(|k| (point.position[k] - expected[k]).abs() < 1e-9), "{index} {point:?}");
        }
    }

    #[test]
    fn neighbours_in_parameters_are_neighbours_in_space_across_borders_too() {
        let mesh = overhang(32);
        let found = parameterise(&mesh, 0, &()).unwrap();
        let n = 64;
        let map = texel_map(&mesh, &found.coordinates, n);
        let mut longest = 0.0f64;
        for row in 0..n {
            for column in 0..n {
                let [a, b] = [column, column + 1].map(|c| {
                    let mut p = map.points[row * n + c % n].position;
                    p[0] += (c / n) as f64;
                    p
                });
                longest = longest.max((0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt());
            }
        }
        assert!(longest < 0.06, "{longest}");
    }
}
