//! CPU decoder of wavelet packs, the reference for shaders.
//!
//! All steps before the last exponential are f32 operations in a fixed order without fused operations. A shader that
//! follows them with manual filtering produces the same bits.

use super::haar::{self, detail_indices};
use crate::crop::Window;
use crate::direction::{DirectionPair, Parameterisation, polynomial_atan2};
use crate::wavelet::{Header, WaveletPack};
use std::f32::consts::{PI, SQRT_2};

/// Interpolation between grid cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Nearest cell on both hemispheres.
    Nearest,
    /// Bilinear over four outer cells in each slice, as a sampler does, at the nearest inner cell: one reconstruction.
    Slices,
    /// Bilinear over four outer cells in each slice, as a sampler does, and over the reconstructions at the four
    /// nearest inner cells (section 5.4.2).
    Bilinear,
}

/// Decoder of one pack, with decompressed coefficients.
#[derive(Debug, Clone)]
pub struct WaveletDecoder {
    header: Header,
    /// Stored outer cells.
    window: Window,
    index: Vec<u16>,
    /// Coefficients `[slice][cell][channel]`, slice 0 all zero.
    coefficients: Vec<f32>,
}

/// Two neighbouring cells along one axis and the weight of the second.
#[derive(Debug, Clone, Copy)]
struct Tap {
    cells: [usize; 2],
    weight: f32,
}

/// Outer cells of a look-up and their weights: up to four cells of a slice.
type Footprint = [(usize, f32); 4];

/// Scratch memory of [`WaveletDecoder::decode_row`].
#[derive(Debug, Clone, Default)]
pub struct RowScratch {
    coefficients: Vec<f32>,
    split: Vec<f32>,
}

impl WaveletDecoder {
    /// Decompresses texels to coefficients: `offset + scale * texel`.
    pub fn new(pack: &WaveletPack) -> Self {
        let header = pack.header;
        let (window, channels) = (pack.window(), header.channels as usize);
        let cells = cells_of(window);
        let format = header.texel_format();
        let stride = format.components();
        let mut coefficients = Vec::with_capacity(pack.slices() * cells * channels);
        for (slice, scale) in pack.scales.iter().enumerate() {
            for cell in 0..cells {
                let texel = (slice * cells + cell) * stride;
                for channel in 0..channels {
                    let unorm = component(&pack.texels, texel + channel, format.component_bytes());
                    coefficients.push(scale.offset + scale.scale * unorm);
                }
            }
        }
        Self { header, window, index: pack.index.clone(), coefficients }
    }

    /// Sizes and constants of the pack.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// `f_r` of a direction pair: linear RGB (grey packs repeat their channel), 1/sr, not negative.
    ///
    /// `level` is the level of detail, clamped to `0.0..=N`. Fractions blend two levels (section 5.4.1); the coarser
    /// value is an intermediate result of the finer one. Returns zero if a direction is at or below the horizon.
    pub fn eval(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        self.log_value(pair, level, filter).map(|v| self.from_log(v))
    }

    /// Log-encoded value `ln(f / μ + ε)` that [`Self::eval`] decodes, for directions above the horizon. A shader with
    /// manual filtering and correctly rounded arithmetic returns the same bits.
    pub fn log_value(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3] {
        let (outer, inner) = axes(self.header.parameterisation, pair);
        let [outer_column, outer_row] = self.taps(outer, filter != Filter::Nearest);
        let [inner_column, inner_row] = self.taps(inner, filter == Filter::Bilinear);
        let footprint = footprint(outer_column, outer_row, self.window);
        let outer = &footprint[..if filter == Filter::Nearest { 1 } else { 4 }];
        let Filter::Bilinear = filter else {
            return self.reconstruct(outer, inner_column.cells[0], inner_row.cells[0], level);
        };
        let mut log_value = [0.0f32; 3];
        // Same order as `footprint`: rows outside, columns inside.
        for (row, row_weight) in [(0, 1.0 - inner_row.weight), (1, inner_row.weight)] {
            for (column, column_weight) in [(0, 1.0 - inner_column.weight), (1, inner_column.weight)] {
                let weight = row_weight * column_weight;
                let value = self.reconstruct(outer, inner_column.cells[column], inner_row.cells[row], level);
                for channel in 0..3 {
                    log_value[channel] += weight * value[channel];
                }
            }
        }
        log_value
    }

