//! Look-ups in environments and height maps, as in `environment.wgsl` and `surface.wgsl`.

use super::scene::{Environment, HeightMap};
use brdfc_formats::direction::{Vector, polynomial_atan2};
use brdfc_formats::tap::Tap;
use brdfc_metrics::image::luminance;
use rayon::prelude::*;
use std::f32::consts::PI;
use std::f64::consts::TAU;

/// Samples along each side of a pixel, which gets their mean.
const SUBSAMPLES: usize = 4;

/// Unit direction of a position in an image, in pixels.
fn direction([x, y]: [f64; 2], [width, height]: [usize; 2]) -> Vector {
    let azimuth = TAU * x / width as f64;
    let colatitude = std::f64::consts::PI * y / height as f64;
    let sine = colatitude.sin();
    [sine * azimuth.cos(), colatitude.cos(), sine * azimuth.sin()]
}

impl Environment {
    /// Image of a function of unit directions, at the centres of the pixels.
    pub fn of(width: usize, height: usize, radiance: impl Fn(Vector) -> [f32; 3] + Sync) -> Self {
        let pixel = |at: usize| {
            let (column, row) = (at % width, at / width);
            radiance(direction([column as f64 + 0.5, row as f64 + 0.5], [width, height]))
        };
        Self { width, height, pixels: (0..width * height).into_par_iter().map(pixel).collect() }
    }

    /// Image of the radiance of a cube map with faces of `side` texels, by unit direction; four faces wide. Pixels are means,
    /// because texels near the edges of faces are smaller than pixels.
    pub fn of_cube(side: usize, radiance: impl Fn(Vector) -> [f32; 3] + Sync) -> Self {
        let (width, height) = (4 * side, 2 * side);
        let pixel = |at: usize| {
            let (mut sum, mut all) = ([0.0; 3], 0.0);
            for part in 0..SUBSAMPLES * SUBSAMPLES {
                let within = [part % SUBSAMPLES, part / SUBSAMPLES].map(|k| (k as f64 + 0.5) / SUBSAMPLES as f64);
                let position = [(at % width) as f64 + within[0], (at / width) as f64 + within[1]];
                // Solid angle of the part of a pixel, up to a factor.
                let weight = (std::f64::consts::PI * position[1] / height as f64).sin();
                let found = radiance(direction(position, [width, height]));
                (0..3).for_each(|k| sum[k] += weight * f64::from(found[k]));
                all += weight;
            }
            sum.map(|sum| (sum / all) as f32)
        };
        Self { width, height, pixels: (0..width * height).into_par_iter().map(pixel).collect() }
    }

    /// Radiance from a direction (any length): bilinear, columns wrap, rows end at the poles. Texel centres at `i + ½`.
    pub fn at(&self, direction: Vector) -> Vector {
        let [x, y, z] = direction.map(|c| c as f32);
        let half_turn = polynomial_atan2(z.abs(), x);
        let azimuth = if z < 0.0 { 2.0 * PI - half_turn } else { half_turn };
        let colatitude = polynomial_atan2((x * x + z * z).sqrt(), y);
        let column = azimuth / (2.0 * PI) * self.width as f32 - 0.5;
        let row = (colatitude / PI * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        let (columns, rows) =
            (Tap::around(column, self.width as u32, true), Tap::around(row, self.height as u32, false));
        let ([a, b], [c, d]) = (columns.indices(), rows.indices());
        let texel = |column: usize, row: usize| self.pixels[row * self.width + column];
        let (s, t) = (f64::from(columns.weight), f64::from(rows.weight));
        [0, 1, 2].map(|k| {
            let mixed = |row| mix(f64::from(texel(a, row)[k]), f64::from(texel(b, row)[k]), s);
            mix(mixed(c), mixed(d), t)
        })
    }
}

impl Environment {
    /// Means of luminance and of its square over the texels of an image of another size, row by row, weighted by the
    /// solid angle that each covers. Luminance is clamped to 0 to `brightest` first.
    ///
    /// # Panics
    /// If there are no pixels, or if their number does not match the size.
    pub fn moments_over(&self, [width, height]: [usize; 2], brightest: f64) -> Vec<[f64; 2]> {
        assert!(self.width > 0 && self.height > 0 && self.pixels.len() == self.width * self.height, "whole rows");
        let columns: Vec<_> = (0..width).map(|at| overlaps(at, width, self.width)).collect();
        let row = |row: usize| -> Vec<[f64; 2]> {
            let band = |[from, to]: [f64; 2]| {
                let angle = |y: f64| std::f64::consts::PI * y / self.height as f64;
                (angle(from).cos() - angle(to).cos()).max(0.0)
            };
            let rows = overlaps(row, height, self.height);
            let texel = |columns: &Vec<(usize, [f64; 2])>| {
                let (mut sums, mut all) = ([0.0f64; 2], 0.0);
                for (row, across) in &rows {
                    for (column, [from, to]) in columns {
                        let weight = band(*across) * (to - from);
                        let shown = luminance(self.pixels[row * self.width + column]).clamp(0.0, brightest);
                        sums[0] += weight * shown;
                        sums[1] += weight * shown * shown;
                        all += weight;
                    }
                }
                sums.map(|sum| if all > 0.0 { sum / all } else { 0.0 })
            };
            columns.iter().map(texel).collect()
        };
        (0..height).into_par_iter().flat_map_iter(row).collect()
    }
}

/// Pixels of `from` along an axis that texel `at` of `count` covers, and the covered interval of each, in pixels.
fn overlaps(at: usize, count: usize, from: usize) -> Vec<(usize, [f64; 2])> {
    let edge = |at: usize| at as f64 * from as f64 / count as f64;
    let (start, end) = (edge(at), edge(at + 1));
    let range = start.floor() as usize..(end.ceil() as usize).min(from);
    let part = |pixel: usize| (pixel, [start.max(pixel as f64), end.min(pixel as f64 + 1.0)]);
    range.map(part).filter(|(_, [from, to])| to > from).collect()
}

impl HeightMap {
    /// `[dh/du, dh/dv]`: central differences of the bilinear heights over one texel.
    pub fn gradient(&self, uv: [f64; 2]) -> [f64; 2] {
        let half = 0.5 / self.size as f64;
        let du = self.at([uv[0] + half, uv[1]]) - self.at([uv[0] - half, uv[1]]);
        let dv = self.at([uv[0], uv[1] + half]) - self.at([uv[0], uv[1] - half]);
        [du, dv].map(|difference| difference * self.size as f64)
    }

