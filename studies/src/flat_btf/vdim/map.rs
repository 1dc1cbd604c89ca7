//! Samples of a map, and the views of these samples.

use brdfc_formats::container::half;
use std::f64::consts::TAU;

/// Sizes of a map, and the views of its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VdimHeader {
    /// Texels of the reference plane per side.
    pub size: u32,
    /// Number of polar angles, 2 or more: sample `k` is at `k φ_max / (zenith_samples - 1)`.
    pub zenith_samples: u32,
    /// Number of azimuths, 3 or more: sample `a` is at `2π a / azimuth_samples`.
    pub azimuth_samples: u32,
    /// Largest polar angle `φ_max`, radians, above 0 up to π/2.
    pub largest_angle: f32,
}

impl VdimHeader {
    /// Polar angle and azimuth of the view of sample `(k, a)`, radians.
    pub fn view_angles(&self, k: u32, a: u32) -> [f64; 2] {
        let polar = f64::from(self.largest_angle) * f64::from(k) / f64::from(self.zenith_samples - 1);
        [polar, TAU * f64::from(a) / f64::from(self.azimuth_samples)]
    }

    /// Number of samples of all texels.
    pub fn samples(&self) -> u64 {
        [self.size, self.size, self.zenith_samples, self.azimuth_samples].into_iter().map(u64::from).product()
    }
}

/// Displacement from the reference, in parameters, and height of the visible point, in tiles.
pub type Displacement = ([f32; 2], f32);

/// A map: equation 2, `VDIM_v = R + Δ_v`, with the displacement `Δ_v = d_v δ_v` of equation 3 in two parts, distance
/// and direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Vdim {
    /// Sizes and views.
    pub header: VdimHeader,
    /// Parameters visible in the view along the normal, `R = VDIM_n`, row by row; not wrapped.
    pub reference: Vec<[f32; 2]>,
    /// Halves `(δx, δy, d, z)`: unit direction and length of the displacement, in parameters, and the height of the
    /// visible point in tiles. A displacement of length 0 may have direction 0.
    samples: Vec<[u16; 4]>,
}

impl Vdim {
    /// Creates a map from displacements and heights, which are rounded to halves: for each row `j` of texels, for each
    /// azimuth `a`, for each column `i`, for each polar angle `k`. Displacements along the normal, `k = 0`, are set
    /// to 0.
    ///
    /// # Panics
    /// Panics if the number of parameters or displacements is wrong.
    pub fn new(
        header: VdimHeader,
        reference: Vec<[f32; 2]>,
        displacements: impl IntoIterator<Item = Displacement>,
    ) -> Self {
        let mut samples: Vec<_> = displacements.into_iter().map(rounded).collect();
        assert_eq!(reference.len(), (header.size * header.size) as usize, "one reference for each texel");
        assert_eq!(samples.len() as u64, header.samples(), "one displacement for each texel and view");
        for polar_angles in samples.chunks_exact_mut(header.zenith_samples as usize) {
            // With the direction of the next sample, blending the two changes only the distance.
            let [x, y, ..] = polar_angles[1];
            polar_angles[0] = [x, y, 0, polar_angles[0][3]];
        }
        Self { header, reference, samples }
    }

    /// Sample `(k, a)` of texel `(i, j)` of the reference plane, `(δx, δy, d, z)`; `a` has period `azimuth_samples`.
    pub fn sample(&self, [i, j]: [u32; 2], k: u32, a: u32) -> [f32; 4] {
        let VdimHeader { size, zenith_samples, azimuth_samples, .. } = self.header;
        let at = ((j * azimuth_samples + a % azimuth_samples) * size + i) * zenith_samples + k;
        self.samples[at as usize].map(half::decode)
    }
}

/// Splits a displacement into direction and length.
fn rounded(([x, y], height): Displacement) -> [u16; 4] {
    let [x, y] = [f64::from(x), f64::from(y)];
    let distance = x.hypot(y);
    let rounded = half::encode(distance as f32);
    let direction = if rounded == 0 { [0.0; 2] } else { [x / distance, y / distance] };
    let [x, y] = direction.map(|c| half::encode(c as f32));
    [x, y, rounded, half::encode(height)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: VdimHeader = VdimHeader { size: 2, zenith_samples: 3, azimuth_samples: 4, largest_angle: 1.0 };

    /// A map whose displacements all differ.
    fn map() -> Vdim {
        let displacement = |at: u16| {
            let (turn, length) = (f32::from(at), 0.01 * f32::from(at));
            ([length * turn.cos(), length * turn.sin()], -0.02 * f32::from(at))
        };
        Vdim::new(HEADER, vec![[0.0; 2]; 4], (0..48).map(displacement))
    }

    #[test]
    fn views_end_at_the_largest_angle_and_before_a_full_turn() {
        assert_eq!([HEADER.view_angles(0, 0), HEADER.view_angles(2, 3)], [[0.0, 0.0], [1.0, 0.75 * TAU]]);
    }

    /// The control: neighbours in any index hold another displacement.
    #[test]
    fn samples_keep_the_precision_of_halves() {
        let map = map();
        let close = |texel: [u32; 2], k: u32, a: u32, at: f32| {
            let [x, y, distance, height] = map.sample(texel, k, a);
            let expected = [0.01 * at * at.cos(), 0.01 * at * at.sin()];
            (x * distance - expected[0]).abs().max((y * distance - expected[1]).abs()) < 2e-3
                && height == half::decode(half::encode(-0.02 * at))
        };
        // Texel (1, 1), azimuth 2, polar angle 2: ((4 + 2) 2 + 1) 3 + 2.
        assert!(close([1, 1], 2, 2, 41.0) && close([1, 1], 2, 6, 41.0));
        for (texel, k, a) in [([0, 1], 2, 2), ([1, 0], 2, 2), ([1, 1], 1, 2), ([1, 1], 2, 3)] {
            assert!(!close(texel, k, a, 41.0), "{texel:?} {k} {a}");
        }
    }

    #[test]
    fn the_pole_has_distance_0_and_the_direction_of_the_next_sample() {
        let map = map();
        for a in 0..4 {
            let ([x, y, distance, height], next) = (map.sample([1, 0], 0, a), map.sample([1, 0], 1, a));
            assert_eq!(([x, y], distance), ([next[0], next[1]], 0.0));
            // The height is its own.
            assert!(height != next[3], "{height}");
            assert!(next[2] > 0.0);
        }
    }

    #[test]
    fn displacements_that_round_to_0_have_no_direction() {
        let of = |length: f32| rounded(([0.6 * length, -0.8 * length], 0.5)).map(half::decode);
        assert_eq!(of(1e-9), [0.0, 0.0, 0.0, 0.5]);
        let [x, y, distance, _] = of(1e-3);
        assert!((x - 0.6).abs() < 1e-3 && (y + 0.8).abs() < 1e-3 && (distance - 1e-3).abs() < 1e-6);
    }
}
