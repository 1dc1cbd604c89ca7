//! Cloth that falls over a round pedestal, by position-based dynamics (Müller et al. 2007) with small steps.
//!
//! Uses only + - * / and square roots, so that the result is the same on every machine.

use crate::vector::{add_scaled, subtract};
use brdfc_flat_btf::structures::noise::value_noise;
use brdfc_formats::direction::{Vector, dot};

/// Number of steps with half as many quads per side, where large motion is cheap.
const COARSE_STEPS: usize = 800;
/// Number of steps with all quads: these add fine folds and remove excess stretch of the finer cloth.
const FINE_STEPS: usize = 110;
/// Length of a step, seconds.
const STEP: f64 = 1.0 / 260.0;
/// Acceleration of the fall, units per second squared.
const GRAVITY: f64 = 6.0;
/// Share of the velocity that a step retains.
const DAMPING: f64 = 0.992;
/// Share of the sliding that friction removes at the pedestal or the floor.
const FRICTION: f64 = 0.35;
/// Decrease of the pedestal's radius per unit of depth below its rim, which leaves room for folds.
const TAPER: f64 = 0.45;
/// Number of passes that remove the last small wrinkles.
const SMOOTHING: usize = 9;
/// Share of the error in length that one step corrects: along the weave, across it, and over two quads (bending).
const STIFFNESS: [f64; 3] = [1.0, 0.3, 0.35];

/// A square cloth and the pedestal that it falls on. The top of the pedestal is at height 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Drape {
    /// Length of a side.
    pub side: f64,
    /// Quads per side, an even number.
    pub quads: usize,
    /// Middle of the cloth relative to the middle of the pedestal, `[x, z]`. An offset makes folds less alike.
    pub offset: [f64; 2],
    /// Radius of the pedestal.
    pub radius: f64,
    /// Radius of its rounded rim.
    pub rim: f64,
    /// Height of a floor, which stops the cloth.
    pub floor: f64,
    /// Seed of the noise that folds start from.
    pub seed: u64,
}

/// Two points that keep their distance.
struct Link {
    ends: [usize; 2],
    length: f64,
    stiffness: f64,
}

impl Drape {
    /// Points of the fallen cloth, `quads + 1` rows of as many; columns run along +x, rows along -z.
    pub(super) fn fall(&self) -> Vec<Vector> {
        let coarse = self.quads / 2;
        let mut points = self.flat(coarse);
        self.relax(&mut points, coarse, COARSE_STEPS);
        let mut points = refine(&points, coarse + 1);
        self.relax(&mut points, 2 * coarse, FINE_STEPS);
        for _ in 0..SMOOTHING {
            points = smooth(&points, 2 * coarse + 1);
            points.iter_mut().for_each(|point| {
                self.push_out(point);
            });
        }
        points
    }

    /// The cloth before it falls: flat except for a little noise, without which it would balance and fold alike
    /// everywhere.
    fn flat(&self, quads: usize) -> Vec<Vector> {
        let point = |index: usize| {
            let at = |i: usize| i as f64 / quads as f64 - 0.5;
            let (u, v) = (at(index % (quads + 1)), at(index / (quads + 1)));
            let (x, z) = (self.offset[0] + self.side * u, self.offset[1] - self.side * v);
            [x, 0.01 + 0.03 * (1.0 + value_noise(9.0 * u + 20.0, 9.0 * v + 20.0, self.seed, None)), z]
        };
        (0..(quads + 1) * (quads + 1)).map(point).collect()
    }

    fn relax(&self, points: &mut [Vector], quads: usize, steps: usize) {
        let links = links(quads, self.side / quads as f64);
        let mut before = points.to_vec();
        for step in 0..steps {
            for (point, before) in points.iter_mut().zip(&mut before) {
                let velocity = subtract(*point, *before);
                *before = *point;
                *point = add_scaled(*point, DAMPING, velocity);
                point[1] -= GRAVITY * STEP * STEP;
            }
            // Alternate the order of links, so that it has no effect.
            if step % 2 == 0 {
                links.iter().for_each(|link| link.pull(points));
            } else {
                links.iter().rev().for_each(|link| link.pull(points));
            }
            for (point, before) in points.iter_mut().zip(&before) {
                if self.push_out(point) {
                    *point = add_scaled(*point, -FRICTION, subtract(*point, *before));
                    self.push_out(point);
                }
            }
        }
    }

    /// Moves a point out of the pedestal and the floor. Returns true if it was inside.
    fn push_out(&self, point: &mut Vector) -> bool {
        let radial = (point[0] * point[0] + point[2] * point[2]).sqrt();
        // Relative to the circle in the middle of the rim's rounding.
        let (out, up) = (radial - (self.radius - self.rim), point[1] + self.rim);
        let wall = out - TAPER * up.min(0.0);
        let (distance, direction) = if out > 0.0 && up > 0.0 {
            let length = (out * out + up * up).sqrt();
            (length, [out / length, up / length])
        } else if up > wall {
            (up, [0.0, 1.0])
        } else {
            (wall, [1.0, 0.0])
        };
        let inside = self.rim - distance;
        let mut touches = inside > 0.0;
        if touches {
            let outwards = direction[0] * inside / radial.max(1e-12);
            *point = [point[0] * (1.0 + outwards), point[1] + direction[1] * inside, point[2] * (1.0 + outwards)];
        }
        if point[1] < self.floor {
            point[1] = self.floor;
            touches = true;
        }
        touches
    }
}

