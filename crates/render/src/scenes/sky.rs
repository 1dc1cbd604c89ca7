//! The default environment of mirrors.

use crate::scene::Environment;

const WIDTH: usize = 128;
const HEIGHT: usize = 64;

/// A soft sky over a dark floor, with two windows.
pub(super) fn environment() -> Environment {
    let pixel = |index: usize| {
        let colatitude = std::f64::consts::PI * ((index / WIDTH) as f64 + 0.5) / HEIGHT as f64;
        let azimuth = std::f64::consts::TAU * ((index % WIDTH) as f64 + 0.5) / WIDTH as f64;
        let up = colatitude.cos();
        let mix = |t: f64, a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]));
        let sky = mix(up.max(0.0), [0.42, 0.44, 0.48], [0.16, 0.22, 0.34]);
        let floor = mix((-up).max(0.0), [0.10, 0.085, 0.07], [0.03, 0.026, 0.022]);
        let base = mix(smooth_step((up + 0.06) / 0.12), floor, sky);
        let window = |centre: f64, width: f64, low: f64, high: f64| {
            let from_centre = (azimuth - centre).sin().atan2((azimuth - centre).cos()).abs();
            let across = smooth_step((width - from_centre) / 0.08);
            across * smooth_step((up - low) / 0.06) * smooth_step((high - up) / 0.06)
        };
        // The camera of the scenes looks along -z, so mirrors show what is behind it, at +z.
        let light = 5.0 * window(1.05, 0.28, 0.25, 0.75) + 3.0 * window(2.4, 0.2, 0.2, 0.7);
        [0, 1, 2].map(|k| (base[k] + light * [1.0, 0.96, 0.9][k]) as f32)
    };
    Environment { width: WIDTH, height: HEIGHT, pixels: (0..WIDTH * HEIGHT).map(pixel).collect() }
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
