//! Colour differences between two images.

use super::LinearImage;
use super::psnr::{decibels, squared_difference};
use palette::color_difference::{Ciede2000, EuclideanDistance};
use palette::white_point::D65;
use palette::{IntoColor, Lab, LinSrgb};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// Mean, standard deviation and upper end of a measure over pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, serde::Deserialize, JsonSchema)]
pub struct Spread {
    /// Mean over pixels.
    pub mean: f64,
    /// Standard deviation over pixels.
    pub standard_deviation: f64,
    /// 95th percentile over pixels.
    pub p95: f64,
    /// Maximum over pixels.
    pub max: f64,
}

/// Differences of an image from a reference, as displayed: `clamp(exposure * radiance, 0, 1)`, white = 1.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ImageDifference {
    /// Pixels that show a surface in either image; the measures below are over these.
    pub pixels: usize,
    /// Number of these pixels that are not finite in either image, and are ignored.
    pub invalid_pixels: usize,
    /// ΔE (CIE76), the distance in CIE L*a*b* with white D65: the measure of Claustres et al. 2007, section 6.3.
    pub delta_e: Spread,
    /// ΔE (CIE76) over all pixels, background included.
    pub delta_e_whole_image: Spread,
    /// Colour difference CIEDE2000 over the same pixels as `delta_e`.
    pub delta_e_2000: Spread,
    /// PSNR of sRGB-encoded values, dB; absent if there is no difference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f64>,
}

/// Relative luminance of linear RGB, Rec. 709.
pub fn luminance(pixel: [f32; 3]) -> f64 {
    brdfc_core::luminance(pixel.map(f64::from))
}

/// The factor that takes the 99th percentile of luminance over surfaces to 1: the brightest 1 % clip. 1 for images
/// without light.
pub fn auto_exposure(image: &LinearImage) -> f64 {
    let covered = image.pixels.iter().zip(&image.coverage).filter(|(_, coverage)| **coverage > 0.0);
    let mut values: Vec<f64> = covered.map(|(pixel, _)| luminance(*pixel)).filter(|y| y.is_finite()).collect();
    let bright = percentile(&mut values, 0.99);
    if bright > 0.0 { 1.0 / bright } else { 1.0 }
}

/// ΔE (CIE76) per pixel; 0 where either image is not finite.
pub fn delta_e_map(image: &LinearImage, reference: &LinearImage, exposure: f64) -> Vec<f32> {
    let map = |(a, b): (&[f32; 3], &[f32; 3])| {
        pixel_difference(*a, *b, exposure).map_or(0.0, |difference| difference.delta_e as f32)
    };
    image.pixels.par_iter().zip(&reference.pixels).map(map).collect()
}

/// Compares an image with a reference of the same size.
///
/// # Panics
/// Panics if sizes differ.
pub fn compare_images(image: &LinearImage, reference: &LinearImage, exposure: f64) -> ImageDifference {
    assert_eq!((image.width, image.height), (reference.width, reference.height), "images of one size");
    let all: Vec<Option<PixelDifference>> =
        image.pixels.par_iter().zip(&reference.pixels).map(|(a, b)| pixel_difference(*a, *b, exposure)).collect();
    let covered = |pixel: usize| image.coverage[pixel] > 0.0 || reference.coverage[pixel] > 0.0;
    let on_surfaces: Vec<&Option<PixelDifference>> =
        all.iter().enumerate().filter(|(pixel, _)| covered(*pixel)).map(|(_, difference)| difference).collect();
    let valid: Vec<&PixelDifference> = on_surfaces.iter().filter_map(|difference| difference.as_ref()).collect();
    let squares: f64 = valid.iter().map(|difference| difference.squared).sum();
    let mean_square = squares / (3 * valid.len().max(1)) as f64;
    ImageDifference {
        pixels: on_surfaces.len(),
        invalid_pixels: on_surfaces.len() - valid.len(),
        delta_e: spread(valid.iter().map(|d| d.delta_e).collect()),
        delta_e_whole_image: spread(all.iter().flatten().map(|d| d.delta_e).collect()),
        delta_e_2000: spread(valid.iter().map(|d| d.delta_e_2000).collect()),
        psnr: decibels(mean_square),
    }
}

struct PixelDifference {
    delta_e: f64,
    delta_e_2000: f64,
    /// Sum over channels of squared differences of sRGB-encoded values.
    squared: f64,
}

fn pixel_difference(a: [f32; 3], b: [f32; 3], exposure: f64) -> Option<PixelDifference> {
    let squared = squared_difference(a, b, exposure)?;
    if a == b {
        return Some(PixelDifference { delta_e: 0.0, delta_e_2000: 0.0, squared: 0.0 });
    }
    let (delta_e, delta_e_2000) = colour_difference(shown_colour(a, exposure), shown_colour(b, exposure));
    Some(PixelDifference { delta_e, delta_e_2000, squared })
}

/// Displayed colour of a pixel.
pub(crate) fn shown_colour(pixel: [f32; 3], exposure: f64) -> Lab<D65, f64> {
    let [r, g, b] = pixel.map(|c| (f64::from(c) * exposure).clamp(0.0, 1.0));
    LinSrgb::<f64>::new(r, g, b).into_color()
}

