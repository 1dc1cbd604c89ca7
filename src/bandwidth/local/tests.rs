use super::*;
use std::f64::consts::TAU;

fn image(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let at = |i: usize, size: usize| (i as f64 + 0.5) / size as f64;
    (0..width * height).map(|i| value(at(i % width, width), at(i / width, height)) as f32).collect()
}

fn range(values: &[f32]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, 0.0], |[low, high], v| [low.min(f64::from(*v)), high.max(f64::from(*v))])
}

/// Smallest and largest ratio of the frequency found to the true one, of waves along u and along v.
fn ratios(size: usize, cycles: f64, epsilon: f64) -> [f64; 2] {
    let mut all = [f64::INFINITY, 0.0f64];
    for along_v in [false, true] {
        let wave = image(size, size, |x, y| (TAU * cycles * if along_v { y } else { x } + 0.3).sin() + 0.1);
        let found = frequencies(&wave, [size; 2], size, Border::Periodic, epsilon);
        let (own, other) = if along_v { (&found.v, &found.u) } else { (&found.u, &found.v) };
        assert_eq!(range(other), [0.0; 2], "nothing across");
        let [low, high] = range(own).map(|f| f * size as f64 / cycles);
        all = [all[0].min(low), all[1].max(high)];
    }
    all
}

#[test]
fn a_wave_has_its_frequency_anywhere() {
    for cycles in [1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 16, 23, 32, 45] {
        let [low, high] = ratios(256, f64::from(cycles), 0.01);
        assert!(low > 1.2 && high < 1.45, "{cycles}: {low} {high}");
    }
}

/// Where there is no finer level.
#[test]
fn waves_up_to_the_nyquist_rate() {
    for cycles in [60, 64, 70, 76, 84, 90, 96, 100, 110, 120, 127] {
        let [low, high] = ratios(256, f64::from(cycles), 0.01);
        assert!(low > 0.85 && high < 2.0, "{cycles}: {low} {high}");
    }
    let checks = image(64, 64, |x, y| (32.0 * TAU * (x - 1.0 / 128.0)).cos() * (32.0 * TAU * (y - 1.0 / 128.0)).cos());
    let found = frequencies(&checks, [64; 2], 64, Border::Periodic, 0.01);
    assert_eq!((range(&found.u), range(&found.v)), ([0.5; 2], [0.5; 2]));
}

#[test]
fn the_threshold_hardly_matters() {
    for cycles in [3.0, 10.0, 33.0] {
        let [low, high] = ratios(256, cycles, 0.01);
        for epsilon in [0.003, 0.03] {
            let other = ratios(256, cycles, epsilon);
            assert!(other[0] / low > 0.93 && other[1] / high < 1.07, "{cycles} {epsilon}: {other:?} {low} {high}");
        }
    }
}

/// The negative control: a tail that starts one level off, either way, is out of the bounds that hold above.
#[test]
fn a_tail_that_starts_one_level_off_is_seen() {
    let cycles = 11.0;
    let wave = image(256, 256, |x, _| (TAU * cycles * x + 0.3).sin());
    let scales = scales(&wave, [256; 2], 128, Border::Periodic);
    let (largest, next) = maxima(&scales, 128, 128);
    let rule = Rule::new(0.01);
    let found = |lambda: &dyn Fn(usize) -> Option<f32>| {
        f64::from(rule.frequency(lambda, largest[0], next.at(0, 0))) * 256.0 / cycles
    };
    let good = found(&|k| scales.get(k).map(|s| s.u[0]));
    assert!(good > 1.28 && good < 1.45, "{good}");
    let coarser = found(&|k| if k == 0 { Some(0.0) } else { scales.get(k - 1).map(|s| s.u[0]) });
    let finer = found(&|k| scales.get(k + 1).map(|s| s.u[0]));
    assert!(coarser < 1.0 && finer > 2.0, "{coarser} {finer}");
}

