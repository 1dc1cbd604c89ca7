//! Photometric stereo (Woodham 1980): normal and albedo of every pixel, without the observations that shadows or gloss
//! spoil.
//!
//! Lambert's law with attached shadows, `I_i = ρ max(n · l_i, 0)`, is fitted to luminance by least absolute deviations:
//! `g = ρ n` minimises `Σ_i |I_i - max(g · l_i, 0)|`. A deviation counts by its size and not by its square, so a
//! minority of lights in highlights or cast shadows changes little. Reweighted least squares finds `g`: it starts from
//! plain least squares, then weights every light by the inverse of its residual, first all lights (a convex problem),
//! then only those in front of the surface.

use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_metrics::image::luminance;
use nalgebra::Matrix3;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Pixels that are solved at once, for vector instructions.
const LANES: usize = 8;
/// Reweightings with all lights, and again without attached shadows.
const ROUNDS: usize = 15;
/// Residual below which weights stay constant, as a share of the albedo: about the noise of 8-bit photographs.
const NOISE: f32 = 3e-3;
/// Mean square of the distances of lights (as points of the unit sphere) from a plane through the surface below which
/// the lights do not determine a normal: 0.6 degrees.
const MIN_SPREAD: f64 = 1e-4;
/// Determinant of their second moments, as a share of the largest, below which they do not either: lights within 2 degrees of each other.
/// A pixel whose lit lights have less retains the fit to more lights.
const MIN_DETERMINANT: f64 = 1e-5;
/// Scaled normals below this are those of black pixels.
const BLACK: f32 = 1e-12;
/// Linear values from which a pixel is white. A pixel that is white under all lights is a mask or a background.
const WHITE: f32 = 0.96;
/// Albedo of pixels that count in [`SurfaceMaps::between_halves_p95`], as a share of the 95th percentile.
const MIN_ALBEDO: f32 = 0.02;
/// Residual from which an observation counts as an outlier in reports, as a share of the albedo.
const OUTLIER: f32 = 0.1;

/// Normals of every row of this number are also computed from halves of the lights.
const HALVED_ROWS: usize = 8;
/// Minimum number of lights of a half: attached shadows leave fewer.
const MIN_HALF: usize = 6;

/// One number per lane.
type Lanes = [f32; LANES];

/// Normals and albedo of a rendering, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMaps {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Unit vectors: x to the right, y up, z to the viewer, not negative. Black and undefined pixels have (0, 0, 1).
    pub normals: Vec<[f32; 3]>,
    /// Linear RGB, 0 or more; 1 is a white diffuser that a light faces. Undefined pixels are black.
    pub albedo: Vec<[f32; 3]>,
    /// Share of the observations of defined pixels that differ from Lambert's law by more than a tenth of the albedo: shadows, gloss and
    /// interreflections. Pixels count by their albedo, so that a black background does not.
    pub outliers: f64,
    /// Mean angle between normals from two halves of the lights, degrees, by albedo; each half has one light of each pair of near ones.
    /// `None` for fewer than 12 lights, and if halves of the lights do not determine normals.
    pub between_halves: Option<f64>,
    /// 95th percentile of the same angle over pixels, by their number; those with an albedo below 2 % of the brightest do not count.
    pub between_halves_p95: Option<f64>,
}

impl SurfaceMaps {
    /// Normals as 8-bit levels of RGB, `255 (n / 2 + 1 / 2)`: y up, as in OpenGL.
    pub fn normal_levels(&self) -> Vec<u8> {
        let level = |c: &f32| (255.0 * (0.5 * c + 0.5)).round() as u8;
        self.normals.as_flattened().iter().map(level).collect()
    }
}

