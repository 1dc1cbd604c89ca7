//! Strength of the completion: rows of a noisy scan are replaced by fits to more neighbours, as many as the left-out
//! rows around them ask for.
//!
//! The residual of a row against the fit to the other rows is `(y - ŷ) / (1 - h)`, with `h` the share of the row's own
//! value in the fit `ŷ`. Its mean square over the nearest rows is the sum of noise and error of the fit at a number of
//! neighbours, so that its minimum over a list of numbers balances both: few neighbours in highlights, many where
//! reflectance changes slowly.
//!
//! The result estimates the median of repeated measurements: it is the truth for symmetric noise, in values or in their
//! logarithms. A scan is smoothed only if more neighbours reduce the residuals of a sample of its rows and the estimated
//! noise is 5 % or more, so that scans without noise keep their values.

use super::coordinates::Space;
use super::fit::Neighbourhood;
use brdfc_core::Tally;
use brdfc_formats::direction::DirectionPair;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;
use std::num::NonZero;

/// Factors of the default number of neighbours that are tried.
const FACTORS: [usize; 5] = [1, 3, 7, 18, 45];
/// Maximum number of rows that decide whether a scan is noisy.
const TRIED_ROWS: usize = 250;
/// Largest ratio of the mean left-out residuals at the second and the first number of neighbours of a noisy scan.
const NOISY: f64 = 0.97;
/// Maximum number of rows that decide about numbers of neighbours.
const DECIDING_ROWS: usize = 2000;
/// Maximum number of rows times neighbours.
const MAX_WORK: usize = 10_000_000;
/// Smallest mean left-out residual of a noisy scan: rounding is below it.
const ROUNDING: f64 = 1e-4;
/// Least estimated noise of a scan that is smoothed, as a fraction of the value. Below, rows count as they were measured:
/// 5 % noise alone is a mean ΔE of 0.65 for `synth:ggx?alpha=0.15`, less than the 1 that is just visible.
pub const LEAST_NOISE: f64 = 0.05;
/// Spread of repeated rows above which all numbers of neighbours are tried.
const NOISY_REPEATS: f64 = 0.02;
/// Share of the rows around a row whose residuals decide about its number of neighbours, and the limits of their number.
const AROUND: (f64, [usize; 2]) = (0.1, [60, 400]);
/// Limit of a residual in the mean square, in units of the median.
const CAP: f64 = 4.0;
/// Maximum share of a row in its own fit.
const MAX_SHARE: f64 = 0.95;
/// Standard deviation of normal noise over the median of its absolute values.
const NORMAL: f64 = 1.4826;

/// Positions in a search space of `S` axes, including images; items of the tree are indices of positions.
pub struct Tree<const S: usize> {
    /// The search tree.
    pub tree: ImmutableKdTree<f64, S>,
    /// The positions.
    pub positions: Vec<[f64; S]>,
    /// Index of the value of each position, image or not.
    pub value_of: Vec<u32>,
}

impl<const S: usize> Tree<S> {
    /// Builds the tree of positions, with the index of the value of each.
    pub fn new((positions, value_of): (Vec<[f64; S]>, Vec<u32>)) -> Self {
        let tree = ImmutableKdTree::new_from_slice(&positions).expect("positions are finite");
        Self { tree, positions, value_of }
    }
}

/// Requested strength.
#[derive(Debug, Clone, PartialEq)]
pub enum Strength {
    /// Chosen by left-out rows, if the estimated noise is at least this fraction of the value.
    Chosen { least_noise: f64 },
    /// The same number of neighbours everywhere.
    Neighbours(usize),
    /// Numbers of neighbours that were chosen before, one per row.
    OfRows(Vec<usize>),
}

/// Rows after the choice of the strength.
pub struct Smoothed {
    /// Number of neighbours of each row and its fitted log values; `None` if rows are used as measured.
    pub rows: Option<(Vec<usize>, Vec<[f64; 3]>)>,
    /// Estimated standard deviation of the noise, as a fraction of the value.
    pub noise: f64,
}

/// The rows of a scan: one of its search spaces, with log values.
pub struct Rows<'a, const S: usize> {
    /// Positions of the rows.
    pub tree: &'a Tree<S>,
    /// Direction pairs of the rows.
    pub pairs: &'a [DirectionPair],
    /// `ln(f + bias)` of the rows.
    pub values: &'a [[f64; 3]],
    /// Bias of the logarithm.
    pub bias: f64,
    /// Number of channels that differ, 1 or 3.
    pub channels: usize,
}

