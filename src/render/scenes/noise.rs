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

/// Gradient noise in about [-1, 1] (Perlin 2002), 0 at the points of the grid: without the flat spots and straight
/// edges of value noise.
fn gradient_noise(x: f64, y: f64, seed: u64) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let (s, t) = (x - x0, y - y0);
    let at = |dx: i64, dy: i64| {
        let slope = |axis: u64| 2.0 * lattice(x0 as i64 + dx, y0 as i64 + dy, seed ^ (axis << 32)) - 1.0;
        slope(1) * (s - dx as f64) + slope(2) * (t - dy as f64)
    };
    let fade = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    1.6 * mix(mix(at(0, 0), at(1, 0), fade(s)), mix(at(0, 1), at(1, 1), fade(s)), fade(t))
}

/// Sum of octaves of gradient noise, each twice as fine and `gain` as high. `shape` is applied to each.
pub(super) fn fractal(x: f64, y: f64, seed: u64, octaves: u32, gain: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut height, mut at) = (0.0, 1.0, [x, y]);
    for octave in 0..octaves {
        sum += height * shape(gradient_noise(at[0], at[1], seed + u64::from(octave)));
        height *= gain;
        // Turned and shifted, so that lattices of octaves do not fall together.
        at = [1.6 * at[0] - 1.2 * at[1] + 17.3, 1.2 * at[0] + 1.6 * at[1] - 9.1];
    }
    sum
}
