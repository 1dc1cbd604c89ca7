//! The nodes of a table as unknowns: which of them a sample touches, and the normal equations over neighbours.

use brdfc_formats::table::{Position, TableHeader};

/// Nodes around a sample: two per axis. Isotropic tables use the first half.
const MOST_TAPS: usize = 16;

/// Nodes that a value is a mean of, with their weights.
#[derive(Debug, Clone, Copy)]
pub struct Taps {
    nodes: [u32; MOST_TAPS],
    weights: [f32; MOST_TAPS],
}

/// Sizes of a table and which of its axes go around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lattice {
    /// Columns, rows, slices, layers.
    sizes: [usize; 4],
    around: [bool; 4],
}

impl Lattice {
    /// The nodes of a table; the slice that stands twice counts once.
    pub fn new(header: &TableHeader) -> Self {
        let axes = header.axes;
        let sizes = [axes.half, axes.difference, axes.azimuth, axes.layers].map(|n| n as usize);
        Self { sizes, around: [false, false, !header.symmetry.mirror, axes.layers > 1 && !header.symmetry.reflected] }
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.sizes.iter().product()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn axes(&self) -> usize {
        if self.sizes[3] == 1 { 3 } else { 4 }
    }

    /// Taps of a sample, two to the power of the number of axes.
    fn count(&self) -> usize {
        1 << self.axes()
    }

    fn strides(&self) -> [usize; 4] {
        let [columns, rows, slices, _] = self.sizes;
        [1, columns, columns * rows, columns * rows * slices]
    }

    /// What the sample at this position is a mean of.
    pub fn taps(&self, position: &Position) -> Taps {
        let mut taps = Taps { nodes: [0; MOST_TAPS], weights: [0.0; MOST_TAPS] };
        let strides = self.strides();
        let pair = |axis: usize, at: f32| {
            let last = if self.around[axis] { self.sizes[axis] - 1 } else { self.sizes[axis] - 2 };
            let lower = (at as usize).min(last);
            let upper = (lower + 1) % self.sizes[axis];
            [(lower * strides[axis], 1.0 - (at - lower as f32)), (upper * strides[axis], at - lower as f32)]
        };
        let columns = pair(0, position.column);
        let rows = pair(1, position.row);
        let slices = pair(2, position.slice);
        let layers = [
            (position.layers[0] as usize * strides[3], 1.0 - position.layer_weight),
            (position.layers[1] as usize * strides[3], position.layer_weight),
        ];
        for k in 0..self.count() {
            let (column, row, slice, layer) = (columns[k & 1], rows[k >> 1 & 1], slices[k >> 2 & 1], layers[k >> 3]);
            let layer = if self.axes() == 3 { (0, 1.0) } else { layer };
            taps.nodes[k] = (column.0 + row.0 + slice.0 + layer.0) as u32;
            taps.weights[k] = column.1 * row.1 * slice.1 * layer.1;
        }
        taps
    }

    /// The values of a sample.
    pub fn value<const C: usize>(&self, taps: &Taps, nodes: &[[f32; C]]) -> [f32; C] {
        let mut sums = [0.0; C];
        for k in 0..self.count() {
            let node = &nodes[taps.nodes[k] as usize];
            (0..C).for_each(|c| sums[c] += taps.weights[k] * node[c]);
        }
        sums
    }

    /// Nodes touched by a sample, with their weights.
    pub fn touched<'t>(&self, taps: &'t Taps) -> impl Iterator<Item = (usize, f32)> + 't {
        (0..self.count()).map(|k| (taps.nodes[k] as usize, taps.weights[k]))
    }

    /// For each node and each offset of -1, 0 or 1 along the axes the node there; beyond a border the node itself.
    fn neighbours(&self) -> Vec<u32> {
        // Of each place along an axis the places around it, as indices of nodes.
        let strides = self.strides();
        let along: [Vec<[Option<u32>; 3]>; 4] = std::array::from_fn(|axis| {
            let size = self.sizes[axis] as isize;
            let moved = |place: isize, step: isize| {
                let at = place + step;
                let at = if self.around[axis] { at.rem_euclid(size) } else { at };
                (0..size).contains(&at).then(|| (at as usize * strides[axis]) as u32)
            };
            (0..size).map(|place| [-1, 0, 1].map(|step| moved(place, step))).collect()
        });
        let layers: &[usize] = if self.axes() == 3 { &[1] } else { &[0, 1, 2] };
        let mut all = Vec::with_capacity(self.len() * self.offsets());
        for layer in &along[3] {
            for slice in &along[2] {
                for row in &along[1] {
                    for column in &along[0] {
                        let place = [column, row, slice, layer].map(|places| places[1].unwrap_or(0));
                        let node: u32 = place.into_iter().sum();
                        for l in layers {
                            for (s, r) in (0..9).map(|code| (code / 3, code % 3)) {
                                for c in column {
                                    let parts = [*c, row[r], slice[s], layer[*l]];
                                    let at = parts.into_iter().try_fold(0, |sum, part| Some(sum + part?));
                                    all.push(at.unwrap_or(node));
                                }
                            }
                        }
                    }
                }
            }
        }
        all
    }

    /// Offsets of -1, 0 or 1 along the axes.
    fn offsets(&self) -> usize {
        3usize.pow(self.axes() as u32)
    }
}

