//! Noise from an integer hash: the same on every machine.

/// Hashes a point of the integer grid to a value in [0, 1).
pub fn lattice(x: i64, y: i64, seed: u64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f) ^ seed;
    for _ in 0..2 {
        h = (h ^ (h >> 31)).wrapping_mul(0xd6e8_feb8_6659_fd93);
    }
    ((h ^ (h >> 32)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Wraps a point of the grid into the period, if there is one.
fn wrapped([x, y]: [i64; 2], period: Option<[i64; 2]>) -> [i64; 2] {
    period.map_or([x, y], |[width, height]| [x.rem_euclid(width), y.rem_euclid(height)])
}

/// Quintic step from 0 to 1, flat to the second derivative at its ends (Perlin 2002).
pub fn fade(t: f64) -> f64 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// `a` at `t = 0`, `b` at `t = 1`.
pub fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

/// [`fade`] from 0 at `start` to 1 at `end`.
pub fn smooth_step(start: f64, end: f64, x: f64) -> f64 {
    fade(((x - start) / (end - start)).clamp(0.0, 1.0))
}

/// Value noise in [-1, 1], smooth (quintic interpolation), with one feature per unit; periodic if `period` is given.
pub fn value_noise(x: f64, y: f64, seed: u64, period: Option<[i64; 2]>) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let (s, t) = (fade(x - x0), fade(y - y0));
    let at = |dx: i64, dy: i64| {
        let [x, y] = wrapped([x0 as i64 + dx, y0 as i64 + dy], period);
        2.0 * lattice(x, y, seed) - 1.0
    };
    mix(mix(at(0, 0), at(1, 0), s), mix(at(0, 1), at(1, 1), s), t)
}

/// Gradient noise in about [-1, 1] (Perlin 2002), 0 at the points of the grid, without the flat spots and straight
/// edges of value noise; periodic if `period` is given.
pub fn gradient_noise(x: f64, y: f64, seed: u64, period: Option<[i64; 2]>) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let (s, t) = (x - x0, y - y0);
    let at = |dx: i64, dy: i64| {
        let [column, row] = wrapped([x0 as i64 + dx, y0 as i64 + dy], period);
        let slope = |axis: u64| 2.0 * lattice(column, row, seed ^ (axis << 32)) - 1.0;
        slope(1) * (s - dx as f64) + slope(2) * (t - dy as f64)
    };
    1.6 * mix(mix(at(0, 0), at(1, 0), fade(s)), mix(at(0, 1), at(1, 1), fade(s)), fade(t))
}

/// Sum of octaves of gradient noise, each with twice the frequency and `gain` times the amplitude of the previous one.
/// `shape` is applied to each octave.
pub fn fractal(x: f64, y: f64, seed: u64, octaves: u32, gain: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut height, mut at) = (0.0, 1.0, [x, y]);
    for octave in 0..octaves {
        sum += height * shape(gradient_noise(at[0], at[1], seed + u64::from(octave), None));
        height *= gain;
        // Rotated and shifted, so that the lattices of octaves do not coincide.
        at = [1.6 * at[0] - 1.2 * at[1] + 17.3, 1.2 * at[0] + 1.6 * at[1] - 9.1];
    }
    sum
}

/// Sum of octaves of gradient noise over the unit tile, with period 1 along u and v: `cells` features per tile in the
/// first octave; each further octave has twice the frequency and `gain` times the amplitude.
pub fn periodic_fractal(u: f64, v: f64, seed: u64, cells: [i64; 2], octaves: u32, gain: f64) -> f64 {
    (0..octaves)
        .map(|octave| {
            let period = cells.map(|n| n << octave);
            // Shifted, so that not all octaves are 0 at the same points.
            let shift = 0.37 * f64::from(octave);
            let noise = gradient_noise(
                u * period[0] as f64 + shift,
                v * period[1] as f64 + shift,
                seed + u64::from(octave),
                Some(period),
            );
            gain.powi(octave as i32) * noise
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_repeats() {
        let at = |u: f64, v: f64| periodic_fractal(u, v, 7, [3, 5], 3, 0.5);
        let mut largest: f64 = 0.0;
        for k in 0..200 {
            let (u, v) = (lattice(k, 0, 1), lattice(k, 1, 1));
            assert!((at(u + 1.0, v) - at(u, v)).abs() < 1e-12 && (at(u, v - 2.0) - at(u, v)).abs() < 1e-12);
            assert!(
                (value_noise(4.0 * u + 4.0, v, 2, Some([4, 1])) - value_noise(4.0 * u, v, 2, Some([4, 1]))).abs()
                    < 1e-12
            );
            largest = largest.max(at(u, v).abs());
        }
        assert!(largest > 0.2, "{largest}");
        assert!((at(0.31, 0.2) - periodic_fractal(0.31, 0.2, 8, [3, 5], 3, 0.5)).abs() > 1e-3);
    }
}
