//! Coefficients of all texels at once: one matrix product, in strips on all cores.

use crate::design::Design;
use rayon::prelude::*;
use std::ops::Range;

/// Values per strip: fixed, so that sums do not depend on the number of threads, and small enough for the cache.
const STRIP: usize = 1 << 11;

/// Coefficients of the terms of a design, term by term: `c_k = Σ_i w_k(l_i) v_i`. `values` are stored light by light.
pub fn coefficients(design: &Design, values: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let (terms, lights) = (design.terms(), design.lights());
    let count = values.first().map_or(0, Vec::len);
    assert_eq!(values.len(), lights, "values of every light");
    // Row by row: terms x lights.
    let weights: Vec<f32> = (0..terms).flat_map(|k| (0..lights).map(move |i| design.row(i)[k] as f32)).collect();
    let mut planes = vec![vec![0.0f32; count]; terms];
    multiply_strips(&mut planes, STRIP, &weights, lights, |texels, strip| {
        values.iter().for_each(|light| strip.extend_from_slice(&light[texels.clone()]));
    });
    planes
}

/// Adds a matrix product to planes, strip by strip of their texels. `factors` are row by row: a row for each plane, a column for
/// each of `count` values per texel. `gather` appends the values of some texels, value by value.
pub fn multiply_strips(
    planes: &mut [Vec<f32>],
    strip: usize,
    factors: &[f32],
    count: usize,
    gather: impl Fn(Range<usize>, &mut Vec<f32>) + Sync,
) {
    let (terms, texels) = (planes.len(), planes.first().map_or(0, Vec::len));
    // For each strip, its part of every plane.
    let mut strips: Vec<Vec<&mut [f32]>> = (0..texels.div_ceil(strip)).map(|_| Vec::with_capacity(terms)).collect();
    for plane in planes {
        strips.iter_mut().zip(plane.chunks_mut(strip)).for_each(|(strip, part)| strip.push(part));
    }
    let buffers = || (Vec::new(), Vec::new());
    strips.into_par_iter().enumerate().for_each_init(buffers, |(values, sums), (index, parts)| {
        let range = index * strip..((index + 1) * strip).min(texels);
        values.clear();
        gather(range.clone(), values);
        sums.clear();
        parts.iter().for_each(|part| sums.extend_from_slice(part));
        multiply_add(terms, count, range.len(), factors, values, sums);
        for (part, row) in parts.into_iter().zip(sums.chunks_exact(range.len())) {
            part.copy_from_slice(row);
        }
    });
}

/// Adds `a b` to `c`: row-major matrices, `m x k` by `k x n`.
pub fn multiply_add(m: usize, k: usize, n: usize, a: &[f32], b: &[f32], c: &mut [f32]) {
    let view = |rows, columns, data| nalgebra::DMatrixView::from_slice(data, columns, rows);
    // In column-major order these are the transposes: c^T = b^T a^T.
    let mut out = nalgebra::DMatrixViewMut::from_slice(c, n, m);
    out.gemm(1.0, &view(k, n, b), &view(m, k, a), 1.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_known_matrices() {
        let mut c = [0.0, 0.0, 0.0, 0.0, 0.0, 0.5];
        multiply_add(2, 2, 3, &[1.0, 2.0, 3.0, 4.0], &[1.0, 0.0, 2.0, 0.0, 1.0, 3.0], &mut c);
        assert_eq!(c, [1.0, 2.0, 8.0, 3.0, 4.0, 18.5]);
    }
}
