//! Compares frames of Bevy with renderings of `brdfc render`, puts images side by side, or adds the light of two images.
//!
//! usage: compare LIMIT EXPECTED.png FOUND.png [LIMIT EXPECTED.png FOUND.png...]
//!        compare --row OUT.png IMAGE.png...
//!        compare --sum OUT.png ONE.png OTHER.png
//!
//! LIMIT is the largest mean ΔE (CIE 1976) over the pixels of surfaces.

use image::{Rgb, RgbImage};
use std::process::ExitCode;

/// Threshold in 8-bit levels: pixels closer to the corner of the expected rendering are background.
const SAME: u8 = 2;
/// Minimum fraction of a rendering that must be surface.
const MIN_SURFACE: f64 = 0.125;
/// Minimum difference of the renderings of two materials, as a multiple of the limit; otherwise the comparison is blind.
const MIN_APART: f64 = 5.0;

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A frame, and the expected rendering.
struct Pair {
    limit: f64,
    expected: RgbImage,
    name: String,
    found: RgbImage,
}

fn run(arguments: &[String]) -> Result<(), Failure> {
    if let [option, out, renderings @ ..] = arguments
        && option == "--row"
    {
        let renderings = renderings.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
        return side_by_side(&renderings).save(out).map_err(|error| format!("{out}: {error}").into());
    }
    if let [option, out, one, other] = arguments
        && option == "--sum"
    {
        return sum(&read(one)?, &read(other)?).save(out).map_err(|error| format!("{out}: {error}").into());
    }
    let (triples, []) = arguments.as_chunks::<3>() else { return Err("each limit has two renderings".into()) };
    if triples.is_empty() {
        return Err("no renderings are named".into());
    }
    let pair = |[limit, expected, found]: &[String; 3]| -> Result<Pair, Failure> {
        let limit = limit.parse().map_err(|_| format!("LIMIT: found {limit}, expected a number"))?;
        Ok(Pair { limit, expected: read(expected)?, name: found.clone(), found: read(found)? })
    };
    let pairs = triples.iter().map(pair).collect::<Result<Vec<_>, _>>()?;
    for Pair { limit, expected, name, found } in &pairs {
        let Difference { mean, p95, codes, pixels } =
            difference(expected, found).map_err(|error| format!("{name}: {error}"))?;
        println!("{name}: mean ΔE {mean:.2}, 95 %: {p95:.2}, at most {codes} 8-bit levels apart, over {pixels} pixels");
        if mean > *limit {
            return Err(format!("{name}: mean ΔE: found {mean:.3}, expected at most {limit}").into());
        }
    }
    for [one, other] in pairs.array_windows() {
        let apart = difference(&one.expected, &other.found)?.mean;
        if apart < MIN_APART * one.limit {
            return Err(format!("{} and {} look alike: a mean ΔE of {apart:.3}", one.name, other.name).into());
        }
    }
    Ok(())
}

fn read(path: &str) -> Result<RgbImage, Failure> {
    Ok(image::open(path).map_err(|error| format!("{path}: {error}"))?.to_rgb8())
}

/// Differences over pixels that show a surface in either rendering.
struct Difference {
    /// ΔE.
    mean: f64,
    /// 95th percentile of ΔE.
    p95: f64,
    /// Largest difference of any channel.
    codes: u8,
    pixels: usize,
}

fn difference(expected: &RgbImage, found: &RgbImage) -> Result<Difference, Failure> {
    if expected.dimensions() != found.dimensions() {
        return Err(format!("{:?} pixels instead of {:?}", found.dimensions(), expected.dimensions()).into());
    }
    let background = *expected.get_pixel(0, 0);
    let covered = |pixel: &Rgb<u8>| (0..3).any(|k| pixel[k].abs_diff(background[k]) > SAME);
    let least = (MIN_SURFACE * f64::from(expected.width() * expected.height())) as usize;
    for image in [expected, found] {
        let surface = image.pixels().filter(|pixel| covered(pixel)).count();
        let lit = image.pixels().filter(|pixel| pixel.0.iter().any(|code| *code > background[0])).count();
        if surface < least || lit == 0 {
            return Err(
                format!("{surface} pixels show a surface, {lit} are bright; at least {least} and 1 have to").into()
            );
        }
    }
    let pairs = expected.pixels().zip(found.pixels()).filter(|(a, b)| covered(a) || covered(b));
    let apart = |(a, b): (&Rgb<u8>, &Rgb<u8>)| (0..3).map(|k| a[k].abs_diff(b[k])).max();
    let codes = pairs.clone().filter_map(apart).max().unwrap_or(0);
    let mut all: Vec<f64> = pairs.map(|(a, b)| delta_e(lab(a), lab(b))).collect();
    all.sort_by(f64::total_cmp);
    let pixels = all.len();
    Ok(Difference { mean: all.iter().sum::<f64>() / pixels as f64, p95: all[(pixels - 1) * 95 / 100], codes, pixels })
}

/// The distance of 1976.
fn delta_e(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The linear value of a code of sRGB.
fn linear(code: u8) -> f64 {
    let value = f64::from(code) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The sum of the light of two images of one scene. Their background stays.
fn sum(one: &RgbImage, other: &RgbImage) -> RgbImage {
    let background = *one.get_pixel(0, 0);
    let code = |value: f64| {
        let value = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
        (255.0 * value.clamp(0.0, 1.0)).round() as u8
    };
    RgbImage::from_fn(one.width(), one.height(), |x, y| {
        let (a, b) = (one.get_pixel(x, y), other.get_pixel(x, y));
        if [a, b].iter().all(|pixel| **pixel == background) {
            return background;
        }
        Rgb([0, 1, 2].map(|k| code(linear(a[k]) + linear(b[k]))))
    })
}

/// L*a*b* (D65) of the codes of sRGB.
fn lab(pixel: &Rgb<u8>) -> [f64; 3] {
    let [r, g, b] = pixel.0.map(linear);
    // Shares of white.
    let x = (0.412_456 * r + 0.357_576 * g + 0.180_438 * b) / 0.950_470;
    let y = 0.212_673 * r + 0.715_152 * g + 0.072_175 * b;
    let z = (0.019_334 * r + 0.119_192 * g + 0.950_304 * b) / 1.088_830;
    let [x, y, z] = [x, y, z].map(|t| if t > 0.008_856_452 { t.cbrt() } else { t * 7.787_037 + 16.0 / 116.0 });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn side_by_side(renderings: &[RgbImage]) -> RgbImage {
    let width = renderings.iter().map(RgbImage::width).sum();
    let height = renderings.iter().map(RgbImage::height).max().unwrap_or(0);
    let mut row = RgbImage::new(width, height);
    let mut left = 0;
    for rendering in renderings {
        image::imageops::replace(&mut row, rendering, left, 0);
        left += i64::from(rendering.width());
    }
    row
}