/// Fit at a row.
#[derive(Debug, Clone, Copy)]
pub struct RowFit {
    value: [f64; 3],
    /// Left-out residual of each channel.
    pub residual: [f64; 3],
    /// Sum of squared shares of the other rows in the left-out fit: variance of its value for rows of unit variance.
    variance: f64,
}

impl<const S: usize> Rows<'_, S> {
    /// The neighbours of a direction pair, and the indices of their rows.
    pub fn around<const D: usize, const M: usize, P: Space<D, S>>(
        &self,
        pair: DirectionPair,
        neighbours: usize,
    ) -> (Neighbourhood<D, M>, impl Iterator<Item = usize> + '_) {
        let point = P::place(pair);
        let mut query = [0.0; S];
        query[..D].copy_from_slice(&point);
        let count = NonZero::new(neighbours + 1).expect("at least one");
        let mut found = self.tree.tree.query(&query).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        // The support reaches just past the first unused neighbour, so that weights of neighbours vanish at its
        // border.
        let radius = (1.001 * found.last().map_or(0.0, |f| f.distance.sqrt())).max(1e-6);
        found.truncate(neighbours);
        let mut neighbourhood = Neighbourhood::with_capacity(found.len());
        for item in &found {
            let position = self.tree.positions[item.item as usize];
            let offset = std::array::from_fn(|axis| (position[axis] - point[axis]) / radius);
            neighbourhood.push(offset, item.distance.sqrt() / radius, self.values[self.row_of(item.item)]);
        }
        (neighbourhood, found.into_iter().map(|item| self.row_of(item.item)))
    }

    fn row_of(&self, item: u32) -> usize {
        self.tree.value_of[item as usize] as usize
    }

    /// Fit to the neighbours of a row, which are itself and others.
    pub fn fit_row<const D: usize, const M: usize, P: Space<D, S>>(&self, row: usize, neighbours: usize) -> RowFit {
        let (neighbourhood, rows) = self.around::<D, M, P>(self.pairs[row], neighbours);
        let fitted = neighbourhood.fit_with_shares(self.channels, true, &mut Tally::default());
        let (mut own, mut squares) = (0.0, 0.0);
        for (share, of) in fitted.shares.iter().zip(rows) {
            if of == row { own += share } else { squares += share * share }
        }
        let rest = 1.0 - own.clamp(0.0, MAX_SHARE);
        let mut residual = [0.0; 3];
        for channel in 0..self.channels {
            residual[channel] = (self.values[row][channel] - fitted.value[channel]) / rest;
        }
        RowFit { value: fitted.value, residual, variance: squares / (rest * rest) }
    }

    /// Fits at pairs of a row and its number of neighbours.
    fn fit_rows<const D: usize, const M: usize, P: Space<D, S>>(
        &self,
        rows: impl IndexedParallelIterator<Item = (usize, usize)>,
    ) -> Vec<RowFit> {
        rows.map(|(row, neighbours)| self.fit_row::<D, M, P>(row, neighbours)).collect()
    }

    /// Fits at the rows by the requested strength; `spread` is the spread of repeated rows.
    pub fn smoothed<const D: usize, const M: usize, P: Space<D, S>>(
        &self,
        default: usize,
        strength: &Strength,
        spread: f64,
    ) -> Smoothed {
        let rows = self.pairs.len();
        let sizes = match strength {
            Strength::Chosen { least_noise } => {
                let candidates = FACTORS.map(|factor| factor * default);
                let allowed = |size: &&usize| **size < rows && **size * rows <= MAX_WORK;
                let count = candidates.iter().filter(allowed).count().max(1);
                match self.choose::<D, M, P>(&candidates[..count], *least_noise, spread) {
                    Ok(sizes) => sizes,
                    Err(noise) => return Smoothed { rows: None, noise },
                }
            }
            Strength::Neighbours(size) if *size <= default => {
                return Smoothed { rows: None, noise: self.noise(&self.tried::<D, M, P>((*size).max(1))) };
            }
            Strength::Neighbours(size) => vec![*size; rows],
            Strength::OfRows(sizes) => sizes.clone(),
        };
        let fits = self.fit_rows::<D, M, P>((0..rows).into_par_iter().map(|row| (row, sizes[row])));
        // Means of logarithms are below medians for symmetric noise, and equal to them for log-normal noise.
        let offset: [f64; 3] =
            std::array::from_fn(|channel| median(fits.iter().map(|fit| fit.residual[channel]).collect()));
        let values = fits.iter().map(|fit| std::array::from_fn(|c| fit.value[c] + offset[c])).collect();
        Smoothed { noise: self.noise(&fits), rows: Some((sizes, values)) }
    }

    /// Number of neighbours of each row with the smallest left-out residuals around it; `Err` with an estimate of the noise
    /// if more than the first number of neighbours does not reduce the residuals of a sample of the rows.
    fn choose<const D: usize, const M: usize, P: Space<D, S>>(
        &self,
        candidates: &[usize],
        least_noise: f64,
        spread: f64,
    ) -> Result<Vec<usize>, f64> {
        let first = self.tried::<D, M, P>(candidates[0]);
        let mean = |fits: &[RowFit]| fits.iter().map(|fit| self.square(fit).sqrt()).sum::<f64>() / fits.len() as f64;
        let noisy = |second: usize| {
            let second = self.tried::<D, M, P>(second);
            self.noise(&second) >= least_noise && (spread > NOISY_REPEATS || mean(&second) < NOISY * mean(&first))
        };
        if mean(&first) < ROUNDING || !candidates.get(1).is_some_and(|second| noisy(*second)) {
            return Err(self.noise(&first));
        }
        let rows = self.pairs.len();
        let step = rows.div_ceil(DECIDING_ROWS);
        let squares: Vec<Vec<f64>> =
            candidates.iter().map(|size| self.squares(&self.every::<D, M, P>(step, *size))).collect();
        let (share, [least, most]) = AROUND;
        let around = step * ((share * rows as f64) as usize).clamp(least, most);
        let around = NonZero::new(around).expect("positive");
        let best = |row: usize| {
            let mut query = [0.0; S];
            query[..D].copy_from_slice(&P::place(self.pairs[row]));
            let found = self.tree.tree.query(&query).nearest_n::<SquaredEuclidean<f64>>(around).execute();
            let deciding = || found.iter().map(|item| self.row_of(item.item)).filter(|row| row.is_multiple_of(step));
            let error = |squares: &Vec<f64>| deciding().map(|row| squares[row / step]).sum::<f64>();
            let errors: Vec<f64> = squares.iter().map(error).collect();
            let best = (0..candidates.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]));
            candidates[best.unwrap_or(0)]
        };
        Ok((0..rows).into_par_iter().map(best).collect())
    }

    /// Fits at a sample of the rows.
    fn tried<const D: usize, const M: usize, P: Space<D, S>>(&self, neighbours: usize) -> Vec<RowFit> {
        self.every::<D, M, P>(self.pairs.len().div_ceil(TRIED_ROWS), neighbours)
    }

    /// Fits at every row whose index is a multiple of `step`.
    fn every<const D: usize, const M: usize, P: Space<D, S>>(&self, step: usize, neighbours: usize) -> Vec<RowFit> {
        let rows = (0..self.pairs.len()).into_par_iter().step_by(step);
        self.fit_rows::<D, M, P>(rows.map(|row| (row, neighbours)))
    }

    /// Mean squares of the left-out residuals of rows, up to a limit.
    fn squares(&self, fits: &[RowFit]) -> Vec<f64> {
        let squares: Vec<f64> = fits.iter().map(|fit| self.square(fit)).collect();
        let limit = CAP * CAP * median(squares.clone());
        squares.into_iter().map(|square| square.min(limit)).collect()
    }

    /// Standard deviation of the noise, as a fraction of the value, from left-out residuals: their variance is that of the
    /// noise and of the fit. Values in the dark noise do not count.
    fn noise(&self, fits: &[RowFit]) -> f64 {
        let of_fit = |fit: &RowFit| {
            let bias = (0..self.channels).map(|channel| self.bias * (-fit.value[channel]).exp()).fold(0.0, f64::max);
            (bias < 0.5).then(|| (self.square(fit) / (1.0 + fit.variance)).sqrt() / (1.0 - bias))
        };
        let found: Vec<f64> = fits.iter().filter_map(of_fit).collect();
        if found.is_empty() { 0.0 } else { NORMAL * median(found) }
    }

    /// Mean square of the left-out residuals of a row.
    fn square(&self, fit: &RowFit) -> f64 {
        fit.residual[..self.channels].iter().map(|r| r * r).sum::<f64>() / self.channels as f64
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
