//! Cloth that falls over a round pedestal, by position-based dynamics (Müller et al. 2007). Only sums, products,
//! quotients and square roots are used, which every machine rounds alike.

use super::grid_mesh::surface;
use crate::render::scene::Mesh;
use crate::render::vector::{add_scaled, subtract};
use brdfc_formats::direction::{Vector, dot};

/// Quads per side of the simulated net.
const NET: usize = 40;
/// Steps, until it hangs still.
const STEPS: usize = 220;
/// Passes over all distances per step.
const PASSES: usize = 8;
/// Fall of one step, in sides of a quad.
const FALL: f64 = 0.006;
/// Share of a step's movement that goes on in the next.
const MOMENTUM: f64 = 0.97;
/// How strongly bends are straightened, 0 to 1.
const STIFFNESS: f64 = 0.12;

/// What the cloth lies on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pedestal {
    /// Radius of the upright cylinder, whose axis is the y axis and whose top is at height 0.
    pub(super) radius: f64,
    /// Radius of its rounded edge.
    pub(super) edge: f64,
    /// Height of the floor, below 0.
    pub(super) floor: f64,
}

impl Pedestal {
    /// Moves a point that is inside to the surface, and says whether it was.
    fn push_out(self, p: &mut Vector) -> bool {
        let mut touched = false;
        if p[1] < self.floor {
            p[1] = self.floor;
            touched = true;
        }
        let from_axis = (p[0] * p[0] + p[2] * p[2]).sqrt();
        // Distance to the cylinder that is smaller by the radius of the edge all around.
        let (out, up) = (from_axis - (self.radius - self.edge), p[1] + self.edge);
        if out <= 0.0 {
            if up < self.edge && up > -2.0 * self.edge {
                p[1] = 0.0;
                touched = true;
            }
        } else {
            let above = up.max(0.0);
            let distance = (out * out + above * above).sqrt();
            if distance < self.edge && from_axis > 0.0 {
                let scale = self.edge / distance;
                let radius = self.radius - self.edge + out * scale;
                (p[0], p[2]) = (p[0] * radius / from_axis, p[2] * radius / from_axis);
                p[1] += above * (scale - 1.0);
                touched = true;
            }
        }
        touched
    }
}

/// A square of side `side`, its centre above `(offset, offset)`, dropped on the pedestal; `quads` per side of the mesh.
pub(super) fn drape(side: f64, offset: [f64; 2], pedestal: Pedestal, quads: usize) -> Mesh {
    let net = fall(side, offset, pedestal);
    // A uniform cubic B-spline over the net: smooth to its second derivative.
    surface(quads, quads, |u, v| spline(&net, u, v))
}

fn fall(side: f64, offset: [f64; 2], pedestal: Pedestal) -> Vec<Vector> {
    let count = NET + 1;
    let step = side / NET as f64;
    let at = |index: usize| {
        let (column, row) = ((index % count) as f64, (index / count) as f64);
        // A slight wave, so that folds know where to begin.
        let wave = 0.1 * step * ((7.0 * column / NET as f64 + 3.0 * row / NET as f64) % 1.0 - 0.5);
        [step * column - 0.5 * side + offset[0], 0.02 * side + wave, 0.5 * side - step * row + offset[1]]
    };
    let mut points: Vec<Vector> = (0..count * count).map(at).collect();
    let mut before = points.clone();
    let links = links();
    for _ in 0..STEPS {
        for (p, last) in points.iter_mut().zip(&mut before) {
            let moved = add_scaled(*p, MOMENTUM, subtract(*p, *last));
            *last = *p;
            *p = [moved[0], moved[1] - FALL * step, moved[2]];
        }
        for _ in 0..PASSES {
            for link in &links {
                let (a, b) = (points[link.a], points[link.b]);
                let between = subtract(b, a);
                let length = dot(between, between).sqrt();
                // Bends are straightened a little; threads do not stretch.
                let share = 0.5 * link.strength * (length - link.length * step) / length;
                points[link.a] = add_scaled(a, share, between);
                points[link.b] = add_scaled(b, -share, between);
            }
            for (p, last) in points.iter_mut().zip(&mut before) {
                if pedestal.push_out(p) {
                    // Friction: what touches hardly slides.
                    *last = add_scaled(*p, 0.25, subtract(*last, *p));
                }
            }
        }
    }
    smoothed(smoothed(points))
}

