//! Noise from a hash of integers: the same everywhere.

/// A value in [0, 1) for each point of the integer grid.
fn lattice(x: i64, y: i64, seed: u64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f) ^ seed;
    for _ in 0..2 {
        h = (h ^ (h >> 31)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    }
    ((h ^ (h >> 32)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Value noise in [-1, 1], smooth (quintic interpolation), with one feature per unit. With a period it repeats.
pub(super) fn value_noise(x: f64, y: f64, seed: u64, period: Option<[i64; 2]>) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let fade = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (s, t) = (fade(x - x0), fade(y - y0));
    let at = |dx: i64, dy: i64| {
        let point = [x0 as i64 + dx, y0 as i64 + dy];
        let [x, y] = period.map_or(point, |period| [0, 1].map(|k| point[k].rem_euclid(period[k])));
        2.0 * lattice(x, y, seed) - 1.0
    };
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    mix(mix(at(0, 0), at(1, 0), s), mix(at(0, 1), at(1, 1), s), t)
}

/// Sum of octaves of noise, each twice as fine and `gain` as high. `shape` is applied to each.
pub(super) fn fractal(x: f64, y: f64, seed: u64, octaves: u32, gain: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut height, mut frequency) = (0.0, 1.0, 1.0);
    for octave in 0..octaves {
        // Shifted, so that lattices of octaves do not fall together.
        let shift = 17.3 * f64::from(octave);
        sum +=
            height * shape(value_noise(x * frequency + shift, y * frequency - shift, seed + u64::from(octave), None));
        height *= gain;
        frequency *= 2.0;
    }
    sum
}
