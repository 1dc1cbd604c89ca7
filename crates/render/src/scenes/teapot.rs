//! A teapot: body, lid, knob, spout and handle.

use super::revolve::{cap, revolution, tube};
use super::vessels::{lit, smooth_step};
use crate::scene::{Camera, Mesh, Scene};
use brdfc_formats::direction::Vector;
use std::f64::consts::{FRAC_PI_2, PI};

/// Tiles around the body.
const AROUND: u32 = 3;
/// Length of a tile at the widest part of the body.
const TILE: f64 = 1.3;

pub(super) fn scene() -> Scene {
    let parts = [
        revolution(96, 72, AROUND, body),
        cap(96, 24, TILE, lid),
        cap(48, 24, TILE, knob),
        tube(40, 48, 1, spout),
        tube(32, 64, 1, handle),
    ];
    let mut whole = Mesh::default();
    for mesh in parts {
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(mesh.vertices);
        whole.triangles.extend(mesh.triangles.iter().map(|t| t.map(|corner| corner + first)));
    }
    let camera = Camera { eye: [0.7, 1.75, 4.2], target: [0.1, 0.45, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 30.0 };
    lit("teapot", whole, camera)
}

/// Profile from the foot to the rim that holds the lid.
fn body(t: f64) -> [f64; 2] {
    let angle = -0.9 + t * 1.95;
    let foot = 0.05 * (-t / 0.03).exp();
    [0.62 * angle.cos().max(0.0).powf(0.8) + foot, 0.38 + 0.40 * angle.sin() / 0.85]
}

/// Profile of a dome from the middle to a little inside the rim.
fn lid(t: f64) -> [f64; 2] {
    let [rim, height] = body(1.0);
    let r = (rim + 0.012) * t;
    [r, height + 0.115 * (1.0 - t * t) - 0.004]
}

/// Profile from the top down to the lid.
fn knob(t: f64) -> [f64; 2] {
    let top = lid(0.0)[1] + 0.15;
    let radius = 0.082;
    // A ball down to its waist, and straight down from there.
    let angle = PI * 0.80 * t;
    let waist = smooth_step((t - 0.78) / 0.3);
    [radius * angle.sin() + 0.02 * waist, top - radius * (1.0 - angle.cos()) - 0.03 * waist]
}

/// Curve out of the body to the right and up, with decreasing radius.
fn spout(t: f64) -> (Vector, f64) {
    let (a, b, c, d) = ([0.42, 0.22], [0.95, 0.22], [0.78, 0.66], [1.12, 0.80]);
    (bezier([a, b, c, d], t), 0.145 - 0.085 * smooth_step(t * 1.05))
}

/// Curve of an ear on the left.
fn handle(t: f64) -> (Vector, f64) {
    let angle = FRAC_PI_2 + PI * t;
    let (x, y) = (0.5 * angle.cos(), 0.235 * angle.sin());
    ([-0.44 + x, 0.42 + y - 0.05 * x, 0.0], 0.055)
}

fn bezier([a, b, c, d]: [[f64; 2]; 4], t: f64) -> Vector {
    let s = 1.0 - t;
    let at = |k: usize| s * s * s * a[k] + 3.0 * s * s * t * b[k] + 3.0 * s * t * t * c[k] + t * t * t * d[k];
    [at(0), at(1), 0.0]
}
