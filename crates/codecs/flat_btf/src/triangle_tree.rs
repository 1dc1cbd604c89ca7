//! Ray casting against triangles: a bounding volume hierarchy with four children per node, whose boxes and triangles
//! are tested four at a time (Dammertz et al. 2008).
//!
//! The nodes are collapsed from a binary tree that obvhs builds.

use glam::{BVec4A, Vec3A, Vec4};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;

/// A segment of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Start point of the segment.
    pub origin: Vec3A,
    /// Direction, a unit vector.
    pub direction: Vec3A,
    /// Length of the segment, from the start point.
    pub length: f32,
}

/// Intersection of a segment with a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// Index of the triangle.
    pub triangle: u32,
    /// Distance from the segment's origin.
    pub distance: f32,
    /// Weights of the second and third corner.
    pub barycentric: [f32; 2],
}

/// Triangles prepared for ray casting.
pub struct TriangleTree {
    /// The first is the root.
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    /// Maximum number of nodes that wait to be visited.
    waiting: usize,
}

/// Boxes of up to four children, and their indices. Fills two cache lines.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Node {
    /// Lower and upper bounds along each axis.
    borders: [[Vec4; 2]; 3],
    children: [u32; 4],
}

/// Up to four triangles: first corners and the two edges from there, by axis.
#[derive(Clone, Copy)]
struct Leaf {
    corner: [Vec4; 3],
    edges: [[Vec4; 3]; 2],
    triangles: [u32; 4],
}

/// Marks a child that is a leaf.
const LEAF: u32 = 1 << 31;
/// Tolerance, in barycentric coordinates, of hits outside a triangle: closes the seams between triangles.
const EDGE: f32 = 1e-5;
/// Padding of boxes beyond their triangles, for coordinates near 1: covers rounding and [`EDGE`].
const PADDING: f32 = 1e-6;
/// Stack entries available without heap allocation.
const SMALL_STACK: usize = 64;

impl TriangleTree {
    /// Builds the tree. Coordinates should be near 1 or below.
    pub fn new(corners: &[[Vec3A; 3]]) -> Self {
        // obvhs depends on its own version of glam, which may differ from ours.
        let corner = |v: &Vec3A| v.to_array().into();
        let triangles: Vec<Triangle> =
            corners.iter().map(|[v0, v1, v2]| Triangle { v0: corner(v0), v1: corner(v1), v2: corner(v2) }).collect();
        let parameters = BvhBuildParams { max_prims_per_leaf: 4, ..BvhBuildParams::slow_build() };
        let binary = build_bvh2_from_tris(&triangles, parameters, &mut Default::default());
        let mut tree = Self { nodes: Vec::new(), leaves: Vec::new(), waiting: 1 };
        if !binary.nodes.is_empty() {
            tree.gather(&binary, corners);
        }
        tree
    }

    /// Collapses binary nodes into wide ones, parents before their children.
    fn gather(&mut self, binary: &Bvh2, corners: &[[Vec3A; 3]]) {
        // For each binary node: the wide node and child slot that it fills, and the stack depth above it.
        let mut open = vec![(0, None, 0)];
        while let Some((index, parent, waiting)) = open.pop() {
            let mut parts = vec![index];
            // Replaces the largest box by its halves while there is room.
            while parts.len() < 4 {
                let inner = parts.iter().enumerate().filter(|(_, part)| !binary.nodes[**part].is_leaf());
                let area = |part: usize| binary.nodes[part].aabb().half_area();
                let Some((place, _)) = inner.max_by(|a, b| area(*a.1).total_cmp(&area(*b.1))) else { break };
                let first = binary.nodes[parts[place]].first_index as usize;
                parts[place] = first;
                parts.insert(place + 1, first + 1);
            }
            let number = self.nodes.len() as u32;
            if let Some((wide, place)) = parent {
                let wide: &mut Node = &mut self.nodes[wide];
                wide.children[place] = number;
            }
            let mut node = Node { borders: [[Vec4::INFINITY, Vec4::NEG_INFINITY]; 3], children: [LEAF; 4] };
            let waiting = waiting + parts.len();
            self.waiting = self.waiting.max(waiting);
            for (place, part) in parts.into_iter().enumerate() {
                let child = &binary.nodes[part];
                for axis in 0..3 {
                    node.borders[axis][0][place] = child.aabb().min[axis] - PADDING;
                    node.borders[axis][1][place] = child.aabb().max[axis] + PADDING;
                }
                if child.is_leaf() {
                    node.children[place] = LEAF | self.leaves.len() as u32;
                    let first = child.first_index as usize;
                    let held = &binary.primitive_indices[first..first + child.prim_count as usize];
                    self.leaves.push(Leaf::new(held, corners));
                } else {
                    open.push((part, Some((number as usize, place)), waiting));
                }
            }
            self.nodes.push(node);
        }
    }

