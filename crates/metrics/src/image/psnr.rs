//! PSNR, the peak signal-to-noise ratio.

use super::LinearImage;
use brdfc_readers::colour::encode_srgb;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Mean squared error of an image, also in decibels, of displayed sRGB-encoded values: `encode(clamp(exposure *
/// radiance, 0, 1))`, white = 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SignalToNoise {
    /// Pixels that show a surface in either image; the measures are over these.
    pub pixels: usize,
    /// Number of these pixels that are not finite in either image, and are ignored.
    pub invalid_pixels: usize,
    /// Mean over pixels and channels of the squared difference, 0 to 1.
    pub mean_squared_error: f64,
    /// `-10 log10(mean_squared_error)`, dB; absent (infinite) if there is no difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
}

/// Compares an image with a reference of the same size, as displayed at this exposure.
///
/// # Panics
/// Panics if sizes differ.
pub fn signal_to_noise(image: &LinearImage, reference: &LinearImage, exposure: f64) -> SignalToNoise {
    assert_eq!((image.width, image.height), (reference.width, reference.height), "images of one size");
    let covered = |pixel: &usize| image.coverage[*pixel] > 0.0 || reference.coverage[*pixel] > 0.0;
    let shown: Vec<usize> = (0..image.pixels.len()).filter(covered).collect();
    let squares: Vec<Option<f64>> = shown
        .par_iter()
        .map(|pixel| squared_difference(image.pixels[*pixel], reference.pixels[*pixel], exposure))
        .collect();
    let valid = squares.iter().flatten().count();
    let sum: f64 = squares.iter().flatten().sum();
    let mean_squared_error = sum / (3 * valid.max(1)) as f64;
    SignalToNoise {
        pixels: shown.len(),
        invalid_pixels: shown.len() - valid,
        mean_squared_error,
        psnr: decibels(mean_squared_error),
    }
}

/// `-10 log10` of a mean squared error; `None` for 0.
pub(super) fn decibels(mean_squared_error: f64) -> Option<f64> {
    (mean_squared_error > 0.0).then(|| -10.0 * mean_squared_error.log10())
}

/// Sum over channels of squared differences of encoded values; `None` where either pixel is not finite.
pub(super) fn squared_difference(a: [f32; 3], b: [f32; 3], exposure: f64) -> Option<f64> {
    if a.iter().chain(&b).any(|c| !c.is_finite()) {
        return None;
    }
    if a == b {
        return Some(0.0);
    }
    let shown = |c: f32| encode_srgb((f64::from(c) * exposure).clamp(0.0, 1.0));
    Some((0..3).map(|k| (shown(a[k]) - shown(b[k])).powi(2)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_readers::colour::decode_srgb;

    fn image(pixels: &[[f32; 3]]) -> LinearImage {
        LinearImage {
            pixels: pixels.to_vec(),
            coverage: vec![1.0; pixels.len()],
            ..LinearImage::black(pixels.len(), 1)
        }
    }

    #[test]
    fn an_offset_of_a_tenth_is_20_decibels() {
        let linear = |v: f64| decode_srgb(v) as f32;
        let [a, b] = [0.2, 0.3].map(|v| image(&[[linear(v); 3], [linear(v); 3]]));
        let found = signal_to_noise(&a, &b, 1.0);
        assert!(
            (found.mean_squared_error - 0.01).abs() < 1e-7 && (found.psnr.unwrap() - 20.0).abs() < 1e-4,
            "{found:?}"
        );
        // Control: differences of linear values are others.
        let linear_difference = f64::from(linear(0.3) - linear(0.2)).powi(2);
        assert!((linear_difference - 0.01).abs() > 1e-3);
        // Half the pixels differ: half the error, 3 dB more.
        let half = signal_to_noise(&image(&[a.pixels[0], b.pixels[0]]), &b, 1.0);
        assert!((half.psnr.unwrap() - 20.0 - 10.0 * 2f64.log10()).abs() < 1e-4, "{half:?}");
    }

    #[test]
    fn black_and_white_is_0_and_no_difference_is_no_number() {
        let (black, white) = (image(&[[0.0; 3]]), image(&[[1.0; 3]]));
        let found = signal_to_noise(&black, &white, 1.0);
        assert!((found.mean_squared_error - 1.0).abs() < 1e-12 && found.psnr.unwrap().abs() < 1e-12, "{found:?}");
        let found = signal_to_noise(&white, &white, 1.0);
        assert_eq!((found.mean_squared_error, found.psnr), (0.0, None));
        assert!(!serde_json::to_string(&found).unwrap().contains("psnr"));
        assert_eq!(signal_to_noise(&LinearImage::black(2, 2), &LinearImage::black(2, 2), 1.0).pixels, 0);
    }

    #[test]
    fn exposure_comes_before_the_clip() {
        let (a, b) = (image(&[[2.0; 3]]), image(&[[3.0; 3]]));
        assert_eq!(signal_to_noise(&a, &b, 1.0).psnr, None);
        let found = signal_to_noise(&a, &b, 0.25);
        let expected = (encode_srgb(0.75) - encode_srgb(0.5)).powi(2);
        assert!((found.mean_squared_error - expected).abs() < 1e-12);
    }

    #[test]
    fn background_and_non_finite_pixels_are_left_out() {
        let mut a = image(&[[0.5; 3], [0.2; 3], [f32::NAN; 3]]);
        let mut b = image(&[[0.5; 3], [0.9; 3], [0.5; 3]]);
        (a.coverage[1], b.coverage[1]) = (0.0, 0.0);
        let found = signal_to_noise(&a, &b, 1.0);
        assert_eq!((found.pixels, found.invalid_pixels, found.psnr), (2, 1, None));
        // Control: where one image shows a surface the difference counts.
        b.coverage[1] = 0.1;
        assert!(signal_to_noise(&a, &b, 1.0).psnr.unwrap() < 20.0);
    }
}
