//! Mesh connectivity: edges, sides, fans, components.

use crate::mesh::Corner;
use rayon::prelude::*;

/// Three corners; side `k` goes from corner `k` to the next.
pub type Triangle = [Corner; 3];

/// Edges without exactly two triangles, and the first triangle with one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadEdges {
    /// Number of such edges.
    pub count: usize,
    /// First triangle with one.
    pub triangle: usize,
    /// Side of that triangle.
    pub side: usize,
    /// Number of triangles at that edge.
    pub triangles: usize,
}

/// Edges that are no part of a closed surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EdgeError {
    /// Edges of one triangle.
    Open(BadEdges),
    /// Edges of three triangles or more.
    NonManifold(BadEdges),
}

/// For each side, `3 triangle + side`, the other side at its edge.
pub type Partners = Vec<u32>;

/// Ends of a side and the tiles that it crosses, in the lexicographically first direction.
pub type EdgeKey = (u32, u32, [i32; 2]);

/// The edge between two corners; the flag is true if the key has the same direction.
pub fn edge(from: Corner, to: Corner) -> (EdgeKey, bool) {
    let step = [0, 1].map(|k| to.tile[k] - from.tile[k]);
    let (along, back) = ((from.vertex, to.vertex, step), (to.vertex, from.vertex, step.map(|s| -s)));
    if along <= back { (along, true) } else { (back, false) }
}

fn edge_at(triangle: &Triangle, side: usize) -> (EdgeKey, bool) {
    edge(triangle[side], triangle[(side + 1) % 3])
}

/// Finds the two sides at each edge.
///
/// # Errors
/// Returns [`EdgeError::NonManifold`] for edges of more than two triangles, else [`EdgeError::Open`] for edges of one.
pub fn partners(triangles: &[Triangle]) -> Result<Partners, EdgeError> {
    let half_edges = 3 * triangles.len();
    let mut sides: Vec<(EdgeKey, u32)> =
        (0..half_edges).map(|half| (edge_at(&triangles[half / 3], half % 3).0, half as u32)).collect();
    sides.par_sort_unstable();
    let mut partners = vec![0; half_edges];
    let [mut open, mut crowded] = [BadEdges { count: 0, triangle: usize::MAX, side: 0, triangles: 0 }; 2];
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, a), (_, b)] = *group {
            partners[a as usize] = b;
            partners[b as usize] = a;
            continue;
        }
        let bad = if group.len() == 1 { &mut open } else { &mut crowded };
        bad.count += 1;
        let (triangle, side) = (group[0].1 as usize / 3, group[0].1 as usize % 3);
        if triangle < bad.triangle {
            *bad = BadEdges { count: bad.count, triangle, side, triangles: group.len() };
        }
    }
    match (crowded.count, open.count) {
        (0, 0) => Ok(partners),
        (0, _) => Err(EdgeError::Open(open)),
        _ => Err(EdgeError::NonManifold(crowded)),
    }
}

/// Partners after turning triangles by exchanging corners 1 and 2, which exchanges sides 0 and 2.
pub fn turned(partners: &Partners, turn: &[bool]) -> Partners {
    let moved = |half: usize| if turn[half / 3] { half / 3 * 3 + 2 - half % 3 } else { half };
    (0..partners.len()).map(|half| moved(partners[moved(half)] as usize) as u32).collect()
}

/// Components connected by edges, and the triangles to turn so that the two sides of every edge run in opposite
/// directions.
#[derive(Debug, PartialEq, Eq)]
pub struct Orientation {
    /// Triangles to turn; the first of each component stays.
    pub turn: Vec<bool>,
    /// First triangle of each component.
    pub pieces: Vec<usize>,
    /// A triangle that would need both orientations.
    pub conflict: Option<usize>,
}

