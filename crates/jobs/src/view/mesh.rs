//! Compact meshes: numbers of up to 16 bits, each stored as the residual of a linear prediction from the two corners before it, and
//! compressed.

use super::packed::packed;
use brdfc_render::scene::{Mesh, Vertex};
use serde::Serialize;

/// Numbers of a corner: position, uv, height above its surface, distance from its border, and two octahedral coordinates each
/// of normal and tangent.
const STREAMS: usize = 11;
/// Numbers that are stored relative to their range: position, uv, height and distance.
const BOUNDED: usize = 7;
/// Largest value of each number: 14 bits of a position, 16 of uv, 14 of height and distance, 13 of a normal, 11 of a tangent.
const MAX_VALUES: [u16; STREAMS] =
    [0x3fff, 0x3fff, 0x3fff, 0xffff, 0xffff, 0x3fff, 0x3fff, 0x1fff, 0x1fff, 0x7ff, 0x7ff];

/// A mesh as pages store it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct PackedMesh {
    vertices: usize,
    triangles: usize,
    /// Lowest value of each bounded number.
    low: [f32; BOUNDED],
    /// Highest minus lowest value of each bounded number.
    span: [f32; BOUNDED],
    /// Largest stored value of each number.
    largest: [u16; STREAMS],
    /// One stream per number: the lower bytes of all corners, then the higher bytes; packed.
    corners: String,
    /// Indices minus the indices of the previous triangle, as 32-bit integers; packed.
    indices: String,
}

impl PackedMesh {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let bounded = |corner: &Vertex| {
            let ([x, y, z], [u, v]) = (corner.position, corner.uv);
            [x, y, z, u, v, corner.raised_by, corner.border]
        };
        let mut low = [f32::MAX; BOUNDED];
        let mut high = [f32::MIN; BOUNDED];
        for numbers in mesh.vertices.iter().map(bounded) {
            for k in 0..BOUNDED {
                low[k] = low[k].min(numbers[k]);
                high[k] = high[k].max(numbers[k]);
            }
        }
        let span: [f32; BOUNDED] = std::array::from_fn(|k| high[k] - low[k]);
        let rounded = |corner: &Vertex| -> [u16; STREAMS] {
            let numbers = bounded(corner);
            let share = |k: usize| if span[k] > 0.0 { (numbers[k] - low[k]) / span[k] } else { 0.0 };
            let ([a, b], [c, d]) = (octahedral(corner.normal), octahedral(corner.tangent));
            let vectors = [a, b, c, d];
            let of = |k: usize| if k < BOUNDED { share(k) } else { 0.5 * vectors[k - BOUNDED] + 0.5 };
            std::array::from_fn(|k| (of(k) * f32::from(MAX_VALUES[k])).round() as u16)
        };
        let corners: Vec<[u16; STREAMS]> = mesh.vertices.iter().map(rounded).collect();
        let streams = (0..STREAMS).flat_map(|stream| {
            let residuals = residuals(corners.iter().map(|corner| corner[stream]));
            let high: Vec<u8> = residuals.iter().map(|residual| residual.to_le_bytes()[1]).collect();
            let low: Vec<u8> = residuals.iter().map(|residual| residual.to_le_bytes()[0]).collect();
            low.into_iter().chain(high)
        });
        let streams: Vec<u8> = streams.collect();
        let mut before = [0u32; 3];
        let steps = mesh.triangles.iter().flat_map(|triangle| {
            let steps: [u32; 3] = std::array::from_fn(|k| triangle[k].wrapping_sub(before[k]));
            before = *triangle;
            steps.into_iter().flat_map(u32::to_le_bytes)
        });
        let steps: Vec<u8> = steps.collect();
        Self {
            vertices: mesh.vertices.len(),
            triangles: mesh.triangles.len(),
            low,
            span,
            largest: MAX_VALUES,
            corners: packed(&streams),
            indices: packed(&steps),
        }
    }
}

impl PackedMesh {
    /// Bytes in the page.
    pub(super) fn bytes(&self) -> usize {
        self.corners.len() + self.indices.len()
    }
}

/// Residuals of linear prediction from the two numbers before, zigzag-encoded: 0, -1, 1, -2 become 0, 1, 2, 3.
fn residuals(numbers: impl Iterator<Item = u16>) -> Vec<u16> {
    let (mut before, mut last) = (0u16, 0u16);
    let residual = |(k, number): (usize, u16)| {
        let guess = if k > 1 { last.wrapping_mul(2).wrapping_sub(before) } else { last };
        (before, last) = (last, number);
        let residual = number.wrapping_sub(guess) as i16;
        ((residual << 1) ^ (residual >> 15)) as u16
    };
    numbers.enumerate().map(residual).collect()
}

/// Octahedral coordinates of a unit vector, -1 to 1 (Meyer et al. 2010).
fn octahedral([x, y, z]: [f32; 3]) -> [f32; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    let (x, y) = (x / sum, y / sum);
    let sign = |c: f32| if c >= 0.0 { 1.0 } else { -1.0 };
    if z >= 0.0 { [x, y] } else { [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_render::scenes::Builtin;

    #[test]
    fn smooth_numbers_have_small_residuals() {
        assert_eq!(residuals([5, 7, 9, 11, 12].into_iter()), [10, 4, 0, 0, 1]);
        // Wraps around at 16 bits.
        assert_eq!(residuals([65535, 1, 3].into_iter())[1..], [4, 0]);
    }

    #[test]
    fn vectors_go_onto_the_octahedron() {
        assert_eq!(octahedral([0.0, 0.0, 1.0]), [0.0, 0.0]);
        assert_eq!(octahedral([0.0, 1.0, 0.0]), [0.0, 1.0]);
        assert_eq!(octahedral([0.0, 0.0, -1.0]), [1.0, 1.0]);
    }

    #[test]
    fn a_mesh_takes_few_bytes() {
        for (scene, most) in [(Builtin::Sphere, 7.0), (Builtin::Cloth, 13.0), (Builtin::Teapot, 8.0)] {
            let mesh = &scene.scene().parts[0].mesh;
            let packed = PackedMesh::new(mesh);
            let bytes = packed.bytes() as f64 / mesh.vertices.len() as f64;
            println!("{}: {bytes:.1} bytes a corner, {} corners", scene.name(), mesh.vertices.len());
            assert!(bytes < most, "{}: {bytes}", scene.name());
        }
    }
}
