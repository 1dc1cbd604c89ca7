//! Separable Daubechies transform of periodic images.
//!
//! Order 4 means 4 vanishing moments, 8 taps. The name is also used for the filter of 4 taps with 2 moments, but that
//! does not suit the rule of [`super::local`]: beyond the level of a sinusoid its coefficients fall by only 8 per
//! octave (`2^(moments + 1)` for images, whose coefficients at equal contrast halve with each finer level), so that a
//! threshold of 0.01 is more than two octaves too high. With 4 moments they fall by 32.
//!
//! Coefficient `i` of a level uses the samples `2 i .. 2 i + 8` of the previous level, modulo the size; in the next
//! level, coefficients start at multiples of 4, and so on. Callers handle the borders: see [`super::image`] and
//! [`super::local`].

use num_traits::Float;
use rayon::prelude::*;

/// Taps of a filter.
pub const TAPS: usize = 8;

/// The low-pass filter (Daubechies 1992, table 6.1, N = 4: the spectral factor of minimal phase), sum `√2`.
pub const LOW_PASS: [f64; TAPS] = [
    0.230_377_813_308_896_5,
    0.714_846_570_552_915_7,
    0.630_880_767_929_858_9,
    -0.027_983_769_416_859_854,
    -0.187_034_811_719_093_1,
    0.030_841_381_835_560_764,
    0.032_883_011_666_885_2,
    -0.010_597_401_785_069_032,
];

/// Output rows that one task computes.
pub(super) const ROWS_OF_A_TASK: usize = 32;

/// Number type of the transform: `f32` for data, `f64` for reference.
pub trait Real: Float + Send + Sync {}
impl<T: Float + Send + Sync> Real for T {}

/// The high-pass filter, `g_k = (-1)^k h_(7-k)`.
pub fn high_pass() -> [f64; TAPS] {
    std::array::from_fn(|k| if k % 2 == 0 { LOW_PASS[TAPS - 1 - k] } else { -LOW_PASS[TAPS - 1 - k] })
}

#[derive(Clone, Copy)]
struct Filters<T> {
    low: [T; TAPS],
    high: [T; TAPS],
}

fn filters<T: Real>() -> Filters<T> {
    let convert = |taps: [f64; TAPS]| taps.map(|tap| T::from(tap).expect("taps are small numbers"));
    Filters { low: convert(LOW_PASS), high: convert(high_pass()) }
}

/// One level: four images of `width x height` coefficients, row by row. Bands along an axis that was not split are
/// empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Level<T> {
    /// Coefficients per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Smooth along both axes.
    pub smooth: Vec<T>,
    /// Detail along u (columns), smooth along v.
    pub along_u: Vec<T>,
    /// Detail along v (rows), smooth along u.
    pub along_v: Vec<T>,
    /// Detail along both.
    pub both: Vec<T>,
}

/// Rows of samples; a row may consist of two parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Image<'a, T> {
    /// Row by row.
    pub values: &'a [T],
    /// Samples per row.
    pub width: usize,
    /// Rows; twice the number of stored rows if the image continues over the poles.
    pub height: usize,
    /// True if row `-1` at azimuth φ is row 0 at `φ + π`, as in latitude-longitude images: all rows form a full circle.
    /// The width is then a multiple of 4.
    pub over_poles: bool,
}

impl<'a, T> Image<'a, T> {
    /// An image that ends at its border.
    pub fn plain(values: &'a [T], width: usize, height: usize) -> Self {
        assert_eq!(values.len(), width * height, "an image has width x height values");
        Self { values, width, height, over_poles: false }
    }

    /// Parts of a row, from left to right.
    pub fn row(self, at: usize) -> [&'a [T]; 2] {
        let row = |at: usize| &self.values[at * self.width..][..self.width];
        if self.over_poles && at >= self.height / 2 {
            let (first, second) = row(self.height - 1 - at).split_at(self.width / 2);
            [second, first]
        } else {
            [row(at), &[]]
        }
    }
}