    /// Inverse of the log encoding (section 5.1), `f = μ (exp(v) - ε)`, clamped to 0 and to the largest finite number.
    pub fn from_log(&self, value: f32) -> f32 {
        let f = self.header.mean * (value.exp() - self.header.bias);
        // NaN, the difference of two infinities, is not greater than 0, so it becomes 0.
        if f > 0.0 { f.min(f32::MAX) } else { 0.0 }
    }

    /// Log-encoded value of one inner cell at a level of detail. Levels with trees of their own are blended between their
    /// values.
    fn reconstruct(&self, footprint: &[(usize, f32)], column: usize, row: usize, level: f32) -> [f32; 3] {
        let (levels, trees) = (self.header.levels, self.header.trees());
        let level = level.clamp(0.0, levels as f32);
        let whole = level.floor() as u32;
        let fraction = level - level.floor();
        if whole >= trees {
            return self.path(0, levels, footprint, [column, row], level);
        }
        let of_level = |level: u32| {
            let (first, depth) = if level < trees { (self.header.first_of_tree(level), level) } else { (0, levels) };
            let cell = [column, row].map(|at| at >> (levels - depth));
            self.path(first, depth, footprint, cell, level as f32)
        };
        let coarser = of_level(whole);
        if fraction == 0.0 {
            return coarser;
        }
        let finer = of_level(whole + 1);
        std::array::from_fn(|channel| coarser[channel] + fraction * (finer[channel] - coarser[channel]))
    }

    /// Synthesis (equation 2) along one path of a tree: log-encoded value of one of its `2^levels x 2^levels` cells. The
    /// coefficients of the tree start at `first`.
    ///
    /// Each level adds the latitude detail, then the longitude detail, with the weights that repeated division by √2
    /// gives: `2^-(N-j)` and `√2 2^-(N-j)`. The sign depends on the half that contains the cell.
    fn path(
        &self,
        first: usize,
        levels: u32,
        footprint: &[(usize, f32)],
        [column, row]: [usize; 2],
        level: f32,
    ) -> [f32; 3] {
        let whole = level.floor() as u32;
        let fraction = level - level.floor();
        let mut value = self.coefficient(first, footprint).map(|c| c * weight(levels));
        let last = whole + u32::from(fraction > 0.0);
        for j in 0..last {
            let (child_column, child_row) = (column >> (levels - j - 1), row >> (levels - j - 1));
            let (parent_column, parent_row) = (child_column >> 1, child_row >> 1);
            let (latitude, longitude) = detail_indices(j, parent_column, parent_row, child_row);
            let scale = weight(levels - j);
            let latitude_sign = if child_row & 1 == 0 { scale } else { -scale };
            let longitude_scale = scale * SQRT_2;
            let longitude_sign = if child_column & 1 == 0 { longitude_scale } else { -longitude_scale };
            let a = self.coefficient(first + latitude, footprint);
            let b = self.coefficient(first + longitude, footprint);
            let part = if j == whole { fraction } else { 1.0 };
            for channel in 0..3 {
                value[channel] += part * (latitude_sign * a[channel] + longitude_sign * b[channel]);
            }
        }
        value
    }

    /// Slice of a coefficient, 0 if it has none.
    fn entry(&self, coefficient: usize) -> usize {
        usize::from(self.index[coefficient])
    }

    /// Coefficient at the outer direction, through the index map.
    fn coefficient(&self, coefficient: usize, footprint: &[(usize, f32)]) -> [f32; 3] {
        let channels = self.header.channels as usize;
        let slice = self.entry(coefficient) * cells_of(self.window);
        let mut value = [0.0; 3];
        if slice == 0 {
            // Shaders fetch the zero slice; skipping it gives the same value.
            return value;
        }
        for (cell, weight) in footprint {
            let texel = &self.coefficients[(slice + cell) * channels..][..channels];
            for channel in 0..3 {
                value[channel] += weight * texel[if channels == 1 { 0 } else { channel }];
            }
        }
        value
    }