/// Computes normals and albedo.
///
/// # Errors
/// Returns an error if images are out of range, and for fewer than three lights or lights in one plane through the
/// surface, which do not determine normals.
pub fn surface_maps(samples: &LightSamples) -> Result<SurfaceMaps, FormatError> {
    samples.check()?;
    let lights = &samples.lights;
    let allowed = "3 or more, not all in one plane through the surface, to determine normals";
    if lights.len() < 3 {
        return Err(FormatError::whole("lights", lights.len().to_string(), allowed));
    }
    if !determine_normals(lights) {
        let found = format!("{} almost in one plane or direction", lights.len());
        return Err(FormatError::whole("lights", found, allowed));
    }
    let width = samples.size[0];
    let halves = halves(lights).map(|of| (of.iter().map(|light| lights[*light]).collect(), of));
    let determined = halves.iter().all(|(half, _): &Half| half.len() >= MIN_HALF && determine_normals(half));
    let halves_of = |row: usize| (determined && row.is_multiple_of(HALVED_ROWS)).then_some(&halves);
    let rows: Vec<Row> =
        (0..samples.size[1]).into_par_iter().map(|row| solve_row(samples, row * width, halves_of(row))).collect();
    let [sum, albedo] = rows.iter().fold([0.0; 2], |all, row| [all[0] + row.outliers[0], all[1] + row.outliers[1]]);
    let outliers = if albedo > 0.0 { sum / albedo } else { 0.0 };
    let angles: Vec<(f32, f32)> = rows.iter().flat_map(|row| row.between_halves.iter().copied()).collect();
    let [all, sum] = angles.iter().fold([0.0; 2], |[all, sum], (albedo, angle)| {
        [all + f64::from(*albedo), sum + f64::from(*albedo) * f64::from(*angle)]
    });
    let between_halves = (all > 0.0).then(|| sum / all);
    let brightest = percentile_95(angles.iter().map(|(albedo, _)| *albedo)).unwrap_or(0.0);
    let shown = angles.iter().filter(|(albedo, _)| *albedo > 0.0 && *albedo >= MIN_ALBEDO * brightest);
    let between_halves_p95 = percentile_95(shown.map(|(_, angle)| *angle)).map(f64::from);
    let (normals, albedo) = rows.into_iter().flat_map(|row| row.pixels).unzip();
    Ok(SurfaceMaps { size: samples.size, normals, albedo, outliers, between_halves, between_halves_p95 })
}

/// A half of the lights, and their indices.
type Half = (Vec<[f32; 3]>, Vec<usize>);

/// Indices of two halves of the lights, each with one light of each pair of near ones. They do not depend on the order of the list, in
/// which every other light may be in the same ring.
fn halves(lights: &[[f32; 3]]) -> [Vec<usize>; 2] {
    let by_place =
        |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| a[c].total_cmp(&b[c])).fold(Ordering::Equal, Ordering::then);
    let mut left: Vec<usize> = (0..lights.len()).collect();
    left.sort_by(|a, b| by_place(lights[*a], lights[*b]));
    let mut halves = [Vec::new(), Vec::new()];
    let mut first = 0;
    while !left.is_empty() {
        let light = left.remove(0);
        halves[first].push(light);
        // All lights are unit vectors.
        let cosine = |other: &usize| (0..3).map(|c| lights[light][c] * lights[*other][c]).sum::<f32>();
        let nearest = (0..left.len()).max_by(|a, b| cosine(&left[*a]).total_cmp(&cosine(&left[*b])));
        if let Some(nearest) = nearest {
            halves[1 - first].push(left.remove(nearest));
        }
        first = 1 - first;
    }
    halves
}

/// The 95th percentile; `None` without values.
fn percentile_95(values: impl Iterator<Item = f32>) -> Option<f32> {
    let mut values: Vec<f32> = values.collect();
    let at = (0.95 * values.len().saturating_sub(1) as f64) as usize;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(at, f32::total_cmp).1)
}

/// Returns false if lights are almost in one plane through the surface, or in one direction.
fn determine_normals(lights: &[[f32; 3]]) -> bool {
    let mut spread = Matrix3::zeros();
    for light in lights {
        let light = nalgebra::Vector3::from(light.map(f64::from));
        spread += light * light.transpose() / lights.len() as f64;
    }
    spread.symmetric_eigenvalues().min() >= MIN_SPREAD && spread.determinant() > least_determinant(&spread)
}

fn least_determinant(matrix: &Matrix3<f64>) -> f64 {
    MIN_DETERMINANT * (matrix.trace() / 3.0).powi(3)
}

/// One row of pixels.
struct Row {
    /// Normal and albedo of each pixel.
    pixels: Vec<([f32; 3], [f32; 3])>,
    /// Sums over pixels of the share of outliers times the albedo, and of the albedo.
    outliers: [f64; 2],
    /// Albedo, and angle between normals from halves of the lights in degrees.
    between_halves: Vec<(f32, f32)>,
}

