//! Local bandwidth of a picture by windowed Fourier transforms: what predictions are held against (figure 12 of Bagher et
//! al. 2012).

use rayon::prelude::*;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::f32::consts::TAU;

/// Pixels per side of a window: the paper's.
pub const WINDOW: usize = 32;

/// Bandwidth around the pixel `[column, row]` of a picture of `width` columns, cycles per pixel, 0 to 0.71: the smallest
/// radius that holds `share` of the energy of the Hann-windowed 32 x 32 pixels around it, without their mean. 0 for a
/// constant.
///
/// Rings of frequencies are half a bin wide, and the radius is interpolated in the ring where the share is reached.
///
/// # Panics
/// If the window does not lie inside the picture.
pub fn window_bandwidth(values: &[f32], width: usize, [column, row]: [usize; 2], share: f64) -> f32 {
    const HALF: usize = WINDOW / 2;
    assert!(column >= HALF && column + HALF <= width && row >= HALF, "the window lies inside");
    let weight = |k: usize| 0.5 - 0.5 * (TAU * (k as f32 + 0.5) / WINDOW as f32).cos();
    let at = |k: usize| values[(row - HALF + k / WINDOW) * width + column - HALF + k % WINDOW];
    let weights: Vec<f32> = (0..WINDOW * WINDOW).map(|k| weight(k % WINDOW) * weight(k / WINDOW)).collect();
    let total: f32 = weights.iter().sum();
    let mean = weights.iter().enumerate().map(|(k, w)| w * at(k)).sum::<f32>() / total;
    let mut spectrum: Vec<Complex<f32>> =
        weights.iter().enumerate().map(|(k, w)| Complex::new(w * (at(k) - mean), 0.0)).collect();
    transform(&mut spectrum);
    radius_of_share(&spectrum, share)
}

/// The same for each of the pixels, in order.
pub fn window_bandwidths(values: &[f32], width: usize, pixels: &[[usize; 2]], share: f64) -> Vec<f32> {
    pixels.par_iter().map(|pixel| window_bandwidth(values, width, *pixel, share)).collect()
}

/// In two dimensions, in place; the result is transposed.
fn transform(values: &mut [Complex<f32>]) {
    let plan = FftPlanner::new().plan_fft_forward(WINDOW);
    plan.process(values);
    for row in 0..WINDOW {
        for column in 0..row {
            values.swap(row * WINDOW + column, column * WINDOW + row);
        }
    }
    plan.process(values);
}

fn radius_of_share(spectrum: &[Complex<f32>], share: f64) -> f32 {
    let signed = |k: usize| if k < WINDOW / 2 { k as f64 } else { k as f64 - WINDOW as f64 };
    let mut rings = [0.0f64; 2 * WINDOW];
    for (k, value) in spectrum.iter().enumerate() {
        let radius = signed(k % WINDOW).hypot(signed(k / WINDOW));
        rings[(2.0 * radius + 0.5) as usize] += f64::from(value.norm_sqr());
    }
    let wanted = share * rings.iter().sum::<f64>();
    if wanted <= 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for (ring, energy) in rings.iter().enumerate() {
        if sum + energy >= wanted {
            let inside = (wanted - sum) / energy;
            return (((ring as f64 - 0.5 + inside) / 2.0).max(0.0) / WINDOW as f64) as f32;
        }
        sum += energy;
    }
    0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_have_their_frequency() {
        for (fx, fy) in [(0.05f32, 0.0f32), (0.1, 0.1), (0.25, 0.1), (0.0, 0.4)] {
            let wave: Vec<f32> =
                (0..64 * 64).map(|i| 3.0 + (TAU * (fx * (i % 64) as f32 + fy * (i / 64) as f32)).sin()).collect();
            let found = window_bandwidth(&wave, 64, [30, 33], 0.9);
            // The window spreads a wave over one and a half bins.
            assert!((found - fx.hypot(fy)).abs() < 1.5 / WINDOW as f32, "{fx} {fy}: {found}");
        }
        assert_eq!(window_bandwidth(&[2.5; 64 * 64], 64, [32, 32], 0.9), 0.0);
    }

    #[test]
    fn a_share_holds_what_is_below_it() {
        // Strong and slow, weak and fast: a quarter of the amplitude, a sixteenth of the energy.
        let wave = |i: usize| {
            let x = (i % 64) as f32;
            (TAU * x / 16.0).sin() + 0.25 * (TAU * x / 3.0).sin()
        };
        let wave: Vec<f32> = (0..64 * 64).map(wave).collect();
        let [slow, fast] = [0.9, 0.99].map(|share| window_bandwidth(&wave, 64, [32, 32], share));
        assert!(slow < 0.12 && (0.28..0.4).contains(&fast), "{slow} {fast}");
    }
}
