//! Local bandwidth of a rendering by windowed Fourier transforms, the reference for predictions (figure 12 of Bagher et
//! al. 2012).

use microfft::Complex32;
use microfft::complex::cfft_32;
use rayon::prelude::*;
use std::f32::consts::TAU;

/// Pixels per side of a window, as in the paper.
pub const WINDOW: usize = 32;

/// Frequencies around a pixel, cycles per pixel, 0 to 0.71.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WindowBandwidth {
    /// Root of the mean squared frequency of the window without its mean. It does not depend on the contrast.
    pub frequency: f32,
    /// The same with the mean, which has the frequency 0: the root mean square of the gradient over that of the value,
    /// divided by 2 π. It is small where little can be seen.
    pub detail: f32,
}

/// Bandwidth around the pixel `[column, row]` of a rendering of `width` columns, of the Hann-windowed 32 x 32 pixels
/// around it. 0 for a constant.
///
/// A share of the energy would be equally good for windows with much of it. In smooth windows it would be determined by
/// the remaining noise of the rendering. The window itself spreads low frequencies to 0.02 cycles per pixel.
///
/// # Panics
/// If the window is not inside the rendering.
pub fn window_bandwidth(values: &[f32], width: usize, [column, row]: [usize; 2]) -> WindowBandwidth {
    const HALF: usize = WINDOW / 2;
    assert!(column >= HALF && column + HALF <= width && row >= HALF, "the window lies inside");
    // Relative to one of the values, so that a constant has no rounding error.
    let at = |k: usize| {
        values[(row - HALF + k / WINDOW) * width + column - HALF + k % WINDOW] - values[row * width + column]
    };
    let weights = hann();
    let total: f32 = weights.iter().sum();
    let mean = weights.iter().enumerate().map(|(k, w)| w * at(k)).sum::<f32>() / total;
    let mut spectrum: Vec<Complex32> =
        weights.iter().enumerate().map(|(k, w)| Complex32::new(w * (at(k) - mean), 0.0)).collect();
    transform(&mut spectrum);
    // The transform of a constant has this energy; its sidelobes are part of the window.
    let mean = f64::from(mean + values[row * width + column]);
    let squared_weights: f32 = weights.iter().map(|w| w * w).sum();
    root_mean_square(&spectrum, mean * mean * f64::from(squared_weights) * spectrum.len() as f64)
}

/// Weights of the pixels of a window, row by row.
fn hann() -> Vec<f32> {
    let weight = |k: usize| 0.5 - 0.5 * (TAU * (k as f32 + 0.5) / WINDOW as f32).cos();
    (0..WINDOW * WINDOW).map(|k| weight(k % WINDOW) * weight(k / WINDOW)).collect()
}

/// [`window_bandwidth`] for each of the pixels, in order.
pub fn window_bandwidths(values: &[f32], width: usize, pixels: &[[usize; 2]]) -> Vec<WindowBandwidth> {
    pixels.par_iter().map(|pixel| window_bandwidth(values, width, *pixel)).collect()
}

/// Two-dimensional transform, in place; the result is transposed.
fn transform(values: &mut [Complex32]) {
    let each_row = |values: &mut [Complex32]| {
        values.as_chunks_mut::<WINDOW>().0.iter_mut().for_each(|row| {
            let _ = cfft_32(row);
        });
    };
    each_row(values);
    for row in 0..WINDOW {
        for column in 0..row {
            values.swap(row * WINDOW + column, column * WINDOW + row);
        }
    }
    each_row(values);
}

fn root_mean_square(spectrum: &[Complex32], of_mean: f64) -> WindowBandwidth {
    let signed = |k: usize| if k < WINDOW / 2 { k as f64 } else { k as f64 - WINDOW as f64 };
    let (mut energy, mut squares) = (0.0, 0.0);
    for (k, value) in spectrum.iter().enumerate() {
        let [u, v] = [signed(k % WINDOW), signed(k / WINDOW)];
        let here = f64::from(value.norm_sqr());
        energy += here;
        squares += here * (u * u + v * v);
    }
    let over = |energy: f64| if energy > 0.0 { ((squares / energy).sqrt() / WINDOW as f64) as f32 } else { 0.0 };
    WindowBandwidth { frequency: over(energy), detail: over(energy + of_mean) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rendering(value: impl Fn(f32, f32) -> f32) -> Vec<f32> {
        (0..64 * 64).map(|i| value((i % 64) as f32, (i / 64) as f32)).collect()
    }

    #[test]
    fn waves_have_their_frequency() {
        for (fx, fy) in [(0.05f32, 0.0f32), (0.1, 0.1), (0.25, 0.1), (0.0, 0.4)] {
            let wave = rendering(|x, y| 3.0 + (TAU * (fx * x + fy * y)).sin());
            let found = window_bandwidth(&wave, 64, [30, 33]);
            assert!((found.frequency / fx.hypot(fy) - 1.0).abs() < 0.15, "{fx} {fy}: {found:?}");
        }
        assert_eq!(window_bandwidth(&[2.5; 64 * 64], 64, [32, 32]), WindowBandwidth::default());
    }

    /// A wave of amplitude a around the value m has a share of a²/2 of the energy a²/2 + m².
    #[test]
    fn detail_grows_with_the_contrast() {
        for (amplitude, mean) in [(1.0f32, 3.0f32), (0.1, 3.0), (0.5, 0.5)] {
            let wave = rendering(|x, _| mean + amplitude * (TAU * x / 8.0).sin());
            let found = window_bandwidth(&wave, 64, [30, 33]);
            let energy = 0.5 * amplitude * amplitude;
            let expected = 0.125 * (energy / (energy + mean * mean)).sqrt();
            assert!((found.detail / expected - 1.0).abs() < 0.1, "{found:?} {expected}");
            // The control: the other measure is the same for every contrast.
            assert!((found.frequency / 0.125 - 1.0).abs() < 0.1, "{found:?}");
        }
    }

    #[test]
    fn frequencies_count_by_their_energy() {
        let mixed = rendering(|x, _| (TAU * x / 16.0).sin() + (TAU * x / 4.0).sin());
        let expected = (0.5 * (0.0625f32.powi(2) + 0.25f32.powi(2))).sqrt();
        let found = window_bandwidths(&mixed, 64, &[[32, 32], [20, 40]]);
        assert!(found.iter().all(|found| (found.frequency / expected - 1.0).abs() < 0.05), "{found:?} {expected}");
    }
}
