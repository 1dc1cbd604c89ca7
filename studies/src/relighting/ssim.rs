//! Structural similarity of images (Wang, Bovik, Sheikh and Simoncelli 2004), of grey levels.

use brdfc_formats::pwt::Domain;
use brdfc_pwt::LightSamples;
use brdfc_readers::pixels::Pixels;
use rayon::prelude::*;

/// Standard deviation of the window, pixels.
const WIDTH: f64 = 1.5;
/// Pixels of the window on both sides of the middle.
const REACH: isize = 5;

/// Mean over the photographs, at their sRGB-encoded grey levels.
pub(super) fn similarity(found: &LightSamples, expected: &LightSamples) -> f64 {
    let size = expected.size;
    let grey = |image: &Pixels| grey(&image.linear(0..image.len()));
    let of = |(a, b): (&Pixels, &Pixels)| of_images(&grey(a), &grey(b), size);
    let all: Vec<f64> = found.images.par_iter().zip(&expected.images).map(of).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

fn grey(image: &[[f32; 3]]) -> Vec<f64> {
    let mut codes: Vec<[f32; 3]> = image.iter().map(|pixel| pixel.map(|c| c.clamp(0.0, 1.0))).collect();
    Domain::Display.encode_each(codes.as_flattened_mut());
    codes.iter().map(|[r, g, b]| 0.299 * f64::from(*r) + 0.587 * f64::from(*g) + 0.114 * f64::from(*b)).collect()
}

fn of_images(a: &[f64], b: &[f64], size: [usize; 2]) -> f64 {
    const STABLE: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];
    let product = |a: &[f64], b: &[f64]| blurred(&a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>(), size);
    let (mean_a, mean_b) = (blurred(a, size), blurred(b, size));
    let (aa, bb, ab) = (product(a, a), product(b, b), product(a, b));
    let at = |k: usize| {
        let (m, n) = (mean_a[k], mean_b[k]);
        let (variances, covariance) = (aa[k] - m * m + bb[k] - n * n, ab[k] - m * n);
        (2.0 * m * n + STABLE[0]) * (2.0 * covariance + STABLE[1])
            / ((m * m + n * n + STABLE[0]) * (variances + STABLE[1]))
    };
    (0..a.len()).map(at).sum::<f64>() / a.len() as f64
}

/// Gaussian means along both axes, within the image.
fn blurred(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    let weights: Vec<f64> = (-REACH..=REACH).map(|k| (-0.5 * (k as f64 / WIDTH).powi(2)).exp()).collect();
    let along = |values: &[f64], at: &dyn Fn(usize, isize) -> Option<usize>| -> Vec<f64> {
        let mean = |k: usize| {
            let taps = (-REACH..=REACH).zip(&weights).filter_map(|(step, weight)| at(k, step).map(|at| (at, weight)));
            let (sum, whole) = taps.fold((0.0, 0.0), |(sum, whole), (at, w)| (sum + w * values[at], whole + w));
            sum / whole
        };
        (0..values.len()).map(mean).collect()
    };
    let inside = |k: usize, step: isize, count: usize| k.checked_add_signed(step).filter(|at| *at < count);
    let rows = along(values, &|k, step| inside(k % width, step, width).map(|x| k - k % width + x));
    along(&rows, &|k, step| inside(k / width, step, height).map(|y| y * width + k % width))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers: 1 for equal images; a constant offset changes only the means; noise of no structure is near 0.
    #[test]
    fn known_similarities() {
        let size = [24, 20];
        let image: Vec<f64> = (0..480).map(|k| 0.5 + 0.3 * (k as f64 * 0.7).sin()).collect();
        assert!((of_images(&image, &image, size) - 1.0).abs() < 1e-12);
        let [flat, brighter] = [0.5, 0.6].map(|level| vec![level; 480]);
        let expected = (2.0 * 0.5 * 0.6 + 1e-4) / (0.25 + 0.36 + 1e-4);
        assert!((of_images(&flat, &brighter, size) - expected).abs() < 1e-9);
        let negative: Vec<f64> = image.iter().map(|v| 1.0 - v).collect();
        assert!(of_images(&image, &negative, size) < 0.0);
    }
}
