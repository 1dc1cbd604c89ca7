//! Mipmaps of bytes and words. Each texel of a level is the mean of the area that it covers, weighted by the share of
//! views that see each texel. Rarely seen texels, such as the lower side of an overhang, may be adjacent in the map to
//! often seen ones, but not in the pixels of a renderer.

use rayon::prelude::*;

/// An integer type that supports averaging.
pub(crate) trait Whole: Copy + Send + Sync + Into<f32> {
    /// The nearest integer.
    fn nearest(number: f32) -> Self;
}

impl Whole for u8 {
    fn nearest(number: f32) -> Self {
        number.round() as Self
    }
}

impl Whole for u16 {
    fn nearest(number: f32) -> Self {
        number.round() as Self
    }
}

/// Computes all levels of square layers, the finest first; `finest` is layer by layer, row by row, with `channels`
/// numbers per texel. `counts` are the weights of the texels, all above 0.
pub(crate) fn with_mipmaps<T: Whole>(finest: &[T], counts: &[f32], channels: usize, levels: u32) -> Vec<T> {
    let size = counts.len().isqrt();
    let length = size * size * channels;
    let mut all = finest.to_vec();
    for level in 1..levels {
        let side = (size >> level).max(1);
        let shares = shares(size, side);
        let layers = finest.par_chunks(length).map(|layer| reduced(layer, counts, channels, &shares));
        all.extend(layers.collect::<Vec<_>>().into_iter().flatten());
    }
    all
}

/// For each of `side` texels, the first of `size` texels that it covers, and the share of each covered texel; shares
/// sum to 1.
fn shares(size: usize, side: usize) -> Vec<(usize, Vec<f32>)> {
    let covered = |k: usize| {
        // In units of 1 / (size side), in which all borders are integers.
        let (from, to) = (k * size, (k + 1) * size);
        let (first, end) = (from / side, to.div_ceil(side));
        let share = |at: usize| ((to.min((at + 1) * side) - from.max(at * side)) as f32) / size as f32;
        (first, (first..end).map(share).collect())
    };
    (0..side).map(covered).collect()
}

fn reduced<T: Whole>(layer: &[T], counts: &[f32], channels: usize, shares: &[(usize, Vec<f32>)]) -> Vec<T> {
    let size = counts.len().isqrt();
    let mut bytes = Vec::with_capacity(shares.len() * shares.len() * channels);
    let (mut row, mut counted) = (vec![0.0f32; size * channels], vec![0.0f32; size]);
    for (first, rows) in shares {
        row.fill(0.0);
        counted.fill(0.0);
        for (k, share) in rows.iter().enumerate() {
            let at = (first + k) * size;
            let source = layer[at * channels..][..size * channels].chunks_exact(channels);
            let sums = row.chunks_exact_mut(channels).zip(&mut counted);
            for ((sums, counted), (numbers, count)) in sums.zip(source.zip(&counts[at..])) {
                *counted += share * count;
                sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += share * count * (*number).into());
            }
        }
        for (first, columns) in shares {
            let sum = |of: &dyn Fn(usize) -> f32| -> f32 {
                columns.iter().enumerate().map(|(k, share)| share * of(first + k)).sum()
            };
            let count = sum(&|column| counted[column]);
            for channel in 0..channels {
                bytes.push(T::nearest(sum(&|column| row[column * channels + channel]) / count));
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_means() {
        let finest: Vec<u8> = vec![0, 100, 8, 8, 100, 200, 8, 8, 1, 1, 50, 60, 1, 1, 70, 80];
        assert_eq!(with_mipmaps(&finest, &[1.0; 16], 1, 3)[16..], [100, 8, 1, 65, 44]);
        // Layers, then levels; channels do not mix.
        let two: Vec<u8> = finest.iter().flat_map(|byte| [*byte, 255]).collect();
        let both = [two.clone(), two].concat();
        let all = with_mipmaps(&both, &[1.0; 16], 2, 3);
        assert_eq!(all.len(), 2 * 2 * 21);
        assert_eq!(all[64..], [100, 255, 8, 255, 1, 255, 65, 255, 100, 255, 8, 255, 1, 255, 65, 255, 44, 255, 44, 255]);
    }

    #[test]
    fn texels_are_weighted_by_visibility() {
        let finest: Vec<u8> = vec![0, 100, 8, 8, 100, 200, 8, 8, 1, 1, 50, 60, 1, 1, 70, 80];
        let mut counts = [0.5; 16];
        counts[5] = 1e-6;
        (counts[10], counts[11], counts[14], counts[15]) = (1.0, 1.0, 1.0, 3.0);
        // A third of 0, 100 and 100; and (50 + 60 + 70 + 3 x 80) / 6.
        assert_eq!(with_mipmaps(&finest, &counts, 1, 2)[16..], [67, 8, 1, 70]);
    }

    #[test]
    fn odd_sides_share_texels() {
        // The first of two texels covers two and a half of five columns.
        let finest: Vec<u8> = (0..5).flat_map(|_| [10, 20, 30, 40, 50]).collect();
        assert_eq!(with_mipmaps(&finest, &[1.0; 25], 1, 3)[25..], [18, 42, 18, 42, 30]);
        assert!(shares(7, 3).iter().all(|(_, shares)| (shares.iter().sum::<f32>() - 1.0).abs() < 1e-6));
    }
}
