//! Least squares projection of finely sampled periodic images onto bilinear interpolation of texels.
//!
//! Means over texels blur: bilinear interpolation of them filters twice. The projection has the smallest mean squared
//! difference from the image, as far as sums over samples equal integrals. It overshoots at steps by up to a fifth.

use rayon::prelude::*;

/// Texels on each side to which the inverse of the tent's correlations reaches.
const REACH: i64 = 10;

/// Projects `size * finer` x `size * finer` samples, row by row, onto `size x size` texels, row by row. The image has
/// period 1; the samples of a texel surround its centre.
pub fn project<const N: usize>(size: usize, finer: usize, sample: impl Fn(usize) -> [f32; N] + Sync) -> Vec<[f32; N]> {
    let side = size * finer;
    let tent = tent(finer);
    let inverse = inverse();
    let line = |samples: &dyn Fn(usize) -> [f32; N]| -> Vec<[f32; N]> {
        let wrapped = |at: i64, length: usize| at.rem_euclid(length as i64) as usize;
        let sums = (0..size as i64).map(|texel| {
            weighted(tent.iter().map(|(k, weight)| (*weight, samples(wrapped(texel * finer as i64 + k, side)))))
        });
        let sums: Vec<[f32; N]> = sums.collect();
        let texel = |texel: i64| {
            weighted((-REACH..).zip(&inverse).map(|(k, weight)| (*weight, sums[wrapped(texel + k, size)])))
        };
        (0..size as i64).map(texel).collect()
    };
    let row = |row: usize| {
        // Tents overlap: each sample counts for more than one texel.
        let samples: Vec<[f32; N]> = (0..side).map(|column| sample(row * side + column)).collect();
        line(&|column| samples[column])
    };
    let rows: Vec<Vec<[f32; N]>> = (0..side).into_par_iter().map(row).collect();
    let columns: Vec<Vec<[f32; N]>> = (0..size).into_par_iter().map(|column| line(&|row| rows[row][column])).collect();
    (0..size * size).map(|at| columns[at % size][at / size]).collect()
}

/// Offsets of samples from the first of a texel, and their weights under its tent, with the sum 1.
fn tent(finer: usize) -> Vec<(i64, f32)> {
    let n = finer as i64;
    let weight = |k: i64| 1.0 - ((k as f32 + 0.5) / finer as f32 - 0.5).abs();
    let weights: Vec<(i64, f32)> = (-n..2 * n).map(|k| (k, weight(k))).filter(|(_, weight)| *weight > 0.0).collect();
    let sum: f32 = weights.iter().map(|(_, weight)| weight).sum();
    weights.into_iter().map(|(k, weight)| (k, weight / sum)).collect()
}

/// Inverse of the correlations `1/6, 4/6, 1/6` of neighbouring tents.
fn inverse() -> Vec<f32> {
    let pole = 3f64.sqrt() - 2.0;
    let gain = -6.0 * pole / (1.0 - pole * pole);
    (-REACH..=REACH).map(|k| (gain * pole.powi(k.abs() as i32)) as f32).collect()
}

fn weighted<const N: usize>(terms: impl Iterator<Item = (f32, [f32; N])>) -> [f32; N] {
    let mut sum = [0.0; N];
    for (weight, values) in terms {
        sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bilinear interpolation of texels at a sample.
    fn interpolated(texels: &[[f32; 1]], size: usize, finer: usize, at: usize) -> f32 {
        let side = size * finer;
        let position = |c: usize| (c as f32 + 0.5) / finer as f32 - 0.5;
        let (x, y) = (position(at % side), position(at / side));
        let texel = |i: f32, j: f32| {
            let wrapped = |c: f32| (c as i64).rem_euclid(size as i64) as usize;
            texels[wrapped(j) * size + wrapped(i)][0]
        };
        let (i, j) = (x.floor(), y.floor());
        let (u, v) = (x - i, y - j);
        (1.0 - v) * ((1.0 - u) * texel(i, j) + u * texel(i + 1.0, j))
            + v * ((1.0 - u) * texel(i, j + 1.0) + u * texel(i + 1.0, j + 1.0))
    }

    #[test]
    fn interpolated_images_are_recovered() {
        let (size, finer) = (8, 4);
        let texels: Vec<[f32; 1]> = (0..64).map(|k| [((k * 37) % 64) as f32 / 64.0]).collect();
        let found = project(size, finer, |at| [interpolated(&texels, size, finer, at)]);
        let largest =
            |found: &[[f32; 1]]| found.iter().zip(&texels).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f32::max);
        // Sums over samples are not integrals: the correlations of tents differ by a few percent.
        assert!(largest(&found) < 0.05, "{}", largest(&found));
        // The negative control: means over texels.
        let side = size * finer;
        let mean = |texel: usize| {
            let first = texel / size * finer * side + texel % size * finer;
            let samples = (0..finer * finer).map(|k| first + k / finer * side + k % finer);
            [samples.map(|at| interpolated(&texels, size, finer, at)).sum::<f32>() / (finer * finer) as f32]
        };
        assert!(largest(&(0..64).map(mean).collect::<Vec<_>>()) > 0.15);
        let constant = project(1, 4, |_| [3.0]);
        assert!((constant[0][0] - 3.0).abs() < 1e-4, "{constant:?}");
    }
}
