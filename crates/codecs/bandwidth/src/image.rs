//! Preparation of images for the transform.

use brdfc_formats::tap::Tap;
use rayon::prelude::*;

/// Colour channels one by one; a single one if all three are equal. Values that are not finite become 0.
pub fn channels(pixels: &[[f32; 3]]) -> impl Iterator<Item = Vec<f32>> {
    let grey = pixels.iter().all(|[r, g, b]| r == g && g == b);
    let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
    let channel = move |k: usize| pixels.par_iter().map(|pixel| finite(pixel[k])).collect();
    (0..if grey { 1 } else { 3 }).map(channel)
}

/// One axis of a resampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Axis {
    /// Number of input samples.
    pub from: usize,
    /// Number of output samples.
    pub to: usize,
    /// True if the axis repeats; otherwise it is extrapolated from the last two samples.
    pub wraps: bool,
}

impl Axis {
    /// Two neighbours and the weight of the second, for an output sample. Sample centres are at `i + ½`.
    fn tap(self, i: usize) -> ([usize; 2], f32) {
        let at = (i as f64 + 0.5) * self.from as f64 / self.to as f64 - 0.5;
        if self.wraps || self.from == 1 {
            let tap = Tap::around_f64(at, self.from as u32, true);
            return (tap.indices(), tap.weight);
        }
        let lower = (at.floor() as i64).clamp(0, self.from as i64 - 2) as usize;
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

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(channels(&[[1.0, f32::NAN, 2.0], [f32::INFINITY, 1.0, 0.5]]).count(), 3);
        assert!(channels(&[[2.0; 3]]).eq([[2.0]]));
    }
}
