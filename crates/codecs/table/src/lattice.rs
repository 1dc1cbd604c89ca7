//! Nodes of a table as unknowns: the nodes of each sample, and the normal equations over neighbours.

use brdfc_formats::table::{Position, TableHeader};

/// Nodes around a sample: two per axis. Isotropic tables use the first half.
const MAX_TAPS: usize = 16;

/// Offsets of the taps from the first one: a step along axis `k` is `3^k`.
const STEPS_OF_TAPS: [usize; MAX_TAPS] = [0, 1, 3, 4, 9, 10, 12, 13, 27, 28, 30, 31, 36, 37, 39, 40];

/// Nodes of an interpolated value with their weights: the nodes on either side along each axis.
#[derive(Debug, Clone, Copy)]
pub struct Taps {
    nodes: [[u32; 2]; 4],
    weights: [[f32; 2]; 4],
}

impl Taps {
    /// Indices of nodes and products of weights for all combinations along the first `AXES` axes.
    #[inline]
    fn all<const AXES: usize, const TAPS: usize>(&self) -> ([u32; TAPS], [f32; TAPS]) {
        let (mut nodes, mut weights) = ([0; TAPS], [0.0; TAPS]);
        for k in 0..TAPS {
            (nodes[k], weights[k]) = (self.nodes[0][k & 1], self.weights[0][k & 1]);
            for axis in 1..AXES {
                nodes[k] += self.nodes[axis][k >> axis & 1];
                weights[k] *= self.weights[axis][k >> axis & 1];
            }
        }
        (nodes, weights)
    }

    #[inline]
    fn sum<const AXES: usize, const TAPS: usize, const C: usize>(&self, values: &[[f32; C]]) -> [f32; C] {
        let (nodes, weights) = self.all::<AXES, TAPS>();
        let mut sums = [0.0; C];
        for k in 0..TAPS {
            let node = &values[nodes[k] as usize];
            (0..C).for_each(|c| sums[c] += weights[k] * node[c]);
        }
        sums
    }
}

/// Means of values around each node.
pub struct Means {
    lattice: Lattice,
    /// Sums of three channels and of the weights.
    sums: Vec<[f32; 4]>,
    all: [f64; 3],
    count: usize,
}

impl Means {
    /// Creates means without samples.
    pub fn new(lattice: Lattice) -> Self {
        Self { lattice, sums: vec![[0.0; 4]; lattice.len()], all: [0.0; 3], count: 0 }
    }

    /// Adds a sample.
    #[inline]
    pub fn add(&mut self, taps: &Taps, values: [f32; 3]) {
        match self.lattice.axes() {
            3 => self.add_all(taps.all::<3, 8>(), values),
            _ => self.add_all(taps.all::<4, 16>(), values),
        }
        (0..3).for_each(|c| self.all[c] += f64::from(values[c]));
        self.count += 1;
    }

    #[inline]
    fn add_all<const TAPS: usize>(&mut self, (nodes, weights): ([u32; TAPS], [f32; TAPS]), [r, g, b]: [f32; 3]) {
        for k in 0..TAPS {
            let sum = &mut self.sums[nodes[k] as usize];
            (0..4).for_each(|c| sum[c] += weights[k] * [r, g, b, 1.0][c]);
        }
    }

    /// The mean around each node; the overall mean for nodes without samples.
    pub fn of_nodes(self) -> Vec<[f32; 3]> {
        let mean = self.all.map(|sum| (sum / self.count.max(1) as f64) as f32);
        let of = |[r, g, b, weight]: [f32; 4]| if weight > 1e-6 { [r, g, b].map(|s| s / weight) } else { mean };
        self.sums.into_iter().map(of).collect()
    }
}

/// Sizes of a table and its periodic axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lattice {
    /// Columns, rows, slices, layers.
    sizes: [usize; 4],
    around: [bool; 4],
}

impl Lattice {
    /// The nodes of a table; the repeated slice counts once.
    pub fn new(header: &TableHeader) -> Self {
        let axes = header.axes;
        let sizes = [axes.half, axes.difference, axes.azimuth, axes.layers].map(|n| n as usize);
        Self { sizes, around: [false, false, !header.symmetry.mirror, axes.layers > 1 && !header.symmetry.reflected] }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.sizes.iter().product()
    }

