//! Numeric factorisation.

use super::front::{Remainder, factorise, subtract_products, zeros};
use super::symbolic::Symbolic;
use super::{FactorError, Lane, TILE};
use brdfc_core::progress::Progress;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Cholesky factor of a matrix.
#[derive(Debug, Clone)]
pub struct Cholesky {
    pub(super) symbolic: Arc<Symbolic>,
    pub(super) lanes: Vec<Lane>,
}

impl Cholesky {
    /// Factorises the matrix with these `values`, in the order of the analysed places. `progress` receives a few steps.
    ///
    /// # Errors
    /// Returns [`FactorError::NotPositiveDefinite`], [`FactorError::Cancelled`], or [`FactorError::TooLarge`] if memory
    /// runs out.
    ///
    /// # Panics
    /// Panics if the number of values differs from the number of places.
    pub fn new(symbolic: &Arc<Symbolic>, values: &[f64], progress: &dyn Progress) -> Result<Self, FactorError> {
        assert_eq!(values.len(), symbolic.places.len(), "one value for each place");
        let too_large = FactorError::TooLarge { rows: symbolic.rows };
        let mut lanes: Vec<Lane> = zeros(symbolic.nodes.lanes).ok_or(too_large)?;
        let flat = lanes.as_flattened_mut();
        symbolic.places.iter().zip(values).for_each(|(place, value)| flat[*place] += value);
        let mut rest = lanes.as_mut_slice();
        let mut stack = Vec::new();
        for stage in &symbolic.stages {
            progress.step()?;
            let mut parts = Vec::with_capacity(stage.len());
            for segment in stage {
                let count = symbolic.nodes.nodes[segment.nodes.clone()].iter().map(|node| node.lane_count()).sum();
                let (own, others) = std::mem::take(&mut rest).split_at_mut(count);
                parts.push((segment, own));
                rest = others;
            }
            let pieces = parts.par_iter_mut().map(|(segment, lanes)| {
                let mut left = Vec::new();
                if !segment.top {
                    symbolic.make(segment.nodes.clone(), lanes, &mut left)?;
                }
                Ok(left)
            });
            let pieces: Vec<Result<Vec<Remainder>, FactorError>> = pieces.collect();
            // In order, so that the first of several errors is returned.
            for ((segment, lanes), left) in parts.into_iter().zip(pieces) {
                stack.extend(left?);
                if segment.top {
                    symbolic.make(segment.nodes.clone(), lanes, &mut stack)?;
                }
            }
        }
        Ok(Self { symbolic: symbolic.clone(), lanes })
    }
}

impl Symbolic {
    /// Computes the columns of consecutive nodes. Their children left their remainders on the stack.
    fn make(&self, nodes: Range<usize>, mut lanes: &mut [Lane], stack: &mut Vec<Remainder>) -> Result<(), FactorError> {
        for index in nodes {
            let node = &self.nodes.nodes[index];
            let pivots = node.pivots as usize;
            let (own, others) = std::mem::take(&mut lanes).split_at_mut(node.lane_count());
            lanes = others;
            let mut remainder =
                Remainder::zeros(self.nodes.range(index as u32)).ok_or(FactorError::TooLarge { rows: self.rows })?;
            for child in stack.drain(stack.len() - node.children as usize..) {
                self.take_up(child, own, pivots, &mut remainder);
            }
            factorise(own, pivots).map_err(|pivot| FactorError::NotPositiveDefinite {
                row: self.order[node.first as usize + pivot] as usize,
            })?;
            if node.below > 0 {
                subtract_products(&mut remainder, &own[node.padded_pivots() / TILE * pivots..], pivots);
                stack.push(remainder);
            }
        }
        Ok(())
    }

    /// Adds the remainder of a child to the columns of its parent and to the parent's remainder.
    fn take_up(&self, child: Remainder, lanes: &mut [Lane], pivots: usize, remainder: &mut Remainder) {
        let above = &self.nodes.above[child.rows.clone()];
        let padded = pivots.next_multiple_of(TILE);
        let flat = lanes.as_flattened_mut();
        for (c, (column, values)) in above.iter().zip(child.values.chunks_exact(child.height)).enumerate() {
            let column = *column as usize;
            let entries = above[c..].iter().zip(&values[c..]);
            if column < pivots {
                for (row, value) in entries {
                    let row = *row as usize;
                    flat[TILE * (row / TILE * pivots + column) + row % TILE] += value;
                }
            } else {
                let into = &mut remainder.values[(column - padded) * remainder.height..][..remainder.height];
                entries.for_each(|(row, value)| into[*row as usize - padded] += value);
            }
        }
    }
}
