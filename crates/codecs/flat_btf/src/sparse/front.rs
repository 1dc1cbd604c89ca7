//! Dense factorisation of fronts.
//!
//! The columns of a node are stored in tiles of [`TILE`] rows: first the tiles of the pivots, padded with zeros, then
//! the tiles of the rows below. The columns of a tile are contiguous, as lanes of one value per row. All operations on
//! a front are then products of two tiles, which vectorise.

use super::{Lane, TILE};
use rayon::prelude::*;
use std::ops::Range;

/// Number of multiplications above which threads share a step.
const SHARED: usize = 1 << 18;
/// Columns per block of the remainder update, so that tiles stay in the cache.
const DEPTH: usize = 256;

/// Update matrix that a node passes to its parent: symmetric, with a row for each row below the pivots.
pub(super) struct Remainder {
    /// Range of the rows among the rows of all nodes.
    pub rows: Range<usize>,
    /// Rows padded to whole tiles.
    pub height: usize,
    /// Columns of `height` rows each, valid from the diagonal down.
    pub values: Vec<f64>,
}

impl Remainder {
    /// Allocates zeros; `None` if memory runs out.
    pub fn zeros(rows: Range<usize>) -> Option<Self> {
        let height = rows.len().next_multiple_of(TILE);
        Some(Self { rows, height, values: zeros(height.checked_mul(height)?)? })
    }
}

/// Allocates `count` zeros; `None` if memory runs out.
pub(super) fn zeros<T: Copy + Default>(count: usize) -> Option<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).ok()?;
    values.resize(count, T::default());
    Some(values)
}

/// `Σ_l a_l b_lᵀ` over the columns of two tiles: a column of the sum for each row of `b`.
fn product(a: &[Lane], b: &[Lane]) -> [Lane; TILE] {
    let mut sum = [[0.0; TILE]; TILE];
    for (a, b) in a.iter().zip(b) {
        for (column, b) in sum.iter_mut().zip(b) {
            column.iter_mut().zip(a).for_each(|(sum, a)| *sum += a * b);
        }
    }
    sum
}

fn subtract(from: &mut [f64], lane: &Lane) {
    from.iter_mut().zip(lane).for_each(|(value, other)| *value -= other);
}

/// Factorises the columns of a node in place. Returns the index of a pivot that is not above 0 as the error.
pub(super) fn factorise(lanes: &mut [Lane], pivots: usize) -> Result<(), usize> {
    for done in (0..pivots).step_by(TILE) {
        let (diagonal, below) = lanes[done / TILE * pivots..].split_at_mut(pivots);
        let (before, tile) = diagonal.split_at_mut(done);
        let width = tile.len().min(TILE);
        let tile = &mut tile[..width];
        let sum = product(before, before);
        tile.iter_mut().zip(&sum).for_each(|(lane, sum)| subtract(lane, sum));
        factorise_tile(tile).map_err(|pivot| done + pivot)?;
        let inverse: Lane = std::array::from_fn(|c| tile.get(c).map_or(0.0, |lane| 1.0 / lane[c]));
        let solve = |lanes: &mut [Lane]| {
            let (made, rest) = lanes.split_at_mut(done);
            let sum = product(made, before);
            for c in 0..width {
                let mut lane = rest[c];
                subtract(&mut lane, &sum[c]);
                for l in 0..c {
                    let other = rest[l].map(|v| v * tile[l][c]);
                    subtract(&mut lane, &other);
                }
                rest[c] = lane.map(|v| v * inverse[c]);
            }
        };
        if below.len() * done >= SHARED {
            below.par_chunks_exact_mut(pivots).for_each(solve);
        } else {
            below.chunks_exact_mut(pivots).for_each(solve);
        }
    }
    Ok(())
}

/// Cholesky factorisation of the tile on the diagonal.
fn factorise_tile(tile: &mut [Lane]) -> Result<(), usize> {
    for c in 0..tile.len() {
        let mut lane = tile[c];
        for l in 0..c {
            let other = tile[l].map(|v| v * tile[l][c]);
            subtract(&mut lane, &other);
        }
        let root = lane[c].sqrt();
        // Also rejects NaN.
        if !(root > 0.0 && root.is_finite()) {
            return Err(c);
        }
        tile[c] = std::array::from_fn(|r| match r.cmp(&c) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => root,
            std::cmp::Ordering::Greater => lane[r] / root,
        });
    }
    Ok(())
}

/// Subtracts the products of the node's columns from the remainder; `lanes` belong to the rows below the pivots.
pub(super) fn subtract_products(remainder: &mut Remainder, lanes: &[Lane], pivots: usize) {
    let height = remainder.height;
    if height == 0 {
        return;
    }
    for start in (0..pivots).step_by(DEPTH) {
        let depth = start..(start + DEPTH).min(pivots);
        let fill = |(at, columns): (usize, &mut [f64])| {
            let b = &lanes[at * pivots..][depth.clone()];
            for (tile, a) in lanes.chunks_exact(pivots).enumerate().skip(at) {
                let sum = product(&a[depth.clone()], b);
                for (c, sum) in sum.iter().enumerate() {
                    subtract(&mut columns[c * height + TILE * tile..][..TILE], sum);
                }
            }
        };
        if height * height * depth.len() >= 2 * SHARED {
            remainder.values.par_chunks_exact_mut(TILE * height).enumerate().for_each(fill);
        } else {
            remainder.values.chunks_exact_mut(TILE * height).enumerate().for_each(fill);
        }
    }
}
