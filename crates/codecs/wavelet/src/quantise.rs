//! Quantisation: retained slices as unsigned integers with a scale and an offset per slice (section 5.1 of Claustres et
//! al. 2007).

use super::haar::flip_coefficient;
use super::table::Table;
use brdfc_formats::wavelet::{Header, SliceScale};
use rayon::prelude::*;

/// Slices as texels.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantised {
    /// One per slice, the zero slice first.
    pub scales: Vec<SliceScale>,
    /// Texels as in [`brdfc_formats::wavelet::WaveletPack::texels`].
    pub texels: Vec<u8>,
}

/// Quantises the chosen coefficients to `header.bits` bits, after the zero slice.
pub fn quantise(coefficients: &Table, chosen: &[u32], header: &Header) -> Quantised {
    let slice_bytes = header.cells() * header.texel_format().texel_bytes();
    let transposed = Transposed::new(coefficients);
    let mut texels = vec![0u8; (chosen.len() + 1) * slice_bytes];
    let mut scales = vec![SliceScale::default(); chosen.len() + 1];
    texels[slice_bytes..]
        .par_chunks_mut(slice_bytes)
        .zip(scales[1..].par_iter_mut())
        .zip(chosen)
        .for_each(|((texels, scale), k)| *scale = quantise_slice(&transposed.slice(*k as usize), header, texels));
    Quantised { scales, texels }
}

/// Quantises one slice, `[channel][outer cell]`, into its texels.
fn quantise_slice(slice: &[f32], header: &Header, texels: &mut [u8]) -> SliceScale {
    let (format, cells) = (header.texel_format(), header.cells());
    let (components, bytes) = (format.components(), format.component_bytes());
    let scale = fit_scale(slice, header.bits);
    for cell in 0..cells {
        for component in 0..components {
            // The component after RGB is full, like the opaque alpha that many readers expect.
            let stored = match slice.get(component * cells + cell) {
                Some(c) => to_stored(to_step(*c, scale, header.bits), header.bits),
                None => u16::MAX >> (16 - 8 * bytes),
            };
            let at = (cell * components + component) * bytes;
            texels[at..at + bytes].copy_from_slice(&stored.to_le_bytes()[..bytes]);
        }
    }
    scale
}

/// Transposed coefficients, `[channel][k][row]`, so that a slice is read in order.
struct Transposed<'a> {
    coefficients: &'a Table,
    values: Vec<f32>,
}

impl<'a> Transposed<'a> {
    fn new(coefficients: &'a Table) -> Self {
        const BLOCK: usize = 64;
        let (channels, rows, cells) = coefficients.values.dim();
        let mut values = vec![0.0f32; channels * rows * cells];
        // Blocks of coefficients, small enough that their lines stay in the cache from row to row.
        let block = BLOCK.min(cells);
        values.par_chunks_mut(block * rows).enumerate().for_each(|(number, output)| {
            let (channel, first) = (number * block / cells, number * block % cells);
            for row in 0..rows {
                let from = &coefficients.row(channel, row)[first..first + block];
                for (k, c) in from.iter().enumerate() {
                    output[k * rows + row] = *c;
                }
            }
        });
        Self { coefficients, values }
    }

    /// One slice, `[channel][outer cell]`, unfolded.
    fn slice(&self, k: usize) -> Vec<f32> {
        let fold = &self.coefficients.fold;
        let (channels, rows, cells) = self.coefficients.values.dim();
        let outer_cells = fold.n * fold.n;
        let images = super::fold::Flip::ALL.map(|flip| flip_coefficient(k, flip));
        let mut slice = Vec::with_capacity(channels * outer_cells);
        for channel in 0..channels {
            for cell in 0..outer_cells {
                let (row, flip) = fold.locate(cell);
                let (image, sign) = images[flip.number()];
                slice.push(sign * self.values[(channel * cells + image) * rows + row]);
            }
        }
        slice
    }
}

