//! Interpolation between sampled directions: three samples and their weights for any direction.
//!
//! The samples are triangulated (Delaunay) in paraboloid coordinates `(x, y) / (1 + z)`; a direction has the
//! barycentric weights of its triangle. Outside the convex hull it has the weights of the nearest point of the hull in
//! the same plane, the only choice that is continuous everywhere. Directions below the horizon are projected to z = 0.
//!
//! Weights are 1 at a sample, non-negative, sum to 1 within rounding, and reproduce linear functions of paraboloid
//! coordinates inside the hull.
//!
//! Sets without a triangle: a single direction has weight 1 everywhere. With two directions, or several that are
//! collinear in paraboloid coordinates (in a plane through the normal), the two around the nearest point of the line
//! are blended.
//!
//! # Words for a shader
//!
//! A look-up reads one list of `u32`, in a texture or a buffer, and computes in f32. The list describes `n` directions,
//! `t` triangles and segments, `G` x `G` cells over [-1, 1]² of paraboloid coordinates, and `c` candidates:
//!
//! | from word | words | contents |
//! |---|---|---|
//! | 0 | 4 | `G`, `n`, `t`, `c` |
//! | 4 | `G² + 1` | first candidate of cell `row * G + column`; then `c` |
//! | `5 + G²` | `c` | candidates: indices of triangles and segments, ascending within a cell |
//! | `5 + G² + c` | `3 t` | directions at the corners of each triangle; a segment from a to b is a, b, b |
//! | `5 + G² + c + 3 t` | `2 n` | x, y of each direction in paraboloid coordinates, bits of f32 |
//!
//! Triangles are counter-clockwise. Segments are the edges of the hull, with the hull on the left; for collinear sets
//! they are the pieces of the line in both directions. A cell lists each triangle that overlaps it and each segment
//! that is nearest to some point of the cell on the segment's right. [`DIRECTION_MESH_WGSL`] is the look-up in WGSL.
//! [`DirectionMesh::weights`] performs the same steps in the same order, so that both give the same bits on adapters
//! with correctly rounded division and without fused operations.

mod build;
mod check;

use crate::FormatError;
use crate::direction_set::DirectionSet;
use build::HEADER_WORDS;

/// WGSL version of [`DirectionMesh::weights`], for words in a texture; see the file.
pub const DIRECTION_MESH_WGSL: &str = include_str!("direction_mesh.wgsl");

/// A triangulated set of directions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DirectionMesh {
    words: Vec<u32>,
}

impl DirectionMesh {
    /// Triangulates a set.
    ///
    /// # Errors
    /// Returns an error as [`DirectionSet::new`], or if directions are less than 1e-4 apart, which f32 cannot
    /// distinguish reliably.
    pub fn new(set: &DirectionSet) -> Result<Self, FormatError> {
        let set = DirectionSet::new(set.name.clone(), set.angles.clone())?;
        let points: Vec<[f32; 2]> = set.directions().iter().map(|d| paraboloid(d.map(|c| c as f32))).collect();
        Ok(Self { words: build::words(&points)? })
    }

    /// Reads the mesh at the start of a list, in the form of [`Self::words`]. Words after it are ignored.
    ///
    /// # Errors
    /// Returns an error if the list is too short or an index is out of range.
    pub fn from_words(words: &[u32]) -> Result<Self, FormatError> {
        let mesh = Self { words: words[..check::length(words)?].to_vec() };
        check::check(&mesh.words)?;
        Ok(mesh)
    }

    /// Number of directions of the set.
    pub fn directions(&self) -> usize {
        self.words[1] as usize
    }