/// Normal equations of least-squares fits over a lattice, `Aᵀ W A x = Aᵀ W b` for `C` right-hand sides `b`: each node is tied
/// to its neighbours alone.
pub struct Equations<const C: usize> {
    lattice: Lattice,
    neighbours: Vec<u32>,
    offsets: usize,
    /// Where the node of the second tap is from that of the first, as an offset.
    between: [[u8; MOST_TAPS]; MOST_TAPS],
    /// `[node][offset]`; 0 where there is no neighbour.
    matrix: Vec<f32>,
    right: Vec<[f32; C]>,
}

impl<const C: usize> Equations<C> {
    /// No samples yet.
    pub fn new(lattice: Lattice) -> Self {
        let (offsets, nodes) = (lattice.offsets(), lattice.len());
        let (matrix, right) = (vec![0.0; nodes * offsets], vec![[0.0; C]; nodes]);
        let step = |axis: usize, a: usize, b: usize| 3usize.pow(axis as u32) * (1 + (b >> axis & 1) - (a >> axis & 1));
        let code = |a: usize, b: usize| (0..lattice.axes()).map(|axis| step(axis, a, b)).sum::<usize>() as u8;
        let between = std::array::from_fn(|a| std::array::from_fn(|b| code(a, b)));
        Self { lattice, neighbours: lattice.neighbours(), offsets, between, matrix, right }
    }

    /// Adds a sample of these values and a weight (the square of what its residual is multiplied by).
    pub fn add(&mut self, taps: &Taps, values: [f32; C], weight: f32) {
        let count = self.lattice.count();
        for a in 0..count {
            let scaled = weight * taps.weights[a];
            let node = taps.nodes[a] as usize;
            let right = &mut self.right[node];
            (0..C).for_each(|c| right[c] += scaled * values[c]);
            let row = &mut self.matrix[node * self.offsets..][..self.offsets];
            for (code, weight) in self.between[a][..count].iter().zip(&taps.weights) {
                row[usize::from(*code)] += scaled * weight;
            }
        }
    }

    /// Ties each node weakly to its neighbours, so that those that no sample touches go on from the others.
    pub fn smooth(&mut self, strength: f32) {
        let centre = self.offsets / 2;
        let nodes = self.lattice.len();
        let trace: f64 = (0..nodes).map(|node| f64::from(self.matrix[node * self.offsets + centre])).sum();
        let tie = strength * ((trace / nodes as f64) as f32).max(f32::MIN_POSITIVE.sqrt());
        for node in 0..nodes {
            for axis in 0..self.lattice.axes() {
                for offset in [centre - 3usize.pow(axis as u32), centre + 3usize.pow(axis as u32)] {
                    let at = node * self.offsets;
                    if self.neighbours[at + offset] as usize != node {
                        self.matrix[at + offset] -= tie;
                        self.matrix[at + centre] += tie;
                    }
                }
            }
        }
    }