    /// Finds the first triangle that a segment meets.
    pub fn nearest(&self, segment: &Segment) -> Option<TriangleHit> {
        let mut found = None;
        let mut length = segment.length;
        self.visit::<true>(segment, &mut |leaf, rays| {
            let (met, [distance, u, v]) = leaf.intersect(rays, length);
            for lane in lanes(met) {
                if distance[lane] < length || (found.is_none() && distance[lane] <= length) {
                    length = distance[lane];
                    found = Some(TriangleHit {
                        triangle: leaf.triangles[lane],
                        distance: length,
                        barycentric: [u[lane], v[lane]],
                    });
                }
            }
            length
        });
        found
    }

    /// Returns true if a segment meets any triangle.
    pub fn is_blocked(&self, segment: &Segment) -> bool {
        let mut blocked = false;
        self.visit::<false>(segment, &mut |leaf, rays| {
            blocked = leaf.intersect(rays, segment.length).0.any();
            if blocked { f32::NEG_INFINITY } else { segment.length }
        });
        blocked
    }

    /// Calls `leaf` for the leaves that a segment may meet, from near to far if `ORDERED`. The return value of `leaf`
    /// replaces the length of the segment; a negative length ends the visit.
    #[inline(always)]
    fn visit<const ORDERED: bool>(&self, segment: &Segment, leaf: &mut impl FnMut(&Leaf, &Rays) -> f32) {
        let (mut small, mut large);
        let stack: &mut [(u32, f32)] = if self.waiting <= SMALL_STACK {
            small = [(0, 0.0); SMALL_STACK];
            &mut small
        } else {
            large = vec![(0, 0.0); self.waiting];
            &mut large
        };
        if self.nodes.is_empty() {
            return;
        }
        let rays = Rays::new(segment);
        let mut length = segment.length;
        let (mut waiting, mut next) = (0, 0);
        loop {
            if next & LEAF == 0 {
                let node = &self.nodes[next as usize];
                let (met, start) = node.intersect(&rays, length);
                let first = waiting;
                for lane in lanes(met) {
                    let entry = (node.children[lane], start[lane]);
                    let mut place = waiting;
                    // The nearest is last, and is visited next.
                    while ORDERED && place > first && stack[place - 1].1 < entry.1 {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = entry;
                    waiting += 1;
                }
            } else {
                length = leaf(&self.leaves[(next ^ LEAF) as usize], &rays);
                if length < 0.0 {
                    return;
                }
            }
            loop {
                if waiting == 0 {
                    return;
                }
                waiting -= 1;
                if stack[waiting].1 <= length {
                    break;
                }
            }
            next = stack[waiting].0;
        }
    }
}

/// A segment replicated to four lanes, by axis.
struct Rays {
    origin: [Vec4; 3],
    direction: [Vec4; 3],
    inverse: [Vec4; 3],
    /// The bound of a box that the ray meets first along each axis: 0 lower, 1 upper.
    near: [usize; 3],
}

impl Rays {
    #[inline(always)]
    fn new(segment: &Segment) -> Self {
        let direction = segment.direction.to_array();
        // Finite, because a bound through the origin would otherwise give NaN.
        let inverse = |d: f32| if d.abs() < 1e-18 { 1e18f32.copysign(d) } else { 1.0 / d };
        Self {
            origin: segment.origin.to_array().map(Vec4::splat),
            direction: direction.map(Vec4::splat),
            inverse: direction.map(|d| Vec4::splat(inverse(d))),
            near: direction.map(|d| usize::from(d.is_sign_negative())),
        }
    }
}

impl Node {
    /// For each child, true if the ray meets it within `length`, and the distance at which it enters.
    #[inline(always)]
    fn intersect(&self, rays: &Rays, length: f32) -> (BVec4A, [f32; 4]) {
        let (mut start, mut end) = (Vec4::ZERO, Vec4::splat(length));
        for axis in 0..3 {
            let near = rays.near[axis] & 1;
            let distance = |border: usize| (self.borders[axis][border] - rays.origin[axis]) * rays.inverse[axis];
            start = distance(near).max(start);
            end = distance(near ^ 1).min(end);
        }
        (start.cmple(end), start.to_array())
    }
}

impl Leaf {
    /// Packs up to four triangles.
    fn new(held: &[u32], corners: &[[Vec3A; 3]]) -> Self {
        // Edges of zero length are never hit.
        assert!(held.len() <= 4, "a leaf of {} triangles", held.len());
        let mut leaf = Self { corner: [Vec4::ZERO; 3], edges: [[Vec4::ZERO; 3]; 2], triangles: [u32::MAX; 4] };
        for (lane, triangle) in held.iter().enumerate() {
            let [a, b, c] = corners[*triangle as usize];
            leaf.triangles[lane] = *triangle;
            for axis in 0..3 {
                leaf.corner[axis][lane] = a[axis];
                leaf.edges[0][axis][lane] = b[axis] - a[axis];
                leaf.edges[1][axis][lane] = c[axis] - a[axis];
            }
        }
        leaf
    }

