//! Scaling coefficients that preserve energy: each level of detail of a pack has the directional albedo of the table. The
//! paper has one scaling coefficient, and coarser levels are darker, because they are means of logarithms.

use super::quantise::quantise_slice;
use super::table::Table;
use brdfc_formats::vector_math::exp;
use brdfc_formats::wavelet::{Header, RowScratch, WaveletDecoder, WaveletPack};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Replaces the scaling coefficient of a pack of the paper by one for each level of detail. `reference` has values of `f`.
///
/// A level has logarithms `v`, constant over blocks of inner cells. The light that it reflects, `Σ w (exp(v + c) - ε)`
/// with weights `w = ∫ cos θ_o dω`, equals that of the table for `c = ln((A / μ + ε W) / Σ w exp(v))`, where
/// `A = Σ w f` and `W = Σ w`. The level adds `c` to all its values. It also replaces the light of dropped slices.
pub fn preserve_energy(pack: WaveletPack, reference: &Table) -> WaveletPack {
    let header = Header { energy_preserving: true, ..pack.header };
    let (cells, channels) = (header.cells(), header.channels as usize);
    let decoder = WaveletDecoder::new(&pack);
    let weights = cosine_weights(header.grid());
    // For each row and channel a coefficient of each level, the coarsest first.
    let of_row = |(row, outer): (usize, &u32)| -> Vec<Vec<f32>> {
        let (mut values, mut scratch) = (vec![0.0f32; cells], RowScratch::default());
        let mut of_channel = |channel: usize| {
            decoder.decode_row(*outer as usize, channel, &mut values, &mut scratch);
            let samples = reference.row(channel, row);
            let light: f64 = samples.iter().zip(&weights).map(|(f, w)| f64::from(*f) * w).sum();
            scaling_coefficients(&values, &weights, light / f64::from(header.mean), f64::from(header.bias))
        };
        (0..channels).map(&mut of_channel).collect()
    };
    let by_row: Vec<Vec<Vec<f32>>> = reference.fold.rows().par_iter().enumerate().map(of_row).collect();
    let slice_of = |level: usize| -> Vec<f32> {
        let of_cell = |channel: usize, cell: usize| by_row[reference.fold.locate(cell).0][channel][level];
        (0..channels * cells).map(|at| of_cell(at / cells, at % cells)).collect()
    };
    let slice_bytes = cells * header.texel_format().texel_bytes();
    let WaveletPack { mut index, mut scales, mut texels, on_grid, off_grid, crop, .. } = pack;
    let coarser = header.coarser_scalings();
    scales[1] = quantise_slice(&slice_of(coarser), &header, &mut texels[slice_bytes..2 * slice_bytes]);
    for level in 0..coarser {
        let mut slice = vec![0; slice_bytes];
        let scale = quantise_slice(&slice_of(level), &header, &mut slice);
        index.push(scales.len() as u16);
        scales.push(scale);
        texels.extend(slice);
    }
    WaveletPack { header, index, scales, on_grid, off_grid, crop, texels }
}

/// Scaling coefficients of the levels of one image, the coarsest first: `values` are its logarithms without a correction,
/// `light` is `A / μ`.
pub fn scaling_coefficients(values: &[f32], weights: &[f64], light: f64, bias: f64) -> Vec<f32> {
    let n = values.len().isqrt();
    let whole: f64 = weights.iter().sum();
    let target = (light + bias * whole).ln();
    let (mut values, mut weights) = (values.to_vec(), weights.to_vec());
    let mut corrections = Vec::new();
    loop {
        let reflected: f64 = values.iter().zip(&weights).map(|(v, w)| f64::from(exp(*v)) * w).sum();
        corrections.push(target - reflected.ln());
        let side = values.len().isqrt();
        if side == 1 {
            break;
        }
        let of_block = |at: usize| {
            let first = at / (side / 2) * 2 * side + at % (side / 2) * 2;
            [first, first + 1, first + side, first + side + 1]
        };
        let blocks = 0..values.len() / 4;
        weights = blocks.clone().map(|at| of_block(at).map(|k| weights[k]).iter().sum()).collect();
        values = blocks.map(|at| 0.25 * of_block(at).map(|k| values[k]).iter().sum::<f32>()).collect();
    }
    corrections.iter().rev().map(|c| (n as f64 * (f64::from(values[0]) + c)) as f32).collect()
}

/// `∫ cos θ_o dω = ∫ sin² φ dφ ∫ sin θ dθ` over each cell of the outgoing hemisphere.
fn cosine_weights(n: usize) -> Vec<f64> {
    let angle = |k: usize| PI * k as f64 / n as f64;
    let row = |r: usize| 0.5 * (angle(r + 1) - angle(r)) - 0.25 * ((2.0 * angle(r + 1)).sin() - (2.0 * angle(r)).sin());
    let column = |c: usize| angle(c).cos() - angle(c + 1).cos();
    (0..n * n).map(|cell| row(cell / n) * column(cell % n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of the level with blocks of `n >> level` cells, for logarithms plus a correction.
    fn light(values: &[f32], weights: &[f64], level: usize, added: f64) -> f64 {
        let n = values.len().isqrt();
        let block = n >> level;
        let mean = |cell: usize| {
            let (top, left) = (cell / n / block * block, cell % n / block * block);
            let of_block = (0..block * block).map(|k| f64::from(values[(top + k / block) * n + left + k % block]));
            of_block.sum::<f64>() / (block * block) as f64
        };
        (0..n * n).map(|cell| weights[cell] * (mean(cell) + added).exp()).sum()
    }

    #[test]
    fn all_levels_reflect_the_light_that_is_asked_for() {
        let n = 8;
        let values: Vec<f32> = (0..n * n).map(|k| ((k * k % 29) as f32 - 20.0) / 5.0).collect();
        let (weights, bias) = (cosine_weights(n), 0.01);
        let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / (n * n) as f64;
        let found = scaling_coefficients(&values, &weights, 0.4, bias);
        assert_eq!(found.len(), 4);
        let expected = 0.4 + bias * weights.iter().sum::<f64>();
        for (level, scaling) in found.iter().enumerate() {
            let added = f64::from(*scaling) / n as f64 - mean;
            let off = light(&values, &weights, level, added) / expected - 1.0;
            assert!(off.abs() < 1e-5, "{level}: {off}");
        }
        // Control: the scaling coefficient of the finest level is too dark for the coarsest.
        let added = f64::from(found[3]) / n as f64 - mean;
        assert!(light(&values, &weights, 0, added) < 0.5 * expected);
    }

    #[test]
    fn a_constant_has_equal_scaling_coefficients() {
        let (weights, bias) = (cosine_weights(4), 0.01);
        let whole: f64 = weights.iter().sum();
        let found = scaling_coefficients(&[0.7f64.ln() as f32; 16], &weights, (0.7 - bias) * whole, bias);
        assert!(found.iter().all(|c| (f64::from(*c) / 4.0 - 0.7f64.ln()).abs() < 1e-6), "{found:?}");
    }

    /// `∫ cos θ_o dω` over the hemisphere is π.
    #[test]
    fn weights_cover_the_hemisphere() {
        for n in [2, 8, 64] {
            assert!((cosine_weights(n).iter().sum::<f64>() - PI).abs() < 1e-12);
        }
    }
}
