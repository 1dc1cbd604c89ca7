//! Sample indices and weights for filtering at a position, used by texture decoders and image filters. The order of
//! operations is fixed.

/// Two neighbouring samples along one axis and the weight of the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tap {
    /// Indices of the samples.
    pub samples: [u32; 2],
    /// Weight of the second, 0 to 1.
    pub weight: f32,
}

impl Tap {
    /// Samples around a position in units of samples from the border of the first of `count`; sample centres are at
    /// halves. Beyond the ends, indices wrap around if `repeats`, otherwise they are clamped.
    pub fn new(position: f32, count: u32, repeats: bool) -> Self {
        Self::around(position - 0.5, count, repeats)
    }

    /// Same as [`Self::new`] with the position counted from the centre of the first sample.
    pub fn around(at: f32, count: u32, repeats: bool) -> Self {
        let lower = at.floor();
        Self::of_samples(lower as i32, at - lower, count, repeats)
    }

    /// Same as [`Self::around`] in double precision, for positions far from the first sample.
    pub fn around_f64(at: f64, count: u32, repeats: bool) -> Self {
        let lower = at.floor();
        Self::of_samples(lower as i32, (at - lower) as f32, count, repeats)
    }

    fn of_samples(first: i32, weight: f32, count: u32, repeats: bool) -> Self {
        let sample = |k: i32| {
            if repeats { k.rem_euclid(count as i32) as u32 } else { k.clamp(0, count as i32 - 1) as u32 }
        };
        Self { samples: [sample(first), sample(first.saturating_add(1))], weight }
    }

    /// Indices of the samples as `usize`.
    pub fn indices(self) -> [usize; 2] {
        self.samples.map(|sample| sample as usize)
    }

    /// Indices with their weights.
    fn weighted(self) -> [(u32, f32); 2] {
        [(self.samples[0], 1.0 - self.weight), (self.samples[1], self.weight)]
    }
}

/// Texels around a parameter with period 1; texel centres are at `(i + ½) / size`.
pub(crate) fn periodic_tap(parameter: f32, size: u32) -> Tap {
    Tap::new(parameter * size as f32, size, true)
}

/// Four samples with their weights, column fastest.
pub(crate) fn footprint(column: Tap, row: Tap) -> [([u32; 2], f32); 4] {
    let mut samples = [([0; 2], 0.0); 4];
    for (r, (row, row_weight)) in row.weighted().into_iter().enumerate() {
        for (c, (column, column_weight)) in column.weighted().into_iter().enumerate() {
            samples[2 * r + c] = ([column, row], row_weight * column_weight);
        }
    }
    samples
}

/// Bilinear interpolation of the four values that `sample` returns by column and row, along rows first.
pub fn bilinear<const N: usize>([column, row]: [Tap; 2], sample: impl Fn([usize; 2]) -> [f32; N]) -> [f32; N] {
    let between = |[a, b]: [[f32; N]; 2], weight: f32| std::array::from_fn(|k| a[k] + weight * (b[k] - a[k]));
    let along = |row: usize| between(column.indices().map(|column| sample([column, row])), column.weight);
    between(row.indices().map(along), row.weight)
}

/// Fractional part, in [0, 1); 0 for non-finite numbers.
pub(crate) fn wrap(x: f32) -> f32 {
    let fraction = x - x.floor();
    // A tiny negative number has a fraction that rounds to 1.
    if fraction < 1.0 { fraction } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_around_positions() {
        for (position, repeats, samples, weight) in [
            (0.5, true, [0, 1], 0.0),
            (1.75, true, [1, 2], 0.25),
            (0.25, true, [3, 0], 0.75),
            (4.0, true, [3, 0], 0.5),
            (0.25, false, [0, 0], 0.75),
            (3.75, false, [3, 3], 0.25),
            (-2.0, false, [0, 0], 0.5),
            (9.0, true, [0, 1], 0.5),
        ] {
            assert_eq!(Tap::new(position, 4, repeats), Tap { samples, weight }, "{position} {repeats}");
        }
        assert_eq!(periodic_tap(0.125, 4), Tap { samples: [0, 1], weight: 0.0 });
        assert_eq!(Tap::around(-0.25, 4, true), Tap { samples: [3, 0], weight: 0.75 });
        assert_eq!(Tap::around_f64(1e6 + 0.25, 4, true), Tap { samples: [0, 1], weight: 0.25 });
        assert_eq!(periodic_tap(0.4, 1).samples, [0, 0]);
        assert_eq!([-1e-9, 1.25, -0.25, f32::NAN].map(wrap), [0.0, 0.25, 0.75, 0.0]);
    }

    #[test]
    fn between_four_samples() {
        let taps = [Tap { samples: [0, 1], weight: 0.25 }, Tap { samples: [1, 0], weight: 0.5 }];
        assert_eq!(bilinear(taps, |[column, row]| [column as f32 + 10.0 * row as f32, 7.0]), [5.25, 7.0]);
    }

    /// Shaders select the last and the first texel by comparison for parameters in [0, 1).
    #[test]
    fn remainders_are_what_shaders_compare() {
        let below_one = f32::from_bits(1.0f32.to_bits() - 1);
        for size in [1, 2, 3, 5, 7, 64, 1000, 8192] {
            for k in 0..4000 {
                let parameter = if k == 0 { below_one } else { wrap(k as f32 * 0.618_034) };
                let tap = periodic_tap(parameter, size);
                let below = (parameter * size as f32 - 0.5).floor();
                let lower = if below < 0.0 { size - 1 } else { (below as u32).min(size - 1) };
                let upper = if lower + 1 == size { 0 } else { lower + 1 };
                assert_eq!(tap.samples, [lower, upper], "{parameter} of {size}");
            }
        }
    }

    /// Indices are valid for any position.
    #[test]
    fn positions_that_are_not_finite_or_huge() {
        for position in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN] {
            for repeats in [false, true] {
                assert!(Tap::new(position, 5, repeats).samples.iter().all(|k| *k < 5), "{position} {repeats}");
            }
        }
    }
}
