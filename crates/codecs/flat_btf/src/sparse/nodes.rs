//! Columns of the factor that share their rows, gathered into nodes.

use super::elimination::{Elimination, Graph};
use super::{NONE, TILE};
use std::ops::Range;

/// Columns with the same rows below them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// The first of its columns.
    pub first: u32,
    /// Number of its columns.
    pub pivots: u32,
    /// Start of its rows below the pivots among all nodes' rows.
    pub rows: usize,
    /// Number of its rows below the pivots.
    pub below: u32,
    /// Number of nodes directly before it in stack order that pass it their remainder.
    pub children: u32,
    /// Start of its lanes in the factor.
    pub lanes: usize,
}

impl Node {
    /// Rows that pivots take up, padded to whole tiles.
    pub fn padded_pivots(&self) -> usize {
        (self.pivots as usize).next_multiple_of(TILE)
    }

    /// Rows below the pivots, padded to whole tiles.
    pub fn padded_below(&self) -> usize {
        (self.below as usize).next_multiple_of(TILE)
    }

    /// Lanes of its columns: tile by tile, and within a tile column by column.
    pub fn lane_count(&self) -> usize {
        (self.padded_pivots() + self.padded_below()) / TILE * self.pivots as usize
    }

    /// Approximate number of multiplications of its factorisation.
    pub fn work(&self) -> u64 {
        let (pivots, below) = (u64::from(self.pivots), u64::from(self.below));
        pivots * (pivots * pivots / 6 + pivots * below / 2 + below * below / 2 + 16 * below + 64)
    }
}

/// Share of zeros among the stored entries up to which a node of at most this many columns is merged with its parent:
/// many tiny nodes cost more than a few operations on zeros (Ashcraft and Grimes 1989, "The influence of relaxed
/// supernode partitions on the multifrontal method").
const RELAXED: [(u64, f64); 4] = [(4, 1.0), (16, 0.6), (48, 0.15), (u64::MAX, 0.05)];

/// A node under construction: columns
struct Draft {
    first: u32,
    last: u32,
    height: u64,
    /// Stored entries that are always 0.
    zeros: u64,
}

impl Draft {
    fn entries(&self) -> u64 {
        let columns = u64::from(self.last - self.first) + 1;
        columns * self.height - columns * (columns - 1) / 2
    }

    /// Merges a child into its parent, unless that stores too many zeros.
    fn merged(&self, child: &Self) -> Option<Self> {
        let columns = u64::from(self.last - child.first) + 1;
        let height = self.height + u64::from(self.first - child.first);
        let mut merged = Self { first: child.first, last: self.last, height, zeros: 0 };
        merged.zeros = self.zeros + child.zeros + merged.entries() - self.entries() - child.entries();
        let allowed = RELAXED.iter().find(|(most, _)| columns <= *most).map_or(0.0, |(_, share)| *share);
        (merged.zeros as f64 <= allowed * merged.entries() as f64).then_some(merged)
    }
}

/// Splits the columns into nodes: joins columns with identical rows, then merges nodes with their parent where that is
/// cheaper.
fn drafts(elimination: &Elimination) -> Vec<Draft> {
    let Elimination { parents, counts, .. } = elimination;
    let mut done: Vec<Draft> = Vec::new();
    let mut first = 0;
    for column in 0..parents.len() {
        let goes_on = parents[column] as usize == column + 1 && counts[column + 1] + 1 == counts[column];
        if goes_on {
            continue;
        }
        let mut draft = Draft { first: first as u32, last: column as u32, height: counts[first].into(), zeros: 0 };
        // The last child of this node, if any, directly precedes it.
        while let Some(child) = done.last().filter(|child| parents[child.last as usize] <= draft.last) {
            let Some(merged) = draft.merged(child) else { break };
            draft = merged;
            done.pop();
        }
        done.push(draft);
        first = column + 1;
    }
    done
}

/// The nodes of a factor, children before their parents.
#[derive(Debug)]
pub(super) struct Nodes {
    pub nodes: Vec<Node>,
    /// Rows below the pivots, ascending for each node.
    pub rows: Vec<u32>,
    /// For each of the rows, its position in the front of the node's parent.
    pub above: Vec<u32>,
    /// The node of each column.
    pub of_column: Vec<u32>,
    /// Lanes of the whole factor.
    pub lanes: usize,
}

impl Nodes {
    pub fn new(graph: &Graph, elimination: &Elimination) -> Self {
        let n = graph.len();
        let drafts = drafts(elimination);
        let mut of_column = vec![0; n];
        for (node, draft) in drafts.iter().enumerate() {
            of_column[draft.first as usize..=draft.last as usize].fill(node as u32);
        }
        let mut all =
            Self { nodes: Vec::with_capacity(drafts.len()), rows: Vec::new(), above: Vec::new(), of_column, lanes: 0 };
        // Position of each row in the current front, and the front that it belongs to.
        let (mut place, mut member) = (vec![0u32; n], vec![NONE; n]);
        let mut waiting: Vec<u32> = Vec::new();
        for (index, draft) in drafts.iter().enumerate() {
            let index = index as u32;
            let start = all.rows.len();
            let mut add = |row: u32, rows: &mut Vec<u32>| {
                if row > draft.last && member[row as usize] != index {
                    member[row as usize] = index;
                    rows.push(row);
                }
            };
            for column in draft.first..=draft.last {
                for neighbour in graph.neighbours(elimination.order[column as usize]) {
                    add(elimination.step[*neighbour as usize], &mut all.rows);
                }
            }
            let is_child = |child: &u32| all.rows[all.nodes[*child as usize].rows] <= draft.last;
            let children = waiting.iter().rev().take_while(|child| is_child(child)).count();
            let children = waiting.split_off(waiting.len() - children);
            for child in &children {
                for at in all.range(*child) {
                    add(all.rows[at], &mut all.rows);
                }
            }
            all.rows[start..].sort_unstable();
            let node = Node {
                first: draft.first,
                pivots: draft.last - draft.first + 1,
                rows: start,
                below: (all.rows.len() - start) as u32,
                children: children.len() as u32,
                lanes: all.lanes,
            };
            (draft.first..=draft.last).for_each(|column| place[column as usize] = column - draft.first);
            let padded = node.padded_pivots() as u32;
            all.rows[start..].iter().zip(padded..).for_each(|(row, at)| place[*row as usize] = at);
            all.above.resize(all.rows.len(), 0);
            for child in children {
                for at in all.range(child) {
                    all.above[at] = place[all.rows[at] as usize];
                }
            }
            all.lanes += node.lane_count();
            all.nodes.push(node);
            if node.below > 0 {
                waiting.push(index);
            }
        }
        all
    }

    /// Range of the rows of a node among the rows of all nodes.
    pub fn range(&self, node: u32) -> Range<usize> {
        let node = &self.nodes[node as usize];
        node.rows..node.rows + node.below as usize
    }

    /// Position of an entry in the factor: 4 times its lane, plus its row in the lane.
    pub fn place(&self, row: u32, column: u32) -> usize {
        let index = self.of_column[column as usize];
        let node = &self.nodes[index as usize];
        let local = if row - node.first < node.pivots {
            (row - node.first) as usize
        } else {
            let below = self.rows[self.range(index)].binary_search(&row).expect("a node has the rows of its entries");
            node.padded_pivots() + below
        };
        let lane = node.lanes + local / TILE * node.pivots as usize + (column - node.first) as usize;
        TILE * lane + local % TILE
    }
}
