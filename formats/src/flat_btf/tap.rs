//! Samples around a position and their weights, as all decoders of flat BTFs find them: f32 arithmetic in a fixed order.

/// Two neighbouring samples along one axis and the weight of the second.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tap {
    pub(super) samples: [u32; 2],
    pub(super) weight: f32,
}

impl Tap {
    /// Samples with their weights.
    fn weighted(self) -> [(u32, f32); 2] {
        [(self.samples[0], 1.0 - self.weight), (self.samples[1], self.weight)]
    }
}

/// Four samples with their weights: rows outside, columns inside.
pub(super) fn footprint(column: Tap, row: Tap) -> [([u32; 2], f32); 4] {
    let mut samples = [([0; 2], 0.0); 4];
    for (r, (row, row_weight)) in row.weighted().into_iter().enumerate() {
        for (c, (column, column_weight)) in column.weighted().into_iter().enumerate() {
            samples[2 * r + c] = ([column, row], row_weight * column_weight);
        }
    }
    samples
}

/// The fraction, 0 to below 1. Numbers that have none become 0.
pub(super) fn wrap(x: f32) -> f32 {
    let fraction = x - x.floor();
    // A tiny negative number has a fraction that rounds to 1.
    if fraction < 1.0 { fraction } else { 0.0 }
}

/// The texels around a parameter, whose centres are at `(i + ½) / size`, with period 1.
pub(super) fn periodic_tap(parameter: f32, size: u32) -> Tap {
    let position = parameter * size as f32 - 0.5;
    let lower = position.floor();
    let weight = position - lower;
    let lower = if lower < 0.0 { size - 1 } else { (lower as u32).min(size - 1) };
    let upper = if lower + 1 == size { 0 } else { lower + 1 };
    Tap { samples: [lower, upper], weight }
}
