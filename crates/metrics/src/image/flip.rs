//! FLIP: visible difference between two images that alternate at the same place.
//!
//! After Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference Evaluator for
//! Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), the version for low dynamic range: sections 4.1
//! (colour), 4.2 (features) and 4.3 (both).

use super::LinearImage;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Default pixels per degree of visual angle: a display of 0.7 m and 3840 pixels at 0.7 m (section 5).
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Contrast sensitivity of the opponent channels (section 4.1.1, table 1): `[a, b]` of sums of Gaussians
/// `a √(π/b) exp(-π² x² / b)`, x in degrees. Achromatic, red-green, blue-yellow.
const SENSITIVITY: [&[[f64; 2]]; 3] = [&[[1.0, 0.0047]], &[[1.0, 0.0053]], &[[34.1, 0.04], [13.5, 0.025]]];
/// Exponent of colour differences (section 4.1.3).
const COLOUR_EXPONENT: f64 = 0.7;
/// Colour differences up to this share of the largest ...
const KNEE: f64 = 0.4;
/// ... are mapped to this share of the range.
const KNEE_VALUE: f64 = 0.95;
/// Width of the feature filters in degrees, and exponent of feature differences (section 4.2).
const FEATURE_WIDTH: f64 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;

/// CIE XYZ of linear RGB (IEC 61966-2-1), and back.
const TO_XYZ: [[f64; 3]; 3] = [
    [0.412_390_799_265_959_5, 0.357_584_339_383_877_96, 0.180_480_788_401_834_3],
    [0.212_639_005_871_510_36, 0.715_168_678_767_755_9, 0.072_192_315_360_733_71],
    [0.019_330_818_715_591_85, 0.119_194_779_794_625_99, 0.950_532_152_249_660_6],
];
const FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_904_521, -1.537_383_177_570_093, -0.498_610_760_293],
    [-0.969_243_636_280_87, 1.875_967_501_507_72, 0.041_555_057_407_175_61],
    [0.055_630_079_696_993_66, -0.203_976_958_888_976_52, 1.056_971_514_242_878_6],
];

/// Differences of an image from a reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// Per pixel, 0 (no difference) to 1.
    pub map: Vec<f32>,
    /// Mean over all pixels.
    pub mean: f64,
    /// Mean over the pixels that show a surface in either image; 0 if none does.
    pub mean_on_surfaces: f64,
}

/// FLIP of an image and a reference of the same size, as displayed: `clamp(exposure * radiance, 0, 1)` over the
/// background. Values that are not finite count as black. Pixels beyond the border repeat the outermost ones.
///
/// `pixels_per_degree`: of visual angle, above 0; see [`PIXELS_PER_DEGREE`].
///
/// # Panics
/// Panics if sizes differ, or `pixels_per_degree` is not a positive number.
pub fn flip(image: &LinearImage, reference: &LinearImage, exposure: f64, pixels_per_degree: f64) -> Flip {
    assert_eq!((image.width, image.height), (reference.width, reference.height), "images of one size");
    assert!(pixels_per_degree > 0.0 && pixels_per_degree.is_finite(), "pixels per degree");
    if image.pixels.is_empty() {
        return Flip { map: Vec::new(), mean: 0.0, mean_on_surfaces: 0.0 };
    }
    let [a, b] = [image, reference].map(|image| Seen::new(image, exposure, pixels_per_degree));
    let largest = largest_colour_difference();
    let difference = |pixel: usize| {
        let colour = redistributed(hyab(a.colours[pixel], b.colours[pixel]), largest);
        let feature = (a.edges[pixel] - b.edges[pixel]).abs().max((a.points[pixel] - b.points[pixel]).abs());
        let feature = (feature * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT);
        // Section 4.3.
        colour.powf(1.0 - feature)
    };
    let map: Vec<f32> = (0..image.pixels.len()).into_par_iter().map(difference).collect();
    let covered = |pixel: &usize| image.coverage[*pixel] > 0.0 || reference.coverage[*pixel] > 0.0;
    let on_surfaces: Vec<f64> = (0..map.len()).filter(covered).map(|pixel| f64::from(map[pixel])).collect();
    let mean = map.iter().map(|value| f64::from(*value)).sum::<f64>() / map.len() as f64;
    let mean_on_surfaces = on_surfaces.iter().sum::<f64>() / on_surfaces.len().max(1) as f64;
    Flip { map, mean, mean_on_surfaces }
}