    /// For each triangle, true if the ray meets it within `length`, the distances, and the weights of the second and
    /// third corners (Möller and Trumbore 1997).
    #[inline(always)]
    fn intersect(&self, rays: &Rays, length: f32) -> (BVec4A, [[f32; 4]; 3]) {
        let [e1, e2] = &self.edges;
        let p = cross(&rays.direction, e2);
        // NaN or infinite if the determinant is 0: all comparisons fail.
        let inverse = Vec4::ONE / dot(e1, &p);
        let from = [0, 1, 2].map(|k| rays.origin[k] - self.corner[k]);
        let u = dot(&from, &p) * inverse;
        let q = cross(&from, e1);
        let v = dot(&rays.direction, &q) * inverse;
        let distance = dot(e2, &q) * inverse;
        let edge = Vec4::splat(-EDGE);
        let inside = u.cmpge(edge) & v.cmpge(edge) & (u + v).cmple(Vec4::splat(1.0 + EDGE));
        let within = distance.cmpge(Vec4::ZERO) & distance.cmple(Vec4::splat(length));
        (inside & within, [distance, u, v].map(|lanes| lanes.to_array()))
    }
}

#[inline(always)]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: &[Vec4; 3], b: &[Vec4; 3]) -> [Vec4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Indices of the lanes that are set, in ascending order.
#[inline(always)]
fn lanes(set: BVec4A) -> impl Iterator<Item = usize> {
    let mut left = set.bitmask();
    std::iter::from_fn(move || {
        if left == 0 {
            return None;
        }
        let lane = left.trailing_zeros() as usize & 3;
        left &= left - 1;
        Some(lane)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random_vector(random: &mut ChaCha8Rng) -> Vec3A {
        Vec3A::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)))
    }

