//! Coefficients of learned terms: photographs, a few at a time, times a matrix.

use crate::fit::multiply_add;
use crate::learned::Learned;
use rayon::prelude::*;

/// Photographs whose values are held at once.
const AT_ONCE: usize = 8;
/// Values per strip: fixed, so that sums do not depend on the number of threads, and small enough for the cache.
const STRIP: usize = 1 << 11;

/// Coefficients of each component for all texels. `channels` gives red, green and blue of a photograph in the domain.
pub fn coefficients(
    learned: &Learned,
    lights: usize,
    texels: usize,
    channels: impl Fn(usize) -> [Vec<f32>; 3] + Sync,
) -> Vec<Vec<f32>> {
    let terms = learned.factors.len();
    let mut planes: Vec<Vec<f32>> = learned.offsets.iter().map(|offset| vec![*offset; texels]).collect();
    let all: Vec<usize> = (0..lights).collect();
    for some in all.chunks(AT_ONCE) {
        let values: Vec<[Vec<f32>; 3]> = some.par_iter().map(|light| channels(*light)).collect();
        // Row by row: components x values.
        let (first, last) = (3 * some[0], 3 * (some[0] + some.len()));
        let factors: Vec<f32> = learned.factors.iter().flat_map(|factors| &factors[first..last]).copied().collect();
        let mut strips: Vec<Vec<&mut [f32]>> = (0..texels.div_ceil(STRIP)).map(|_| Vec::with_capacity(terms)).collect();
        for plane in &mut planes {
            strips.iter_mut().zip(plane.chunks_mut(STRIP)).for_each(|(strip, part)| strip.push(part));
        }
        let buffers = || (Vec::new(), Vec::new());
        strips.into_par_iter().enumerate().for_each_init(buffers, |(gathered, sums), (strip, parts)| {
            let range = strip * STRIP..((strip + 1) * STRIP).min(texels);
            gathered.clear();
            values.iter().flatten().for_each(|channel| gathered.extend_from_slice(&channel[range.clone()]));
            sums.clear();
            parts.iter().for_each(|part| sums.extend_from_slice(part));
            multiply_add(terms, last - first, range.len(), &factors, gathered, sums);
            for (part, row) in parts.into_iter().zip(sums.chunks_exact(range.len())) {
                part.copy_from_slice(row);
            }
        });
    }
    planes
}
