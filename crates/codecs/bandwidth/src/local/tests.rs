use super::*;
use crate::daubechies::split;
use std::f64::consts::TAU;

fn image(width: usize, height: usize, value: impl Fn(f64, f64) -> f64) -> Vec<f32> {
    let at = |i: usize, size: usize| (i as f64 + 0.5) / size as f64;
    (0..width * height).map(|i| value(at(i % width, width), at(i / width, height)) as f32).collect()
}

fn range(values: &[f32]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, 0.0], |[low, high], v| [low.min(f64::from(*v)), high.max(f64::from(*v))])
}

/// Smallest and largest ratio of the estimated to the true frequency, for waves along u and along v.
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

/// Frequencies without a finer level.
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

/// The negative control: a tail that starts one level off, in either direction, exceeds the bounds of the tests above.
#[test]
fn a_tail_that_starts_one_level_off_is_detected() {
    let cycles = 11.0;
    let wave = image(256, 256, |x, _| (TAU * cycles * x + 0.3).sin());
    let scales = scales(Image::plain(&wave, 256, 256), 128, Border::Periodic, [0; 2], f32::max);
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
fn constants_up_to_rounding_have_no_bandwidth() {
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

/// A step at the border, a ramp that does not meet itself: only periodic images have them.
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

/// Detail in one place raises the frequency only there.
#[test]
fn detail_is_local() {
    let size = 256;
    let burst = |x: f64, y: f64| (-((x - 0.25).powi(2) + (y - 0.25).powi(2)) / 0.002).exp();
    let rendering = image(size, size, |x, y| (TAU * 2.0 * x).sin() + burst(x, y) * (TAU * 50.0 * y).sin());
    for border in [Border::Periodic, Border::Bounded] {
        let found = frequencies(&rendering, [size; 2], size, border, 0.01);
        let at = |column: usize, row: usize| f64::from(found.v[row * size / 2 + column]) * size as f64;
        // Below the 50 cycles, because the coefficients of the strong wave are 25 times as large: see the module.
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

/// Weaker detail is underestimated more.
#[test]
fn weak_detail_is_underestimated_or_ignored() {
    let size = 256;
    for cycles in [23.0, 32.0, 40.0] {
        // `Λ` of a wave over the whole image is proportional to its amplitude divided by its frequency.
        let found = |weight: f64| {
            let amplitude = weight * cycles / 2.0;
            let both = |x: f64, y: f64| (TAU * 2.0 * x).sin() + amplitude * (TAU * cycles * y + 0.3).sin();
            let found = frequencies(&image(size, size, both), [size; 2], size, Border::Periodic, 0.01);
            range(&found.v).map(|f| f * size as f64 / cycles)
        };
        for weight in [1.0f64, 0.3, 0.1, 0.03, 0.02] {
            let expected = 1.33 * weight.powf(0.2);
            let [low, high] = found(weight);
            assert!(low / expected > 0.85 && high / expected < 1.1, "{cycles} {weight}: {low} {high} {expected}");
        }
        let [low, high] = found(0.01);
        assert!(low > 0.34 && high < 0.46, "{cycles}: {low} {high}");
        assert_eq!(found(0.003), [0.0; 2]);
    }
}

/// Reference implementation of the whole rule in double precision, without optimisations: for every block, it checks
/// all wavelets of all levels.
fn reference(image: &[f64], [width, height]: [usize; 2], border: Border, epsilon: f64) -> [Vec<f64>; 2] {
    let fits = |side: usize, splits: u32| match border {
        Border::Periodic => 1 << splits <= side,
        Border::Bounded => support(splits) <= side,
    };
    let (columns, rows) = (width / 2, height / 2);
    // Per level and axis: the largest coefficient around each block.
    let mut lambda: [Vec<Vec<f64>>; 2] = [Vec::new(), Vec::new()];
    let (mut smooth, mut size, mut splits) = (image.to_vec(), [width, height], [0u32; 2]);
    loop {
        let axes = [fits(width, splits[0] + 1), fits(height, splits[1] + 1)];
        if axes == [false; 2] {
            break;
        }
        let level = split(&smooth, size[0], size[1], axes);
        splits = [0, 1].map(|axis| splits[axis] + u32::from(axes[axis]));
        size = [level.width, level.height];
        let holds = |axis: usize, block: usize| -> Vec<usize> {
            let (step, count) = (1 << splits[axis], size[axis]);
            let last = match border {
                Border::Periodic => count - 1,
                Border::Bounded => (count * step - support(splits[axis])) / step,
            };
            let at = 2 * block / step;
            let starts = (0..support(splits[axis]).div_ceil(step)).map(|before| match border {
                Border::Periodic => (at + 8 * count - before) % count,
                Border::Bounded => at.saturating_sub(before).min(last),
            });
            starts.collect()
        };
        for (axis, band) in [&level.along_u, &level.along_v].into_iter().enumerate() {
            if band.is_empty() {
                continue;
            }
            let value = |at: usize| {
                let largest = band[at].abs().max(level.both.get(at).map_or(0.0, |both| both.abs()));
                if largest > f64::from(ROUNDING) * level.smooth[at].abs() { largest } else { 0.0 }
            };
            let around = |number: usize| {
                let (us, vs) = (holds(0, number % columns), holds(1, number / columns));
                let all = vs.iter().flat_map(|v| us.iter().map(move |u| v * size[0] + u)).map(value);
                all.fold(0.0, f64::max)
            };
            lambda[axis].push((0..columns * rows).map(around).collect());
        }
        smooth = level.smooth;
    }
    if border == Border::Bounded {
        let single: Vec<f32> = image.iter().map(|value| *value as f32).collect();
        let gain = 2f64.powf(0.5 * f64::from(splits[0] + splits[1] + 2));
        for (axis, half_range) in variation(&single, [width, height]).into_iter().enumerate() {
            lambda[axis].push(vec![gain * f64::from(half_range); columns * rows]);
        }
    }
    let frequency = |axis: usize, block: usize| {
        let at = |axis: usize| lambda[axis].iter().map(move |level| level[block]);
        let largest = at(0).chain(at(1)).fold(0.0, f64::max);
        let coarser = at(0).skip(1).chain(at(1).skip(1)).fold(0.0, f64::max);
        let threshold = epsilon * largest;
        let unit = 0.125 * (epsilon / 0.01).powf(0.2);
        let mut total = 0.0;
        for (k, value) in at(axis).enumerate() {
            let finer = total;
            total += value;
            if largest > 0.0 && total >= threshold {
                let octaves = match k {
                    0 => (total / threshold * (total / coarser).max(1.0)).log2() / 5.0,
                    _ if finer > 0.0 => (total / threshold).ln() / (total / finer).ln() - k as f64,
                    _ => -(k as f64),
                };
                return (unit * octaves.exp2()).min(0.5);
            }
        }
        0.0
    };
    [0, 1].map(|axis| (0..columns * rows).map(|block| frequency(axis, block)).collect())
}

/// Largest relative difference between the rule in single precision and [`reference`].
fn off_reference(size: [usize; 2], border: Border, value: impl Fn(f64, f64) -> f64) -> f64 {
    let single = image(size[0], size[1], value);
    let double: Vec<f64> = single.iter().map(|value| f64::from(*value)).collect();
    let found = frequencies(&single, size, size[1], border, 0.01);
    let [u, v] = reference(&double, size, border, 0.01);
    let pairs = found.u.iter().zip(&u).chain(found.v.iter().zip(&v));
    pairs.map(|(a, b)| (f64::from(*a) - b).abs() / b.max(1e-6)).fold(0.0, f64::max)
}

/// Frequencies are within 1e-4, or within 1e-2 if the mean is thirty times the detail, so that coefficients lose five
/// bits.
#[test]
fn single_precision_is_close_to_double() {
    let busy = |x: f64, y: f64| (TAU * (3.0 * x + y)).sin() + (-((x - 0.3).powi(2) + (y - 0.6).powi(2)) / 0.003).exp();
    for border in [Border::Periodic, Border::Bounded] {
        for size in [[64, 64], [128, 32]] {
            let plain = off_reference(size, border, busy);
            let offset = off_reference(size, border, |x, y| 30.0 + busy(x, y));
            println!("{border:?} {size:?}: {plain:e}, offset {offset:e}");
            assert!(plain < 1e-4 && offset < 1e-2, "{border:?} {size:?}: {plain} {offset}");
        }
    }
    // The negative control: an image with an error of a thousandth of the detail.
    let single = image(64, 64, busy);
    let double: Vec<f64> = single.iter().enumerate().map(|(i, v)| f64::from(*v) + 1e-3 * (i % 2) as f64).collect();
    let found = frequencies(&single, [64; 2], 64, Border::Periodic, 0.01);
    let [u, _] = reference(&double, [64; 2], Border::Periodic, 0.01);
    assert!(found.u.iter().zip(&u).any(|(a, b)| (f64::from(*a) / b - 1.0).abs() > 1e-3));
}

/// Larger blocks have at least the frequency of the blocks of 2 x 2 pixels in them, up to 5 %, and little more.
#[test]
fn larger_blocks_miss_nothing() {
    let size = 256;
    let burst = |x: f64, y: f64| (-((x - 0.26).powi(2) + (y - 0.27).powi(2)) / 0.0005).exp();
    let rendering = image(size, size, |x, y| (TAU * 2.0 * x).sin() + burst(x, y) * (TAU * 60.0 * y).sin());
    for border in [Border::Periodic, Border::Bounded] {
        let fine = frequencies(&rendering, [size; 2], size, border, 0.01);
        // Share of blocks that are too low, and mean ratio.
        let compared = |doublings: [u32; 2], join: fn(f32, f32) -> f32| {
            let whole = Image::plain(&rendering, size, size);
            let found = block_frequencies(whole, size, border, 0.01, doublings, join);
            assert_eq!((found.width, found.height), (128 >> doublings[0], 128 >> doublings[1]));
            let (mut low, mut sum) = (0, 0.0);
            for at in 0..found.u.len() {
                let (column, row) = ((at % found.width) << doublings[0], (at / found.width) << doublings[1]);
                let length = |u: f32, v: f32| f64::from(u.hypot(v));
                let inside = (row..row + (1 << doublings[1]))
                    .flat_map(|r| (column..column + (1 << doublings[0])).map(move |c| r * 128 + c));
                let most = inside.map(|k| length(fine.u[k], fine.v[k])).fold(0.0, f64::max);
                let ratio = length(found.u[at], found.v[at]) / most;
                low += usize::from(ratio < 0.95);
                sum += ratio;
            }
            (low as f64 / found.u.len() as f64, sum / found.u.len() as f64)
        };
        for doublings in [[1, 1], [2, 0], [0, 2], [2, 3]] {
            let (low, mean) = compared(doublings, f32::max);
            println!("{border:?} {doublings:?}: {low} low, mean {mean}");
            assert!(low == 0.0 && mean < 1.1, "{border:?} {doublings:?}: {low} {mean}");
            // The negative control: a mean.
            let (low, _) = compared(doublings, |a, b| 0.5 * (a + b));
            assert!(low > 0.0, "{border:?} {doublings:?}: a mean is not detected");
        }
    }
}