    /// Distance to the first of all triangles, in double precision and by volumes: the line passes all three edges on
    /// the same side.
    fn expected(corners: &[[Vec3A; 3]], segment: &Segment) -> Option<(u32, f64)> {
        let double = |v: Vec3A| v.as_dvec3();
        let (o, d) = (double(segment.origin), double(segment.direction));
        let met = |(index, triangle): (usize, &[Vec3A; 3])| {
            let [a, b, c] = triangle.map(|corner| double(corner) - o);
            let side = [d.dot(a.cross(b)), d.dot(b.cross(c)), d.dot(c.cross(a))];
            let normal = (b - a).cross(c - a);
            let distance = a.dot(normal) / d.dot(normal);
            let inside = side.iter().all(|s| *s > 0.0) || side.iter().all(|s| *s < 0.0);
            (inside && distance >= 0.0 && distance <= f64::from(segment.length)).then_some((index as u32, distance))
        };
        corners.iter().enumerate().filter_map(met).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    #[test]
    fn hits_match_a_search_through_all_triangles() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        for (count, size) in [(1, 0.8), (3, 0.8), (5, 0.5), (40, 0.4), (700, 0.15)] {
            let corners: Vec<[Vec3A; 3]> = (0..count)
                .map(|_| {
                    let middle = random_vector(&mut random);
                    [0, 1, 2].map(|_| middle + size * random_vector(&mut random))
                })
                .collect();
            let tree = TriangleTree::new(&corners);
            let (mut met, mut blocked) = (0, 0);
            for k in 0..2000 {
                let mut direction = random_vector(&mut random).normalize();
                if k % 8 < 3 {
                    direction = Vec3A::AXES[k % 8] * if k % 16 < 8 { 1.0 } else { -1.0 };
                }
                let length = if k % 2 == 0 { 0.5 } else { 4.0 };
                let segment = Segment { origin: random_vector(&mut random), direction, length };
                let (found, expected) = (tree.nearest(&segment), expected(&corners, &segment));
                assert_eq!(tree.is_blocked(&segment), found.is_some(), "{count} {segment:?}");
                match (found, expected) {
                    (Some(found), Some((triangle, distance))) => {
                        assert_eq!(found.triangle, triangle, "{count} {segment:?}");
                        assert!((f64::from(found.distance) - distance).abs() < 1e-4, "{count} {segment:?}");
                        let [a, b, c] = corners[triangle as usize];
                        let point = a + found.barycentric[0] * (b - a) + found.barycentric[1] * (c - a);
                        let along = segment.origin + found.distance * direction;
                        assert!((point - along).length() < 1e-4, "{point} {along}");
                        met += 1;
                    }
                    (None, None) => blocked += 1,
                    other => panic!("{count} {segment:?}: {other:?}"),
                }
            }
            assert!(met > 10 && blocked > 10, "{count}: {met} {blocked}");
        }
    }

    #[test]
    fn empty_trees_and_degenerate_triangles_have_no_hits() {
        let corner = Vec3A::new(0.3, 0.2, 0.0);
        let segment = Segment { origin: corner + Vec3A::Z, direction: -Vec3A::Z, length: 2.0 };
        for corners in [vec![], vec![[corner; 3]; 9], vec![[corner, corner, Vec3A::ZERO]; 2]] {
            let tree = TriangleTree::new(&corners);
            assert!(tree.nearest(&segment).is_none() && !tree.is_blocked(&segment));
        }
    }

    #[test]
    fn deep_trees_do_not_overflow_the_stack() {
        // Nested boxes that one ray meets.
        let square = |k: i32| {
            let r = 0.9f32.powi(k);
            [Vec3A::new(-r, -r, -r), Vec3A::new(3.0 * r, -r, -r), Vec3A::new(-r, 3.0 * r, -r)]
        };
        let corners: Vec<_> = (0..800).map(square).collect();
        let tree = TriangleTree::new(&corners);
        let down = |length| Segment { origin: Vec3A::Z, direction: -Vec3A::Z, length };
        assert!(tree.nearest(&down(1.0)).is_some_and(|hit| hit.distance >= 1.0 - 1e-6));
        let up = Segment { origin: Vec3A::new(0.0, 0.0, -1.5), direction: Vec3A::Z, length: 3.0 };
        assert_eq!(tree.nearest(&up).map(|hit| hit.triangle), Some(0));
        assert!(tree.is_blocked(&up));
    }
}