    fn taps(&self, direction: [f32; 3], filtered: bool) -> [Tap; 2] {
        let n = self.header.grid();
        let [x, y, z] = direction;
        let z = z.max(0.0);
        let longitude = polynomial_atan2(z, x);
        let sine = (x * x + z * z).sqrt();
        let colatitude = polynomial_atan2(sine, y);
        [longitude, colatitude].map(|angle| {
            let position = angle / PI * n as f32;
            if !filtered {
                let cell = (position as usize).min(n - 1);
                return Tap { cells: [cell, cell], weight: 0.0 };
            }
            let centred = (position - 0.5).clamp(0.0, (n - 1) as f32);
            let lower = (centred as usize).min(n - 1);
            Tap { cells: [lower, (lower + 1).min(n - 1)], weight: centred - lower as f32 }
        })
    }

    /// Log-encoded values of a whole table row at the finest level: all inner cells of one outer cell, for one channel,
    /// by the inverse transform. In a cropped pack an outer cell outside the window is clamped to it. `output` has
    /// `cells` elements, longitude fastest.
    pub fn decode_row(&self, outer_cell: usize, channel: usize, output: &mut [f32], scratch: &mut RowScratch) {
        let (n, cells, channels) = (self.header.grid(), self.header.cells(), self.header.channels as usize);
        let stored = cells_of(self.window);
        let outer_cell = stored_cell(self.window, outer_cell % n, outer_cell / n);
        scratch.coefficients.resize(cells, 0.0);
        scratch.coefficients.fill(0.0);
        for (k, slice) in self.index[..cells].iter().enumerate() {
            if *slice != 0 {
                let texel = usize::from(*slice) * stored + outer_cell;
                scratch.coefficients[k] = self.coefficients[texel * channels + channel];
            }
        }
        haar::inverse(&scratch.coefficients, n, output, &mut scratch.split);
    }
}

/// `α` of [`level_of_detail`] from the paper, per unit of distance.
pub const DEFAULT_DISTANCE_SCALE: f64 = 0.15;

/// Level of detail at a distance `d` from the viewer: `l = N - clamp(log2(α d), 0, N)` (section 5.4.1, with the sign
/// that its discussion of cost and its renderings imply: far is coarse). `levels` is `N`, `scale` is `α`.
pub fn level_of_detail(levels: u32, distance: f64, scale: f64) -> f64 {
    f64::from(levels) - (scale * distance).log2().clamp(0.0, f64::from(levels))
}

/// `2^-n`.
fn weight(n: u32) -> f32 {
    1.0 / (1u64 << n) as f32
}

fn component(texels: &[u8], index: usize, bytes: usize) -> f32 {
    if bytes == 1 {
        f32::from(texels[index]) * (1.0 / 255.0)
    } else {
        f32::from(u16::from_le_bytes([texels[2 * index], texels[2 * index + 1]])) * (1.0 / 65535.0)
    }
}

/// Number of cells in a slice.
fn cells_of(window: Window) -> usize {
    window.size.into_iter().map(|n| n as usize).product()
}

/// Index in a slice of a grid cell, clamped to the window.
fn stored_cell(window: Window, column: usize, row: usize) -> usize {
    let within = |cell: usize, axis: usize| {
        let (first, size) = (window.first[axis] as usize, window.size[axis] as usize);
        cell.clamp(first, first + size - 1) - first
    };
    within(row, 1) * window.size[0] as usize + within(column, 0)
}

fn footprint(column: Tap, row: Tap, window: Window) -> Footprint {
    let mut cells = [(0, 0.0); 4];
    let mut k = 0;
    for (r, row_weight) in [(0, 1.0 - row.weight), (1, row.weight)] {
        for (c, column_weight) in [(0, 1.0 - column.weight), (1, column.weight)] {
            cells[k] = (stored_cell(window, column.cells[c], row.cells[r]), row_weight * column_weight);
            k += 1;
        }
    }
    cells
}

/// Same as [`Parameterisation::to_axes`] in f32.
fn axes(parameterisation: Parameterisation, pair: DirectionPair) -> ([f32; 3], [f32; 3]) {
    let (i, o) = (pair.incoming.map(|c| c as f32), pair.outgoing.map(|c| c as f32));
    match parameterisation {
        Parameterisation::TangentPole => (i, o),
        Parameterisation::HalfDifference => {
            let sum = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
            let length = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
            let h = [sum[0] / length, sum[1] / length, sum[2] / length];
            let s = (h[0] * i[0] + h[1] * i[1]) / (1.0 + h[2]) + i[2];
            let z = h[0] * i[0] + h[1] * i[1] + h[2] * i[2];
            (h, [i[0] - h[0] * s, i[1] - h[1] * s, z])
        }
    }
}