/// Splits an image of `width x height`, row by row, along the selected axes `[u, v]`.
///
/// # Panics
/// Panics if the length is not `width * height`, and for odd sizes of an axis that is split.
pub fn split<T: Real>(image: &[T], width: usize, height: usize, axes: [bool; 2]) -> Level<T> {
    let [columns, rows] = halved([width, height], axes);
    let band = |present: bool| vec![T::zero(); if present { columns * rows } else { 0 }];
    let [mut along_u, mut along_v, mut both] = [axes[0], axes[1], axes[0] && axes[1]].map(band);
    let mut bands = [&mut along_u, &mut along_v, &mut both].map(|band| band.chunks_mut(columns * ROWS_OF_A_TASK));
    // Bands of axes that are not split have no rows.
    let tasks = (0..rows.div_ceil(ROWS_OF_A_TASK))
        .map(|_| bands.each_mut().map(|rows| rows.next().unwrap_or_default()))
        .collect();
    let keep = |bands: &mut [&mut [T]; 3], row: usize, found: &Row<'_, T>| {
        for (band, values) in bands.iter_mut().zip([found.along_u, found.along_v, found.both]) {
            if !values.is_empty() {
                band[row * columns..][..columns].copy_from_slice(values);
            }
        }
    };
    let smooth = split_rows(Image::plain(image, width, height), axes, |_| true, tasks, keep);
    Level { width: columns, height: rows, smooth, along_u, along_v, both }
}

/// Size of a level.
pub(super) fn halved(size: [usize; 2], axes: [bool; 2]) -> [usize; 2] {
    [0, 1].map(|axis| if axes[axis] { size[axis] / 2 } else { size[axis] })
}

/// A row of a [`Level`].
pub(super) struct Row<'a, T> {
    pub smooth: &'a [T],
    pub along_u: &'a [T],
    pub along_v: &'a [T],
    pub both: &'a [T],
}

/// Variant of [`split`] that does not store details. It passes each row to `sink` while it is in the cache, with the
/// output of its task, which has [`ROWS_OF_A_TASK`] rows, and its number in the task. Skips the details of tasks
/// without a row that `needs_detail`. Returns the smooth part.
pub(super) fn split_rows<T: Real, O: Send>(
    image: Image<'_, T>,
    axes: [bool; 2],
    needs_detail: impl Fn(usize) -> bool + Sync,
    outputs: Vec<O>,
    sink: impl Fn(&mut O, usize, &Row<'_, T>) + Sync,
) -> Vec<T> {
    let (width, height) = (image.width, image.height);
    assert!(axes[0] || axes[1], "at least one axis is split");
    assert!((!axes[0] || width.is_multiple_of(2)) && (!axes[1] || height.is_multiple_of(2)), "split axes are even");
    let filters = filters::<T>();
    let [columns, rows] = halved([width, height], axes);
    let mut smooth = vec![T::zero(); columns * rows];
    let tasks = smooth.par_chunks_mut(columns * ROWS_OF_A_TASK).zip(outputs).enumerate();
    tasks.for_each_init(Scratch::default, |scratch, (number, (smooth, mut output))| {
        let (first, count) = (number * ROWS_OF_A_TASK, smooth.len() / columns);
        let detail = (first..first + count).any(&needs_detail);
        let Scratch { across, pairs, bands } = scratch;
        // Rows of the image that this task reads, each split along u: low half, high half.
        let (start, needed) = if axes[1] { (2 * first, 2 * count + TAPS - 2) } else { (first, count) };
        across.resize(needed * width, T::zero());
        bands.iter_mut().for_each(|band| band.resize(columns, T::zero()));
        for (r, target) in across.chunks_exact_mut(width).enumerate() {
            let parts = image.row((start + r) % height);
            if axes[0] {
                let (low, high) = target.split_at_mut(columns);
                split_row(parts, &filters, pairs, low, detail.then_some(high));
            } else {
                let (first, second) = target.split_at_mut(parts[0].len());
                first.copy_from_slice(parts[0]);
                second.copy_from_slice(parts[1]);
            }
        }
        for (r, smooth) in smooth.chunks_exact_mut(columns).enumerate() {
            let [u, v, b] = bands.each_mut();
            let mut found = Row { smooth: &[], along_u: &[], along_v: &[], both: &[] };
            if axes[1] {
                let taps = |start: usize| -> [&[T]; TAPS] {
                    std::array::from_fn(|k| &across[(2 * r + k) * width + start..][..columns])
                };
                if !detail {
                    combine_one(taps(0), &filters.low, smooth);
                    continue;
                }
                combine(taps(0), &filters, smooth, v);
                found.along_v = v;
                if axes[0] {
                    combine(taps(columns), &filters, u, b);
                    (found.along_u, found.both) = (u, b);
                }
            } else {
                let (low, high) = across[r * width..(r + 1) * width].split_at(columns);
                smooth.copy_from_slice(low);
                if !detail {
                    continue;
                }
                found.along_u = high;
            }
            sink(&mut output, r, &Row { smooth, ..found });
        }
    });
    smooth
}

/// Scratch memory of a task.
#[derive(Debug)]
struct Scratch<T> {
    across: Vec<T>,
    pairs: [Vec<T>; 2],
    bands: [Vec<T>; 3],
}

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        Self { across: Vec::new(), pairs: [const { Vec::new() }; 2], bands: [const { Vec::new() }; 3] }
    }
}

