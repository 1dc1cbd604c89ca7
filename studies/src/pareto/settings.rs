//! What is swept.

use brdfc_jobs::encode::PackRecipe;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::recipe::{Ranking, Recipe, Target};
use schemars::JsonSchema;
use serde::Serialize;

/// Tables, plain and factored, in KiB on a GPU.
const SIZES: [u64; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// `N` of grids on which everything is tried with everything: 8 x 8 to 32 x 32.
const LEVELS: [u32; 3] = [3, 4, 5];
const RATIOS: [f64; 3] = [64.0, 16.0, 4.0];
/// Of components: in textures of 8 and of 16 bits.
const BITS: [u32; 2] = [8, 12];
/// 64 x 64: on this grid ratios and bits alone, as each takes seconds.
const FINEST: u32 = 6;

/// A wavelet pack that is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct WaveletSetting {
    /// Cells per axis and hemisphere.
    pub grid: u32,
    /// One slice in so many is kept.
    pub ratio: f64,
    /// Bits per component.
    pub bits: u32,
    /// Whether slices are ranked by what is seen, with the bias that goes with it, or by energy.
    pub visible: bool,
    /// Whether levels of detail and slices that are left out keep the light.
    pub lifted: bool,
    /// Whether the table is smoothed first.
    pub smoothed: bool,
}

impl WaveletSetting {
    /// Of a recipe with a ratio.
    pub(super) fn of(recipe: &Recipe) -> Option<Self> {
        let Target::Ratio(ratio) = recipe.target else { return None };
        Some(Self {
            grid: 1 << recipe.levels,
            ratio,
            bits: recipe.bits,
            visible: recipe.ranking == Ranking::Visible,
            lifted: recipe.lift,
            smoothed: recipe.smooth,
        })
    }
}

/// Grid, ratio, bits, and what else was asked for.
impl std::fmt::Display for WaveletSetting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { grid, ratio, bits, .. } = self;
        write!(f, "{grid}², {ratio}:1, {bits} bits, {}", if self.visible { "visible" } else { "energy" })?;
        for (asked, name) in [(self.lifted, ", lifted"), (self.smoothed, ", smoothed")] {
            f.write_str(if asked { name } else { "" })?;
        }
        Ok(())
    }
}

/// All settings, or few that take seconds: tables by size, then wavelets from coarse to fine.
pub fn settings(small: bool) -> Vec<PackRecipe> {
    let table = |factored, kib: u64| {
        PackRecipe::Table(TableRecipe { size: Size::Bytes(kib << 10), factored, ..TableRecipe::default() }.into())
    };
    let sizes = if small { &SIZES[..2] } else { &SIZES };
    let mut all: Vec<PackRecipe> =
        [false, true].into_iter().flat_map(|factored| sizes.iter().map(move |kib| table(factored, *kib))).collect();
    let (levels, ratios) = if small { (&LEVELS[..1], &RATIOS[1..2]) } else { (&LEVELS[..], &RATIOS[..]) };
    let others = [(false, false), (true, true), (true, false), (false, true)];
    for levels in levels {
        for ranking in [Ranking::Visible, Ranking::Energy] {
            for (lift, smooth) in others.into_iter().take(if small { 2 } else { 4 }) {
                all.extend(wavelets(*levels, ratios, ranking, lift, smooth));
            }
        }
    }
    if !small {
        all.extend(wavelets(FINEST, ratios, Ranking::Visible, false, false));
    }
    all
}

fn wavelets(
    levels: u32,
    ratios: &[f64],
    ranking: Ranking,
    lift: bool,
    smooth: bool,
) -> impl Iterator<Item = PackRecipe> {
    let of_ranking = match ranking {
        Ranking::Visible => Recipe::visible(),
        Ranking::Energy => Recipe::default(),
    };
    let recipe = Recipe { levels, stored_levels: levels, lift, smooth, ..of_ranking };
    let each = ratios.iter().flat_map(|ratio| BITS.map(|bits| (Target::Ratio(*ratio), bits)));
    each.map(move |(target, bits)| PackRecipe::Wavelet(Recipe { target, bits, ..recipe.clone() }))
}

/// About how long a setting takes, in parts of the cheapest: for the time that is left.
pub(super) fn cost(recipe: &PackRecipe) -> f64 {
    match recipe {
        PackRecipe::Wavelet(recipe) => 1.0 + f64::from(1u32 << (4 * recipe.levels)) / 2e5,
        _ => 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_is_there_once() {
        let all = settings(false);
        assert_eq!(all.len(), 2 * 8 + 3 * 2 * 4 * 6 + 6);
        assert!((1..all.len()).all(|k| !all[..k].contains(&all[k])));
        assert!(settings(true).iter().all(|recipe| all.contains(recipe)));
        let PackRecipe::Wavelet(last) = &all[all.len() - 1] else { panic!("{all:?}") };
        assert_eq!(WaveletSetting::of(last).unwrap().to_string(), "64², 4:1, 12 bits, visible");
    }
}
