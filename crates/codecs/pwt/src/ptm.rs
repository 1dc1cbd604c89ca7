//! Polynomial texture maps (Malzbender, Gelb and Wolters 2001): the format of viewers for reflectance transformation
//! imaging, and the baseline for trees. Also renderings of such maps and of other files of these viewers.

use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::Domain;
use brdfc_readers::colour::decode_srgb;
use brdfc_readers::ptm::{Ptm, TERMS, terms};
use brdfc_readers::viewer_file::ViewerFile;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;

/// Singular values below this share of the largest count as 0: components that the lights do not determine stay small.
const SINGULAR: f64 = 1e-6;

/// Unit vectors above the horizon, spread evenly: a spiral (Vogel 1979) from the pole to a polar angle of 84 degrees.
pub fn spread_lights(count: usize) -> Vec<[f32; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let light = |k: usize| {
        let z = 1.0 - 0.9 * (k as f64 + 0.5) / count as f64;
        let (r, azimuth) = ((1.0 - z * z).sqrt(), golden * k as f64);
        [r * azimuth.cos(), r * azimuth.sin(), z].map(|c| c as f32)
    };
    (0..count).map(light).collect()
}

/// Images that a map shows under some lights.
pub fn images_of(map: &dyn ViewerFile, lights: Vec<[f32; 3]>) -> LightSamples {
    let rows = 0..map.size()[1] as usize;
    samples(map, lights, |light| image_rows(map, light, rows.clone()))
}

/// Unclamped values of a map's functions under some lights, including above white and below black. The functions can
/// be recovered from them.
pub fn samples_of(map: &dyn ViewerFile, lights: Vec<[f32; 3]>) -> LightSamples {
    let rows = 0..map.size()[1] as usize;
    samples(map, lights, |light| linear_rows(map, light, rows.clone(), |level| level))
}

fn samples(
    map: &dyn ViewerFile,
    lights: Vec<[f32; 3]>,
    image: impl Fn([f32; 3]) -> Vec<[f32; 3]> + Sync,
) -> LightSamples {
    let size = map.size().map(|side| side as usize);
    let images: Vec<Vec<[f32; 3]>> = lights.par_iter().map(|light| image(*light)).collect();
    LightSamples::new(size, lights, images)
}

/// Linear RGB of some rows of a map under a light.
///
/// # Panics
/// Panics if the map has no such rows.
pub fn image_rows(map: &dyn ViewerFile, light: [f32; 3], rows: Range<usize>) -> Vec<[f32; 3]> {
    linear_rows(map, light, rows, |level| level.clamp(0.0, 255.0))
}

fn linear_rows(map: &dyn ViewerFile, light: [f32; 3], rows: Range<usize>, shown: impl Fn(f64) -> f64) -> Vec<[f32; 3]> {
    let (width, levels) = (map.size()[0] as usize, map.under(light));
    let linear = |level: f64| decode_srgb(shown(level) / 255.0) as f32;
    (rows.start * width..rows.end * width).map(|pixel| levels(pixel).map(linear)).collect()
}

/// Layout of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MapModel {
    /// A polynomial for each channel.
    Rgb,
    /// One polynomial for luminance, multiplied by a colour.
    Lrgb,
}

