//! Identifies vertices that coincide modulo whole tiles.

use crate::mesh::Corner;
use brdfc_formats::direction::Vector;
use std::collections::HashMap;

/// Maximum distance between coinciding vertices, in tiles.
pub const TOLERANCE: f64 = 1e-5;
/// Cells per tile of the grid for the neighbour search: cells are much larger than the tolerance and smaller than
/// triangles.
const CELLS: i64 = 4096;
/// Marks the end of a list.
const NONE: u32 = u32::MAX;

/// Welded vertices.
pub struct Identified {
    /// Positions: the first vertex of each group, shifted by whole tiles to `[0, 1)` less the tolerance.
    pub positions: Vec<Vector>,
    /// Index of that first vertex.
    pub first: Vec<u32>,
    /// Welded vertex and tile of each input vertex.
    pub corners: Vec<Corner>,
}

/// Joins each point to the nearest earlier one within the tolerance, modulo whole tiles along x and y.
pub fn identify(points: impl Iterator<Item = Vector>) -> Identified {
    let mut found = Identified { positions: Vec::new(), first: Vec::new(), corners: Vec::new() };
    // Last vertex of each cell, and the previous vertex in the cell of each vertex.
    let mut last: HashMap<[i64; 3], u32> = HashMap::new();
    let mut before: Vec<u32> = Vec::new();
    for (index, point) in points.enumerate() {
        let [x, y] = [0, 1].map(|k| point[k] - (point[k] + TOLERANCE).floor());
        let reduced = [x, y, point[2]];
        let mut best: Option<(f64, u32)> = None;
        for cell in cells_around(reduced) {
            let mut candidate = last.get(&cell).copied().unwrap_or(NONE);
            while candidate != NONE {
                let other = found.positions[candidate as usize];
                let step = |k: usize| reduced[k] - other[k];
                let wrapped = |k: usize| step(k) - step(k).round();
                let distance = (wrapped(0).powi(2) + wrapped(1).powi(2) + step(2).powi(2)).sqrt();
                let nearer = |(d, v): (f64, u32)| distance < d || (distance == d && candidate < v);
                if distance <= TOLERANCE && best.is_none_or(nearer) {
                    best = Some((distance, candidate));
                }
                candidate = before[candidate as usize];
            }
        }
        let vertex = best.map_or(found.positions.len() as u32, |(_, vertex)| vertex);
        if best.is_none() {
            found.positions.push(reduced);
            found.first.push(index as u32);
            before.push(last.insert(cell_of(reduced), vertex).unwrap_or(NONE));
        }
        let home = found.positions[vertex as usize];
        found.corners.push(Corner { vertex, tile: [0, 1].map(|k| (point[k] - home[k]).round() as i32) });
    }
    found
}

fn cell_of([x, y, z]: Vector) -> [i64; 3] {
    let [x, y, z] = [x, y, z].map(|c| (c * CELLS as f64).floor() as i64);
    [x.rem_euclid(CELLS), y.rem_euclid(CELLS), z]
}

/// Cells within the tolerance of a point, each once: one for most points.
fn cells_around(point: Vector) -> impl Iterator<Item = [i64; 3]> {
    let [low, high] = [-1.0, 1.0].map(|sign| point.map(|c| ((c + sign * TOLERANCE) * CELLS as f64).floor() as i64));
    let range = move |k: usize| low[k]..=high[k];
    range(0).flat_map(move |x| {
        range(1).flat_map(move |y| range(2).map(move |z| [x.rem_euclid(CELLS), y.rem_euclid(CELLS), z]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(points: &[Vector]) -> Vec<(u32, [i32; 2])> {
        identify(points.iter().copied()).corners.iter().map(|c| (c.vertex, c.tile)).collect()
    }

    #[test]
    fn vertices_are_one_modulo_tiles() {
        let points = [[0.25, 0.5, 0.0], [1.25, -2.5, 0.0], [0.25, 0.5, 1.0], [-0.75, 3.5, 1.0]];
        assert_eq!(corners(&points), [(0, [0, 0]), (0, [1, -3]), (1, [0, 0]), (1, [-1, 3])]);
    }

    #[test]
    fn the_tolerance_reaches_across_cells_and_tiles() {
        for edge in [0.0, 1.0 / 4096.0, 0.25, -3.0, 7.0 + 1.0 / 4096.0] {
            for (step, one) in [(0.9e-5, true), (-0.9e-5, true), (1.1e-5, false), (-1.1e-5, false)] {
                for axis in 0..3 {
                    let (mut a, mut b) = ([edge; 3], [edge; 3]);
                    a[axis] -= 0.4 * step;
                    b[axis] += 0.6 * step;
                    let found = identify([a, b].into_iter());
                    assert_eq!(found.positions.len() == 1, one, "{edge} {step} {axis}");
                    for (point, corner) in [a, b].iter().zip(&found.corners) {
                        let home = found.positions[corner.vertex as usize];
                        for k in 0..3 {
                            let tile = if k < 2 { f64::from(corner.tile[k]) } else { 0.0 };
                            assert!((home[k] + tile - point[k]).abs() <= TOLERANCE);
                        }
                        assert!(home[..2].iter().all(|c| (-TOLERANCE..1.0).contains(c)));
                    }
                }
            }
        }
    }

    #[test]
    fn the_nearest_counts_and_the_first_stays() {
        let points = [[0.5, 0.5, 0.0], [0.5, 0.5, 1.5e-5], [0.5, 0.5, 0.9e-5], [0.5, 0.5, 0.6e-5]];
        assert_eq!(corners(&points), [(0, [0, 0]), (1, [0, 0]), (1, [0, 0]), (0, [0, 0])]);
        let found = identify(points.into_iter());
        assert_eq!((found.positions[0], found.first), (points[0], vec![0, 1]));
    }
}