/// Range of a slice, over all channels. If it spans 0, one of the steps is exactly 0: most details are close to zero
/// almost everywhere, and become exactly zero.
pub fn fit_scale(slice: &[f32], bits: u32) -> SliceScale {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for c in slice {
        low = low.min(f64::from(*c));
        high = high.max(f64::from(*c));
    }
    if low >= high {
        return SliceScale { scale: 0.0, offset: low as f32 };
    }
    let steps = last_step(bits);
    if low < 0.0 && high > 0.0 {
        // Steps below and above zero; the step is as fine as both sides allow.
        let below = (steps * -low / (high - low)).round().clamp(1.0, steps - 1.0);
        let step = (-low / below).max(high / (steps - below));
        return SliceScale { scale: (step * steps) as f32, offset: (-step * below) as f32 };
    }
    SliceScale { scale: (high - low) as f32, offset: low as f32 }
}

/// Nearest step of a coefficient, 0 to `2^bits - 1`.
#[inline]
pub fn to_step(coefficient: f32, scale: SliceScale, bits: u32) -> u32 {
    if scale.scale == 0.0 {
        return 0;
    }
    let unit = (f64::from(coefficient) - f64::from(scale.offset)) / f64::from(scale.scale);
    // Adding half a step and truncating rounds, because no value is negative.
    ((unit * last_step(bits)).clamp(0.0, last_step(bits)) + 0.5) as u32
}

/// Converts a step to the unsigned normalised integer of the texture. Fewer than 16 bits in a texture of 16 are spread
/// over its whole range.
fn to_stored(step: u32, bits: u32) -> u16 {
    if bits == 8 || bits == 16 {
        return step as u16;
    }
    (f64::from(step) * 65535.0 / last_step(bits)).round() as u16
}

fn last_step(bits: u32) -> f64 {
    f64::from((1u32 << bits) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn decoded(c: f32, scale: SliceScale, bits: u32) -> f64 {
        let stored = f64::from(to_stored(to_step(c, scale, bits), bits));
        let full = if bits == 8 { 255.0 } else { 65535.0 };
        f64::from(scale.offset) + f64::from(scale.scale) * stored / full
    }

    proptest! {
        #[test]
        fn error_is_at_most_half_a_step(
            slice in prop::collection::vec(prop_oneof![-5.0f32..5.0, -1e-3f32..1e-3, 1e-12f32..1e6], 2..64),
            bits in prop_oneof![Just(8u32), 10u32..=16]
        ) {
            let scale = fit_scale(&slice, bits);
            let half_step = 0.5 * f64::from(scale.scale) / last_step(bits);
            let spread = if bits > 8 { f64::from(scale.scale) / 65535.0 } else { 0.0 };
            let rounding = 1e-6 * f64::from(scale.scale + scale.offset.abs());
            for c in &slice {
                prop_assert!((decoded(*c, scale, bits) - f64::from(*c)).abs() <= half_step + spread + rounding);
            }
        }

        #[test]
        fn zero_stays_zero(low in -5.0f32..-1e-6, high in 1e-6f32..5.0, bits in 8u32..=8) {
            let scale = fit_scale(&[low, high], bits);
            prop_assert!(decoded(0.0, scale, bits).abs() <= 1e-6 * f64::from(scale.scale));
        }

        #[test]
        fn the_range_is_hardly_widened_for_zero(low in -5.0f32..-1e-3, high in 1e-3f32..5.0) {
            let scale = fit_scale(&[low, high], 8);
            let width = f64::from(high - low);
            prop_assert!(f64::from(scale.scale) <= width * (1.0 + 2.0 / 254.0) + 255.0 * f64::from(low.abs().min(high)));
        }
    }

    #[test]
    fn constants_and_denormals() {
        for c in [0.0f32, 1.5, -2.5, 1e-40, f32::MIN_POSITIVE] {
            let scale = fit_scale(&[c, c], 8);
            assert_eq!(scale, SliceScale { scale: 0.0, offset: c });
            assert_eq!(to_step(c, scale, 8), 0);
        }
        let scale = fit_scale(&[-1e-40, 1e-40], 8);
        assert!(scale.scale.is_finite() && decoded(1e-40, scale, 8).abs() < 1e-39);
    }
}
