//! Tables over the unit square, and the map that makes the visible normals uniform.

use brdfc_formats::FormatError;
use brdfc_formats::memory::{filled, reserved};
use brdfc_readers::rgl::Map;

/// Position between two nodes of a table.
#[derive(Debug, Clone, Copy)]
pub struct Cell {
    /// Index of the node before the position.
    pub index: usize,
    /// Fraction to the next node, 0 to 1.
    pub fraction: f64,
}

impl Cell {
    /// Position of `u` (clamped to `[0, 1]`) on `nodes >= 2` evenly spaced nodes from 0 to 1.
    pub fn new(u: f64, nodes: usize) -> Self {
        let position = u.clamp(0.0, 1.0) * (nodes - 1) as f64;
        let index = (position as usize).min(nodes - 2);
        Self { index, fraction: position - index as f64 }
    }
}

/// Bilinear interpolation of a table.
pub fn bilinear(map: &Map, u: f64, v: f64) -> f64 {
    let (x, y) = (Cell::new(u, map.columns), Cell::new(v, map.rows));
    let row = |index: usize| {
        let start = index * map.columns + x.index;
        mix(f64::from(map.values[start]), f64::from(map.values[start + 1]), x.fraction)
    };
    mix(row(y.index), row(y.index + 1), y.fraction)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// Tabulated incident directions around a given one, with their weights.
#[derive(Debug, Clone, Copy)]
pub struct Incidence {
    entries: [(usize, f64); 4],
    count: usize,
}

impl Incidence {
    /// Weights of linear interpolation along both axes, clamped to the ends of an axis.
    pub fn new(phi_axis: &[f64], phi: f64, theta_axis: &[f64], theta: f64) -> Self {
        let mut this = Self { entries: [(0, 0.0); 4], count: 0 };
        for (p, phi_weight) in neighbours(phi_axis, phi) {
            for (t, theta_weight) in neighbours(theta_axis, theta) {
                let weight = phi_weight * theta_weight;
                if weight > 0.0 {
                    this.entries[this.count] = (p * theta_axis.len() + t, weight);
                    this.count += 1;
                }
            }
        }
        this
    }

    /// Indices over (phi_i, theta_i) and weights; the weights are positive and add up to 1.
    pub fn slices(&self) -> &[(usize, f64)] {
        &self.entries[..self.count]
    }
}

fn neighbours(axis: &[f64], value: f64) -> [(usize, f64); 2] {
    let last = axis.len() - 1;
    let next = axis.partition_point(|entry| *entry <= value);
    if next == 0 || next > last {
        return [(next.min(last), 1.0), (0, 0.0)];
    }
    let t = (value - axis[next - 1]) / (axis[next] - axis[next - 1]);
    [(next - 1, 1.0 - t), (next, t)]
}

/// Densities of visible normals and their cumulative integrals, each incident direction scaled to integral 1.
///
/// The map follows the inversion method, first over rows, then along a row, for the density that is bilinear between
/// the nodes. Lengths are counted in nodes, so that no spacing enters.
#[derive(Debug, Clone)]
pub struct VisibleNormals {
    rows: usize,
    columns: usize,
    /// Density, and its cumulative integral along the row. Shape (incidence, row, column).
    nodes: Vec<[f32; 2]>,
    /// Integral of the whole row, and the cumulative integral of the rows. Shape (incidence, row).
    totals: Vec<[f32; 2]>,
}

impl VisibleNormals {
    /// Creates the map from densities of shape (incidence, `rows`, `columns`).
    ///
    /// # Errors
    /// Returns an error if there is not enough memory.
    pub fn new(densities: &[f32], rows: usize, columns: usize) -> Result<Self, FormatError> {
        let mut this = Self {
            rows,
            columns,
            nodes: reserved("vndf", densities.len())?,
            totals: reserved("vndf", densities.len() / columns)?,
        };
        let mut running = filled("vndf", rows * columns, 0.0)?;
        let mut marginal = vec![0.0; rows];
        for slice in densities.chunks_exact(rows * columns) {
            for (line, sums) in slice.chunks_exact(columns).zip(running.chunks_exact_mut(columns)) {
                for x in 1..columns {
                    sums[x] = sums[x - 1] + 0.5 * (f64::from(line[x - 1]) + f64::from(line[x]));
                }
            }
            let total = |y: usize| running[(y + 1) * columns - 1];
            for y in 1..rows {
                marginal[y] = marginal[y - 1] + 0.5 * (total(y - 1) + total(y));
            }
            let scale = 1.0 / marginal[rows - 1];
            let scaled = |v: f64| (v * scale) as f32;
            this.nodes.extend(slice.iter().zip(&running).map(|(d, sum)| [scaled(f64::from(*d)), scaled(*sum)]));
            this.totals.extend((0..rows).map(|y| [scaled(total(y)), scaled(marginal[y])]));
        }
        Ok(this)
    }

    /// Maps `[s, t]` to the point `(u, v)`, for one tabulated incident direction: the inverse of [`Self::invert`].
    pub fn sample(&self, slice: usize, [s, t]: [f64; 2]) -> [f64; 2] {
        let total = |y: usize| self.totals[slice * self.rows + y].map(f64::from);
        let (y, down) = place(self.rows, t * total(self.rows - 1)[1], |y| total(y)[1], |y| total(y)[0]);
        let whole = mix(total(y)[0], total(y + 1)[0], down);
        let node = |x: usize, which: usize| {
            let of = |row: usize| f64::from(self.nodes[(slice * self.rows + row) * self.columns + x][which]);
            mix(of(y), of(y + 1), down)
        };
        let (x, along) = place(self.columns, s * whole, |x| node(x, 1), |x| node(x, 0));
        let u = (x as f64 + along) / (self.columns - 1) as f64;
        [if whole > 0.0 { u } else { s }, (y as f64 + down) / (self.rows - 1) as f64]
    }

    /// Maps the point `(u, v)` to the square in which the density is uniform; both in `[0, 1]`.
    pub fn invert(&self, incidence: &Incidence, u: f64, v: f64) -> [f64; 2] {
        let (x, y) = (Cell::new(u, self.columns), Cell::new(v, self.rows));
        let (mut before, mut left, mut right) = (0.0, 0.0, 0.0);
        let (mut rows_before, mut upper, mut lower) = (0.0, 0.0, 0.0);
        for &(slice, weight) in incidence.slices() {
            let row = slice * self.rows + y.index;
            for (row, weight) in [(row, weight * (1.0 - y.fraction)), (row + 1, weight * y.fraction)] {
                let start = row * self.columns + x.index;
                let ([density, sum], [next, _]) = (self.nodes[start], self.nodes[start + 1]);
                before += weight * f64::from(sum);
                left += weight * f64::from(density);
                right += weight * f64::from(next);
            }
            upper += weight * f64::from(self.totals[row][0]);
            lower += weight * f64::from(self.totals[row + 1][0]);
            rows_before += weight * f64::from(self.totals[row][1]);
        }
        let along_row = before + segment(left, right, x.fraction);
        let whole_row = mix(upper, lower, y.fraction);
        // A row without visible normals has a uniform density.
        let s = if whole_row > 0.0 { along_row / whole_row } else { u };
        [s.clamp(0.0, 1.0), (rows_before + segment(upper, lower, y.fraction)).clamp(0.0, 1.0)]
    }
}

/// Finds the position at which a cumulative integral has a value: the node before it, and the distance from that node.
/// `from(k)` is the integral up to node `k`, and `density(k)` the integrand there. The inverse of [`segment`].
fn place(nodes: usize, value: f64, from: impl Fn(usize) -> f64, density: impl Fn(usize) -> f64) -> (usize, f64) {
    let (mut low, mut high) = (0, nodes - 1);
    while high - low > 1 {
        let middle = (low + high) / 2;
        if from(middle) <= value {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (rest, a, b) = ((value - from(low)).max(0.0), density(low), density(low + 1));
    let root = (a * a + 2.0 * (b - a) * rest).max(0.0).sqrt();
    let fraction = if a + root > 0.0 { 2.0 * rest / (a + root) } else { 0.0 };
    (low, fraction.clamp(0.0, 1.0))
}

/// Integral from 0 to `t` of the line from `a` at 0 to `b` at 1.
fn segment(a: f64, b: f64, t: f64) -> f64 {
    t * (a + 0.5 * t * (b - a))
}