#[test]
fn what_is_constant_up_to_rounding_has_no_bandwidth() {
    for border in [Border::Periodic, Border::Bounded] {
        for value in [0.0f32, 1.0, 0.1, 3.3e7, 1e-30, 1e38, -0.7] {
            let constant = vec![value; 64 * 64];
            let mut rounded = constant.clone();
            for (i, v) in rounded.iter_mut().enumerate() {
                *v = f32::from_bits(v.to_bits() + (i * i % 7 / 3) as u32);
            }
            for image in [constant, if value == 0.0 { vec![0.0; 64 * 64] } else { rounded }] {
                let found = frequencies(&image, [64; 2], 64, border, 0.01);
                assert!(found.u.iter().chain(&found.v).all(|f| *f == 0.0), "{value} {border:?}");
            }
        }
    }
}

#[test]
fn large_and_small_numbers_make_no_difference() {
    let wave = image(64, 64, |x, _| (TAU * 5.0 * x).sin());
    let expected = frequencies(&wave, [64; 2], 64, Border::Periodic, 0.01);
    for factor in [1e38f32, 1e-30] {
        let scaled: Vec<f32> = wave.iter().map(|v| v * factor).collect();
        let found = frequencies(&scaled, [64; 2], 64, Border::Periodic, 0.01);
        for (a, b) in expected.u.iter().zip(&found.u) {
            assert!((a - b).abs() < 1e-4 * a, "{a} {b}");
        }
    }
}

/// A step at the border, a ramp that does not meet itself: only a periodic image has them.
#[test]
fn a_bounded_image_has_no_border() {
    let size = 128;
    let ramp = image(size, size, |x, y| 3.0 + x + 0.5 * y);
    let wrapped = frequencies(&ramp, [size; 2], size, Border::Periodic, 0.01);
    let bounded = frequencies(&ramp, [size; 2], size, Border::Bounded, 0.01);
    let [low, high] = range(&bounded.u).map(|f| f * size as f64);
    assert!(low >= 0.9 && high < 1.5, "a ramp is slow: {low} {high}");
    let [_, edge] = range(&wrapped.u).map(|f| f * size as f64);
    assert!(edge > 10.0 * high, "{edge}");
    for cycles in [0.5, 1.0, 2.0, 4.0, 8.0, 15.5, 30.3] {
        let wave = image(size, size, |x, y| (TAU * cycles * (0.8 * x + 0.6 * y) + 0.3).sin());
        let found = frequencies(&wave, [size; 2], size, Border::Bounded, 0.01);
        let [low, high] = range(&found.u).map(|f| f * size as f64 / (0.8 * cycles));
        let bound = if cycles < 2.0 { 4.0 } else { 2.0 };
        assert!(low > 0.9 && high < bound, "{cycles}: {low} {high}");
    }
}

/// Detail in one place raises the frequency there, and not everywhere.
#[test]
fn detail_is_local() {
    let size = 256;
    let burst = |x: f64, y: f64| (-((x - 0.25).powi(2) + (y - 0.25).powi(2)) / 0.002).exp();
    let picture = image(size, size, |x, y| (TAU * 2.0 * x).sin() + burst(x, y) * (TAU * 50.0 * y).sin());
    for border in [Border::Periodic, Border::Bounded] {
        let found = frequencies(&picture, [size; 2], size, border, 0.01);
        let at = |column: usize, row: usize| f64::from(found.v[row * size / 2 + column]) * size as f64;
        assert!(at(32, 32) > 30.0 && at(96, 96) < 8.0, "{border:?}: {} {}", at(32, 32), at(96, 96));
    }
}

#[test]
fn odd_shapes() {
    for size in [[1, 1], [1, 64], [64, 1], [2, 256], [256, 4], [2, 2]] {
        let wave = image(size[0], size[1], |x, y| (TAU * (x + y)).sin());
        let found = frequencies(&wave, size, size[1], Border::Periodic, 0.01);
        assert!(found.u.iter().chain(&found.v).all(|f| (0.0..=0.5).contains(f)));
        assert_eq!(found.u.len(), size[0].div_ceil(2) * size[1].div_ceil(2));
    }
    let wave = image(512, 16, |x, _| (TAU * 40.0 * x).sin());
    let [low, high] = range(&frequencies(&wave, [512, 16], 16, Border::Bounded, 0.01).u).map(|f| f * 512.0 / 40.0);
    assert!(low > 1.0 && high < 2.0, "{low} {high}");
    let rows = frequencies(&wave, [512, 16], 6, Border::Periodic, 0.01);
    assert_eq!(rows.u[..], frequencies(&wave, [512, 16], 16, Border::Periodic, 0.01).u[..3 * 256]);
}