/// Orients by flood fill from the first triangle of each component.
pub fn orient(triangles: &[Triangle], partners: &Partners) -> Orientation {
    let mut seen = vec![false; triangles.len()];
    let mut found = Orientation { turn: vec![false; triangles.len()], pieces: Vec::new(), conflict: None };
    let mut waiting = Vec::new();
    for start in 0..triangles.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        found.pieces.push(start);
        waiting.push(start);
        while let Some(triangle) = waiting.pop() {
            for side in 0..3 {
                let partner = partners[3 * triangle + side] as usize;
                let (other, other_side) = (partner / 3, partner % 3);
                let same_way = edge_at(&triangles[triangle], side).1 == edge_at(&triangles[other], other_side).1;
                let turn = found.turn[triangle] != same_way;
                if !seen[other] {
                    seen[other] = true;
                    found.turn[other] = turn;
                    waiting.push(other);
                } else if found.turn[other] != turn {
                    found.conflict = Some(found.conflict.map_or(other, |c| c.min(other)));
                }
            }
        }
    }
    found
}

/// The first vertex whose triangles form more than one fan, in an oriented surface.
pub fn touching_vertex(triangles: &[Triangle], partners: &Partners, vertices: usize) -> Option<u32> {
    let mut seen = vec![false; partners.len()];
    let mut has_fan = vec![false; vertices];
    for start in 0..partners.len() {
        if seen[start] {
            continue;
        }
        let vertex = triangles[start / 3][start % 3].vertex;
        if std::mem::replace(&mut has_fan[vertex as usize], true) {
            return Some(vertex);
        }
        // Walk around the vertex: cross the side that ends at a corner, to the side that starts there.
        let mut corner = start;
        while !std::mem::replace(&mut seen[corner], true) {
            corner = partners[corner / 3 * 3 + (corner + 2) % 3] as usize;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(vertex: u32, tile: [i32; 2]) -> Corner {
        Corner { vertex, tile }
    }

    /// The tile as one vertex and two triangles, the smallest torus.
    fn smallest() -> Vec<Triangle> {
        let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|tile| corner(0, tile));
        vec![[a, b, c], [a, c, d]]
    }

    #[test]
    fn the_smallest_torus_closes() {
        let triangles = smallest();
        let partners = partners(&triangles).unwrap();
        for half in 0..6 {
            let partner = partners[half] as usize;
            assert!(partners[partner] as usize == half && partner / 3 != half / 3);
        }
        let orientation = orient(&triangles, &partners);
        assert_eq!((orientation.turn, orientation.pieces, orientation.conflict), (vec![false; 2], vec![0], None));
        assert_eq!(touching_vertex(&triangles, &partners, 1), None);
    }

    #[test]
    fn turned_triangles_are_detected() {
        let mut triangles = smallest();
        triangles[1].swap(1, 2);
        let before = partners(&triangles).unwrap();
        assert_eq!(orient(&triangles, &before).turn, [false, true]);
        triangles[1].swap(1, 2);
        assert_eq!(turned(&before, &[false, true]), partners(&triangles).unwrap());
        triangles[0].swap(1, 2);
        assert_eq!(turned(&before, &[true, true]), partners(&triangles).unwrap());
    }

    #[test]
    fn edges_without_two_triangles_are_counted() {
        let triangles = smallest();
        let open = BadEdges { count: 3, triangle: 0, side: 0, triangles: 1 };
        assert!(matches!(partners(&triangles[..1]), Err(EdgeError::Open(bad)) if bad.count == open.count));
        let three = [triangles[0], triangles[1], triangles[1]];
        assert!(matches!(partners(&three), Err(EdgeError::NonManifold(bad)) if (bad.count, bad.triangles) == (3, 3)));
    }

    /// The tile with its right border joined upside down to its left one is a Klein bottle.
    #[test]
    fn a_klein_bottle_has_a_conflict() {
        let n = 4u32;
        let vertex = |column: u32, row: u32| {
            let row = if column == n { (n - row) % n } else { row % n };
            corner(column % n * n + row, [0, 0])
        };
        let mut triangles = Vec::new();
        for column in 0..n {
            for row in 0..n {
                let [a, b] = [vertex(column, row), vertex(column + 1, row)];
                let [d, c] = [vertex(column, row + 1), vertex(column + 1, row + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let partners = partners(&triangles).unwrap();
        assert!(orient(&triangles, &partners).conflict.is_some());
    }
}
