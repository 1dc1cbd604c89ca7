//! Triangular solves with a factor.

use super::factor::Cholesky;
use super::nodes::Node;
use super::{Lane, TILE};

impl Cholesky {
    /// Solves `A x = b` for `K` right sides at once, in place: one entry of `x` per row.
    ///
    /// # Panics
    /// Panics if `x` does not have one entry per row.
    pub fn solve<const K: usize>(&self, x: &mut [[f64; K]]) {
        let symbolic = &*self.symbolic;
        assert_eq!(x.len(), symbolic.rows(), "one value for each row");
        let mut ordered: Vec<[f64; K]> = symbolic.order.iter().map(|row| x[*row as usize]).collect();
        for node in &symbolic.nodes.nodes {
            self.forward(node, &mut ordered);
        }
        let mut sums = Vec::new();
        for node in symbolic.nodes.nodes.iter().rev() {
            self.backward(node, &mut ordered, &mut sums);
        }
        symbolic.order.iter().zip(ordered).for_each(|(row, value)| x[*row as usize] = value);
    }

    /// The lanes of the pivots and those below them, and the rows of the latter.
    fn parts(&self, node: &Node) -> (&[Lane], &[Lane], &[u32]) {
        let lanes = &self.lanes[node.lanes..][..node.lane_count()];
        let (diagonal, below) = lanes.split_at(node.padded_pivots() / TILE * node.pivots as usize);
        (diagonal, below, &self.symbolic.nodes.rows[node.rows..][..node.below as usize])
    }

    /// `x = L⁻¹ x`, restricted to the columns of one node.
    fn forward<const K: usize>(&self, node: &Node, x: &mut [[f64; K]]) {
        let (diagonal, below, rows) = self.parts(node);
        let pivots = node.pivots as usize;
        let (own, others) = x[node.first as usize..].split_at_mut(pivots);
        for (tile, lanes) in diagonal.chunks_exact(pivots).enumerate() {
            let start = TILE * tile;
            let (made, rest) = own.split_at_mut(start);
            let mut sum = tile_gemv(lanes, made);
            for c in 0..rest.len().min(TILE) {
                let lane = &lanes[start + c];
                for k in 0..K {
                    rest[c][k] = (rest[c][k] - sum[k][c]) / lane[c];
                    (c + 1..TILE).for_each(|r| sum[k][r] += lane[r] * rest[c][k]);
                }
            }
        }
        let after = node.first as usize + pivots;
        for (lanes, rows) in below.chunks_exact(pivots).zip(rows.chunks(TILE)) {
            let sum = tile_gemv(lanes, own);
            for (r, row) in rows.iter().enumerate() {
                (0..K).for_each(|k| others[*row as usize - after][k] -= sum[k][r]);
            }
        }
    }

    /// `x = L⁻ᵀ x`, restricted to the columns of one node.
    fn backward<const K: usize>(&self, node: &Node, x: &mut [[f64; K]], sums: &mut Vec<[Lane; K]>) {
        let (diagonal, below, rows) = self.parts(node);
        let pivots = node.pivots as usize;
        let (own, others) = x[node.first as usize..].split_at_mut(pivots);
        let after = node.first as usize + pivots;
        sums.clear();
        sums.resize(pivots, [[0.0; TILE]; K]);
        for (lanes, rows) in below.chunks_exact(pivots).zip(rows.chunks(TILE)) {
            let mut values = [[0.0; TILE]; K];
            for (r, row) in rows.iter().enumerate() {
                (0..K).for_each(|k| values[k][r] = others[*row as usize - after][k]);
            }
            tile_gemv_t(lanes, &values, sums);
        }
        for (tile, lanes) in diagonal.chunks_exact(pivots).enumerate().rev() {
            let start = TILE * tile;
            let mut values = [[0.0; TILE]; K];
            for c in (0..(pivots - start).min(TILE)).rev() {
                let lane = &lanes[start + c];
                for k in 0..K {
                    let [s0, s1, s2, s3] = sums[start + c][k];
                    let mut sum = (s0 + s1) + (s2 + s3);
                    (c + 1..TILE).for_each(|r| sum += lane[r] * values[k][r]);
                    values[k][c] = (own[start + c][k] - sum) / lane[c];
                    own[start + c][k] = values[k][c];
                }
            }
            tile_gemv_t(&lanes[..start], &values, &mut sums[..start]);
        }
    }
}

/// `Σ_l lane_l x_l` for the first columns of a tile.
fn tile_gemv<const K: usize>(lanes: &[Lane], x: &[[f64; K]]) -> [Lane; K] {
    let mut sum = [[0.0; TILE]; K];
    for (lane, x) in lanes.iter().zip(x) {
        for (sum, x) in sum.iter_mut().zip(x) {
            sum.iter_mut().zip(lane).for_each(|(sum, value)| *sum += value * x);
        }
    }
    sum
}

/// Adds to the sum of each column its products with the values of a tile's rows, row by row.
fn tile_gemv_t<const K: usize>(lanes: &[Lane], values: &[Lane; K], sums: &mut [[Lane; K]]) {
    for (lane, sums) in lanes.iter().zip(sums) {
        for (sum, values) in sums.iter_mut().zip(values) {
            for r in 0..TILE {
                sum[r] += lane[r] * values[r];
            }
        }
    }
}