/// ΔE (CIE76) and CIEDE2000 of two colours.
pub(crate) fn colour_difference(a: Lab<D65, f64>, b: Lab<D65, f64>) -> (f64, f64) {
    (a.distance(b), Ciede2000::difference(a, b))
}

/// Statistics of the values of pixels.
pub(crate) fn spread(mut values: Vec<f64>) -> Spread {
    if values.is_empty() {
        return Spread::default();
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
    let p95 = percentile(&mut values, 0.95);
    let max = values.iter().fold(0.0, |a: f64, b| a.max(*b));
    Spread { mean, standard_deviation: variance.sqrt(), p95, max }
}

/// The value at a percentile; 0 without values.
fn percentile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let at = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(pixels: &[[f32; 3]]) -> LinearImage {
        LinearImage {
            width: pixels.len(),
            height: 1,
            pixels: pixels.to_vec(),
            coverage: vec![1.0; pixels.len()],
            background: [0.0; 3],
        }
    }

    #[test]
    fn equal_images_have_no_difference() {
        let a = image(&[[0.1, 0.5, 0.9], [4.0, 0.0, 0.2]]);
        let d = compare_images(&a, &a, 1.0);
        assert_eq!((d.delta_e, d.delta_e_2000, d.psnr), (Spread::default(), Spread::default(), None));
        assert_eq!(d.pixels, 2);
    }

    /// L*a*b* of the sRGB primaries as published, D65: red 53.24, 80.09, 67.20; green 87.73, -86.18, 83.18; white 100.
    #[test]
    fn the_distance_of_red_and_green() {
        let d = compare_images(&image(&[[1.0, 0.0, 0.0]]), &image(&[[0.0, 1.0, 0.0]]), 1.0);
        let expected = ((53.24f64 - 87.73).powi(2) + (80.09f64 + 86.18).powi(2) + (67.20f64 - 83.18).powi(2)).sqrt();
        assert!((d.delta_e.mean - expected).abs() < 0.05, "{} {expected}", d.delta_e.mean);
        let white = compare_images(&image(&[[1.0; 3]]), &image(&[[0.0; 3]]), 1.0);
        assert!((white.delta_e.mean - 100.0).abs() < 1e-3);
        assert!(white.psnr.unwrap().abs() < 1e-9);
    }

    /// Rows of Sharma, Wu and Dalal 2005, table 1.
    #[test]
    fn ciede2000_of_published_pairs() {
        for ([l1, a1, b1], [l2, a2, b2], expected) in [
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
        ] {
            let (a, b) = (Lab::<D65, f64>::new(l1, a1, b1), Lab::<D65, f64>::new(l2, a2, b2));
            assert!((Ciede2000::difference(a, b) - expected).abs() < 1e-4);
        }
    }

    #[test]
    fn the_ratio_of_a_known_offset() {
        // Encoded 0.5 and 0.6.
        let linear = |v: f64| ((v + 0.055) / 1.055).powf(2.4) as f32;
        let d = compare_images(&image(&[[linear(0.5); 3]]), &image(&[[linear(0.6); 3]]), 1.0);
        assert!((d.psnr.unwrap() - 20.0).abs() < 1e-3);
    }

    #[test]
    fn values_beyond_white_do_not_count() {
        let d = compare_images(&image(&[[3.0; 3]]), &image(&[[5.0; 3]]), 1.0);
        assert_eq!(d.delta_e.max, 0.0);
        // Control: at a lower exposure it does.
        assert!(compare_images(&image(&[[3.0; 3]]), &image(&[[5.0; 3]]), 0.1).delta_e.max > 1.0);
    }

    #[test]
    fn pixels_without_a_number_are_counted_and_left_out() {
        let a = image(&[[f32::NAN, 0.0, 0.0], [0.5; 3]]);
        let b = image(&[[0.5; 3], [0.5; 3]]);
        let d = compare_images(&a, &b, 1.0);
        assert_eq!((d.pixels, d.invalid_pixels, d.delta_e.max), (2, 1, 0.0));
        assert!(delta_e_map(&a, &b, 1.0).iter().all(|e| *e == 0.0));
        assert!(auto_exposure(&a).is_finite());
    }

    #[test]
    fn background_is_left_out_of_all_but_the_whole_image() {
        let mut a = image(&[[0.5; 3], [0.5; 3]]);
        let mut b = image(&[[0.5; 3], [0.1; 3]]);
        (a.coverage[1], b.coverage[1]) = (0.0, 0.0);
        let d = compare_images(&a, &b, 1.0);
        assert_eq!((d.pixels, d.delta_e.max), (1, 0.0));
        assert!(d.delta_e_whole_image.max > 10.0);
    }

    #[test]
    fn exposure_takes_the_brightest_surfaces_to_white() {
        let mut pixels = vec![[0.2; 3]; 980];
        pixels.extend([[0.5; 3]; 15]);
        pixels.extend([[100.0; 3]; 5]);
        assert!((auto_exposure(&image(&pixels)) - 2.0).abs() < 1e-6);
        assert_eq!(auto_exposure(&image(&[[0.0; 3]])), 1.0);
    }
}
