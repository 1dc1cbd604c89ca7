//! Repairs slivers: triangles with collinear corners, which tools leave where a vertex lies on an edge.

use super::topology::{self, EdgeKey};
use crate::mesh::{Corner, PeriodicMesh};
use brdfc_formats::direction::{Vector, cross, dot, subtract};
use std::collections::HashSet;

/// Ratio of height to longest side below which a triangle is flat.
const FLAT: f64 = 1e-7;

/// Returns true if the corners are collinear.
pub fn is_flat(corners: [Vector; 3]) -> bool {
    let normal = cross(subtract(corners[1], corners[0]), subtract(corners[2], corners[0]));
    let longest = (0..3).map(|side| square_length(corners, side)).fold(0.0, f64::max);
    dot(normal, normal).sqrt() <= FLAT * longest
}

fn square_length(corners: [Vector; 3], side: usize) -> f64 {
    let along = subtract(corners[(side + 1) % 3], corners[side]);
    dot(along, along)
}

/// Flips the longest edge of flat triangles where that leaves fewer flat ones and the new diagonal is not yet an edge.
/// Returns the number of flips. The surface remains closed and oriented.
pub fn repair(surface: &mut PeriodicMesh) -> usize {
    let mut exchanged = 0;
    loop {
        let flat: Vec<usize> =
            (0..surface.triangles.len()).filter(|triangle| is_flat(surface.corners(*triangle))).collect();
        let before = exchanged;
        if !flat.is_empty() {
            exchanged += repair_pass(surface, &flat);
        }
        // A flip may enable the next one.
        if exchanged == before {
            return exchanged;
        }
    }
}

fn repair_pass(surface: &mut PeriodicMesh, flat: &[usize]) -> usize {
    let Ok(partners) = topology::partners(&surface.triangles) else { return 0 };
    let sides = |triangle: &[Corner; 3]| [0, 1, 2].map(|k| topology::edge(triangle[k], triangle[(k + 1) % 3]).0);
    let mut edges: HashSet<EdgeKey> = surface.triangles.iter().flat_map(sides).collect();
    let mut touched = vec![false; surface.triangles.len()];
    let mut exchanged = 0;
    for &triangle in flat {
        let corners = surface.corners(triangle);
        let longest = |a: &usize, b: &usize| square_length(corners, *a).total_cmp(&square_length(corners, *b));
        let side = (0..3).max_by(longest).unwrap_or(0);
        let partner = partners[3 * triangle + side] as usize;
        let (other, other_side) = (partner / 3, partner % 3);
        if touched[triangle] || touched[other] || other == triangle {
            continue;
        }
        // The longest side runs from `c` to `a`, past `b`; `d` is the corner beyond it.
        let [c, a, b] = [0, 1, 2].map(|k| surface.triangles[triangle][(side + k) % 3]);
        let beyond = surface.triangles[other];
        let (same, d) = (beyond[other_side], beyond[(other_side + 2) % 3]);
        let d = Corner { tile: [0, 1].map(|k| d.tile[k] + a.tile[k] - same.tile[k]), ..d };
        let pair = [[a, b, d], [b, c, d]].map(in_first_tile);
        let still_flat = pair.iter().any(|corners| is_flat(corners.map(|corner| surface.position(corner))));
        if still_flat || !edges.insert(topology::edge(b, d).0) {
            continue;
        }
        [surface.triangles[triangle], surface.triangles[other]] = pair;
        (touched[triangle], touched[other]) = (true, true);
        exchanged += 1;
    }
    exchanged
}

/// Shifts a triangle by whole tiles so that its lowest corner along each axis is in the first.
pub fn in_first_tile(corners: [Corner; 3]) -> [Corner; 3] {
    let lowest = [0, 1].map(|axis| corners.iter().map(|corner| corner.tile[axis]).min().unwrap_or(0));
    corners.map(|corner| Corner { tile: [0, 1].map(|axis| corner.tile[axis] - lowest[axis]), ..corner })
}
