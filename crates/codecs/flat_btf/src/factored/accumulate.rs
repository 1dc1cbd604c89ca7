//! Sums over views and lights, in one pass: the right side of the equations of each texel's weights. With these sums and
//! the mask, weights can be solved without values.

use super::base::{Rays, StoredBase};
use super::basis::Basis;
use super::masks::Masks;
use super::matrix::{Rows, add_product};
use super::residual::Shares;
use super::words::ViewWords;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::to_opponent;
use rayon::prelude::*;

/// Texels of a strip, the unit of parallel work.
const STRIP: usize = 128;

/// Sums of some texels, `Σ m s Bᵀ (x - s o)` with view weight m, root s of the lit share, value x less its shaded part, and
/// base o: `texels x K`.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    components: usize,
    right: Vec<f32>,
}

impl Sums {
    pub(super) fn new(texels: usize, basis: &Basis) -> Self {
        Self { components: basis.components, right: vec![0.0; texels * basis.components] }
    }

    /// Sums of a texel.
    pub(super) fn of(&self, texel: usize) -> &[f32] {
        &self.right[texel * self.components..][..self.components]
    }

    /// Adds some views. The rounding of the result depends on how views are grouped. `base` is the base of these
    /// texels, `shares` their shares.
    pub(super) fn add(
        &mut self,
        basis: &Basis,
        (base, rays, shares): (&StoredBase, &Rays, &Shares),
        masks: &Masks,
        views: &[ViewWords<'_>],
    ) {
        let (k, lights) = (basis.components, basis.lights);
        let columns = 3 * views.len();
        // For each light, the rows of all these views, concatenated.
        let rows_of = |light: usize| views.iter().flat_map(move |words| basis.pair(words.view, light));
        let rows: Vec<f32> = (0..lights).flat_map(rows_of).copied().collect();
        self.right.par_chunks_mut(STRIP * k).enumerate().for_each(|(strip, right)| {
            let (first, count) = (strip * STRIP, right.len() / k);
            let mut values = vec![0.0; count * columns];
            let weights: Vec<f32> =
                views.iter().flat_map(|v| (0..count).map(|texel| masks.weight(first + texel, v.view))).collect();
            for light in 0..lights {
                for (number, view) in views.iter().enumerate() {
                    let words = &view.words[light * view.stride + view.first + first..][..count];
                    let weights = &weights[number * count..][..count];
                    let (outgoing, incoming) = (rays.views[view.view], rays.lights[light]);
                    for (texel, (word, weight)) in words.iter().zip(weights).enumerate() {
                        let pair = (first + texel) * lights + light;
                        let root = shares.fit_roots[pair];
                        let value = if root > 0.0 {
                            let value = base.without(first + texel, shares.shaded[pair], rgb9e5::decode(*word));
                            let colour = to_opponent(value);
                            let plain = base.opponent(first + texel, outgoing, incoming);
                            [0, 1, 2].map(|c: usize| weight * root * (colour[c] - root * plain[c]))
                        } else {
                            [0.0; 3]
                        };
                        values[texel * columns + 3 * number..][..3].copy_from_slice(&value);
                    }
                }
                let rows = Rows::new(&rows[light * columns * k..][..columns * k], columns, k);
                add_product(right, k, Rows::new(&values, count, columns), rows);
            }
        });
    }
}
