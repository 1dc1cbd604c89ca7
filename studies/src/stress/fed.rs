//! Inputs of stages.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::{DirectionPair, Parameterisation, Vector, from_polar};
use brdfc_formats::wavelet::Header;
use brdfc_wavelet::recipe::Recipe;
use brdfc_wavelet::resample::resample;
use brdfc_wavelet::table::{Grid, Table};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, PI};

/// Decades of the dynamic range: 1e-12 to 1e6.
const DECADES: [f64; 2] = [-12.0, 6.0];

/// Pseudo-random numbers, the same on every run.
pub struct Numbers(ChaCha8Rng);

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// `0.0..1.0`.
    pub fn unit(&mut self) -> f64 {
        self.0.random()
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Number in the whole dynamic range, uniform over the decades.
    pub fn wide(&mut self) -> f64 {
        10f64.powf(self.between(DECADES[0], DECADES[1]))
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }
}

/// Contents of images and slices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filling {
    Zero,
    Constant,
    Even,
    /// 1e-12 to 1e6, either sign.
    Wide,
    Denormal,
    /// Nearly 0 except for one value.
    Spike,
}

impl Filling {
    pub const ALL: [Self; 6] = [Self::Zero, Self::Constant, Self::Even, Self::Wide, Self::Denormal, Self::Spike];

    /// Makes `count` numbers.
    pub fn numbers(self, count: usize, numbers: &mut Numbers) -> Vec<f32> {
        let constant = numbers.between(-8.0, 8.0) as f32;
        let spike = numbers.below(count);
        let mut number = |k: usize| match self {
            Self::Zero => 0.0,
            Self::Constant => constant,
            Self::Even => numbers.between(-8.0, 8.0) as f32,
            Self::Wide if numbers.unit() < 0.5 => -numbers.wide() as f32,
            Self::Wide => numbers.wide() as f32,
            Self::Denormal => (1e-40 * numbers.between(-1.0, 1.0)) as f32,
            Self::Spike if k == spike => 1e6,
            Self::Spike => 1e-12,
        };
        (0..count).map(&mut number).collect()
    }
}

/// `N` of grids: 4 to 64 cells per axis, or up to 16.
pub fn levels(small: bool) -> std::ops::RangeInclusive<u32> {
    2..=if small { 4 } else { 6 }
}

/// Directions including the extremes: the normal, the poles of the tangent-pole grid, rings just above the horizon.
pub fn directions(small: bool) -> Vec<Vector> {
    let mut polar = vec![0.0, 1e-12, 1e-8, 1e-4, 0.3, 1.2];
    polar.extend([1e-2, 1e-4, 1e-8, 1e-12].map(|above| FRAC_PI_2 - above));
    let steps = if small { 8 } else { 16 };
    let azimuths =
        (0..steps).flat_map(|k| [0.0, 1e-9, -1e-9].map(|off| 2.0 * PI * f64::from(k) / f64::from(steps) + off));
    azimuths.flat_map(|azimuth| polar.clone().into_iter().map(move |theta| from_polar(theta, azimuth))).collect()
}

/// Pairs of these above the horizon, including neighbouring and nearly opposite ones.
pub fn pairs(small: bool) -> Vec<DirectionPair> {
    let all = directions(small);
    let step = if small { 5 } else { 1 };
    let each = all.iter().flat_map(|i| all.iter().step_by(step).map(|o| DirectionPair::new(*i, *o)));
    each.filter(|pair| pair.is_above_horizon()).collect()
}

/// A source by a function.
pub struct Of<F> {
    pub value: F,
    pub symmetry: Symmetry,
}

impl<F: Fn(DirectionPair) -> f64 + Send + Sync> Source for Of<F> {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        [(self.value)(pair); 3]
    }

    fn symmetry(&self) -> Symmetry {
        self.symmetry
    }

    fn is_grey(&self) -> bool {
        true
    }
}

/// A source of one value.
pub fn constant(value: f64) -> Of<impl Fn(DirectionPair) -> f64 + Send + Sync> {
    Of { value: move |pair: DirectionPair| if pair.is_above_horizon() { value } else { 0.0 }, symmetry: Symmetry::FULL }
}

/// A grey table that repeats these numbers.
pub fn table(levels: u32, symmetry: Symmetry, numbers: &[f32]) -> Table {
    let grid = Grid { parameterisation: Parameterisation::TangentPole, levels };
    let (mut table, _) = resample(&Of { value: |_| 0.0, symmetry }, grid);
    let from = numbers.iter().cycle();
    table.values.iter_mut().zip(from).for_each(|(value, number)| *value = *number);
    table
}

/// The header of a grey wavelet pack.
pub fn header(recipe: &Recipe, mean: f32, bias: f32) -> Header {
    Header {
        parameterisation: Parameterisation::TangentPole,
        levels: recipe.levels,
        stored_levels: recipe.stored_levels,
        channels: 1,
        bits: recipe.bits,
        mean,
        bias,
        energy_preserving: recipe.energy_preserving,
    }
}
