//! The decoder of wavelet packs compared with the same in f64: inverse transform of whole images, exact angles.

use super::fed::{Numbers, levels, pairs};
use super::pack::pack;
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_formats::direction::{DirectionPair, Vector, to_tangent_pole};
use brdfc_formats::wavelet::haar::inverse;
use brdfc_formats::wavelet::{WaveletDecoder, WaveletPack};
use std::f64::consts::PI;

/// Maximum error of an angle of the decoder: see the row of angles.
const ANGLE: f64 = 3e-7;

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let [mut plain, mut preserving] = [Worst::default(); 2];
    let every = pairs(small);
    for levels in levels(small) {
        for is_preserving in [false, true] {
            let cells = 1usize << (2 * levels);
            let pack = pack(levels, (cells / 2).min(512), 8, is_preserving, u64::from(levels));
            let (decoder, exact) = (WaveletDecoder::new(&pack), ExactDecoder::new(&pack));
            let worst = if is_preserving { &mut preserving } else { &mut plain };
            let n = f64::from(1u32 << levels);
            let mut numbers = Numbers::new(10);
            // A look-up in f64 reconstructs sixteen images.
            for _ in 0..if small { 40 } else { 200 } {
                let pair = every[numbers.below(every.len())];
                let level = [0.0, f64::from(levels), numbers.between(0.0, f64::from(levels))][numbers.below(3)] as f32;
                let (found, expected) = ((stages.decode)(&decoder, pair, level)[0], exact.log_value(pair, level));
                let moved = 4.0 * ANGLE * n / PI * 2.0;
                let allowed = exact.largest * (moved + f64::from(levels) * 8.0 * U + 16.0 * U);
                worst.add((f64::from(found) - expected) / allowed);
            }
        }
    }
    let fed = "all grids, poles and grazing rings, all levels of detail and between";
    vec![
        plain.row(
            ["decoding wavelets, f32", fed],
            Measure::OfBound,
            1.0,
            "errors of 3e-7 in 4 angles change it by N/π as much between values ±M; 8 roundings per level of M, the largest sum of coefficients",
        ),
        preserving.row(["decoding energy-preserving wavelets, f32", fed], Measure::OfBound, 1.0, "the same"),
    ]
}

struct ExactDecoder<'a> {
    pack: &'a WaveletPack,
    /// Maximum sum of coefficients.
    largest: f64,
}

impl<'a> ExactDecoder<'a> {
    fn new(pack: &'a WaveletPack) -> Self {
        let header = &pack.header;
        let most = |k: usize| {
            let scale = pack.scales[usize::from(pack.index[k])];
            f64::from((scale.offset + scale.scale).abs().max(scale.offset.abs()))
        };
        // The path to a cell has one detail of each kind per level.
        let of_tree = |first: usize, levels: u32| {
            let n = f64::from(1u32 << levels);
            let of_level = |j: u32| {
                let (start, scale) = (1usize << (2 * j), f64::from(1u32 << j) / n);
                let most_of = |from: usize, to: usize| (first + from..first + to).map(most).fold(0.0, f64::max);
                scale * (most_of(start, 2 * start) + std::f64::consts::SQRT_2 * most_of(2 * start, 4 * start))
            };
            most(first) / n + (0..levels).map(of_level).sum::<f64>()
        };
        let trees = (0..header.trees()).map(|level| of_tree(header.first_of_tree(level), level));
        let largest = trees.fold(of_tree(0, header.levels), f64::max);
        Self { pack, largest }
    }

    /// All inner cells of an outer one at a level of detail.
    fn image(&self, outer: usize, level: f32) -> Vec<f64> {
        let header = &self.pack.header;
        let level = f64::from(level).clamp(0.0, f64::from(header.levels));
        let whole = level as u32;
        if whole >= header.trees() {
            return self.image_of_tree(0, header.levels, outer, level);
        }
        let of_level = |own: u32| match own < header.trees() {
            true => self.image_of_tree(header.first_of_tree(own), own, outer, f64::from(own)),
            false => self.image_of_tree(0, header.levels, outer, f64::from(own)),
        };
        let (coarser, finer) = (of_level(whole), of_level((whole + 1).min(header.levels)));
        coarser.iter().zip(&finer).map(|(a, b)| a + level.fract() * (b - a)).collect()
    }

    /// Image of a tree. Finer details are left out, those of a fractional level are weighted.
    fn image_of_tree(&self, first: usize, levels: u32, outer: usize, level: f64) -> Vec<f64> {
        let header = &self.pack.header;
        let (n, side, cells) = (header.grid(), 1usize << levels, 1usize << (2 * levels));
        let value = |k: usize| {
            let slice = usize::from(self.pack.index[first + k]);
            let scale = self.pack.scales[slice];
            let texel = f64::from(self.pack.texels[slice * header.cells() + outer]) / 255.0;
            let part = if k == 0 { 1.0 } else { (level - f64::from(k.ilog2() / 2)).clamp(0.0, 1.0) };
            part * (f64::from(scale.offset) + f64::from(scale.scale) * texel)
        };
        let coefficients: Vec<f64> = (0..cells).map(value).collect();
        let mut samples = vec![0.0; cells];
        inverse(&coefficients, side, &mut samples, &mut Vec::new());
        let block = n / side;
        (0..n * n).map(|cell| samples[cell / n / block * side + cell % n / block]).collect()
    }

    /// Four cells around a direction and their weights.
    fn taps(&self, direction: Vector) -> [(usize, f64); 4] {
        let n = self.pack.header.grid();
        let [column, row] = to_tangent_pole(direction).map(|angle| {
            let at = (angle / PI * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
            let lower = (at as usize).min(n - 2);
            [(lower, 1.0 - (at - lower as f64)), (lower + 1, at - lower as f64)]
        });
        std::array::from_fn(|k| {
            let ((row, a), (column, b)) = (row[k / 2], column[k % 2]);
            (row * n + column, a * b)
        })
    }

    fn log_value(&self, pair: DirectionPair, level: f32) -> f64 {
        let inner = self.taps(pair.outgoing);
        let of_outer = |outer: usize| {
            let image = self.image(outer, level);
            inner.iter().map(|(cell, weight)| weight * image[*cell]).sum::<f64>()
        };
        self.taps(pair.incoming).into_iter().map(|(outer, weight)| weight * of_outer(outer)).sum()
    }
}