    fn apply(&self, x: &[[f32; C]], result: &mut [[f32; C]]) {
        let rows = self.matrix.chunks_exact(self.offsets).zip(self.neighbours.chunks_exact(self.offsets));
        for (result, (row, places)) in result.iter_mut().zip(rows) {
            let mut sum = [0.0; C];
            for (a, place) in row.iter().zip(places) {
                let x = &x[*place as usize];
                (0..C).for_each(|c| sum[c] += a * x[c]);
            }
            *result = sum;
        }
    }

    /// How far errors of its neighbours move the best value of a node.
    pub fn pull(&self, node: usize, errors: &[f32]) -> f32 {
        let at = node * self.offsets;
        let (row, places) = (&self.matrix[at..at + self.offsets], &self.neighbours[at..at + self.offsets]);
        let centre = self.offsets / 2;
        let of_others = |(offset, (a, place)): (usize, (&f32, &u32))| {
            if offset == centre { 0.0 } else { a * errors[*place as usize] }
        };
        let sum: f32 = row.iter().zip(places).enumerate().map(of_others).sum();
        if row[centre] > 0.0 { sum / row[centre] } else { 0.0 }
    }

    /// Solves by conjugate gradients from a first guess, scaled by the diagonal; at most so many steps.
    pub fn solve(&self, x: &mut [[f32; C]], steps: usize) {
        let nodes = self.lattice.len();
        let centre = self.offsets / 2;
        let inverse: Vec<f32> = (0..nodes).map(|node| 1.0 / self.matrix[node * self.offsets + centre]).collect();
        let mut product = vec![[0.0; C]; nodes];
        self.apply(x, &mut product);
        let each = |f: &dyn Fn(usize, usize) -> f32| -> Vec<[f32; C]> {
            (0..nodes).map(|node| std::array::from_fn(|c| f(node, c))).collect()
        };
        let mut residual = each(&|node, c| self.right[node][c] - product[node][c]);
        let mut direction = each(&|node, c| residual[node][c] * inverse[node]);
        let dot = |a: &[[f32; C]], b: &[[f32; C]]| -> [f64; C] {
            let mut sums = [0.0; C];
            for (a, b) in a.iter().zip(b) {
                (0..C).for_each(|c| sums[c] += f64::from(a[c]) * f64::from(b[c]));
            }
            sums
        };
        let mut energy = dot(&residual, &direction);
        let enough = energy.map(|energy| energy * 1e-8);
        for _ in 0..steps {
            // Zero once solved, and for no samples at all.
            if (0..C).all(|c| energy[c] <= enough[c] || energy[c].is_nan()) {
                break;
            }
            self.apply(&direction, &mut product);
            let along = dot(&direction, &product);
            let step: [f32; C] =
                std::array::from_fn(|c| if along[c] > 0.0 { (energy[c] / along[c]) as f32 } else { 0.0 });
            let mut next = [0.0f64; C];
            for node in 0..nodes {
                for c in 0..C {
                    x[node][c] += step[c] * direction[node][c];
                    residual[node][c] -= step[c] * product[node][c];
                    next[c] += f64::from(residual[node][c]) * f64::from(residual[node][c] * inverse[node]);
                }
            }
            let share: [f32; C] =
                std::array::from_fn(|c| if energy[c] > 0.0 { (next[c] / energy[c]) as f32 } else { 0.0 });
            for node in 0..nodes {
                for c in 0..C {
                    direction[node][c] = residual[node][c] * inverse[node] + share[c] * direction[node][c];
                }
            }
            energy = next;
        }
    }
}