    /// Indices into the set and weights of three directions, which may repeat with weight 0.
    ///
    /// `direction` is a unit vector; NaN gives an arbitrary sample.
    pub fn weights(&self, direction: [f32; 3]) -> ([u32; 3], [f32; 3]) {
        let words = &self.words[..];
        let point = paraboloid(direction);
        let grid = words[0] as usize;
        let column = cell(point[0], grid);
        let row = cell(point[1], grid);
        let candidates = HEADER_WORDS + grid * grid + 1;
        let triangles = candidates + words[3] as usize;
        let vertices = triangles + 3 * words[2] as usize;
        let first = words[HEADER_WORDS + row * grid + column];
        let end = words[HEADER_WORDS + row * grid + column + 1];
        let mut best = f32::MAX;
        let mut indices = [0; 3];
        let mut weights = [1.0, 0.0, 0.0];
        for k in first..end {
            let triangle = triangles + 3 * words[candidates + k as usize] as usize;
            let corners = [words[triangle], words[triangle + 1], words[triangle + 2]];
            let [a, b, c] = corners.map(|index| {
                let vertex = vertices + 2 * index as usize;
                [f32::from_bits(words[vertex]), f32::from_bits(words[vertex + 1])]
            });
            let q = difference(point, a);
            let e1 = difference(b, a);
            let mut w = [1.0, 0.0, 0.0];
            let mut distance;
            if corners[1] == corners[2] {
                // A segment applies on its right side, because the hull is on the left.
                let squared = e1[0] * e1[0] + e1[1] * e1[1];
                let mut t = 0.0;
                if squared > 0.0 {
                    t = (q[0] * e1[0] + q[1] * e1[1]) / squared;
                }
                if (0.0..=1.0).contains(&t) {
                    if e1[0] * q[1] - e1[1] * q[0] <= 0.0 {
                        return (corners, [1.0 - t, t, 0.0]);
                    }
                    continue;
                }
                distance = q[0] * q[0] + q[1] * q[1];
                if t > 1.0 {
                    w = [0.0, 1.0, 0.0];
                    let r = difference(point, b);
                    distance = r[0] * r[0] + r[1] * r[1];
                }
            } else {
                let e2 = difference(c, a);
                let area = e1[0] * e2[1] - e1[1] * e2[0];
                let w1 = (q[0] * e2[1] - q[1] * e2[0]) / area;
                let w2 = (e1[0] * q[1] - e1[1] * q[0]) / area;
                let w0 = 1.0 - w1 - w2;
                if w0 >= 0.0 && w1 >= 0.0 && w2 >= 0.0 {
                    return (corners, [w0, w1, w2]);
                }
                // Rounding may leave a point between two triangles.
                let [c0, c1, c2] = [w0.max(0.0), w1.max(0.0), w2.max(0.0)];
                let sum = c0 + c1 + c2;
                w = [c0 / sum, c1 / sum, c2 / sum];
                let x = q[0] - (w[1] * e1[0] + w[2] * e2[0]);
                let y = q[1] - (w[1] * e1[1] + w[2] * e2[1]);
                // Outside the hull the corner of a segment must win.
                distance = 4.0 * (x * x + y * y);
            }
            if k == first || distance < best {
                best = distance;
                indices = corners;
                weights = w;
            }
        }
        (indices, weights)
    }

    /// Words of the table above.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Corners of the triangles: indices into the set, counter-clockwise seen from above. Empty for collinear sets.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let grid = self.words[0] as usize;
        let start = HEADER_WORDS + grid * grid + 1 + self.words[3] as usize;
        let words = &self.words[start..start + 3 * self.words[2] as usize];
        let all = words.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
        all.filter(|corners| corners[1] != corners[2]).collect()
    }
}

/// `(x, y) / (1 + z)` with z clamped to at least 0; in [-1, 1] for any direction.
#[expect(clippy::manual_clamp, reason = "NaN becomes -1")]
fn paraboloid([x, y, z]: [f32; 3]) -> [f32; 2] {
    let scale = 1.0 + z.max(0.0);
    [(x / scale).max(-1.0).min(1.0), (y / scale).max(-1.0).min(1.0)]
}

/// Cell, among `grid` cells over [-1, 1], that contains a coordinate.
fn cell(coordinate: f32, grid: usize) -> usize {
    let size = grid as f32;
    ((coordinate + 1.0) * 0.5 * size).min(size - 1.0) as usize
}

fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

#[cfg(test)]
mod tests;
