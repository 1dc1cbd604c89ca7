//! Solves weights and shadows of each texel independently, from its sums over the views, without its values.

use super::accumulate::{Scalars, Sums};
use super::basis::{Basis, Squares};
use super::lit::threshold;
use super::masks::Masks;
use super::matrix::{Rows, add_product, dot, quadratic_weights, solve};
use super::quantise::{shadow_byte, shadow_of_byte};
use super::rounded::Rounded;
use super::train::ridged_shadows;
use rayon::prelude::*;

/// Rounds of weights and shadows; they converge in about four.
const ROUNDS: usize = 4;
/// Number of masks whose products are computed at once.
const MASKS: usize = 16;

/// Solution for some texels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Texels {
    /// Texels x K, optimal for the rounded shadows.
    pub(super) weights: Vec<f32>,
    /// Texels x L, as stored; empty without shadows.
    pub(super) shadows: Vec<u8>,
}

/// A texel's index, weights and stored shadows.
type SolvedTexel = (usize, Vec<f32>, Vec<u8>);

/// Solves all texels of the sums. The prior is added to the diagonal for weights.
///
/// In addition to sums and results it takes `2 L K (K + 1)` bytes for each mask in progress, 16 per thread.
pub(super) fn solve_texels(sums: &Sums, masks: &Masks, rounded: &Rounded) -> Texels {
    let Rounded { basis, squares, prior, shadowed, .. } = rounded;
    let shadowed = *shadowed;
    let (k, lights) = (basis.components, basis.lights);
    let groups = masks.groups();
    let solved: Vec<Vec<SolvedTexel>> = groups
        .par_chunks(MASKS)
        .map(|groups| {
            let products = mask_products(groups, masks, basis, squares);
            let mut solver = Solver::new(k, lights, prior);
            let mut solved = Vec::new();
            for (group, products) in groups.iter().zip(products.chunks_exact(lights * squares.length)) {
                for texel in group {
                    let of = texel * lights * k..(texel + 1) * lights * k;
                    let sums = TexelSums {
                        products: &sums.products[of.clone()],
                        bases: &sums.bases[of],
                        scalars: &sums.scalars[texel * lights..][..lights],
                    };
                    let (weights, shadows) = solver.texel(sums, products, shadowed);
                    solved.push((*texel, weights, shadows));
                }
            }
            solved
        })
        .collect();
    let texels = sums.scalars.len() / lights;
    let mut result =
        Texels { weights: vec![0.0; texels * k], shadows: vec![0; if shadowed { texels * lights } else { 0 }] };
    for (texel, weights, shadows) in solved.into_iter().flatten() {
        result.weights[texel * k..][..k].copy_from_slice(&weights);
        if shadowed {
            result.shadows[texel * lights..][..lights].copy_from_slice(&shadows);
        }
    }
    result
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

/// The sums of one texel.
#[derive(Clone, Copy)]
struct TexelSums<'a> {
    products: &'a [f32],
    bases: &'a [f32],
    scalars: &'a [Scalars],
}

/// Scratch memory for solving texels one after the other.
struct Solver<'a> {
    components: usize,
    lights: usize,
    prior: &'a [f64],
    packed: Vec<f32>,
    right: Vec<f64>,
    room: Vec<f64>,
    pairs: Vec<f32>,
    fractions: Vec<[f32; 2]>,
}

impl<'a> Solver<'a> {
    fn new(components: usize, lights: usize, prior: &'a [f64]) -> Self {
        Self {
            components,
            lights,
            prior,
            packed: Vec::new(),
            right: Vec::new(),
            room: Vec::new(),
            pairs: Vec::new(),
            fractions: vec![[0.0; 2]; lights],
        }
    }

    /// Solves the weights and stored shadows of a texel.
    fn texel(&mut self, sums: TexelSums<'_>, products: &[f32], shadowed: bool) -> (Vec<f32>, Vec<u8>) {
        if !shadowed {
            return (self.weights(sums, products, &vec![1.0; self.lights]), Vec::new());
        }
        let mut shadows: Vec<f32> = sums.scalars.iter().map(|[lightness, ..]| *lightness).collect();
        threshold(&mut shadows);
        self.shadows(sums, products, &vec![0.0; self.components], &mut shadows);
        for _ in 0..ROUNDS {
            let weights = self.weights(sums, products, &shadows);
            self.shadows(sums, products, &weights, &mut shadows);
        }
        let bytes: Vec<u8> = shadows.iter().map(|shadow| shadow_byte(*shadow)).collect();
        let rounded: Vec<f32> = bytes.iter().map(|byte| shadow_of_byte(*byte)).collect();
        (self.weights(sums, products, &rounded), bytes)
    }

    fn weights(&mut self, sums: TexelSums<'_>, products: &[f32], shadows: &[f32]) -> Vec<f32> {
        let k = self.components;
        let length = products.len() / self.lights;
        self.packed.clear();
        self.packed.resize(length, 0.0);
        self.right.clear();
        self.right.resize(k, 0.0);
        let of_lights = sums.products.chunks_exact(k).zip(sums.bases.chunks_exact(k));
        for (((sums, bases), packed), shadow) in of_lights.zip(products.chunks_exact(length)).zip(shadows) {
            if *shadow > 0.0 {
                let square = shadow * shadow;
                self.packed.iter_mut().zip(packed).for_each(|(sum, number)| *sum += square * number);
                for ((sum, number), base) in self.right.iter_mut().zip(sums).zip(bases) {
                    *sum += f64::from(shadow * (number - shadow * base));
                }
            }
        }
        let (prior, mean) = (self.prior, super::train::trace(&self.packed, k) / k as f64);
        solve(&self.packed, |row| prior[row] + 1e-7 * mean + 1e-9, &mut self.right, &mut self.room);
        self.right.iter().map(|weight| *weight as f32).collect()
    }

    fn shadows(&mut self, sums: TexelSums<'_>, products: &[f32], weights: &[f32], shadows: &mut [f32]) {
        let k = self.components;
        let length = products.len() / self.lights;
        self.pairs.resize(length, 0.0);
        quadratic_weights(weights, &mut self.pairs);
        let of_lights = sums.products.chunks_exact(k).zip(sums.bases.chunks_exact(k)).zip(sums.scalars);
        for ((fraction, ((sums, bases), [_, mixed, plain])), packed) in
            self.fractions.iter_mut().zip(of_lights).zip(products.chunks_exact(length))
        {
            *fraction = [mixed + dot(sums, weights), plain + 2.0 * dot(bases, weights) + dot(packed, &self.pairs)];
        }
        ridged_shadows(shadows, &self.fractions);
    }
}
