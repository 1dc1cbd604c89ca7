//! Settings of the sweep.

use brdfc_jobs::encode::PackRecipe;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::recipe::{Ranking, Recipe, Target};
use schemars::JsonSchema;
use serde::Serialize;

/// Tables, plain and factored, in KiB on a GPU.
const SIZES: [u64; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// `N` of grids on which all combinations are tried: 8 x 8 to 32 x 32.
const LEVELS: [u32; 3] = [3, 4, 5];
const RATIOS: [f64; 3] = [64.0, 16.0, 4.0];
/// Bits of components, in textures of 8 and of 16 bits.
const BITS: [u32; 2] = [8, 12];
/// `N` of 64 x 64 cells, a grid with only ratios and bits varied, since each encode takes seconds.
const FINEST: u32 = 6;

/// Settings of a wavelet pack.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct WaveletSetting {
    /// Cells per axis and hemisphere.
    pub grid: u32,
    /// Number of coefficients per stored slice.
    pub ratio: f64,
    /// Bits per component.
    pub bits: u32,
    /// True if ranking of slices is perceptually weighted, with the corresponding bias; false if it is by energy.
    pub visible: bool,
}

impl WaveletSetting {
    /// Settings of a recipe with a ratio.
    pub(super) fn of(recipe: &Recipe) -> Option<Self> {
        let Target::Ratio(ratio) = recipe.target else { return None };
        Some(Self { grid: 1 << recipe.levels, ratio, bits: recipe.bits, visible: recipe.ranking == Ranking::Visible })
    }
}

/// Writes grid, ratio, bits, and the other options.
impl std::fmt::Display for WaveletSetting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { grid, ratio, bits, .. } = self;
        write!(f, "{grid}², {ratio}:1, {bits} bits, {}", if self.visible { "visible" } else { "energy" })
    }
}

/// All settings, or a few that take seconds: tables by size, then wavelets from coarse to fine.
pub fn settings(small: bool) -> Vec<PackRecipe> {
    let table = |factored, kib: u64| {
        PackRecipe::Table(TableRecipe { size: Size::Bytes(kib << 10), factored, ..TableRecipe::default() }.into())
    };
    let sizes = if small { &SIZES[..2] } else { &SIZES };
    let mut all: Vec<PackRecipe> =
        [false, true].into_iter().flat_map(|factored| sizes.iter().map(move |kib| table(factored, *kib))).collect();
    let (levels, ratios) = if small { (&LEVELS[..1], &RATIOS[1..2]) } else { (&LEVELS[..], &RATIOS[..]) };
    for levels in levels {
        for ranking in [Ranking::Visible, Ranking::Energy] {
            all.extend(wavelets(*levels, ratios, ranking));
        }
    }
    if !small {
        all.extend(wavelets(FINEST, ratios, Ranking::Visible));
    }
    all
}

fn wavelets(levels: u32, ratios: &[f64], ranking: Ranking) -> impl Iterator<Item = PackRecipe> {
    let of_ranking = match ranking {
        Ranking::Visible => Recipe::visible(),
        Ranking::Energy => Recipe::default(),
    };
    let recipe = Recipe { levels, stored_levels: levels, energy_preserving: true, ..of_ranking };
    let each = ratios.iter().flat_map(|ratio| BITS.map(|bits| (Target::Ratio(*ratio), bits)));
    each.map(move |(target, bits)| PackRecipe::Wavelet(Recipe { target, bits, ..recipe.clone() }))
}

/// Approximate duration of a setting, in units of the cheapest, for estimates of the remaining time.
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
    fn settings_are_distinct() {
        let all = settings(false);
        assert_eq!(all.len(), 2 * 8 + 3 * 2 * 6 + 6);
        assert!((1..all.len()).all(|k| !all[..k].contains(&all[k])));
        assert!(settings(true).iter().all(|recipe| all.contains(recipe)));
        let PackRecipe::Wavelet(last) = &all[all.len() - 1] else { panic!("{all:?}") };
        assert_eq!(WaveletSetting::of(last).unwrap().to_string(), "64², 4:1, 12 bits, visible");
    }
}
