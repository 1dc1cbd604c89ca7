//! Bottle and vase: surfaces of revolution.

use super::revolve::revolution;
use super::sky;
use crate::scene::{Camera, Mesh, Part, PointLight, Scene, Surface};
use std::f64::consts::PI;

/// A scene of one part, lit from the left above, and a little from the right.
pub(super) fn lit(name: &'static str, mesh: Mesh, camera: Camera) -> Scene {
    Scene {
        parts: vec![Part { name, mesh, surface: Surface::default() }],
        camera,
        lights: vec![
            PointLight { position: [-2.8, 3.4, 3.2], intensity: [PI * 22.0; 3] },
            PointLight { position: [3.4, 1.6, 2.2], intensity: [PI * 4.0; 3] },
        ],
        environment: sky::environment(),
        background: [0.1, 0.1, 0.11],
    }
}

pub(super) fn bottle() -> Scene {
    let profile = |t: f64| {
        let foot = 0.07 * (-t / 0.02).exp();
        let lip = 0.028 * (-((t - 0.955) / 0.022).powi(2)).exp();
        let shoulder = smooth_step((t - 0.5) / 0.27);
        [0.44 - foot - 0.285 * shoulder + lip, 1.75 * t]
    };
    let mesh = revolution(96, 160, 2, profile);
    let camera = Camera { eye: [0.0, 2.3, 4.5], target: [0.0, 0.86, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 24.5 };
    lit("bottle", mesh, camera)
}

pub(super) fn vase() -> Scene {
    let profile = |t: f64| {
        let belly = 0.36 * (-((t - 0.5) / 0.27).powi(2)).exp();
        let lip = 0.14 * ((t - 0.78) / 0.22).max(0.0).powi(2);
        [0.24 + belly + lip, 1.45 * t]
    };
    let mesh = revolution(128, 128, 3, profile);
    let camera = Camera { eye: [0.0, 1.9, 4.2], target: [0.0, 0.7, 0.0], up: [0.0, 1.0, 0.0], field_of_view: 25.0 };
    lit("vase", mesh, camera)
}

pub(super) fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