/// Splits one row, given in two parts of even length; `pairs` is scratch memory for its even and odd samples.
fn split_row<T: Real>(
    parts: [&[T]; 2],
    filters: &Filters<T>,
    pairs: &mut [Vec<T>; 2],
    low: &mut [T],
    high: Option<&mut [T]>,
) {
    let half = low.len();
    for (parity, samples) in pairs.iter_mut().enumerate() {
        samples.clear();
        for part in parts {
            samples.extend(part.as_chunks::<2>().0.iter().map(|pair| pair[parity]));
        }
        for i in 0..TAPS / 2 {
            samples.push(samples[i % half]);
        }
    }
    let taps: [&[T]; TAPS] = std::array::from_fn(|k| &pairs[k % 2][k / 2..][..half]);
    match high {
        Some(high) => combine(taps, filters, low, high),
        None => combine_one(taps, &filters.low, low),
    }
}

/// The low-pass half of [`combine`].
fn combine_one<T: Real>(taps: [&[T]; TAPS], filter: &[T; TAPS], values: &mut [T]) {
    let count = values.len();
    let taps = taps.map(|row| &row[..count]);
    for i in 0..count {
        let mut sum = T::zero();
        for k in 0..TAPS {
            sum = sum + filter[k] * taps[k][i];
        }
        values[i] = sum;
    }
}

/// `low_i = Σ_k h_k taps_k,i` and `high_i = Σ_k g_k taps_k,i`, in the order of k.
fn combine<T: Real>(taps: [&[T]; TAPS], filters: &Filters<T>, low: &mut [T], high: &mut [T]) {
    let count = low.len();
    let taps = taps.map(|row| &row[..count]);
    let high = &mut high[..count];
    for i in 0..count {
        let (mut a, mut b) = (T::zero(), T::zero());
        for k in 0..TAPS {
            a = a + filters.low[k] * taps[k][i];
            b = b + filters.high[k] * taps[k][i];
        }
        low[i] = a;
        high[i] = b;
    }
}

