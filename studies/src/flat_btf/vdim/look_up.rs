//! Look-ups in a map: equation 3 of Hadim et al. 2009, `VDIM_v = VDIM_n + d_v δ_v`.
//!
//! All steps are f32 operations, as in a shader.

use super::map::{Vdim, VdimHeader};
use brdfc_formats::direction::{Vector, polynomial_atan2};
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Four view samples `(k, a)` with their weights.
type Samples = [([u32; 2], f32); 4];

impl Vdim {
    /// Parameters that the map gives for a view through each texel of the reference plane, row by row, in [0, 1).
    pub fn parameters(&self, view: Vector) -> Vec<[f32; 2]> {
        let (size, samples) = (self.header.size, samples_around(&self.header, view));
        let seen = |texel: u32| {
            let [u, v, _] = self.blended([texel % size, texel / size], &samples);
            [u, v]
        };
        (0..size * size).into_par_iter().map(seen).collect()
    }

    /// Parameters, in [0, 1), and height in tiles of the surface point visible through texel `(i, j)` of the reference
    /// plane; `view` is a unit vector to the viewer.
    ///
    /// The directions of four view samples are blended and normalised; their distances are blended linearly. Steeper
    /// views than the largest polar angle are clamped to it.
    pub fn seen(&self, texel: [u32; 2], view: Vector) -> [f32; 3] {
        self.blended(texel, &samples_around(&self.header, view))
    }

    fn blended(&self, [i, j]: [u32; 2], samples: &Samples) -> [f32; 3] {
        let mut blended = [0.0f32; 4];
        for ([k, a], weight) in samples {
            let sample = self.sample([i, j], *k, *a);
            (0..4).for_each(|component| blended[component] += weight * sample[component]);
        }
        let [x, y, distance, height] = blended;
        let length = (x * x + y * y).sqrt();
        let scale = if length > 0.0 { distance / length } else { 0.0 };
        let [u, v] = self.reference[(j * self.header.size + i) as usize];
        [wrap(u + scale * x), wrap(v + scale * y), height]
    }
}

/// View samples around a view. The azimuth of a sample may be a full turn.
fn samples_around(header: &VdimHeader, view: Vector) -> Samples {
    let [polar, azimuth] = view_position(header, view.map(|c| c as f32));
    let [(k, along), (a, turn)] = [between(polar, header.zenith_samples - 1), between(azimuth, header.azimuth_samples)];
    [
        ([k, a], (1.0 - turn) * (1.0 - along)),
        ([k + 1, a], (1.0 - turn) * along),
        ([k, a + 1], turn * (1.0 - along)),
        ([k + 1, a + 1], turn * along),
    ]
}

/// Position of a view among the samples, polar angle first.
fn view_position(header: &VdimHeader, [x, y, z]: [f32; 3]) -> [f32; 2] {
    let polar = polynomial_atan2((x * x + y * y).sqrt(), z).min(header.largest_angle);
    let azimuth = polynomial_atan2(y.abs(), x);
    let azimuth = if y < 0.0 { TAU - azimuth } else { azimuth };
    let column = polar / header.largest_angle * (header.zenith_samples - 1) as f32;
    [column, azimuth / TAU * header.azimuth_samples as f32]
}

/// Sample below a position from 0 to `last`, and the weight of the sample above.
fn between(position: f32, last: u32) -> (u32, f32) {
    let lower = (position as u32).min(last - 1);
    (lower, position - lower as f32)
}

