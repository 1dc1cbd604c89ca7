//! Texels of the six faces of a cube map, and their convolution with kernels.

use super::kernel::Kernel;
use brdfc_formats::direction::{Vector, dot, normalize};
use brdfc_formats::environment::cube::FacePoint;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Angle between the centre and a corner of a face, rounded up, radians.
const CORNER: f64 = 0.9554;

/// Six faces of square texels, in the order of a cube map.
pub struct Faces {
    side: usize,
    texels: Vec<[f32; 3]>,
}

impl Faces {
    /// Wraps `6 side²` texels.
    pub fn new(side: usize, texels: Vec<[f32; 3]>) -> Self {
        Self { side, texels }
    }

    /// Texels along each side of a face.
    pub fn side(&self) -> usize {
        self.side
    }

    /// All texels, face by face, row by row.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// Faces of half the side. Each texel is the mean of four, weighted by their solid angles.
    pub fn halved(&self) -> Self {
        let half = self.side / 2;
        let mean = |at: usize| {
            let (face, row, column) = (at / (half * half), at / half % half, at % half);
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [2 * column + x, 2 * row + y]) {
                let weight = self.solid_angle([x, y]);
                let texel = self.texels[(face * self.side + y) * self.side + x];
                (0..3).for_each(|k| sum[k] += weight * f64::from(texel[k]));
                total += weight;
            }
            sum.map(|s| (s / total) as f32)
        };
        Self { side: half, texels: (0..6 * half * half).map(mean).collect() }
    }

    /// Convolution with a kernel, at the texels of faces with another side. A constant environment stays constant.
    pub fn convolved(&self, side: usize, kernel: &dyn Kernel) -> Vec<[f32; 3]> {
        let place = |at: usize| {
            let (face, row, column) = (at / (self.side * self.side), at / self.side % self.side, at % self.side);
            (centre(face, self.side, column, row), self.solid_angle([column, row]))
        };
        let places: Vec<(Vector, f64)> = (0..6 * self.side * self.side).map(place).collect();
        let texel = |at: usize| {
            let (face, row, column) = (at / (side * side), at / side % side, at % side);
            self.mean_around(centre(face, side, column, row), kernel, &places)
        };
        (0..6 * side * side).into_par_iter().map(texel).collect()
    }

    /// Mean of the texels around a unit vector, weighted by the kernel and their solid angles. `places` are the
    /// directions and solid angles of all texels.
    fn mean_around(&self, axis: Vector, kernel: &dyn Kernel, places: &[(Vector, f64)]) -> [f32; 3] {
        let least = kernel.radius().cos();
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for face in 0..6 {
            let [columns, rows] = self.covered(face, axis, kernel.radius());
            for row in rows {
                let start = (face * self.side + row) * self.side;
                for at in start + columns.start..start + columns.end {
                    let (direction, solid_angle) = places[at];
                    let cosine = dot(direction, axis);
                    if cosine > least {
                        let weight = kernel.at(cosine) * solid_angle;
                        (0..3).for_each(|k| sum[k] += weight * f64::from(self.texels[at][k]));
                        total += weight;
                    }
                }
            }
        }
        sum.map(|s| (s / total) as f32)
    }

    /// Columns and rows of a face that contain all texels within an angle of a unit vector.
    fn covered(&self, face: usize, axis: Vector, radius: f64) -> [std::ops::Range<usize>; 2] {
        let centre = FacePoint { face, s: 0.0, t: 0.0 }.direction();
        // The corners of a face are farthest from its centre. Most faces end here, before the trigonometry.
        if dot(axis, centre) < (radius + CORNER).min(PI).cos() {
            return [0..0, 0..0];
        }
        let [s_axis, t_axis] = [[1.0, 0.0], [0.0, 1.0]].map(|[s, t]| {
            let direction = FacePoint { face, s, t }.direction();
            [0, 1, 2].map(|k| direction[k] - centre[k])
        });
        let depth = dot(axis, centre);
        [s_axis, t_axis].map(|along| {
            let [low, high] = tangents(dot(axis, along), depth, radius);
            let texel = |tangent: f64| 0.5 * (tangent + 1.0) * self.side as f64;
            let (low, high) = (texel(low).floor().max(0.0) as usize, texel(high).ceil().max(0.0) as usize);
            low.min(self.side)..high.min(self.side)
        })
    }

    /// Solid angle of a texel, sr, from the solid angle per area at its centre.
    fn solid_angle(&self, [column, row]: [usize; 2]) -> f64 {
        let [s, t] = [column, row].map(|at| 2.0 * (at as f64 + 0.5) / self.side as f64 - 1.0);
        4.0 / (self.side * self.side) as f64 / (1.0 + s * s + t * t).powf(1.5)
    }
}