/// Reconstructs the image that was passed to [`split`].
pub fn join<T: Real>(level: &Level<T>) -> Vec<T> {
    let (columns, rows) = (level.width, level.height);
    let axes = [!level.along_u.is_empty(), !level.along_v.is_empty()];
    let height = if axes[1] { 2 * rows } else { rows };
    let width = if axes[0] { 2 * columns } else { columns };
    let filters = filters::<T>();
    let along_v = |smooth: &[T], detail: &[T]| {
        let mut joined = vec![T::zero(); columns * height];
        for i in 0..rows {
            for k in 0..TAPS {
                let target = &mut joined[(2 * i + k) % height * columns..][..columns];
                for (c, value) in target.iter_mut().enumerate() {
                    let (a, b) = (smooth[i * columns + c], detail[i * columns + c]);
                    *value = *value + filters.low[k] * a + filters.high[k] * b;
                }
            }
        }
        joined
    };
    let low = if axes[1] { along_v(&level.smooth, &level.along_v) } else { level.smooth.clone() };
    if !axes[0] {
        return low;
    }
    let high = if axes[1] { along_v(&level.along_u, &level.both) } else { level.along_u.clone() };
    let mut joined = vec![T::zero(); width * height];
    for (row, target) in joined.chunks_exact_mut(width).enumerate() {
        for i in 0..columns {
            for k in 0..TAPS {
                let value = &mut target[(2 * i + k) % width];
                *value = *value + filters.low[k] * low[row * columns + i] + filters.high[k] * high[row * columns + i];
            }
        }
    }
    joined
}

/// Computes all levels, the finest first, down to one smooth coefficient. An axis of one sample is no longer split.
///
/// # Panics
/// Panics if sizes are not powers of two.
pub fn forward<T: Real>(image: &[T], width: usize, height: usize) -> Vec<Level<T>> {
    assert!(width.is_power_of_two() && height.is_power_of_two(), "sizes are powers of two");
    let mut levels: Vec<Level<T>> = Vec::new();
    let (mut w, mut h) = (width, height);
    while w > 1 || h > 1 {
        let input = levels.last().map_or(image, |level| &level.smooth);
        let level = split(input, w, h, [w > 1, h > 1]);
        (w, h) = (level.width, level.height);
        levels.push(level);
    }
    levels
}