impl Link {
    fn pull(&self, points: &mut [Vector]) {
        let [a, b] = self.ends;
        let apart = subtract(points[b], points[a]);
        let length = dot(apart, apart).sqrt();
        let share = 0.5 * self.stiffness * (1.0 - self.length / length.max(1e-12));
        points[a] = add_scaled(points[a], share, apart);
        points[b] = add_scaled(points[b], -share, apart);
    }
}

fn links(quads: usize, spacing: f64) -> Vec<Link> {
    let [weave, shear, bend] = STIFFNESS;
    let side = quads as i64 + 1;
    let diagonal = 2f64.sqrt() * spacing;
    let mut links = Vec::new();
    for (step, length, stiffness) in [
        ([2, 0], 2.0 * spacing, bend),
        ([0, 2], 2.0 * spacing, bend),
        ([1, 1], diagonal, shear),
        ([-1, 1], diagonal, shear),
        ([1, 0], spacing, weave),
        ([0, 1], spacing, weave),
    ] {
        for row in 0..side - step[1] {
            for column in 0..side {
                let other = column + step[0];
                if (0..side).contains(&other) {
                    let ends = [row * side + column, (row + step[1]) * side + other].map(|i| i as usize);
                    links.push(Link { ends, length, stiffness });
                }
            }
        }
    }
    links
}

/// Inserts a point between any two of a square grid, on the cubic through four.
fn refine(points: &[Vector], side: usize) -> Vec<Vector> {
    let finer = |line: &dyn Fn(usize) -> Vector| -> Vec<Vector> {
        (0..2 * side - 1)
            .map(|k| {
                let i = k / 2;
                if k % 2 == 0 {
                    return line(i);
                }
                if i == 0 || i + 2 == side {
                    return [0, 1, 2].map(|c| 0.5 * (line(i)[c] + line(i + 1)[c]));
                }
                let [a, b, c, d] = [i - 1, i, i + 1, i + 2].map(line);
                [0, 1, 2].map(|k| 0.5625 * (b[k] + c[k]) - 0.0625 * (a[k] + d[k]))
            })
            .collect()
    };
    let long = 2 * side - 1;
    let wide: Vec<Vector> = (0..side).flat_map(|row| finer(&|column| points[row * side + column])).collect();
    let columns: Vec<Vec<Vector>> = (0..long).map(|column| finer(&|row| wide[row * long + column])).collect();
    (0..long * long).map(|index| columns[index % long][index / long]).collect()
}

/// Moves each point a quarter of the way to the middle of its neighbours. Points of the hem move only along it.
fn smooth(points: &[Vector], side: usize) -> Vec<Vector> {
    let point = |index: usize| {
        let (column, row) = (index % side, index / side);
        let (hem_u, hem_v) = (column == 0 || column + 1 == side, row == 0 || row + 1 == side);
        let pull = |stays: bool, step: usize| -> Vector {
            if stays {
                return [0.0; 3];
            }
            let (a, b, middle) = (points[index - step], points[index + step], points[index]);
            [0, 1, 2].map(|k| 0.125 * (a[k] + b[k] - 2.0 * middle[k]))
        };
        let (along_u, along_v) = (pull(hem_u, 1), pull(hem_v, side));
        [0, 1, 2].map(|k| points[index][k] + along_u[k] + along_v[k])
    };
    (0..points.len()).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRAPE: Drape =
        Drape { side: 2.0, quads: 24, offset: [0.03, 0.02], radius: 0.5, rim: 0.1, floor: -0.4, seed: 3 };

    #[test]
    fn a_fallen_cloth_is_outside_and_has_its_lengths() {
        let points = DRAPE.fall();
        assert_eq!(points.len(), 25 * 25);
        assert_eq!(points, DRAPE.fall());
        for point in &points {
            let mut moved = *point;
            DRAPE.push_out(&mut moved);
            let off = subtract(moved, *point);
            assert!(dot(off, off).sqrt() < 1e-9, "{point:?}");
        }
        // It has fallen.
        assert!(points[0][1] < -0.3 && points[24 * 25 + 24][1] < -0.3);
        let stretch: Vec<f64> = links(24, 2.0 / 24.0)
            .iter()
            .filter(|link| link.stiffness == STIFFNESS[0])
            .map(|link| {
                let apart = subtract(points[link.ends[0]], points[link.ends[1]]);
                dot(apart, apart).sqrt() / link.length
            })
            .collect();
        assert!(stretch.iter().all(|s| (0.8..1.2).contains(s)), "{stretch:?}");
    }

    #[test]
    fn refinement_preserves_points_and_planes() {
        let side = 5;
        let plane = |x: f64, z: f64| [x, 0.5 * x - 0.25 * z, z];
        let coarse: Vec<Vector> = (0..25).map(|i| plane((i % side) as f64, (i / side) as f64)).collect();
        let fine = refine(&coarse, side);
        for (index, point) in fine.iter().enumerate() {
            let expected = plane((index % 9) as f64 / 2.0, (index / 9) as f64 / 2.0);
            assert!((0..3).all(|k| (point[k] - expected[k]).abs() < 1e-12), "{index}: {point:?}");
        }
    }
}
