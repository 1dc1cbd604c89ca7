//! The CPU decoder of table packs: the reference that shaders are held against.
//!
//! Every step up to the last exponential is f32 arithmetic in a fixed order without fused operations, so that a shader that
//! follows it with manual filtering gives the same bits.

use super::coordinates::{Angles, Position};
use super::curve::Curve;
use super::header::TableHeader;
use super::pack::TablePack;
use crate::direction::DirectionPair;

/// A pack made ready for random access.
#[derive(Debug, Clone)]
pub struct TableDecoder {
    header: TableHeader,
    values: Vec<[f32; 3]>,
    /// Span and values.
    curve: Option<([f32; 3], Vec<[f32; 3]>)>,
}

impl TableDecoder {
    /// Unpacks texels.
    pub fn new(pack: &TablePack) -> Self {
        let curve = pack.curve().map(|curve| (curve.span(), curve.values()));
        Self { header: *pack.header(), values: pack.values(), curve }
    }

    /// Sizes and constants.
    pub fn header(&self) -> &TableHeader {
        &self.header
    }

    /// `f_r` at a direction pair, linear RGB (grey packs repeat their channel), 1/sr, not negative. Zero where a direction
    /// is at or below the horizon.
    pub fn eval(&self, pair: DirectionPair) -> [f32; 3] {
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        self.log_value(pair).map(|value| self.from_log(value))
    }

    /// `ln(f / μ + ε)` that [`Self::eval`] decodes, of directions above the horizon. A shader with manual filtering and
    /// correctly rounded arithmetic returns the same bits.
    pub fn log_value(&self, pair: DirectionPair) -> [f32; 3] {
        let angles = self.header.angles(pair);
        let position = self.header.position_of(angles);
        let mut value = self.sample(&position, position.layers[0]);
        if !self.header.isotropic() {
            let upper = self.sample(&position, position.layers[1]);
            value = between(value, upper, position.layer_weight);
        }
        let table: [f32; 3] = std::array::from_fn(|k| self.header.low[k] + self.header.span[k] * value[k]);
        let Some((span, curve)) = &self.curve else { return table };
        let value = along(curve, angles);
        std::array::from_fn(|k| table[k] + span[k] * value[k])
    }

    /// `f = μ (exp(v) - ε)`, raised to 0 where rounding made it negative, and lowered to the largest number.
    pub fn from_log(&self, value: f32) -> f32 {
        let f = self.header.mean * (value.exp() - self.header.bias);
        if f > 0.0 { f.min(f32::MAX) } else { 0.0 }
    }

    /// Trilinear filtering of the eight texels around a position, columns first.
    fn sample(&self, position: &Position, layer: u32) -> [f32; 3] {
        let [columns, rows, _] = self.header.extent();
        let slices = self.header.slices();
        let [(column, x), (row, y), (slice, z)] =
            [(position.column, columns), (position.row, rows), (position.slice, slices)].map(|(at, count)| {
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

/// A curve at `θ_h`, filtered linearly.
fn along(curve: &[[f32; 3]], angles: Angles) -> [f32; 3] {
    let at = Curve::position(curve.len(), angles.theta_half);
    let lower = (at as usize).min(curve.len() - 2);
    between(curve[lower], curve[lower + 1], at - lower as f32)
}

fn between(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + weight * (b[k] - a[k]))
}