/// Features of an image after the model of the visual system.
struct Seen {
    /// L*, a*, b* after the contrast sensitivity filters, with Hunt's adjustment.
    colours: Vec<[f32; 3]>,
    /// Strength of edges.
    edges: Vec<f32>,
    /// Strength of points.
    points: Vec<f32>,
}

impl Seen {
    fn new(image: &LinearImage, exposure: f64, pixels_per_degree: f64) -> Self {
        let width = image.width;
        let opponent: Vec<[f32; 3]> = (0..image.pixels.len())
            .into_par_iter()
            .map(|pixel| to_opponent(displayed(image, pixel, exposure)).map(|c| c as f32))
            .collect();
        let channel = |k: usize| -> Vec<f32> { opponent.iter().map(|pixel| pixel[k]).collect() };
        let filtered: Vec<Vec<f32>> =
            (0..3).map(|k| sensitivity_filtered(&channel(k), width, k, pixels_per_degree)).collect();
        let colour = |pixel: usize| {
            let seen = from_opponent([0, 1, 2].map(|k| f64::from(filtered[k][pixel])));
            hunt_adjusted(to_lab(seen.map(|c| c.clamp(0.0, 1.0)))).map(|c| c as f32)
        };
        let colours = (0..opponent.len()).into_par_iter().map(colour).collect();

        // Features come from the unfiltered image; luminance from 0 to 1.
        let luminance: Vec<f32> = opponent.iter().map(|pixel| (pixel[0] + 16.0) / 116.0).collect();
        let [smooth, edge, point] = feature_kernels(pixels_per_degree);
        let strength = |kernel: &[f32]| -> Vec<f32> {
            let across = convolved(&luminance, width, kernel, &smooth);
            let down = convolved(&luminance, width, &smooth, kernel);
            across.iter().zip(&down).map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Self { colours, edges: strength(&edge), points: strength(&point) }
    }
}

fn displayed(image: &LinearImage, pixel: usize, exposure: f64) -> [f64; 3] {
    let behind = 1.0 - f64::from(image.coverage[pixel]);
    // The minimum of a number and NaN is the number.
    [0, 1, 2].map(|k| {
        let shown = (f64::from(image.pixels[pixel][k]) * exposure).max(0.0);
        (shown.min(1.0) + f64::from(image.background[k]) * behind).clamp(0.0, 1.0)
    })
}

fn transform(matrix: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ relative to white.
fn to_relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let (xyz, white) = (transform(&TO_XYZ, rgb), transform(&TO_XYZ, [1.0; 3]));
    [0, 1, 2].map(|k| xyz[k] / white[k])
}

/// The linear opponent space Y Cx Cz: L*a*b* without its cube roots.
fn to_opponent(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = to_relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([achromatic, red_green, blue_yellow]: [f64; 3]) -> [f64; 3] {
    let y = (achromatic + 16.0) / 116.0;
    let relative = [y + red_green / 500.0, y, y - blue_yellow / 200.0];
    let white = transform(&TO_XYZ, [1.0; 3]);
    transform(&FROM_XYZ, [0, 1, 2].map(|k| relative[k] * white[k]))
}

/// CIE L*a*b* (1976).
fn to_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let [x, y, z] =
        to_relative_xyz(rgb).map(|t| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Applies the Hunt effect: chroma seems weaker in the dark (section 4.1.2).
fn hunt_adjusted([l, a, b]: [f64; 3]) -> [f64; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// The HyAB distance of Abasi, Tehran and Fairchild 2020: city blocks in lightness, Euclidean in chroma.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, r, y] = [0, 1, 2].map(|k| a[k] - b[k]);
    l.abs() + (r * r + y * y).sqrt()
}

/// Largest colour difference of a display, between green and blue, raised to the exponent of differences.
fn largest_colour_difference() -> f64 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt_adjusted(to_lab(rgb)).map(|c| c as f32));
    f64::from(hyab(green, blue)).powf(COLOUR_EXPONENT)
}

/// Maps colour differences to the range from 0 to 1 (section 4.1.3): large ones are compressed.
fn redistributed(distance: f32, largest: f64) -> f32 {
    let value = f64::from(distance).powf(COLOUR_EXPONENT);
    let knee = KNEE * largest;
    let share = if value < knee {
        value * KNEE_VALUE / knee
    } else {
        KNEE_VALUE + (value - knee) / (largest - knee) * (1.0 - KNEE_VALUE)
    };
    share.min(1.0) as f32
}

/// Filters a channel by the contrast sensitivity of the eye.
fn sensitivity_filtered(plane: &[f32], width: usize, channel: usize, pixels_per_degree: f64) -> Vec<f32> {
    // One window for all channels, three standard deviations of the widest Gaussian.
    let widest = SENSITIVITY.iter().copied().flatten().map(|[_, b]| *b).fold(0.0, f64::max);
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
    let terms = SENSITIVITY[channel].iter().map(|[a, b]| {
        let gaussian: Vec<f64> =
            (-radius..=radius).map(|x| (-(PI * x as f64 / pixels_per_degree).powi(2) / b).exp()).collect();
        let sum = gaussian.iter().sum::<f64>();
        // Each Gaussian separates, their sum does not: `weight` is the term's share of the window.
        let kernel: Vec<f32> = gaussian.iter().map(|g| (g / sum) as f32).collect();
        (kernel, a * (PI / b).sqrt() * sum * sum)
    });
    let terms: Vec<(Vec<f32>, f64)> = terms.collect();
    let total: f64 = terms.iter().map(|(_, weight)| weight).sum();
    let mut filtered = vec![0.0; plane.len()];
    for (kernel, weight) in &terms {
        let share = (weight / total) as f32;
        let part = convolved(plane, width, kernel, kernel);
        filtered.iter_mut().zip(&part).for_each(|(sum, value)| *sum += share * value);
    }
    filtered
}

/// A Gaussian and its first and second derivative. The Gaussian sums to 1, positive and negative weights of the others
/// to 1 and -1 (section 4.2).
fn feature_kernels(pixels_per_degree: f64) -> [Vec<f32>; 3] {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as i64;
    let kernel = |factor: &dyn Fn(f64) -> f64| -> Vec<f32> {
        let at = |x: i64| factor(x as f64) * (-0.5 * (x as f64 / deviation).powi(2)).exp();
        let weights: Vec<f64> = (-radius..=radius).map(at).collect();
        let sum_of = |sign: f64| weights.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
        let (above, below) = (sum_of(1.0), sum_of(-1.0));
        // With very large pixels the neighbours weigh nothing, and there is no sum to divide by.
        let share = |w: &f64| w / if *w < 0.0 { below } else { above }.max(f64::MIN_POSITIVE);
        weights.iter().map(|w| share(w) as f32).collect()
    };
    [kernel(&|_| 1.0), kernel(&|x| -x), kernel(&|x| (x / deviation).powi(2) - 1.0)]
}

/// Convolves a plane along rows and then along columns with kernels of an odd number of weights.
fn convolved(plane: &[f32], width: usize, along_rows: &[f32], along_columns: &[f32]) -> Vec<f32> {
    let height = plane.len() / width;
    let clamped = |at: usize, step: usize, radius: usize, size: usize| (at + step).saturating_sub(radius).min(size - 1);
    let mut across = vec![0.0; plane.len()];
    let radius = along_rows.len() / 2;
    across.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each(|(across, row)| {
        for (x, sum) in across.iter_mut().enumerate() {
            *sum = along_rows.iter().enumerate().map(|(k, w)| w * row[clamped(x, k, radius, width)]).sum();
        }
    });
    let mut both = vec![0.0; plane.len()];
    let radius = along_columns.len() / 2;
    both.par_chunks_mut(width).enumerate().for_each(|(y, both)| {
        for (k, weight) in along_columns.iter().enumerate() {
            let row = clamped(y, k, radius, height) * width;
            both.iter_mut().zip(&across[row..row + width]).for_each(|(sum, value)| *sum += weight * value);
        }
    });
    both
}

#[cfg(test)]
mod tests;