/// Each point half-way to the mean of its neighbours along both threads: creases of one quad are no folds.
fn smoothed(points: Vec<Vector>) -> Vec<Vector> {
    let count = NET + 1;
    let of = |index: usize| {
        let (column, row) = (index % count, index / count);
        let border = column == 0 || row == 0 || column == NET || row == NET;
        if border {
            return points[index];
        }
        let neighbours = [index - 1, index + 1, index - count, index + count];
        let sum = neighbours.iter().fold([0.0; 3], |sum, k| add_scaled(sum, 1.0, points[*k]));
        [0, 1, 2].map(|k| 0.5 * points[index][k] + 0.125 * sum[k])
    };
    (0..points.len()).map(of).collect()
}

/// A distance between two points that is kept.
struct Link {
    a: usize,
    b: usize,
    /// In sides of a quad.
    length: f64,
    strength: f64,
}

fn links() -> Vec<Link> {
    let count = NET + 1;
    let mut links = Vec::new();
    let diagonal = 2f64.sqrt();
    // Along both threads, across them, and over two quads against bending.
    for (columns, rows, length, strength) in [
        (1i64, 0i64, 1.0, 1.0),
        (0, 1, 1.0, 1.0),
        (1, 1, diagonal, 0.5),
        (-1, 1, diagonal, 0.5),
        (2, 0, 2.0, STIFFNESS),
        (0, 2, 2.0, STIFFNESS),
    ] {
        for row in 0..count as i64 {
            for column in 0..count as i64 {
                let (c, r) = (column + columns, row + rows);
                if (0..count as i64).contains(&c) && (0..count as i64).contains(&r) {
                    let index = |c: i64, r: i64| r as usize * count + c as usize;
                    links.push(Link { a: index(column, row), b: index(c, r), length, strength });
                }
            }
        }
    }
    links
}

/// The uniform cubic B-spline of the net at `(u, v)` in the unit square, v upwards along rows. Beyond the border the net
/// goes on straight.
fn spline(net: &[Vector], u: f64, v: f64) -> Vector {
    let [columns, rows] = [u, v].map(|t| {
        let position = t * NET as f64;
        let lower = position.floor().clamp(0.0, NET as f64 - 1.0);
        (lower as i64, weights(position - lower))
    });
    let mut point = [0.0; 3];
    for (r, row_weight) in rows.1.iter().enumerate() {
        for (c, column_weight) in columns.1.iter().enumerate() {
            let corner = beyond(net, columns.0 + c as i64 - 1, rows.0 + r as i64 - 1);
            point = add_scaled(point, row_weight * column_weight, corner);
        }
    }
    point
}

fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * t * t * t - 6.0 * t * t + 4.0, 3.0 * s * s * s - 6.0 * s * s + 4.0, t * t * t].map(|w| w / 6.0)
}

fn beyond(net: &[Vector], column: i64, row: i64) -> Vector {
    let last = NET as i64;
    let inside = |c: i64, r: i64| net[r as usize * (NET + 1) + c as usize];
    let (c, r) = (column.clamp(0, last), row.clamp(0, last));
    let here = inside(c, r);
    let mirrored = |c: i64, r: i64| inside(c.clamp(0, last), r.clamp(0, last));
    let opposite = mirrored(2 * c - column, 2 * r - row);
    if (c, r) == (column, row) { here } else { add_scaled(here, 1.0, subtract(here, opposite)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PEDESTAL: Pedestal = Pedestal { radius: 0.7, edge: 0.12, floor: -0.9 };

    #[test]
    fn threads_keep_their_length_and_nothing_is_inside_the_pedestal() {
        let side = 3.0;
        let net = fall(side, [0.03, -0.05], PEDESTAL);
        let step = side / NET as f64;
        let (mut longest, mut lowest) = (0.0f64, 0.0f64);
        for row in 0..=NET {
            for column in 0..NET {
                let between = subtract(net[row * (NET + 1) + column + 1], net[row * (NET + 1) + column]);
                longest = longest.max(dot(between, between).sqrt() / step);
            }
        }
        for p in &net {
            let mut moved = *p;
            PEDESTAL.push_out(&mut moved);
            let off = subtract(moved, *p);
            assert!(dot(off, off).sqrt() < 0.02, "{p:?}");
            lowest = lowest.min(p[1]);
        }
        assert!(longest < 1.15, "{longest}");
        assert!(lowest < -0.5, "it hangs: {lowest}");
    }

    #[test]
    fn splines_go_through_straight_nets() {
        let net: Vec<Vector> =
            (0..(NET + 1) * (NET + 1)).map(|i| [(i % (NET + 1)) as f64, 1.0, (i / (NET + 1)) as f64]).collect();
        for (u, v) in [(0.0, 0.0), (0.31, 0.77), (1.0, 0.5), (1.0, 1.0)] {
            let p = spline(&net, u, v);
            assert!((p[0] - u * NET as f64).abs() < 1e-9 && (p[2] - v * NET as f64).abs() < 1e-9, "{u} {v} {p:?}");
        }
    }
}
