//! Solves the weights of each texel independently, from its sums over views and lights, without its values.

use super::accumulate::Sums;
use super::basis::{Basis, Squares};
use super::masks::Masks;
use super::matrix::{Rows, add_product, solve};
use super::rounded::Rounded;
use rayon::prelude::*;

/// Number of masks whose products are computed at once.
const MASKS: usize = 16;

/// Solves the weights of all texels of the sums, `texels x K`, for the same factors `fit_roots`, `texels x L`. The prior is
/// added to the diagonal.
///
/// In addition to sums and results it takes `2 L K (K + 1)` bytes for each mask in progress, 16 per thread.
pub(super) fn solve_texels(sums: &Sums, masks: &Masks, fit_roots: &[f32], rounded: &Rounded) -> Vec<f32> {
    let Rounded { basis, squares, prior, .. } = rounded;
    let (k, lights) = (basis.components, basis.lights);
    let of_masks = |groups: &[Vec<usize>]| -> Vec<(usize, Vec<f32>)> {
        let products = mask_products(groups, masks, basis, squares);
        let (mut packed, mut room) = (Vec::new(), Vec::new());
        let mut solved = Vec::new();
        for (group, products) in groups.iter().zip(products.chunks_exact(lights * squares.length)) {
            for texel in group {
                packed.clear();
                packed.resize(squares.length, 0.0f32);
                let fit_roots = &fit_roots[texel * lights..][..lights];
                let reached = products.chunks_exact(squares.length).zip(fit_roots).filter(|(_, root)| **root > 0.0);
                for (product, root) in reached {
                    let square = root * root;
                    packed.iter_mut().zip(product).for_each(|(sum, number)| *sum += square * number);
                }
                let mean = super::train::trace(&packed, k) / k as f64;
                let mut right: Vec<f64> = sums.of(*texel).iter().map(|sum| f64::from(*sum)).collect();
                solve(&packed, |row| prior[row] + 1e-7 * mean + 1e-9, &mut right, &mut room);
                solved.push((*texel, right.iter().map(|weight| *weight as f32).collect()));
            }
        }
        solved
    };
    let solved: Vec<_> = masks.groups().par_chunks(MASKS).map(of_masks).collect();
    let mut weights = vec![0.0; fit_roots.len() / lights * k];
    for (texel, row) in solved.into_iter().flatten() {
        weights[texel * k..][..k].copy_from_slice(&row);
    }
    weights
}

/// `Σ_v m(v) Bᵀ B` of each light, packed, for each group of texels with one mask: `groups x L x length`.
fn mask_products(groups: &[Vec<usize>], masks: &Masks, basis: &Basis, squares: &Squares) -> Vec<f32> {
    let (views, lights) = (basis.views, basis.lights);
    let weights: Vec<f32> =
        groups.iter().flat_map(|group| (0..views).map(|view| masks.weight(group[0], view))).collect();
    let stride = lights * squares.length;
    let mut products = vec![0.0; groups.len() * stride];
    for light in 0..lights {
        let weights = Rows::new(&weights, groups.len(), views);
        add_product(&mut products[light * squares.length..], stride, weights, squares.light(light, views));
    }
    products
}