/// Solves the row that starts at a pixel, with `halves` also from each of these halves of the lights.
fn solve_row(samples: &LightSamples, first: usize, halves: Option<&[Half; 2]>) -> Row {
    let width = samples.size[0];
    let mut row = Row { pixels: Vec::with_capacity(width), outliers: [0.0; 2], between_halves: Vec::new() };
    for start in (first..first + width).step_by(LANES) {
        let count = LANES.min(first + width - start);
        let is_defined = |lane: usize| lane < count && samples.is_defined(start + lane);
        let luminances: Vec<Lanes> = samples
            .images
            .iter()
            .map(|image| {
                std::array::from_fn(
                    |lane| if is_defined(lane) { luminance(image.pixel(start + lane)) as f32 } else { 0.0 },
                )
            })
            .collect();
        let scaled = solve(&samples.lights, &luminances);
        let is_surface = |lane: usize| luminances.iter().any(|values| values[lane] < WHITE);
        if let Some(halves) = halves {
            let solved = halves.each_ref().map(|(lights, indices)| {
                let luminances: Vec<Lanes> = indices.iter().map(|light| luminances[*light]).collect();
                solve(lights, &luminances)
            });
            for lane in (0..count).filter(|lane| is_defined(*lane) && is_surface(*lane)) {
                let [a, b] = solved.map(|g| normal_of(g.map(|c| c[lane])).unwrap_or(UP));
                let angle = lit(a, b).min(1.0).acos().to_degrees();
                row.between_halves.push((length(scaled.map(|c| c[lane])), angle));
            }
        }
        for lane in 0..count {
            let g = scaled.map(|c| c[lane]);
            let (normal, albedo) = finished(samples, start + lane, g);
            let floor = OUTLIER * length(g);
            let is_outlier = |(light, values): (&[f32; 3], &Lanes)| (values[lane] - lit(g, *light)).abs() > floor;
            let outliers = samples.lights.iter().zip(&luminances).filter(|pair| is_outlier(*pair)).count();
            let weight = if is_surface(lane) { f64::from(length(g)) } else { 0.0 };
            row.outliers[0] += weight * outliers as f64 / samples.lights.len() as f64;
            row.outliers[1] += weight;
            row.pixels.push((normal, albedo));
        }
    }
    row
}

fn length(g: [f32; 3]) -> f32 {
    g.iter().map(|c| c * c).sum::<f32>().sqrt()
}

/// Luminance by Lambert's law.
fn lit(g: [f32; 3], light: [f32; 3]) -> f32 {
    g.iter().zip(light).map(|(a, b)| a * b).sum::<f32>().max(0.0)
}

/// Fits `g` of each lane.
fn solve(lights: &[[f32; 3]], luminances: &[Lanes]) -> [Lanes; 3] {
    let mut g = [[0.0; LANES]; 3];
    for round in 0..=2 * ROUNDS {
        let floor: Lanes = match round {
            // Equal weights.
            0 => [1.0e6; LANES],
            _ => std::array::from_fn(|lane| NOISE * length(g.map(|c| c[lane])) + BLACK),
        };
        let horizon = if round > ROUNDS { 0.0 } else { f32::MIN };
        let sums = equations(lights, luminances, &g, &floor, horizon);
        for lane in 0..LANES {
            let [a, b, c, d, e, f, x, y, z] = sums.map(|sum| f64::from(sum[lane]));
            let matrix = Matrix3::new(a, b, c, b, d, e, c, e, f);
            if matrix.determinant() > least_determinant(&matrix)
                && let Some(inverse) = matrix.try_inverse()
            {
                let found = inverse * nalgebra::Vector3::new(x, y, z);
                (0..3).for_each(|axis| g[axis][lane] = found[axis] as f32);
            }
        }
    }
    g
}

/// Weighted normal equations of each lane: the upper triangle of `Σ w l l^T`, then `Σ w I l`, with `w = 1 / max(|I - g
/// · l|, floor)`. Lights with `g · l` below the horizon do not count.
fn equations(lights: &[[f32; 3]], luminances: &[Lanes], g: &[Lanes; 3], floor: &Lanes, horizon: f32) -> [Lanes; 9] {
    let mut sums = [[0.0; LANES]; 9];
    for ([x, y, z], values) in lights.iter().zip(luminances) {
        let products = [x * x, x * y, x * z, y * y, y * z, z * z];
        for lane in 0..LANES {
            let expected = g[0][lane] * x + g[1][lane] * y + g[2][lane] * z;
            let weight = 1.0 / (values[lane] - expected).abs().max(floor[lane]);
            let weight = if expected > horizon { weight } else { 0.0 };
            (0..6).for_each(|k| sums[k][lane] += weight * products[k]);
            let value = weight * values[lane];
            sums[6][lane] += value * x;
            sums[7][lane] += value * y;
            sums[8][lane] += value * z;
        }
    }
    sums
}

