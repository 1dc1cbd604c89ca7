//! Meshes in few bytes: up to 16 bits a number, each stored as what the two corners before it do not tell, and compressed.

use super::packed::packed;
use brdfc_render::scene::{Mesh, Vertex};
use serde::Serialize;

/// Numbers of a corner: position, uv, and two octahedral coordinates each of normal and tangent.
const STREAMS: usize = 9;
/// Numbers that are stored between the lowest and the highest: position and uv.
const BOUNDED: usize = 5;
/// The largest of each number: 14 bits of a position, 16 of uv, 13 of a normal, 11 of a tangent.
const LARGEST: [u16; STREAMS] = [0x3fff, 0x3fff, 0x3fff, 0xffff, 0xffff, 0x1fff, 0x1fff, 0x7ff, 0x7ff];

/// A mesh as a page holds it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct PackedMesh {
    vertices: usize,
    triangles: usize,
    /// Of each number that is bounded, the lowest.
    low: [f32; BOUNDED],
    /// And how far the highest is from it.
    span: [f32; BOUNDED],
    /// The largest of each number.
    largest: [u16; STREAMS],
    /// Numbers one after the other, of each the lower bytes of all corners, then the higher ones; packed.
    corners: String,
    /// Indices, each less the one of the triangle before, as 32-bit numbers; packed.
    indices: String,
}

impl PackedMesh {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let bounded = |corner: &Vertex| {
            let ([x, y, z], [u, v]) = (corner.position, corner.uv);
            [x, y, z, u, v]
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
            std::array::from_fn(|k| (of(k) * f32::from(LARGEST[k])).round() as u16)
        };
        let corners: Vec<[u16; STREAMS]> = mesh.vertices.iter().map(rounded).collect();
        let streams = (0..STREAMS).flat_map(|stream| {
            let rests = rests(corners.iter().map(|corner| corner[stream]));
            let high: Vec<u8> = rests.iter().map(|rest| rest.to_le_bytes()[1]).collect();
            let low: Vec<u8> = rests.iter().map(|rest| rest.to_le_bytes()[0]).collect();
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
            largest: LARGEST,
            corners: packed(&streams),
            indices: packed(&steps),
        }
    }
}

/// What the line through the two numbers before does not tell: 0, -1, 1, -2 and so on become 0, 1, 2, 3.
fn rests(numbers: impl Iterator<Item = u16>) -> Vec<u16> {
    let (mut before, mut last) = (0u16, 0u16);
    let rest = |(k, number): (usize, u16)| {
        let guess = if k > 1 { last.wrapping_mul(2).wrapping_sub(before) } else { last };
        (before, last) = (last, number);
        let rest = number.wrapping_sub(guess) as i16;
        ((rest << 1) ^ (rest >> 15)) as u16
    };
    numbers.enumerate().map(rest).collect()
}

/// Where a unit vector is on the unfolded octahedron, -1 to 1 (Meyer et al. 2010).
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
    fn smooth_numbers_leave_little() {
        assert_eq!(rests([5, 7, 9, 11, 12].into_iter()), [10, 4, 0, 0, 1]);
        // Around the end of 16 bits.
        assert_eq!(rests([65535, 1, 3].into_iter())[1..], [4, 0]);
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
            let bytes = (packed.corners.len() + packed.indices.len()) as f64 / mesh.vertices.len() as f64;
            println!("{}: {bytes:.1} bytes a corner, {} corners", scene.name(), mesh.vertices.len());
            assert!(bytes < most, "{}: {bytes}", scene.name());
        }
    }
}