/// Unit vector to the centre of a texel.
fn centre(face: usize, side: usize, column: usize, row: usize) -> Vector {
    normalize(FacePoint::on_grid(face, side, [column as f64 + 0.5, row as f64 + 0.5]).direction())
}

/// Range of `tan` of the angles that a cone covers within 45 degrees of the centre of a face, along one of its axes. The
/// cone has an axis with these components along that axis and towards the face. Empty ranges are reversed.
fn tangents(along: f64, depth: f64, radius: f64) -> [f64; 2] {
    let length = along.hypot(depth);
    // The projection of the cone on the plane of both axes is a wedge, or everything.
    if radius >= FRAC_PI_2 || length <= radius.sin() {
        return [-1.0, 1.0];
    }
    let (angle, spread) = (along.atan2(depth), (radius.sin() / length).asin());
    let (low, high) = (angle - spread, angle + spread);
    if low > FRAC_PI_4 || high < -FRAC_PI_4 {
        return [1.0, -1.0];
    }
    [low.max(-FRAC_PI_4).tan(), high.min(FRAC_PI_4).tan()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{Cosine, Gaussian};

    fn unit(at: usize) -> Vector {
        let (z, turn) = (1.0 - 2.0 * (at as f64 + 0.5) / 50.0, at as f64 * 2.4);
        let r = (1.0 - z * z).sqrt();
        [r * turn.cos(), z, r * turn.sin()]
    }

    #[test]
    fn solid_angles_cover_the_sphere() {
        for side in [8, 32] {
            let faces = Faces::new(side, Vec::new());
            let sum: f64 = (0..side * side).map(|at| 6.0 * faces.solid_angle([at % side, at / side])).sum();
            assert!((sum / (2.0 * std::f64::consts::TAU) - 1.0).abs() < 0.3 / (side * side) as f64, "{side}: {sum}");
        }
    }

    #[test]
    fn covered_texels_are_all_that_are_near() {
        let side = 16;
        let faces = Faces::new(side, vec![[0.0; 3]; 6 * side * side]);
        for (axis, radius) in
            (0..50).map(unit).flat_map(|axis| [0.05, 0.4, 1.1, FRAC_PI_2].map(|radius| (axis, radius)))
        {
            for face in 0..6 {
                let [columns, rows] = faces.covered(face, axis, radius);
                for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
                    let direction = centre(face, side, column, row);
                    let is_near = dot(direction, axis) > radius.cos();
                    assert!(!is_near || (columns.contains(&column) && rows.contains(&row)), "{axis:?} {radius} {face}");
                }
            }
        }
    }

    /// Linear functions of the direction are scaled by the mean cosine of a kernel: 2/3 for irradiance, coth κ - 1/κ for
    /// Gaussians.
    #[test]
    fn first_harmonics_have_their_known_factor() {
        let side = 64;
        let texels = (0..6 * side * side).map(|at| {
            let [x, y, z] = centre(at / (side * side), side, at % side, at / side % side);
            [1.0 + 0.5 * x, 1.0 + 0.5 * y, 1.0 + 0.5 * z].map(|c| c as f32)
        });
        let faces = Faces::new(side, texels.collect());
        let concentration = |deviation: f64| 1.0 / (deviation * deviation);
        let gaussian = |deviation: f64| 1.0 / concentration(deviation).tanh() - 1.0 / concentration(deviation);
        let kernels: [(Box<dyn Kernel>, f64); 3] = [
            (Box::new(Cosine), 2.0 / 3.0),
            (Box::new(Gaussian::new(0.2, side)), gaussian(0.2)),
            (Box::new(Gaussian::new(0.07, side)), gaussian(0.07)),
        ];
        for (kernel, factor) in kernels {
            for (at, found) in faces.convolved(4, kernel.as_ref()).into_iter().enumerate() {
                let direction = centre(at / 16, 4, at % 4, at / 4 % 4);
                for k in 0..3 {
                    let expected = 1.0 + 0.5 * factor * direction[k];
                    assert!((f64::from(found[k]) - expected).abs() < 1e-3, "{at} {factor}: {found:?} {expected}");
                }
            }
        }
    }
}