/// Normal of black pixels.
const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// Normal of a solution; `None` for a black pixel.
fn normal_of(g: [f32; 3]) -> Option<[f32; 3]> {
    // Surfaces that face away are not visible: noise at a grazing angle, or no Lambertian surface at all.
    let facing = [g[0], g[1], g[2].max(0.0)];
    let size = length(facing);
    (size >= BLACK).then(|| facing.map(|c| c / size))
}

/// Normal of `g`, and the albedo of each channel: the fit with the weights of luminance.
fn finished(samples: &LightSamples, pixel: usize, g: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let Some(normal) = normal_of(g) else { return (UP, [0.0; 3]) };
    let floor = NOISE * length(g) + BLACK;
    let (mut sums, mut squares) = ([0.0; 3], 0.0);
    for (light, image) in samples.lights.iter().zip(&samples.images) {
        let cosine = lit(normal, *light);
        let colour = image.pixel(pixel);
        let weight = 1.0 / (luminance(colour) as f32 - lit(g, *light)).abs().max(floor);
        (0..3).for_each(|c| sums[c] += weight * cosine * colour[c]);
        squares += weight * cosine * cosine;
    }
    (normal, sums.map(|sum| if squares > 0.0 { (sum / squares).max(0.0) } else { 0.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ptm::spread_lights;
    use brdfc_formats::direction::from_polar;

    const SIDE: usize = 41;

    /// Normal of a sphere that fills an image; y goes up.
    fn normal(pixel: usize) -> [f32; 3] {
        let at = |k: usize| 1.9 * ((k as f32 + 0.5) / SIDE as f32) - 0.95;
        let [x, y] = [at(pixel % SIDE), -at(pixel / SIDE)];
        let square = x * x + y * y;
        let z = (1.0 - square).max(0.04).sqrt();
        let size = (square + z * z).sqrt();
        [x / size, y / size, z / size]
    }

    /// Images of the sphere: `shade` returns light by normal, light, index of light and cosine.
    fn sphere(lights: Vec<[f32; 3]>, shade: impl Fn([f32; 3], [f32; 3], usize, f32) -> f32) -> LightSamples {
        let image = |(index, light): (usize, &[f32; 3])| -> Vec<[f32; 3]> {
            let pixel = |pixel: usize| {
                let n = normal(pixel);
                let value = shade(n, *light, index, lit(n, *light));
                [0.8 * value, 0.5 * value, 0.2 * value]
            };
            (0..SIDE * SIDE).map(pixel).collect()
        };
        let images: Vec<_> = lights.iter().enumerate().map(image).collect();
        LightSamples::new([SIDE, SIDE], lights, images)
    }

    /// Mean angle to the sphere's normals, degrees.
    fn error(normals: &[[f32; 3]]) -> f64 {
        let angle = |(pixel, found): (usize, &[f32; 3])| {
            let cosine: f32 = normal(pixel).iter().zip(found).map(|(a, b)| a * b).sum();
            f64::from(cosine.clamp(-1.0, 1.0).acos().to_degrees())
        };
        normals.iter().enumerate().map(angle).sum::<f64>() / normals.len() as f64
    }

    /// Normals by plain least squares.
    fn least_squares(samples: &LightSamples) -> Vec<[f32; 3]> {
        let matrix = nalgebra::DMatrix::from_fn(samples.lights.len(), 3, |i, k| samples.lights[i][k]);
        let inverse = matrix.pseudo_inverse(1e-6).unwrap();
        let pixel = |pixel: usize| {
            let values = samples.images.iter().map(|image| luminance(image.pixel(pixel)) as f32);
            let g = &inverse * nalgebra::DVector::from_iterator(samples.lights.len(), values);
            let size = g.norm();
            [g[0] / size, g[1] / size, g[2] / size]
        };
        (0..SIDE * SIDE).map(pixel).collect()
    }

    /// Known answer; the negative control is plain least squares, which attached shadows spoil.
    #[test]
    fn a_lambertian_sphere_is_recovered_to_8_bits() {
        let samples = sphere(spread_lights(40), |_, _, _, cosine| cosine);
        let maps = surface_maps(&samples).unwrap();
        let expected = SurfaceMaps { normals: (0..SIDE * SIDE).map(normal).collect(), ..maps.clone() };
        let differences = maps.normal_levels().into_iter().zip(expected.normal_levels()).map(|(a, b)| a.abs_diff(b));
        assert!(differences.max() <= Some(1));
        for albedo in &maps.albedo {
            assert!(albedo.iter().zip([0.8, 0.5, 0.2]).all(|(a, b)| (a - b).abs() < 2e-3), "{albedo:?}");
        }
        assert!(maps.outliers < 1e-3, "{}", maps.outliers);
        assert!(maps.between_halves.unwrap() < 0.1, "{:?}", maps.between_halves);
        assert!(error(&maps.normals) < 0.1 && error(&least_squares(&samples)) > 1.0);
    }

    #[test]
    fn highlights_and_cast_shadows_change_little() {
        let samples = sphere(spread_lights(60), |n, light, index, cosine| {
            let half = [light[0], light[1], light[2] + 1.0];
            let gloss = (lit(n, half) / length(half)).powi(60);
            // One light in seven is blocked, another one for each region.
            let is_blocked = (index + (4.0 * n[0] + 4.0) as usize).is_multiple_of(7);
            if is_blocked { 0.0 } else { cosine + 2.0 * gloss * cosine.min(1.0) }
        });
        let maps = surface_maps(&samples).unwrap();
        let (robust, plain) = (error(&maps.normals), error(&least_squares(&samples)));
        println!("mean error: {robust:.2} degrees, plain least squares {plain:.2}");
        assert!(robust < 0.6 && plain > 5.0 * robust, "{robust} {plain}");
        assert!(maps.outliers > 0.1, "{}", maps.outliers);
    }

    /// A sphere with a GGX highlight of a share of the reflected light, at which a share of the lights is blocked at random.
    fn glossy(share: f32, alpha: f32, blocked: f32) -> SurfaceMaps {
        let samples = sphere(spread_lights(60), |n, light, _, cosine| {
            let place = (7.3 * n[0] + 3.1 * n[1]) * 10.0 + 5.0 * light[0] + 9.0 * light[1];
            if (place.sin() * 43_758.0).fract().abs() < blocked {
                return 0.0;
            }
            let half = [light[0], light[1], light[2] + 1.0];
            let (c, square) = (lit(n, half) / length(half), alpha * alpha);
            let d = square / (std::f32::consts::PI * (c * c * (square - 1.0) + 1.0).powi(2));
            let highlight = 0.9 * d / (4.0 * n[2].max(0.1));
            if cosine > 0.0 { (1.0 - share) * cosine + share * highlight } else { 0.0 }
        });
        surface_maps(&samples).unwrap()
    }

    /// The table of the page on relighting. Halves of the lights show the error; outliers do not.
    #[test]
    fn halves_of_the_lights_show_the_error() {
        for (share, alpha, blocked, [outliers, halves, expected]) in [
            (0.3, 0.3, 0.0, [0.04, 0.5, 0.9]),
            (0.9, 0.2, 0.0, [0.28, 5.2, 8.9]),
            (1.0, 0.25, 0.0, [0.42, 11.0, 24.0]),
            (1.0, 0.08, 0.0, [0.40, 12.0, 28.0]),
            (0.0, 0.3, 0.2, [0.14, 1.5, 0.08]),
            (0.0, 0.3, 0.3, [0.22, 6.6, 1.0]),
        ] {
            let maps = glossy(share, alpha, blocked);
            let (between, error) = (maps.between_halves.unwrap(), error(&maps.normals));
            println!("{share} {alpha} {blocked}: {:.3} {between:.2} {error:.2}", maps.outliers);
            let near = |found: f64, printed: f64| (found / printed - 1.0).abs() < 0.13;
            assert!(near(maps.outliers, outliers) && near(between, halves) && near(error, expected));
            // Highlights mislead both halves, and blocked lights each half more than all lights.
            let ratio = if blocked == 0.0 { 1.3..3.0 } else { 0.05..0.2 };
            assert!(ratio.contains(&(error / between)), "{error} {between}");
        }
        // Rings of lights, in two orders.
        let rings = || (0..36).map(|k| (0.5 + 0.4 * f64::from(k % 2), 0.3 * f64::from(k / 2)));
        let lights: Vec<[f32; 3]> =
            rings().map(|(polar, azimuth)| from_polar(polar, azimuth).map(|c| c as f32)).collect();
        let sorted: Vec<[f32; 3]> = (0..36).map(|k| lights[2 * (k % 18) + k / 18]).collect();
        let of_order = |lights: Vec<[f32; 3]>| {
            let blocked = |light: [f32; 3]| light[0] > 0.3;
            let samples = sphere(lights, |_, light, _, cosine| if blocked(light) { 0.0 } else { cosine });
            surface_maps(&samples).unwrap().between_halves.unwrap()
        };
        let [mixed, sorted] = [lights, sorted].map(of_order);
        assert!((mixed / sorted - 1.0).abs() < 1e-3, "{mixed} {sorted}");
        // Ten lights determine normals, their halves do not.
        assert_eq!(surface_maps(&sphere(spread_lights(10), |_, _, _, cosine| cosine)).unwrap().between_halves, None);
    }

    /// Three lights in front of every pixel are enough.
    #[test]
    fn three_lights_determine_normals() {
        let lights = vec![[0.6, 0.0, 0.8], [-0.3, 0.52, 0.8], [-0.3, -0.52, 0.8]];
        let lights: Vec<[f32; 3]> = lights.into_iter().map(|l: [f32; 3]| l.map(|c| c / length(l))).collect();
        let samples =
            sphere(lights.clone(), |n, light, _, _| 0.5 * (n[0] * light[0] + n[1] * light[1] + n[2] * light[2]));
        assert!(error(&surface_maps(&samples).unwrap().normals) < 0.1);
        for wrong in
            [vec![lights[0], lights[1]], vec![[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [-0.8, 0.0, 0.6]]]
        {
            let count = wrong.len();
            let error = surface_maps(&sphere(wrong, |_, _, _, cosine| cosine)).unwrap_err();
            assert!(error.field == "lights" && error.found.starts_with(&count.to_string()), "{error}");
        }
    }

    #[test]
    fn black_pixels_face_the_viewer() {
        let maps = surface_maps(&sphere(spread_lights(10), |_, _, _, _| 0.0)).unwrap();
        assert!(maps.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]) && maps.albedo.iter().all(|a| *a == [0.0; 3]));
    }

    /// Filled values of undefined pixels would be outliers; without a mask they are.
    #[test]
    fn undefined_pixels_do_not_count() {
        let mut samples = sphere(spread_lights(20), |_, _, index, cosine| if index % 2 == 0 { 1.0 } else { cosine });
        let whole = sphere(spread_lights(20), |_, _, _, cosine| cosine);
        let defined: Vec<bool> = (0..SIDE * SIDE).map(|pixel| pixel % 3 > 0).collect();
        for (filled, known) in samples.images.iter_mut().zip(&whole.images) {
            filled
                .to_mut()
                .iter_mut()
                .zip(known.linear(0..known.len()).iter())
                .zip(&defined)
                .filter(|(_, defined)| **defined)
                .for_each(|((a, b), _)| *a = *b);
        }
        let filled = surface_maps(&samples).unwrap();
        samples.defined = Some(defined.clone());
        let (masked, expected) = (surface_maps(&samples).unwrap(), surface_maps(&whole).unwrap());
        for (pixel, defined) in defined.into_iter().enumerate() {
            let found = (masked.normals[pixel], masked.albedo[pixel]);
            let known = (expected.normals[pixel], expected.albedo[pixel]);
            assert_eq!(found, if defined { known } else { ([0.0, 0.0, 1.0], [0.0; 3]) });
        }
        assert!(filled.outliers > 0.1 && masked.outliers < 1e-3, "{} {}", filled.outliers, masked.outliers);
    }

    #[test]
    fn threads_change_nothing() {
        let samples = sphere(spread_lights(20), |n, _, _, cosine| cosine * (1.0 + n[0]));
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| surface_maps(&samples).unwrap())
        };
        assert_eq!(on(1), on(3));
    }
}
