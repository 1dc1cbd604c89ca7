//! One pass over the views: for each texel and light the sum over views of values times the basis. With it and the mask,
//! weights and shadows of a texel can be solved for as often as wanted without its values.

use super::basis::Basis;
use super::masks::Masks;
use super::matrix::{Rows, add_product};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::to_opponent;
use rayon::prelude::*;

/// Texels of a strip that is worked on at once.
const STRIP: usize = 128;

/// Words of some texels in a view: those from `first` on of each light, lights `stride` apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct ViewWords<'a> {
    pub(super) view: usize,
    pub(super) words: &'a [u32],
    pub(super) first: usize,
    pub(super) stride: usize,
}

/// Sums of some texels: `texels x L x K`, and `Σ m x₀` with `x₀` the lightness, `texels x L`. Bytes: `4 texels L (K + 1)`.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    pub(super) products: Vec<f32>,
    pub(super) lightness: Vec<f32>,
}

impl Sums {
    pub(super) fn new(texels: usize, basis: &Basis) -> Self {
        let pairs = texels * basis.lights;
        Self { products: vec![0.0; pairs * basis.components], lightness: vec![0.0; pairs] }
    }

    /// Adds some views. The result depends on which come together, as rounding does.
    pub(super) fn add(&mut self, basis: &Basis, masks: &Masks, views: &[ViewWords<'_>]) {
        let (k, lights) = (basis.components, basis.lights);
        let columns = 3 * views.len();
        // Of each light the rows of all these views, one below the other.
        let rows_of = |light: usize| views.iter().flat_map(move |words| basis.pair(words.view, light));
        let rows: Vec<f32> = (0..lights).flat_map(rows_of).copied().collect();
        let strips =
            self.products.par_chunks_mut(STRIP * lights * k).zip(self.lightness.par_chunks_mut(STRIP * lights));
        strips.enumerate().for_each(|(strip, (products, lightness))| {
            let (first, count) = (strip * STRIP, lightness.len() / lights);
            let mut values = vec![0.0; count * columns];
            let weights: Vec<f32> =
                views.iter().flat_map(|v| (0..count).map(|texel| masks.weight(first + texel, v.view))).collect();
            for light in 0..lights {
                for (number, view) in views.iter().enumerate() {
                    let words = &view.words[light * view.stride + view.first + first..][..count];
                    let weights = &weights[number * count..][..count];
                    for (texel, (word, weight)) in words.iter().zip(weights).enumerate() {
                        let colour = to_opponent(rgb9e5::decode(*word)).map(|c| weight * c);
                        values[texel * columns + 3 * number..][..3].copy_from_slice(&colour);
                        lightness[texel * lights + light] += colour[0];
                    }
                }
                let target = &mut products[light * k..];
                let rows = Rows::new(&rows[light * columns * k..][..columns * k], columns, k);
                add_product(target, lights * k, Rows::new(&values, count, columns), rows);
            }
        });
    }
}
