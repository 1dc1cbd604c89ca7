//! Elimination order and elimination tree.

use super::{FactorError, NONE};

const MAX_ROWS: usize = 1 << 29;
const MAX_PLACES: usize = 1 << 29;
/// Maximum number of entries of a factor: 16 GiB.
const MAX_ENTRIES: u64 = 1 << 31;

/// Neighbours of each vertex of a graph, ascending, without the vertex itself.
pub(super) struct Graph {
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Graph {
    /// Builds the graph of a symmetric matrix of `n` rows with entries in `places`: row and column, in either half, in
    /// any order, duplicates allowed.
    pub fn new(n: usize, places: &[[u32; 2]]) -> Result<Self, FactorError> {
        // Rows and twice the places are counted in signed 32-bit integers.
        if n >= MAX_ROWS || places.len() >= MAX_PLACES {
            return Err(FactorError::TooLarge { rows: n });
        }
        let apart = || places.iter().filter(|[a, b]| a != b).flat_map(|[a, b]| [[*a, *b], [*b, *a]]);
        let mut starts = vec![0u32; n + 1];
        apart().for_each(|[from, _]| starts[from as usize + 1] += 1);
        (0..n).for_each(|vertex| starts[vertex + 1] += starts[vertex]);
        let mut ends = starts.clone();
        let mut neighbours = vec![0; starts[n] as usize];
        for [from, to] in apart() {
            let end = &mut ends[from as usize];
            neighbours[*end as usize] = to;
            *end += 1;
        }
        let mut count = 0;
        for vertex in 0..n {
            let (from, to) = (starts[vertex] as usize, starts[vertex + 1] as usize);
            neighbours[from..to].sort_unstable();
            let start = count;
            for at in from..to {
                if count == start || neighbours[count - 1] != neighbours[at] {
                    neighbours[count] = neighbours[at];
                    count += 1;
                }
            }
            starts[vertex] = start as u32;
        }
        starts[n] = count as u32;
        neighbours.truncate(count);
        Ok(Self { starts, neighbours })
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a vertex.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        &self.neighbours[self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize]
    }

    /// Fill-reducing elimination order: approximate minimum degree.
    fn approximate_minimum_degree(&self) -> Vec<u32> {
        // The lower half with its diagonal, since the crate subtracts the number of rows from the number of entries.
        let n = self.len();
        let (mut starts, mut rows) = (Vec::with_capacity(n + 1), Vec::with_capacity(n + self.neighbours.len() / 2));
        starts.push(0);
        for column in 0..n as u32 {
            rows.push(column as i32);
            rows.extend(self.neighbours(column).iter().filter(|row| **row > column).map(|row| *row as i32));
            starts.push(rows.len() as i32);
        }
        let (order, _, _) =
            amd::order(n as i32, &starts, &rows, &amd::Control::default()).expect("columns are sorted and in range");
        order.into_iter().map(|vertex| vertex as u32).collect()
    }
}

/// Elimination order, tree and column counts.
pub(super) struct Elimination {
    /// Row eliminated at each step.
    pub order: Vec<u32>,
    /// Step at which each row is eliminated.
    pub step: Vec<u32>,
    /// The elimination tree: for each step, the next one that it changes, or [`NONE`] (Davis 2006, section 4.1).
    pub parents: Vec<u32>,
    /// Entries of each column of the factor.
    pub counts: Vec<u32>,
}

impl Elimination {
    /// Orders by approximate minimum degree; the descendants of every step directly precede it.
    pub fn new(graph: &Graph) -> Result<Self, FactorError> {
        Self::in_order(graph, graph.approximate_minimum_degree(), MAX_ENTRIES)
    }

    /// Eliminates in a given order, except that independent steps may be reordered. Returns an error if the factor has
    /// more than `most` entries.
    pub fn in_order(graph: &Graph, order: Vec<u32>, most: u64) -> Result<Self, FactorError> {
        let raw = tree(graph, &order, &inverse(&order));
        let post = postorder(&raw);
        let renamed = inverse(&post);
        let mut parents = vec![NONE; order.len()];
        for (at, parent) in raw.iter().enumerate().filter(|(_, parent)| **parent != NONE) {
            parents[renamed[at] as usize] = renamed[*parent as usize];
        }
        let order: Vec<u32> = post.iter().map(|at| order[*at as usize]).collect();
        let step = inverse(&order);
        let counts = column_counts(graph, &order, &step, &parents, most)?;
        Ok(Self { order, step, parents, counts })
    }
}

fn inverse(order: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, value)| inverse[*value as usize] = at as u32);
    inverse
}

/// The elimination tree (Liu 1990, "The role of elimination trees in sparse factorization").
fn tree(graph: &Graph, order: &[u32], step: &[u32]) -> Vec<u32> {
    let mut parents = vec![NONE; order.len()];
    // Ancestors found so far, which shorten the paths to the root.
    let mut ancestors = vec![NONE; order.len()];
    for (now, row) in order.iter().enumerate() {
        let now = now as u32;
        for neighbour in graph.neighbours(*row) {
            let mut at = step[*neighbour as usize];
            while at < now {
                let above = std::mem::replace(&mut ancestors[at as usize], now);
                if above == NONE {
                    parents[at as usize] = now;
                    break;
                }
                at = above;
            }
        }
    }
    parents
}

/// Postorder of a tree: children before their parents, siblings in the given order.
fn postorder(parents: &[u32]) -> Vec<u32> {
    let n = parents.len();
    let (mut first_child, mut next_sibling) = (vec![NONE; n], vec![NONE; n]);
    let mut roots = NONE;
    for at in (0..n).rev() {
        let first = if parents[at] == NONE { &mut roots } else { &mut first_child[parents[at] as usize] };
        next_sibling[at] = std::mem::replace(first, at as u32);
    }
    let mut order = Vec::with_capacity(n);
    let mut path = Vec::new();
    let mut root = roots;
    while root != NONE {
        path.push(root);
        while let Some(at) = path.last().copied() {
            // Children are visited before their parent, once.
            let child = std::mem::replace(&mut first_child[at as usize], NONE);
            if child == NONE {
                order.push(at);
                path.pop();
                if let Some(above) = path.last() {
                    first_child[*above as usize] = next_sibling[at as usize];
                }
            } else {
                path.push(child);
            }
        }
        root = next_sibling[root as usize];
    }
    order
}

/// Number of entries of each column of the factor: row `i` has one in each column on the paths up the tree from its
/// entries left of the diagonal to `i` (Davis 2006, section 4.2).
fn column_counts(
    graph: &Graph,
    order: &[u32],
    step: &[u32],
    parents: &[u32],
    most: u64,
) -> Result<Vec<u32>, FactorError> {
    let mut counts = vec![1; order.len()];
    let mut total = order.len() as u64;
    let mut last_seen = vec![NONE; order.len()];
    for (now, row) in order.iter().enumerate() {
        let now = now as u32;
        for neighbour in graph.neighbours(*row) {
            let mut at = step[*neighbour as usize];
            while at < now && last_seen[at as usize] != now {
                last_seen[at as usize] = now;
                counts[at as usize] += 1;
                total += 1;
                at = parents[at as usize];
            }
        }
        if total > most {
            return Err(FactorError::TooLarge { rows: order.len() });
        }
    }
    Ok(counts)
}