/// Fractional part, in [0, 1).
fn wrap(x: f32) -> f32 {
    let fraction = x - x.floor();
    // A tiny negative number has a fraction that rounds to 1.
    if fraction < 1.0 { fraction } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::from_polar;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// A map of the plane with this displacement and height for all texels.
    fn plane(header: VdimHeader, sample: impl Fn(u32, u32) -> ([f32; 2], f32)) -> Vdim {
        let size = header.size;
        let centre = |k: u32| (k as f32 + 0.5) / size as f32;
        let reference = (0..size * size).map(|at| [centre(at % size), centre(at / size)]).collect();
        let row = (0..header.azimuth_samples).flat_map(|a| (0..size).map(move |_| a));
        let row: Vec<_> =
            row.flat_map(|a| (0..header.zenith_samples).map(move |k| (k, a))).map(|(k, a)| sample(k, a)).collect();
        Vdim::new(header, reference, row.repeat(size as usize))
    }

    /// Distance of parameters with period 1.
    fn apart(a: f32, b: f32) -> f32 {
        let distance = a - b;
        distance - distance.round()
    }

    #[test]
    fn a_plane_has_no_parallax() {
        let header = VdimHeader { size: 8, zenith_samples: 5, azimuth_samples: 6, largest_angle: 1.5 };
        let map = plane(header, |_, _| ([0.0; 2], 0.0));
        for k in 0..500u32 {
            let view = from_polar(f64::from(k % 23) / 14.0, f64::from(k) / 79.0);
            let [i, j] = [k % 8, k / 8 % 8];
            let centre = [i, j].map(|c| c as f32 / 8.0 + 0.0625);
            assert_eq!(map.seen([i, j], view), [centre[0], centre[1], 0.0], "{view:?}");
        }
    }

    /// With samples that are linear in the angle the blend is exact along it for any azimuth, because directions are
    /// blended, not displacements.
    #[test]
    fn linear_displacements_are_rebuilt() {
        let slope = 0.25;
        let header = VdimHeader { size: 4, zenith_samples: 9, azimuth_samples: 64, largest_angle: 1.5 };
        let map = plane(header, |k, a| {
            let [polar, azimuth] = header.view_angles(k, a).map(|angle| angle as f32);
            ([slope * polar * azimuth.cos(), slope * polar * azimuth.sin()], -0.1 * polar)
        });
        for k in 0..2000u32 {
            let (polar, azimuth) = (1.5 * f64::from(k * 619 % 1999) / 1999.0, 6.2 * f64::from(k) / 2000.0);
            let [i, j] = [k % 4, k / 4 % 4];
            let [u, v, z] = map.seen([i, j], from_polar(polar, azimuth));
            let [x, y] = map.reference[(4 * j + i) as usize];
            let [du, dv] = [apart(u, x), apart(v, y)];
            // Halves have a relative precision of 2^-12; blending between 64 directions turns them by less than 1e-3.
            let (polar, azimuth) = (polar as f32, azimuth as f32);
            let distance = slope * polar;
            assert!((du - distance * azimuth.cos()).abs() < 4e-4, "{polar} {azimuth}: {du}");
            assert!((dv - distance * azimuth.sin()).abs() < 4e-4, "{polar} {azimuth}: {dv}");
            assert!((du.hypot(dv) - distance).abs() < 2e-4 && (z + 0.1 * polar).abs() < 1e-4);
        }
    }

    /// Equation 3 with four samples of known values, and the view halfway between all of them.
    #[test]
    fn directions_and_distances_blend_separately() {
        let header = VdimHeader { size: 1, zenith_samples: 3, azimuth_samples: 4, largest_angle: 1.0 };
        let map = plane(header, |k, a| {
            let direction = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][a as usize];
            let distance = 0.1 * k as f32 * (1 + a) as f32;
            (direction.map(|c| c * distance), k as f32)
        });
        let displaced = |polar, azimuth| {
            let [u, v, z] = map.seen([0, 0], from_polar(polar, azimuth));
            [u - 0.5, v - 0.5, z]
        };
        // Distances of the first two azimuths: 0.1, 0.2 at 0.5, and 0.2, 0.4 at 1.0. The direction is halfway.
        let mean = (0.1 + 0.2 + 0.2 + 0.4) / 4.0;
        let [x, y, z] = displaced(0.75, FRAC_PI_2 / 2.0);
        let expected = mean * 0.5f32.sqrt();
        assert!((x - expected).abs() < 1e-4 && (y - expected).abs() < 1e-4 && (z - 1.5).abs() < 1e-5, "{x} {y} {z}");
        // Across the seam of the azimuth, from the last to the first.
        let [x, y, _] = displaced(0.5, 1.75 * PI);
        let expected = (0.4 + 0.1) / 2.0 * 0.5f32.sqrt();
        assert!((x - expected).abs() < 1e-4 && (y + expected).abs() < 1e-4, "{x} {y}");
        // Beyond the largest angle, and below the horizon, nothing changes any more.
        assert_eq!(displaced(1.0, 0.3), displaced(1.2, 0.3));
        assert_eq!(displaced(1.0, 0.3), displaced(2.5, 0.3));
        // The negative control: within it, the angle matters.
        assert!(displaced(0.9, 0.3) != displaced(1.0, 0.3));
    }

    #[test]
    fn parameters_are_those_of_each_texel() {
        let random = |salt: u32, k: u32| ((k * 7919 + salt * 104_729 + 13) % 1009) as f32 / 1009.0;
        let header = VdimHeader { size: 6, zenith_samples: 4, azimuth_samples: 5, largest_angle: 1.3 };
        let reference = (0..36).map(|k| [random(3, k), random(4, k)]).collect();
        let moved = |k| ([random(0, k) - 0.5, random(1, k) - 0.5], random(2, k));
        let map = Vdim::new(header, reference, (0..header.samples() as u32).map(moved));
        for view in [from_polar(0.0, 0.0), from_polar(0.9, 0.7), from_polar(1.25, 5.0)] {
            let mut changed = 0;
            for (texel, found) in (0..).zip(map.parameters(view)) {
                let seen = |view| map.seen([texel % 6, texel / 6], view);
                let [u, v, _] = seen(view);
                assert!(found == [u, v] && found.iter().all(|c| (0.0..1.0).contains(c)), "{found:?}");
                // The negative control: another view gives other values.
                changed += usize::from(apart(seen(from_polar(0.5, 3.0))[0], u).abs() > 0.01);
            }
            assert!(changed > 18, "{changed}");
        }
    }
}