/// Reconstructs the image from its levels; reads only the smooth part of the last one. Empty for no levels.
pub fn inverse<T: Real>(levels: &[Level<T>]) -> Vec<T> {
    let Some(last) = levels.last() else { return Vec::new() };
    let mut image = last.smooth.clone();
    for level in levels.iter().rev() {
        image = join(&Level { smooth: image, ..level.clone() });
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Numbers in [-1, 1) that are the same in every run.
    fn noise(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / 2f64.powi(52) - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    fn coefficients<T: Real>(levels: &[Level<T>]) -> Vec<T> {
        let details = |level: &Level<T>| [&level.along_u[..], &level.along_v, &level.both].concat();
        let last = levels.last().map(|level| level.smooth.clone()).unwrap_or_default();
        levels.iter().flat_map(details).chain(last).collect()
    }

    #[test]
    fn rows_continue_behind_the_pole() {
        let values: Vec<f32> = (0..8).map(|i| i as f32).collect();
        let image = Image { values: &values, width: 4, height: 4, over_poles: true };
        let rows: Vec<Vec<f32>> = (0..4).map(|row| image.row(row).concat()).collect();
        assert_eq!(rows.concat(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 6.0, 7.0, 4.0, 5.0, 2.0, 3.0, 0.0, 1.0]);
        // The transform reads these rows.
        let wide = noise(64 * 32, 5);
        let over = Image { values: &wide, width: 64, height: 64, over_poles: true };
        let torus: Vec<f64> = (0..64).flat_map(|row| over.row(row).concat()).collect();
        let smooth = split_rows(over, [true; 2], |_| true, vec![(); 1], |(), _, _| ());
        assert_eq!(smooth, split(&torus, 64, 64, [true; 2]).smooth);
    }

    #[test]
    fn the_filters_are_orthonormal() {
        let (low, high) = (LOW_PASS, high_pass());
        assert!((low.iter().sum::<f64>() - 2f64.sqrt()).abs() < 1e-15);
        for shift in 0..4 {
            let product =
                |a: &[f64; TAPS], b: &[f64; TAPS]| (2 * shift..TAPS).map(|k| a[k] * b[k - 2 * shift]).sum::<f64>();
            let one = if shift == 0 { 1.0 } else { 0.0 };
            assert!((product(&low, &low) - one).abs() < 1e-15 && (product(&high, &high) - one).abs() < 1e-15);
            assert!(product(&low, &high).abs() < 1e-15 && product(&high, &low).abs() < 1e-15);
        }
    }

    /// Four moments vanish and the fifth does not: a filter with 2 moments fails this test.
    #[test]
    fn four_moments_vanish() {
        let moment = |n: i32| high_pass().iter().enumerate().map(|(k, g)| (k as f64 - 3.5).powi(n) * g).sum::<f64>();
        for n in 0..4 {
            assert!(moment(n).abs() < 1e-12, "{n}: {}", moment(n));
        }
        assert!(moment(4).abs() > 1.0);
    }

    /// A cubic has no detail in wavelets that do not cross the border.
    #[test]
    fn cubics_are_smooth() {
        let (width, height) = (64, 32);
        let cubic = |x: f64| ((0.02 * x - 0.3) * x + 1.0) * x - 2.0;
        let image: Vec<f64> = (0..width * height).map(|i| cubic((i % width) as f64 / 8.0)).collect();
        let level = &split(&image, width, height, [true, true]);
        for row in 0..16 {
            for column in 0..29 {
                assert!(level.along_u[row * 32 + column].abs() < 1e-12);
            }
            assert!(level.along_u[row * 32 + 30].abs() > 0.1, "the wrapped one has detail");
        }
        assert!(level.both.iter().all(|c| c.abs() < 1e-12));
    }

    /// Every unit vector of coefficients is an image of norm 1, orthogonal to the others.
    #[test]
    fn the_transform_is_orthonormal() {
        let (width, height) = (16, 8);
        let basis: Vec<Vec<f64>> = (0..width * height)
            .map(|i| {
                let mut image = vec![0.0; width * height];
                image[i] = 1.0;
                coefficients(&forward(&image, width, height))
            })
            .collect();
        for a in 0..basis.len() {
            for b in 0..=a {
                let product: f64 = basis[a].iter().zip(&basis[b]).map(|(x, y)| x * y).sum();
                assert!((product - f64::from(u8::from(a == b))).abs() < 1e-13, "{a} {b}");
            }
        }
    }

    #[test]
    fn single_precision_is_close_to_double() {
        let (width, height) = (256, 128);
        let image = noise(width * height, 3);
        let single: Vec<f32> = image.iter().map(|v| *v as f32).collect();
        let (a, b) = (coefficients(&forward(&image, width, height)), coefficients(&forward(&single, width, height)));
        let error = a.iter().zip(&b).map(|(a, b)| (a - f64::from(*b)).abs()).fold(0.0, f64::max);
        // Coefficients of white noise have the magnitude of the noise, about 0.6 and at most 3.
        assert!(error < 4e-6 && error > 1e-8, "{error}");
    }

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        let image: Vec<f32> = noise(1 << 14, 1).into_iter().map(|v| v as f32).collect();
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| forward(&image, 64, 256))
        };
        assert!(on(1) == on(3));
    }

    proptest! {
        #[test]
        fn inverse_reconstructs_the_image(log_width in 0u32..8, log_height in 0u32..8, seed in 0u64..1000) {
            let (width, height) = (1 << log_width, 1 << log_height);
            let image = noise(width * height, seed);
            let levels = forward(&image, width, height);
            prop_assert_eq!(levels.len(), log_width.max(log_height) as usize);
            let energy = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
            if !levels.is_empty() {
                let back = inverse(&levels);
                for (a, b) in image.iter().zip(&back) {
                    prop_assert!((a - b).abs() < 1e-12);
                }
                prop_assert!((energy(&coefficients(&levels)) / energy(&image) - 1.0).abs() < 1e-12);
            }
        }
    }
}