    /// Returns true if there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn axes(&self) -> usize {
        if self.sizes[3] == 1 { 3 } else { 4 }
    }

    fn strides(&self) -> [usize; 4] {
        let [columns, rows, slices, _] = self.sizes;
        [1, columns, columns * rows, columns * rows * slices]
    }

    /// Taps of a sample at this position.
    #[inline]
    pub fn taps(&self, position: &Position) -> Taps {
        let strides = self.strides();
        let mut taps = Taps { nodes: [[0; 2]; 4], weights: [[0.0; 2]; 4] };
        for (axis, at) in [position.column, position.row, position.slice].into_iter().enumerate() {
            let last = if self.around[axis] { self.sizes[axis] - 1 } else { self.sizes[axis] - 2 };
            let lower = (at as usize).min(last);
            let upper = if lower + 1 == self.sizes[axis] { 0 } else { lower + 1 };
            taps.nodes[axis] = [lower, upper].map(|node| (node * strides[axis]) as u32);
            taps.weights[axis] = [1.0 - (at - lower as f32), at - lower as f32];
        }
        taps.nodes[3] = position.layers.map(|layer| layer * strides[3] as u32);
        taps.weights[3] = [1.0 - position.layer_weight, position.layer_weight];
        taps
    }

    /// Interpolated value of a sample.
    #[inline]
    pub fn value<const C: usize>(&self, taps: &Taps, nodes: &[[f32; C]]) -> [f32; C] {
        if self.axes() == 3 { taps.sum::<3, 8, C>(nodes) } else { taps.sum::<4, 16, C>(nodes) }
    }

    /// Nodes of a sample with their weights.
    pub fn touched(&self, taps: &Taps) -> impl Iterator<Item = (usize, f32)> + use<> {
        // A single layer uses the first half, with a weight of 1 along that axis.
        let (nodes, weights) = taps.all::<4, 16>();
        let count = if self.axes() == 3 { 8 } else { 16 };
        nodes.into_iter().zip(weights).take(count).map(|(node, weight)| (node as usize, weight))
    }

    /// The neighbour at each offset of -1, 0 or 1 along the axes, for each node; beyond a border the node itself.
    fn neighbours(&self) -> Vec<u32> {
        // Neighbours of each position along an axis, as indices of nodes.
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

    /// Number of offsets of -1, 0 or 1 along the axes.
    fn offsets(&self) -> usize {
        3usize.pow(self.axes() as u32)
    }
}

/// Normal equations of least-squares fits over a lattice, `Aᵀ W A x = Aᵀ W b` for `C` right-hand sides `b`: each node
/// depends on its neighbours only.
pub struct Equations<const C: usize> {
    lattice: Lattice,
    neighbours: Vec<u32>,
    offsets: usize,
    /// `[node][offset]`; 0 without a neighbour.
    matrix: Vec<f32>,
    right: Vec<[f32; C]>,
}

impl<const C: usize> Equations<C> {
    /// Creates equations without samples.
    pub fn new(lattice: Lattice) -> Self {
        let (offsets, nodes) = (lattice.offsets(), lattice.len());
        let (matrix, right) = (vec![0.0; nodes * offsets], vec![[0.0; C]; nodes]);
        Self { lattice, neighbours: lattice.neighbours(), offsets, matrix, right }
    }

    /// Adds a sample with these values and a weight (the square of the factor of its residual).
    #[inline]
    pub fn add(&mut self, taps: &Taps, values: [f32; C], weight: f32) {
        match self.lattice.axes() {
            3 => self.add_all::<8, 14>(taps.all::<3, 8>(), values, weight),
            _ => self.add_all::<16, 41>(taps.all::<4, 16>(), values, weight),
        }
    }

    /// Same as [`Self::add`], for `TAPS` taps, the last of which is `SPAN - 1` offsets from the first.
    #[inline]
    fn add_all<const TAPS: usize, const SPAN: usize>(
        &mut self,
        (nodes, weights): ([u32; TAPS], [f32; TAPS]),
        values: [f32; C],
        weight: f32,
    ) {
        for a in 0..TAPS {
            let scaled = weight * weights[a];
            let node = nodes[a] as usize;
            let right = &mut self.right[node];
            (0..C).for_each(|c| right[c] += scaled * values[c]);
            // The first tap is one step back from the node along each axis that its own tap has stepped along.
            let first = node * self.offsets + self.offsets / 2 - STEPS_OF_TAPS[a];
            let row: &mut [f32; SPAN] =
                self.matrix[first..].first_chunk_mut().expect("a row extends to its last offset");
            for b in 0..TAPS {
                row[STEPS_OF_TAPS[b]] += scaled * weights[b];
            }
        }
    }

    /// Ties each node weakly to its neighbours, so that nodes without samples continue the others.
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

    /// Effect of the neighbours' errors on the best value of a node.
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

    /// Solves by conjugate gradients from an initial guess, scaled by the diagonal, in at most `steps` steps.
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
