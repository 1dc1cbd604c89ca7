//! Sums over views, in one pass: for each texel and light, of values and of the base, times the basis. With these sums
//! and the mask, weights and shadows of a texel can be solved any number of times without its values.

use super::base::{Rays, StoredBase};
use super::basis::Basis;
use super::masks::Masks;
use super::matrix::{Rows, add_product};
use super::words::ViewWords;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::to_opponent;
use rayon::prelude::*;

/// Texels of a strip, the unit of parallel work.
const STRIP: usize = 128;

/// Sums of a texel and a light, with values x, base o and view weight m: `Σ m x₀` (lightness), `Σ m x·o`, `Σ m o·o`.
pub(super) type Scalars = [f32; 3];

/// Sums of some texels: `Σ m Bᵀ x` and `Σ m Bᵀ o`, `texels x L x K` each, and scalars, `texels x L`. Bytes:
/// `4 texels L (2 K + 3)`.
#[derive(Debug, Clone)]
pub(super) struct Sums {
    pub(super) products: Vec<f32>,
    pub(super) bases: Vec<f32>,
    pub(super) scalars: Vec<Scalars>,
}

impl Sums {
    pub(super) fn new(texels: usize, basis: &Basis) -> Self {
        let pairs = texels * basis.lights;
        let products = vec![0.0; pairs * basis.components];
        Self { bases: products.clone(), products, scalars: vec![[0.0; 3]; pairs] }
    }

    /// Adds some views. The rounding of the result depends on how views are grouped. `base` is the base of these
    /// texels.
    pub(super) fn add(
        &mut self,
        basis: &Basis,
        (base, rays): (&StoredBase, &Rays),
        masks: &Masks,
        views: &[ViewWords<'_>],
    ) {
        let (k, lights) = (basis.components, basis.lights);
        let columns = 3 * views.len();
        // For each light, the rows of all these views, concatenated.
        let rows_of = |light: usize| views.iter().flat_map(move |words| basis.pair(words.view, light));
        let rows: Vec<f32> = (0..lights).flat_map(rows_of).copied().collect();
        let sums = self.products.par_chunks_mut(STRIP * lights * k).zip(self.bases.par_chunks_mut(STRIP * lights * k));
        let strips = sums.zip(self.scalars.par_chunks_mut(STRIP * lights));
        strips.enumerate().for_each(|(strip, ((products, bases), scalars))| {
            let (first, count) = (strip * STRIP, scalars.len() / lights);
            let mut values = vec![0.0; count * columns];
            let mut of_base = values.clone();
            let weights: Vec<f32> =
                views.iter().flat_map(|v| (0..count).map(|texel| masks.weight(first + texel, v.view))).collect();
            for light in 0..lights {
                for (number, view) in views.iter().enumerate() {
                    let words = &view.words[light * view.stride + view.first + first..][..count];
                    let weights = &weights[number * count..][..count];
                    let (outgoing, incoming) = (rays.views[view.view], rays.lights[light]);
                    for (texel, (word, weight)) in words.iter().zip(weights).enumerate() {
                        let colour = to_opponent(rgb9e5::decode(*word)).map(|c| weight * c);
                        let plain = base.opponent(first + texel, outgoing, incoming);
                        let at = texel * columns + 3 * number;
                        values[at..][..3].copy_from_slice(&colour);
                        of_base[at..][..3].copy_from_slice(&plain.map(|c| weight * c));
                        let sums = &mut scalars[texel * lights + light];
                        sums[0] += colour[0];
                        sums[1] += colour[0] * plain[0] + colour[1] * plain[1] + colour[2] * plain[2];
                        sums[2] += weight * (plain[0] * plain[0] + plain[1] * plain[1] + plain[2] * plain[2]);
                    }
                }
                let rows = Rows::new(&rows[light * columns * k..][..columns * k], columns, k);
                for (target, values) in [(&mut *products, &values), (&mut *bases, &of_base)] {
                    add_product(&mut target[light * k..], lights * k, Rows::new(values, count, columns), rows);
                }
            }
        });
    }
}