/// Fits a map to photographs by least squares of sRGB-encoded values.
///
/// # Errors
/// Returns an error if images are out of range, or if the format does not have the size.
pub fn fit_map(samples: &LightSamples, model: MapModel) -> Result<Ptm, FormatError> {
    samples.check()?;
    let count = samples.size[0] * samples.size[1];
    let size = samples.size.map(|side| side as u32);
    let matrix = DMatrix::from_fn(samples.lights.len(), TERMS, |light, term| {
        let [x, y, _] = samples.lights[light];
        terms([x, y])[term]
    });
    let singular = SINGULAR * matrix.singular_values().max();
    let inverse = matrix.pseudo_inverse(singular).expect("the bound is positive");
    let codes: Vec<Vec<[f32; 3]>> = samples.images.par_iter().map(|image| codes(&image.linear(0..count))).collect();
    let fitted = |values: &dyn Fn(usize) -> f64| -> [f32; TERMS] {
        let mut coefficients = [0.0f64; TERMS];
        for light in 0..codes.len() {
            let value = values(light);
            coefficients.iter_mut().enumerate().for_each(|(term, sum)| *sum += inverse[(term, light)] * value);
        }
        coefficients.map(|c| c as f32)
    };
    match model {
        MapModel::Rgb => {
            let pixel = |at: usize| [0, 1, 2].map(|c| fitted(&|light| 255.0 * f64::from(codes[light][at][c])));
            let pixels: Vec<_> = (0..count).into_par_iter().map(pixel).collect();
            Ptm::from_coefficients_rgb(size, &pixels)
        }
        MapModel::Lrgb => {
            let pixel = |at: usize| {
                let mut sum = [0.0f64; 3];
                for image in &codes {
                    sum.iter_mut().zip(image[at]).for_each(|(sum, code)| *sum += f64::from(code));
                }
                let most = sum.into_iter().fold(0.0, f64::max);
                let colour = sum.map(|s| if most > 0.0 { (255.0 * s / most).round() } else { 255.0 });
                let square: f64 = colour.iter().map(|c| c * c).sum();
                // The image is the product of light and colour: the factor whose product is nearest to the encoded
                // value.
                let luminance = |light: usize| {
                    let code = codes[light][at].map(f64::from);
                    255.0 * 255.0 * colour.iter().zip(code).map(|(a, b)| a * b).sum::<f64>() / square
                };
                (fitted(&luminance), colour.map(|c| c as u8))
            };
            let (luminance, colour): (Vec<_>, Vec<_>) = (0..count).into_par_iter().map(pixel).unzip();
            Ptm::from_coefficients_lrgb(size, &luminance, &colour)
        }
    }
}

/// sRGB-encoded values, 0 to 1.
pub(crate) fn codes(image: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut codes = image.to_vec();
    codes.as_flattened_mut().iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
    Domain::Display.encode_each(codes.as_flattened_mut());
    codes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answer: a map sampled under many lights is recovered; other lights are the negative control.
    #[test]
    fn a_map_is_recovered() {
        let coefficients = [[-30.0, -20.0, 10.0, 40.0, -25.0, 140.0], [5.0; 6], [0.0, 0.0, 0.0, 0.0, 0.0, 200.0]];
        let map =
            Ptm::from_coefficients_rgb([2, 1], &[coefficients, coefficients.map(|c| c.map(|c| 0.5 * c))]).unwrap();
        let samples = images_of(&map, spread_lights(60));
        let found = fit_map(&samples, MapModel::Rgb).unwrap();
        let wrong = LightSamples { lights: samples.lights.iter().map(|[x, y, z]| [-x, -y, *z]).collect(), ..samples };
        let wrong = fit_map(&wrong, MapModel::Rgb).unwrap();
        for (pixel, light) in [(0, [0.3, 0.2]), (1, [-0.5, 0.4]), (0, [0.0, 0.0])] {
            let [a, b, c] = [&map, &found, &wrong].map(|map| map.value(pixel, light));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2.0), "{a:?} {b:?}");
            assert!(light == [0.0; 2] || (a[0] - c[0]).abs() > 5.0, "{a:?} {c:?}");
        }
    }

    #[test]
    fn luminance_and_colour_of_one_hue() {
        let coefficients = [[-30.0, -20.0, 0.0, 40.0, -25.0, 140.0]];
        let map = Ptm::from_coefficients_lrgb([1, 1], &coefficients, &[[255, 128, 64]]).unwrap();
        let samples = images_of(&map, spread_lights(60));
        let found = fit_map(&samples, MapModel::Lrgb).unwrap();
        for light in [[0.3, 0.2], [-0.5, 0.4]] {
            let [a, b] = [&map, &found].map(|map| map.value(0, light));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2.0), "{a:?} {b:?}");
        }
    }
}