    /// Bilinear, periodic height. Texel centres at `(i + ½) / size`.
    pub fn at(&self, uv: [f64; 2]) -> f64 {
        let [columns, rows] = uv.map(|c| Tap::around((c * self.size as f64 - 0.5) as f32, self.size as u32, true));
        let ([a, b], [c, d]) = (columns.indices(), rows.indices());
        let height = |column: usize, row: usize| f64::from(self.heights[row * self.size + column]);
        let (s, t) = (f64::from(columns.weight), f64::from(rows.weight));
        mix(mix(height(a, c), height(b, c), s), mix(height(a, d), height(b, d), s), t)
    }
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment_light::texel_solid_angle;

    #[test]
    fn an_environment_has_its_texels_at_their_directions() {
        let (width, height) = (8, 4);
        let pixels: Vec<[f32; 3]> = (0..width * height).map(|i| [i as f32, 2.0 * i as f32, 1.0]).collect();
        let environment = Environment { width, height, pixels };
        for row in 0..height {
            for column in 0..width {
                let theta = std::f64::consts::PI * (row as f64 + 0.5) / height as f64;
                let phi = std::f64::consts::TAU * (column as f64 + 0.5) / width as f64;
                let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|c| 3.0 * c);
                let found = environment.at(d);
                assert!((found[0] - (row * width + column) as f64).abs() < 1e-4, "{row} {column} {found:?}");
            }
        }
        let up = environment.at([0.0, 1.0, 0.0]);
        assert!(up.iter().all(|c| c.is_finite()));
    }

    /// One bright pixel brings the same amount of light at every size; means of squares are at least squared means.
    #[test]
    fn means_over_texels_are_energy_preserving() {
        for (from, to) in [([12, 6], [8, 4]), ([12, 6], [4, 2]), ([7, 3], [4, 2]), ([3, 5], [2, 4]), ([1, 1], [2, 1])] {
            for lit in 0..from[0] * from[1] {
                let pixels = (0..from[0] * from[1]).map(|at| [if at == lit { 5.0 } else { 0.25 }; 3]).collect();
                let environment = Environment { width: from[0], height: from[1], pixels };
                let flux = |width: usize, height: usize, value: &dyn Fn(usize) -> f64| -> f64 {
                    let solid_angle = |at: usize| texel_solid_angle(at / width, width, height);
                    (0..width * height).map(|at| solid_angle(at) * value(at)).sum()
                };
                let moments = environment.moments_over(to, 1e12);
                for (k, power) in [(0, 1), (1, 2)] {
                    let light = |at: usize| luminance(environment.pixels[at]).powi(power);
                    let expected = flux(from[0], from[1], &light);
                    let found = flux(to[0], to[1], &|at| moments[at][k]);
                    assert!((found / expected - 1.0).abs() < 1e-9, "{from:?} {to:?} {lit}: {found} {expected}");
                }
                assert!(moments.iter().all(|[mean, squares]| *squares > 0.999_999 * mean * mean));
            }
        }
    }

    #[test]
    fn slopes_of_a_wave() {
        let size = 256;
        let wave = |i: usize| (std::f64::consts::TAU * (i as f64 + 0.5) / size as f64).sin() as f32;
        let heights = (0..size * size).map(|i| 0.1 * wave(i % size) + 0.2 * wave(i / size)).collect();
        let map = HeightMap { size, heights };
        for uv in [[0.0, 0.0], [0.3, 0.9], [1.7, -0.4]] {
            let [du, dv] = map.gradient(uv);
            let slope = |a: f64, t: f64| a * std::f64::consts::TAU * (std::f64::consts::TAU * t).cos();
            assert!((du - slope(0.1, uv[0])).abs() < 2e-3, "{uv:?}: {du}");
            assert!((dv - slope(0.2, uv[1])).abs() < 4e-3, "{uv:?}: {dv}");
        }
    }
}
