//! Symbolic factorisation, before values are known.

use super::elimination::{Elimination, Graph};
use super::nodes::Nodes;
use super::{FactorError, NONE};
use std::ops::Range;

/// Share of all work up to which a subtree is one task.
const PIECE: f64 = 1.0 / 64.0;
/// Parts of all work between two calls of `progress`.
const STAGES: u64 = 4;

/// The analysed pattern of a matrix. Serves all matrices with entries in the same places.
#[derive(Debug)]
pub struct Symbolic {
    pub(super) rows: usize,
    /// Row of the matrix that is eliminated at each step.
    pub(super) order: Vec<u32>,
    pub(super) nodes: Nodes,
    /// Position in the factor at which each entry of the matrix is added.
    pub(super) places: Vec<usize>,
    /// All nodes in order, in stages of about equal work.
    pub(super) stages: Vec<Vec<Segment>>,
}

/// Nodes that one task computes.
#[derive(Debug)]
pub(super) struct Segment {
    pub nodes: Range<usize>,
    /// True if the nodes are above others and wait for them; false for an independent subtree.
    pub top: bool,
}

impl Symbolic {
    /// Analyses a matrix of `rows` rows with entries in `places`: row and column, in either half. Values of the same
    /// place or of its mirror image are added.
    ///
    /// # Errors
    /// Returns [`FactorError::TooLarge`].
    ///
    /// # Panics
    /// Panics if a place is outside the matrix.
    pub fn new(rows: usize, places: &[[u32; 2]]) -> Result<Self, FactorError> {
        let graph = Graph::new(rows, places)?;
        let elimination = Elimination::new(&graph)?;
        Ok(Self::of(&graph, elimination, places))
    }

    pub(super) fn of(graph: &Graph, elimination: Elimination, places: &[[u32; 2]]) -> Self {
        let nodes = Nodes::new(graph, &elimination);
        let place = |[a, b]: &[u32; 2]| {
            let [a, b] = [a, b].map(|row| elimination.step[*row as usize]);
            nodes.place(a.max(b), a.min(b))
        };
        let places = places.iter().map(place).collect();
        Self { rows: graph.len(), order: elimination.order, stages: stages(&nodes), nodes, places }
    }

    /// Rows of the matrix.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Entries of the factor, including zeros stored by merged nodes.
    pub fn factor_entries(&self) -> u64 {
        let entries = |pivots: u64, below: u64| pivots * (pivots + 1) / 2 + pivots * below;
        self.nodes.nodes.iter().map(|node| entries(node.pivots.into(), node.below.into())).sum()
    }
}

/// Splits the tree of nodes into independent subtrees and the nodes above them.
fn stages(nodes: &Nodes) -> Vec<Vec<Segment>> {
    let own: Vec<u64> = nodes.nodes.iter().map(|node| node.work()).collect();
    let total: u64 = own.iter().sum();
    let most = (PIECE * total as f64) as u64;
    // For each subtree: its work and its first node.
    let (mut work, mut first): (Vec<u64>, Vec<usize>) = (own.clone(), (0..own.len()).collect());
    let mut parents = vec![NONE; own.len()];
    for (index, node) in nodes.nodes.iter().enumerate().filter(|(_, node)| node.below > 0) {
        let parent = nodes.of_column[nodes.rows[node.rows] as usize];
        parents[index] = parent;
        work[parent as usize] += work[index];
        first[parent as usize] = first[parent as usize].min(first[index]);
    }
    let (mut stages, mut done) = (vec![Vec::new()], 0);
    for index in 0..own.len() {
        let top = work[index] > most;
        let under_top = parents[index] == NONE || work[parents[index] as usize] > most;
        if !top && !under_top {
            continue;
        }
        let nodes = if top { index..index + 1 } else { first[index]..index + 1 };
        if done > total / STAGES * stages.len() as u64 {
            stages.push(Vec::new());
        }
        done += own[nodes.clone()].iter().sum::<u64>();
        if let Some(stage) = stages.last_mut() {
            stage.push(Segment { nodes, top });
        }
    }
    stages
}
