//! Samples of texels with all their values: for the fit and for error measurements.

use super::base::{Rays, StoredBase};
use super::masks::Masks;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::FlatView;
use brdfc_formats::flat_btf::factored::to_opponent;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

/// Seed of the sampling.
const SEED: u64 = 0xfac7;

/// Draws disjoint sets of texels for the fit and for measurements, spread over the surface in random order: `held_out`
/// texels for measurements, or a fifth of all if that is less, and `fitted` for the fit, or the rest. With fewer than
/// 25 texels, both sets contain all.
pub(super) fn choose(texels: usize, fitted: usize, held_out: usize) -> [Vec<usize>; 2] {
    if texels < 25 {
        return [(0..texels).collect(), (0..texels).collect()];
    }
    let held_out = held_out.min(texels / 5);
    let fitted = fitted.min(texels - held_out);
    // The first of a random order (Fisher and Yates).
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut order: Vec<usize> = (0..texels).collect();
    for k in 0..held_out + fitted {
        order.swap(k, random.random_range(k..texels));
    }
    [order[held_out..held_out + fitted].to_vec(), order[..held_out].to_vec()]
}

/// Texels of the flat BTF with the words of all views and lights.
#[derive(Debug, Clone)]
pub(super) struct Sample {
    /// Texel indices, `row T + column`.
    pub(super) texels: Vec<usize>,
    pub(super) masks: Masks,
    pub(super) lights: usize,
    /// For each view, `L x texels` words, light by light.
    pub(super) views: Vec<Vec<u32>>,
}

impl Sample {
    pub(super) fn new(texels: Vec<usize>, masks: Masks) -> Self {
        Self { texels, masks, lights: 0, views: Vec::new() }
    }

    /// Adds the next view.
    pub(super) fn add_view(&mut self, view: &FlatView) {
        self.lights = view.header().lights.len();
        let light = |light: usize| {
            let words = view.light(light as u32);
            self.texels.iter().map(|texel| words[*texel])
        };
        self.views.push((0..self.lights).flat_map(light).collect());
    }

    /// The word of a texel in a view under a light.
    pub(super) fn word(&self, texel: usize, view: usize, light: usize) -> u32 {
        self.views[view][light * self.texels.len() + texel]
    }

    /// The first `count` texels, as numbers for a fit. `base` is the base of the texels of this sample, `shaded` the share of
    /// their diffuse albedo in each value: `texels x L`.
    pub(super) fn values(&self, count: usize, base: &StoredBase, shaded: &[f32], rays: &Rays) -> Values {
        let views = self.views.len();
        let [mut numbers, mut bases] = [(); 2].map(|()| vec![0.0; views * count * self.lights * 3]);
        let length = self.lights * 3;
        numbers.par_chunks_mut(length).zip(bases.par_chunks_mut(length)).enumerate().for_each(|(at, (row, bases))| {
            let (view, texel) = (at / count, at % count);
            for (light, (colour, of_base)) in row.chunks_exact_mut(3).zip(bases.chunks_exact_mut(3)).enumerate() {
                let value = rgb9e5::decode(self.word(texel, view, light));
                let shaded = shaded[texel * self.lights + light];
                colour.copy_from_slice(&to_opponent(base.without(texel, shaded, value)));
                of_base.copy_from_slice(&base.opponent(texel, rays.views[view], rays.lights[light]));
            }
        });
        let weights = (0..views).flat_map(|view| (0..count).map(move |texel| self.masks.weight(texel, view)));
        Values { views, lights: self.lights, texels: count, weights: weights.collect(), numbers, bases }
    }
}

/// Opponent colours of texels in all views under all lights, and opponent colours of their bases. Bytes: `24 V L` per
/// texel.
#[derive(Debug, Clone)]
pub(super) struct Values {
    pub(super) views: usize,
    pub(super) lights: usize,
    pub(super) texels: usize,
    /// Weights of the views of each texel: `V x texels`.
    pub(super) weights: Vec<f32>,
    /// `V x texels x L x 3`.
    pub(super) numbers: Vec<f32>,
    /// Colours of the base under unshadowed lights, in the same layout.
    pub(super) bases: Vec<f32>,
}

impl Values {
    /// Colours of a texel in a view: three for each light.
    pub(super) fn row(&self, view: usize, texel: usize) -> &[f32] {
        let length = 3 * self.lights;
        &self.numbers[(view * self.texels + texel) * length..][..length]
    }

    /// Colours of its base, in the same layout.
    pub(super) fn base_row(&self, view: usize, texel: usize) -> &[f32] {
        let length = 3 * self.lights;
        &self.bases[(view * self.texels + texel) * length..][..length]
    }

    /// Weight of a view of a texel.
    pub(super) fn weight(&self, view: usize, texel: usize) -> f32 {
        self.weights[view * self.texels + texel]
    }

    /// Computes `m s (x - s o)` for some texels in a view, with weight m, value x and base o, where s is the texel's
    /// row of L in `fit_roots`: `texels x 3 L`.
    pub(super) fn scaled(&self, view: usize, texels: Range<usize>, fit_roots: &[f32], rows: &mut Vec<f32>) {
        rows.clear();
        for texel in texels {
            let weight = self.weight(view, texel);
            let fit_roots = &fit_roots[texel * self.lights..][..self.lights];
            let (colours, bases) =
                (self.row(view, texel).as_chunks::<3>().0, self.base_row(view, texel).as_chunks::<3>().0);
            rows.extend(colours.iter().zip(bases).zip(fit_roots).flat_map(|((colour, base), root)| {
                let factor = weight * root;
                [0, 1, 2].map(|k: usize| factor * (colour[k] - root * base[k]))
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_are_chosen_once() {
        let [fitted, held_out] = choose(1000, 300, 100);
        assert_eq!((fitted.len(), held_out.len()), (300, 100));
        let mut all = [fitted.clone(), held_out].concat();
        all.sort_unstable();
        all.dedup();
        assert!(all.len() == 400 && all[399] < 1000);
        // The sets are spread over all texels.
        assert!((0..4).all(|k| (40..160).contains(&fitted.iter().filter(|at| *at / 250 == k).count())));
        let [fitted, held_out] = choose(30, 300, 100);
        assert_eq!((fitted.len(), held_out.len()), (24, 6));
        assert_eq!(choose(2, 9, 9), [vec![0, 1], vec![0, 1]]);
    }
}
