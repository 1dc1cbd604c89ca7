//! Images on their way into the transform and maps on their way out.

use rayon::prelude::*;

/// Colour channels one by one; a single one where all three are equal. What is no finite number becomes 0.
pub fn channels(pixels: &[[f32; 3]]) -> Vec<Vec<f32>> {
    let grey = pixels.iter().all(|[r, g, b]| r == g && g == b);
    let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
    let channel = |k: usize| pixels.par_iter().map(|pixel| finite(pixel[k])).collect();
    (0..if grey { 1 } else { 3 }).map(channel).collect()
}

/// One axis of a resampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// Samples.
    pub from: usize,
    /// Samples wanted.
    pub to: usize,
    /// Whether the axis repeats; else it goes on as its last two samples do.
    pub wraps: bool,
}

impl Axis {
    /// Two neighbours and the weight of the second, for a wanted sample. Sample centres are at `i + ½`.
    fn tap(self, i: usize) -> ([usize; 2], f32) {
        let at = (i as f64 + 0.5) * self.from as f64 / self.to as f64 - 0.5;
        let lower = at.floor() as i64;
        if self.wraps || self.from == 1 {
            let index = |i: i64| i.rem_euclid(self.from as i64) as usize;
            return ([index(lower), index(lower + 1)], (at - at.floor()) as f32);
        }
        let lower = lower.clamp(0, self.from as i64 - 2) as usize;
        ([lower, lower + 1], (at - lower as f64) as f32)
    }
}

/// Bilinear resampling of an image, row by row.
pub fn resample(image: Vec<f32>, u: Axis, v: Axis) -> Vec<f32> {
    if u.from == u.to && v.from == v.to {
        return image;
    }
    let columns: Vec<_> = (0..u.to).map(|i| u.tap(i)).collect();
    let mut resampled = vec![0.0; u.to * v.to];
    resampled.par_chunks_exact_mut(u.to).enumerate().for_each(|(row, target)| {
        let ([a, b], t) = v.tap(row);
        let (above, below) = (&image[a * u.from..][..u.from], &image[b * u.from..][..u.from]);
        for (value, ([c, d], s)) in target.iter_mut().zip(&columns) {
            let (top, bottom) = (above[*c] + s * (above[*d] - above[*c]), below[*c] + s * (below[*d] - below[*c]));
            *value = top + t * (bottom - top);
        }
    });
    resampled
}

/// A latitude-longitude image continued over both poles: row `-1` at azimuth φ is row 0 at `φ + π`, so that `2 height` rows
/// go once around, and both axes span 2π. `width` is even.
pub fn continue_over_poles(image: &[f32], width: usize, height: usize) -> Vec<f32> {
    let mut torus = vec![0.0; 2 * image.len()];
    torus.par_chunks_exact_mut(width).enumerate().for_each(|(row, target)| {
        if row < height {
            target.copy_from_slice(&image[row * width..][..width]);
        } else {
            let (first, second) = image[(2 * height - 1 - row) * width..][..width].split_at(width / 2);
            target[..width / 2].copy_from_slice(second);
            target[width / 2..].copy_from_slice(first);
        }
    });
    torus
}

/// A map reduced by maximum to at most `most` per axis, each axis by a power of two that divides it. Returns the values with
/// their width and height.
pub fn reduce_by_maximum(values: Vec<f32>, size: [usize; 2], most: [usize; 2]) -> (Vec<f32>, [usize; 2]) {
    let factor = |axis: usize| {
        let mut factor = 1;
        while size[axis] / factor > most[axis] && (size[axis] / factor).is_multiple_of(2) {
            factor *= 2;
        }
        factor
    };
    let [across, down] = [factor(0), factor(1)];
    if across == 1 && down == 1 {
        return (values, size);
    }
    let [width, height] = [size[0] / across, size[1] / down];
    let mut reduced = vec![0.0f32; width * height];
    reduced.par_chunks_exact_mut(width).enumerate().for_each(|(row, target)| {
        for source in values[row * down * size[0]..][..down * size[0]].chunks_exact(size[0]) {
            for (value, cell) in target.iter_mut().zip(source.chunks_exact(across)) {
                *value = cell.iter().copied().fold(*value, f32::max);
            }
        }
    });
    (reduced, [width, height])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_maximum_is_no_mean() {
        let mut values = vec![1.0; 64];
        values[3 * 8 + 5] = 9.0;
        let (reduced, size) = reduce_by_maximum(values.clone(), [8, 8], [2, 4]);
        assert_eq!((size, reduced), ([2, 4], vec![1.0, 1.0, 1.0, 9.0, 1.0, 1.0, 1.0, 1.0]));
        assert_eq!(reduce_by_maximum(values.clone(), [8, 8], [8, 8]).0, values);
    }

    #[test]
    fn rows_go_on_behind_the_pole() {
        let image: Vec<f32> = (0..8).map(|i| i as f32).collect();
        let torus = continue_over_poles(&image, 4, 2);
        assert_eq!(torus, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 6.0, 7.0, 4.0, 5.0, 2.0, 3.0, 0.0, 1.0]);
    }

    #[test]
    fn waves_survive_resampling() {
        let wave = |n: usize| (0..n).map(move |i| (std::f64::consts::TAU * (i as f64 + 0.5) / n as f64).sin() as f32);
        let (u, v) = (Axis { from: 96, to: 128, wraps: true }, Axis { from: 1, to: 2, wraps: false });
        let found = resample(wave(96).collect(), u, v);
        for (i, expected) in wave(128).enumerate() {
            assert!((found[i] - expected).abs() < 1e-3 && found[i] == found[i + 128]);
        }
        let ends =
            resample(vec![1.0, 3.0], Axis { from: 2, to: 4, wraps: false }, Axis { from: 1, to: 1, wraps: false });
        assert_eq!(ends, [0.5, 1.5, 2.5, 3.5]);
        assert_eq!(channels(&[[1.0, f32::NAN, 2.0], [f32::INFINITY, 1.0, 0.5]]).len(), 3);
        assert_eq!(channels(&[[2.0; 3]]), [[2.0]]);
    }
}
