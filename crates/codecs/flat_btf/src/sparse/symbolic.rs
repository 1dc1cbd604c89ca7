//! What can be said about a factor before the numbers are known.

use super::elimination::{Elimination, Graph};
use super::nodes::Nodes;
use super::{FactorError, NONE};
use std::ops::Range;

/// Share of all work up to which a part of the tree is done in one piece.
const PIECE: f64 = 1.0 / 64.0;
/// Parts of all work after which the caller is asked whether to go on.
const STAGES: u64 = 4;

/// The pattern of a matrix, analysed: serves all matrices with entries in the same places.
#[derive(Debug)]
pub struct Symbolic {
    pub(super) rows: usize,
    /// Which row of the matrix comes at each step of the elimination.
    pub(super) order: Vec<u32>,
    pub(super) nodes: Nodes,
    /// Where in the factor each entry of the matrix starts.
    pub(super) places: Vec<usize>,
    /// All nodes in their order, in parts of about the same work.
    pub(super) stages: Vec<Vec<Segment>>,
}

/// Nodes that are made in one go.
#[derive(Debug)]
pub(super) struct Segment {
    pub nodes: Range<usize>,
    /// Whether it is above others, and has to wait for them; otherwise it is a part of the tree that hangs on no other.
    pub top: bool,
}

impl Symbolic {
    /// Analyses a matrix of `rows` rows with entries in `places`: row and column, in either half. The values of entries
    /// in one place, or in one and its mirror image, will be added.
    ///
    /// # Errors
    /// [`FactorError::TooLarge`].
    ///
    /// # Panics
    /// If a place is outside the matrix.
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

    /// Entries of the factor, with those that are 0 for what nodes were merged.
    pub fn factor_entries(&self) -> u64 {
        let entries = |pivots: u64, below: u64| pivots * (pivots + 1) / 2 + pivots * below;
        self.nodes.nodes.iter().map(|node| entries(node.pivots.into(), node.below.into())).sum()
    }
}

/// Cuts the tree of nodes into pieces that can be made at the same time, and what is above them.
fn stages(nodes: &Nodes) -> Vec<Vec<Segment>> {
    let own: Vec<u64> = nodes.nodes.iter().map(|node| node.work()).collect();
    let total: u64 = own.iter().sum();
    let most = (PIECE * total as f64) as u64;
    // Of each node and all that hangs on it: how much work, and the first node.
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
