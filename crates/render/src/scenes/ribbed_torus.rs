//! A torus with a smooth and a ribbed half, for environment lighting.

use super::grid_mesh::{quads, vertex};
use super::sky;
use crate::scene::{Camera, Mesh, Part, Scene, Surface};
use crate::vector::cross;
use brdfc_formats::direction::{Vector, normalize};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Distance from the axis to the middle of the tube.
const RING: f64 = 0.70;
/// Radius of the tube.
const TUBE: f64 = 0.36;
/// Height of the ribs, from the mean.
const HEIGHT: f64 = 0.014;
/// Number of ribs of a fully ribbed torus.
const RIBS: f64 = 18.0;
/// Azimuths of the ribbed half, radians, over which ribs rise and fall.
const RIBBED: [f64; 2] = [-FRAC_PI_2, FRAC_PI_2];
const RAMP: f64 = 0.5;
/// Angle by which the ring is turned from lying flat towards the viewer, radians.
const TURN: f64 = 0.95;

/// A step from 0 to 1 over the unit interval, twice continuously differentiable, and its derivative.
fn step(t: f64) -> [f64; 2] {
    let t = t.clamp(0.0, 1.0);
    [t * t * t * (10.0 + t * (6.0 * t - 15.0)), 30.0 * t * t * (1.0 - t) * (1.0 - t)]
}

/// Radius of the tube at an azimuth of -π to π, and its derivative.
fn tube(azimuth: f64) -> [f64; 2] {
    let ([rise, rising], [fall, falling]) = (step((azimuth - RIBBED[0]) / RAMP), step((RIBBED[1] - azimuth) / RAMP));
    let (share, change) = (rise * fall, (rising * fall - rise * falling) / RAMP);
    let (sine, cosine) = (RIBS * azimuth).sin_cos();
    [TUBE + HEIGHT * share * cosine, HEIGHT * (change * cosine - share * RIBS * sine)]
}

/// Position, and its derivatives around the ring and around the tube, in the camera's space.
fn point(azimuth: f64, around: f64) -> [Vector; 3] {
    let [radius, slope] = tube(azimuth);
    let ((sa, ca), (st, ct)) = (azimuth.sin_cos(), around.sin_cos());
    let out = RING + radius * ct;
    // The ring lies in the plane y = 0, and is turned around x.
    let turned = |[x, y, z]: Vector| [x, y * TURN.cos() - z * TURN.sin(), y * TURN.sin() + z * TURN.cos()];
    [
        turned([out * ca, radius * st, -out * sa]),
        turned([slope * ct * ca - out * sa, slope * st, -slope * ct * sa - out * ca]),
        turned([-radius * st * ca, radius * ct, radius * st * sa]),
    ]
}

/// The mesh: u runs around the ring, v around the tube.
fn mesh(columns: usize, rows: usize) -> Mesh {
    let mut mesh = Mesh { vertices: Vec::new(), triangles: quads(columns, rows) };
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = [column as f64 / columns as f64, row as f64 / rows as f64];
            let [position, along, around] = point(TAU * uv[0] - PI, TAU * uv[1]);
            mesh.vertices.push(vertex(position, normalize(cross(along, around)), along, uv));
        }
    }
    mesh
}

pub(super) fn scene() -> Scene {
    Scene {
        parts: vec![Part { name: "torus", mesh: mesh(400, 128), surface: Surface::default() }],
        camera: Camera { eye: [0.0, 0.0, 4.6], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 27.0 },
        lights: Vec::new(),
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::subtract;

    #[test]
    fn derivatives_are_those_of_positions() {
        let h = 1e-6;
        let mut sloped = 0;
        for azimuth in (-31..=31).map(|i| 0.1 * f64::from(i)) {
            for around in (0..12).map(|i| 0.5 * f64::from(i)) {
                let [_, along, across] = point(azimuth, around);
                let difference = |a: [Vector; 3], b: [Vector; 3]| subtract(b[0], a[0]).map(|c| c / (2.0 * h));
                let found = [
                    difference(point(azimuth - h, around), point(azimuth + h, around)),
                    difference(point(azimuth, around - h), point(azimuth, around + h)),
                ];
                for (found, expected) in found.iter().zip([along, across]) {
                    assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-7), "{found:?} {expected:?}");
                }
            }
            // The control: without the slope of ribs a derivative would be wrong by this much.
            sloped += usize::from(tube(azimuth)[1].abs() > 0.05);
        }
        assert!(sloped > 10, "{sloped}");
    }

    #[test]
    fn one_half_is_a_plain_torus() {
        for azimuth in [-3.1, -2.0, -1.6, 1.6, 2.5, 3.1] {
            assert_eq!(tube(azimuth), [TUBE, 0.0]);
        }
        let heights: Vec<f64> = (-100..=100).map(|i| tube(0.01 * f64::from(i))[0] - TUBE).collect();
        assert!(heights.iter().any(|h| *h > 0.9 * HEIGHT) && heights.iter().any(|h| *h < -0.9 * HEIGHT));
    }
}
