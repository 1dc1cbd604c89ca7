//! CPU decoder of table packs, the reference for shaders.
//!
//! All steps before the last exponential are f32 operations in a fixed order without fused operations. A shader that
//! follows them with manual filtering produces the same bits.

use super::coordinates::{Angles, Position};
use super::curve::Curve;
use super::header::TableHeader;
use super::pack::TablePack;
use crate::crop::Window;
use crate::direction::DirectionPair;

#[derive(Debug, Clone)]
struct UnpackedCurve {
    levels: u32,
    /// `[row][node]`.
    values: Vec<[f32; 3]>,
}

impl UnpackedCurve {
    /// Number of rows between the finest level of detail, which has the first row, and `level`.
    fn rows_below_finest(&self, level: f32) -> f32 {
        (self.levels as f32 - level).clamp(0.0, self.levels as f32)
    }

    /// Linearly filtered row at `θ_h`.
    fn along(&self, row: u32, angles: Angles) -> [f32; 3] {
        let nodes = self.values.len() / (self.levels as usize + 1);
        let at = Curve::position(nodes, angles.theta_half);
        let lower = (at as usize).min(nodes - 2);
        let first = row as usize * nodes + lower;
        between(self.values[first], self.values[first + 1], at - lower as f32)
    }
}

/// Logarithms `ln(f / μ + ε)` at the two levels around a level of detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogValues {
    /// Value at the finer level, or at the requested level if it is whole.
    pub fine: [f32; 3],
    /// Value at the coarser level.
    pub coarse: [f32; 3],
    /// Weight of the coarser value, `0.0..=1.0`.
    pub coarse_weight: f32,
}

/// Decoder of one pack, with decompressed values.
#[derive(Debug, Clone)]
pub struct TableDecoder {
    header: TableHeader,
    window: Window,
    values: Vec<[f32; 3]>,
    curve: Option<UnpackedCurve>,
}

impl TableDecoder {
    /// Decompresses the texels of a pack.
    pub fn new(pack: &TablePack) -> Self {
        let unpacked = |curve: &Curve| UnpackedCurve { levels: curve.levels(), values: curve.values() };
        let curve = pack.curve().map(unpacked);
        Self { header: *pack.header(), window: pack.window(), values: pack.values(), curve }
    }

    /// Sizes and constants of the pack.
    pub fn header(&self) -> &TableHeader {
        &self.header
    }

    /// Index of the finest level of detail; level 0 is the coarsest.
    pub fn levels(&self) -> u32 {
        self.curve.as_ref().map_or(0, |curve| curve.levels)
    }

    /// `f_r` of a direction pair at the finest level of detail: linear RGB (grey packs repeat their channel), 1/sr, not
    /// negative. Returns zero if a direction is at or below the horizon.
    pub fn eval(&self, pair: DirectionPair) -> [f32; 3] {
        self.eval_at(pair, self.levels() as f32)
    }

    /// Same as [`Self::eval`] at a level of detail, clamped to the range from 0 to [`Self::levels`].
    pub fn eval_at(&self, pair: DirectionPair, level: f32) -> [f32; 3] {
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        self.eval_angles(self.header.angles(pair), level)
    }

    /// Same as [`Self::eval_at`] for a pair above the horizon with these angles.
    pub fn eval_angles(&self, angles: Angles, level: f32) -> [f32; 3] {
        let LogValues { fine, coarse, coarse_weight } = self.log_values_of(angles, level);
        let fine = fine.map(|value| self.from_log(value));
        if coarse_weight > 0.0 { between(fine, coarse.map(|value| self.from_log(value)), coarse_weight) } else { fine }
    }

    /// Logarithms that [`Self::eval_at`] decodes, for directions above the horizon. A shader with manual filtering and
    /// correctly rounded arithmetic returns the same bits. Levels are blended by value, not by logarithm, to preserve
    /// energy.
    pub fn log_values(&self, pair: DirectionPair, level: f32) -> LogValues {
        self.log_values_of(self.header.angles(pair), level)
    }

    fn log_values_of(&self, angles: Angles, level: f32) -> LogValues {
        let position = self.header.position_of(angles);
        let mut value = self.sample(&position, position.layers[0]);
        if !self.header.isotropic() {
            let upper = self.sample(&position, position.layers[1]);
            value = between(value, upper, position.layer_weight);
        }
        let table: [f32; 3] = std::array::from_fn(|k| self.header.low[k] + self.header.span[k] * value[k]);
        let Some(curve) = &self.curve else { return LogValues { fine: table, coarse: table, coarse_weight: 0.0 } };
        let down = curve.rows_below_finest(level);
        let row = down as u32;
        let on_row = |row: u32| {
            let value = curve.along(row, angles);
            std::array::from_fn(|k| table[k] + value[k])
        };
        let (fine, coarse_weight) = (on_row(row), down - row as f32);
        LogValues { fine, coarse: if coarse_weight > 0.0 { on_row(row + 1) } else { fine }, coarse_weight }
    }

    /// `f = μ (exp(v) - ε)`, clamped to 0 and to the largest finite number.
    pub fn from_log(&self, value: f32) -> f32 {
        let f = self.header.mean * (value.exp() - self.header.bias);
        if f > 0.0 { f.min(f32::MAX) } else { 0.0 }
    }

    /// Trilinear filtering of the eight texels around a position, columns first. In cropped packs the position is
    /// clamped to the window.
    fn sample(&self, position: &Position, layer: u32) -> [f32; 3] {
        let Window { first, size: [columns, rows] } = self.window;
        let slices = self.header.slices();
        let [column, row] = [position.column - first[0] as f32, position.row - first[1] as f32];
        let [(column, x), (row, y), (slice, z)] =
            [(column, columns), (row, rows), (position.slice, slices)].map(|(at, count)| {
                let at = at.clamp(0.0, (count - 1) as f32);
                let lower = (at as u32).min(count - 2);
                (lower, at - lower as f32)
            });
        let texel = |row: u32, slice: u32| {
            let at = (((layer * slices + slice) * rows + row) * columns + column) as usize;
            between(self.values[at], self.values[at + 1], x)
        };
        let of_slice = |slice: u32| between(texel(row, slice), texel(row + 1, slice), y);
        between(of_slice(slice), of_slice(slice + 1), z)
    }
}

fn between(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + weight * (b[k] - a[k]))
}
