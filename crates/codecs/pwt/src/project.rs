//! Coefficients of learned terms: photographs, a few at a time, times a matrix.

use crate::fit::accumulate;
use crate::learned::Learned;
use rayon::prelude::*;

/// Photographs whose values are held at once.
const AT_ONCE: usize = 8;
/// Coefficients of each component for all texels. `channels` gives red, green and blue of a photograph in the domain.
pub fn coefficients(
    learned: &Learned,
    lights: usize,
    texels: usize,
    channels: impl Fn(usize) -> [Vec<f32>; 3] + Sync,
) -> Vec<Vec<f32>> {
    let mut planes: Vec<Vec<f32>> = learned.offsets.iter().map(|offset| vec![*offset; texels]).collect();
    let all: Vec<usize> = (0..lights).collect();
    for some in all.chunks(AT_ONCE) {
        let values: Vec<[Vec<f32>; 3]> = some.par_iter().map(|light| channels(*light)).collect();
        // Row by row: components x values.
        let range = 3 * some[0]..3 * (some[0] + some.len());
        let factors: Vec<f32> = learned.factors.iter().flat_map(|factors| &factors[range.clone()]).copied().collect();
        accumulate(&mut planes, &factors, &values.iter().flatten().map(Vec::as_slice).collect::<Vec<_>>());
    }
    planes
}
