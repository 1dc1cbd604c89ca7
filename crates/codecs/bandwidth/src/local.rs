//! Local bandwidth per pixel: the rule of appendix A of Bagher et al. 2012.
//!
//! `Λ_k` (`Λ_h` there) at a pixel is the largest coefficient of level k among the wavelets whose support contains it;
//! level k has `2^k` wavelets per axis. The paper's local level is the smallest n with `T(n) = Σ_(k ≥ n) Λ_k < ε max_k
//! Λ_k`, and its bandwidth is `2^n`. Here n is a real number, and 2 octaves are subtracted:
//!
//! - Whole levels would make bandwidths that jump by 2. T falls by about 32 per octave beyond a sinusoid, so `ln T` is
//!   interpolated linearly between the levels where it crosses `ε max Λ`.
//! - For a sinusoid of k cycles per image the crossing is 2.39 to 2.49 octaves above `log2 k`, for every k and
//!   everywhere in the image: `2^n` would be 5.4 times too high. `2^(n - 2)` is 1.31 to 1.41 times k, which is
//!   conservative and within an octave. With another ε the crossing moves by `log32(0.01 / ε)`, which is subtracted
//!   too; this makes sinusoids independent of ε.
//! - Above a quarter of a cycle per pixel, the tail does not end in a finer level. It is continued with the sinusoid's
//!   2^-5 per octave and, where the finest level exceeds all others, additionally by that ratio. The result is limited
//!   to half a cycle per pixel.
//!
//! The two octaves hold for the component with the largest coefficient. Detail whose `Λ` is w times the largest is
//! underestimated by `log32(1 / w)` octaves. This is a property of the rule, not of its interpolation: the tail of weak
//! detail starts nearer to the threshold. Coefficients at equal contrast double with each coarser level, so fine detail
//! on a strong slow wave is such a case. Its estimate is 0.83 of its frequency for w = 0.1, 0.5 for 0.02, and 0.35 to
//! 0.45 for w = ε; detail below half of that is ignored. The paper's `2^n` is four times as high, above the frequency
//! of even the weakest detail.
//!
//! Bands with detail along u and along v are followed separately, both relative to the common maximum.
//!
//! Rounding does not count as detail: a coefficient below 2^-20 of the corresponding smooth coefficient counts as 0.

use super::daubechies::{Image, ROWS_OF_A_TASK, Row, TAPS, halved, split_rows};
use rayon::prelude::*;

/// Extension of the image beyond its border.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Border {
    /// The image repeats.
    Periodic,
    /// No extension: wavelets that would cross the border are replaced by the nearest one wholly inside, so that no
    /// extrapolated value contributes to the bandwidth. Levels without a wavelet that fits are replaced by one level,
    /// whose coefficient is the variation of the means of an eighth of the image: images that are not constant have at
    /// least one cycle per image.
    Bounded,
}

/// Frequencies around each block of pixels, row by row: cycles per pixel along u and v, 0 to 1/2.
#[derive(Debug, Clone, PartialEq)]
pub struct Frequencies {
    /// Blocks per row.
    pub width: usize,
    /// Rows of blocks.
    pub height: usize,
    /// Along u.
    pub u: Vec<f32>,
    /// Along v.
    pub v: Vec<f32>,
}

/// Number of times that blocks of 2 pixels are doubled so that at most `most` of them fit along an axis of `pixels`
/// pixels, a power of two.
pub fn doublings(pixels: usize, most: usize) -> u32 {
    (pixels / 2).max(1).div_ceil(most).next_power_of_two().ilog2()
}

/// Detail below this share of the smooth coefficient is rounding.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;
/// Means per axis that replace coarse levels of bounded images.
const MEANS: usize = 8;
/// Smallest side of a bounded image.
pub const MIN_BOUNDED_SIDE: usize = 16;

/// One level: `Λ` of blocks of `2^shift` finest blocks. Empty along an axis that is not split.
struct Scale {
    shift: [u32; 2],
    width: usize,
    u: Vec<f32>,
    v: Vec<f32>,
}

/// Wavelets of a level along one axis.
#[derive(Clone, Copy)]
struct Wavelets {
    /// Number of wavelets whose support may contain a given block.
    cells: usize,
    /// Last wavelet that may be used; the border determines how others are replaced.
    last: usize,
    border: Border,
}

impl Wavelets {
    /// Creates `count` wavelets after `splits` splits.
    fn new(count: usize, splits: u32, border: Border) -> Self {
        if splits == 0 {
            return Self { cells: 1, last: count - 1, border };
        }
        let step = 1usize << splits;
        let support = support(splits);
        let last = match border {
            Border::Periodic => count - 1,
            Border::Bounded => (count * step).saturating_sub(support) / step,
        };
        Self { cells: support.div_ceil(step), last, border }
    }

    /// The wavelet that starts `before` blocks before block `at`.
    fn index(self, at: usize, before: usize) -> usize {
        match self.border {
            // `last` is -1 modulo the count.
            Border::Periodic => (at + before * self.last) % (self.last + 1),
            Border::Bounded => at.saturating_sub(before).min(self.last),
        }
    }

    /// Returns true if any of the first `blocks` blocks may be in the support of wavelet `at`.
    fn is_used(self, at: usize, blocks: usize) -> bool {
        at < blocks || at + self.cells > self.last + 1 || self.border == Border::Bounded
    }
}

/// Number of samples in the support of a wavelet after `splits` splits.
pub fn support(splits: u32) -> usize {
    (TAPS - 1) * ((1 << splits) - 1) + 1
}

/// Frequencies around each block of 2 x 2 pixels, for the first `rows` rows of an image of `width x height` finite
/// values, both powers of two. `rows` is even, or all of them.
///
/// # Panics
/// Panics for other sizes; bounded images have at least [`MIN_BOUNDED_SIDE`] pixels per axis.
pub fn frequencies(
    image: &[f32],
    [width, height]: [usize; 2],
    rows: usize,
    border: Border,
    epsilon: f64,
) -> Frequencies {
    block_frequencies(Image::plain(image, width, height), rows, border, epsilon, [0; 2], f32::max)
}

/// Function that merges two neighbouring blocks.
pub(super) trait Join: Fn(f32, f32) -> f32 + Copy + Sync {}
impl<T: Fn(f32, f32) -> f32 + Copy + Sync> Join for T {}

/// Variant of [`frequencies`] for blocks of `2^(1 + doublings)` pixels per axis. `Λ` of such a block is merged from
/// the `Λ` of its blocks of 2 x 2 pixels, by the maximum if no detail may be missed, so that the rule is evaluated once
/// per block.
pub(super) fn block_frequencies(
    image: Image<'_, f32>,
    rows: usize,
    border: Border,
    epsilon: f64,
    doublings: [u32; 2],
    join: impl Join,
) -> Frequencies {
    let (width, height) = (image.width, image.height);
    assert!(width.is_power_of_two() && height.is_power_of_two(), "sizes are powers of two");
    assert!(rows <= height && (rows.is_multiple_of(2) || rows == height), "rows are of the image");
    assert!(border == Border::Periodic || width.min(height) >= MIN_BOUNDED_SIDE, "bounded images have some pixels");
    let [columns, block_rows] = [(width / 2).max(1) >> doublings[0], rows.div_ceil(2) >> doublings[1]];
    let largest = |values: &[f32]| values.iter().fold(0.0f32, |most, value| most.max(value.abs()));
    let magnitude = image.values.par_chunks(1 << 14).map(largest).reduce(|| 0.0, f32::max);
    let blank = |columns: usize| vec![0.0; columns * block_rows];
    let mut found = Frequencies { width: columns, height: block_rows, u: blank(columns), v: blank(columns) };
    if magnitude == 0.0 || width * height == 1 {
        return found;
    }
    // Scales away from overflow and underflow; a power of two changes no other bits.
    let scaled: Vec<f32>;
    let mut image = image;
    if !(1e-20..1e20).contains(&magnitude) {
        let factor = 2f64.powi(-magnitude.log2() as i32);
        scaled = image.values.iter().map(|value| (f64::from(*value) * factor) as f32).collect();
        image.values = &scaled;
    }
    let scales = scales(image, block_rows, border, doublings, join);
    let (finest, next) = maxima(&scales, columns, block_rows);
    let rule = Rule::new(epsilon);
    let outputs = found.u.par_chunks_exact_mut(columns).zip(found.v.par_chunks_exact_mut(columns));
    outputs.enumerate().for_each(|(row, (u, v))| {
        let along = |pick: fn(&Scale) -> &Vec<f32>| -> Vec<(&[f32], u32)> {
            let used = scales.iter().filter(|scale| !pick(scale).is_empty());
            used.map(|s| (&pick(s)[(row >> s.shift[1]) * s.width..][..s.width], s.shift[0])).collect()
        };
        let (along_u, along_v) = (along(|s| &s.u), along(|s| &s.v));
        let finest = &finest[row * columns..][..columns];
        for at in 0..columns {
            let (largest, coarser) = (finest[at], next.at(at, row));
            let value = |scales: &[(&[f32], u32)], k: usize| scales.get(k).map(|(row, shift)| row[at >> shift]);
            u[at] = rule.frequency(|k| value(&along_u, k), largest, coarser);
            v[at] = rule.frequency(|k| value(&along_v, k), largest, coarser);
        }
    });
    found
}

/// `ε` and the constants that depend on it.
#[derive(Clone, Copy)]
struct Rule {
    epsilon: f32,
    /// `2^(-3) (ε / 0.01)^(1/5)`: cycles per pixel of a crossing at the finest level.
    unit: f32,
}

impl Rule {
    fn new(epsilon: f64) -> Self {
        Self { epsilon: epsilon as f32, unit: (0.125 * (epsilon / 0.01).powf(0.2)) as f32 }
    }

    /// Cycles per pixel at which the tail of `Λ` (finest level first) crosses ε times the `largest` of all; `coarser`
    /// is the largest of all but the finest level.
    fn frequency(self, lambda: impl Fn(usize) -> Option<f32>, largest: f32, coarser: f32) -> f32 {
        let threshold = self.epsilon * largest;
        let mut total = lambda(0).unwrap_or(0.0);
        if largest <= 0.0 {
            return 0.0;
        }
        if total >= threshold {
            let octaves = (total / threshold * (total / coarser).max(1.0)).log2() / 5.0;
            return (self.unit * octaves.exp2()).min(0.5);
        }
        for k in 1.. {
            let Some(value) = lambda(k) else { break };
            let finer = total;
            total += value;
            if total >= threshold {
                let share = if finer > 0.0 { (total / threshold).log2() / (total / finer).log2() } else { 0.0 };
                return (self.unit * (share - k as f32).exp2()).min(0.5);
            }
        }
        0.0
    }
}

/// `Λ` of every level, the finest first.
fn scales(
    image: Image<'_, f32>,
    block_rows: usize,
    border: Border,
    doublings: [u32; 2],
    join: impl Join,
) -> Vec<Scale> {
    let size = [image.width, image.height];
    // Maximum splits along an axis: down to one coefficient, or as long as a wavelet fits.
    let most = size.map(|side| match border {
        Border::Periodic => side.ilog2(),
        Border::Bounded => (1..).take_while(|splits| support(*splits) <= side).count() as u32,
    });
    // Blocks of the finest level are two pixels wide, if there are two.
    let first = size.map(|side| u32::from(side > 1));
    let mut scales = Vec::new();
    let mut smooth: Vec<f32> = Vec::new();
    let (mut current, mut splits) = (size, [0u32; 2]);
    while (0..2).any(|axis| splits[axis] < most[axis]) {
        let axes = [splits[0] < most[0], splits[1] < most[1]];
        let input = if scales.is_empty() { image } else { Image::plain(&smooth, current[0], current[1]) };
        current = halved(current, axes);
        splits = [0, 1].map(|axis| splits[axis] + u32::from(axes[axis]));
        let own = [0, 1].map(|axis| splits[axis].saturating_sub(first[axis]));
        let cells = Cells {
            wavelets: [0, 1].map(|axis| Wavelets::new(current[axis], splits[axis], border)),
            doublings: [0, 1].map(|axis| doublings[axis].saturating_sub(own[axis])),
            columns: current[0],
            rows: block_rows.div_ceil(1 << own[1].saturating_sub(doublings[1])),
            join,
        };
        let shift = [0, 1].map(|axis| own[axis].saturating_sub(doublings[axis]));
        let (next, [u, v]) = cells.largest(input, axes, current[1]);
        scales.push(Scale { shift, width: cells.width(), u, v });
        smooth = next;
    }
    if border == Border::Bounded {
        let [u, v] = variation(image.values, size);
        // Gain of a coefficient over the amplitude of a wave.
        let gain = 2f32.powf(0.5 * (splits[0] + splits[1] + 2) as f32);
        let whole = [0, 1].map(|axis| size[axis].ilog2() - doublings[axis]);
        scales.push(Scale { shift: whole, width: 1, u: vec![gain * u], v: vec![gain * v] });
    }
    scales
}

/// The blocks of a level.
struct Cells<J> {
    /// Along u and v.
    wavelets: [Wavelets; 2],
    /// Number of doublings of the blocks of the level.
    doublings: [u32; 2],
    /// Coefficients per row.
    columns: usize,
    /// Number of rows of joined blocks to compute.
    rows: usize,
    join: J,
}

impl<J: Join> Cells<J> {
    /// Joined blocks per row.
    fn width(&self) -> usize {
        self.columns >> self.doublings[0]
    }

    /// Splits an image into a level of `height` rows. Returns the smooth part, and the largest detail of the wavelets
    /// around each block along u and along v, both including the diagonal band.
    fn largest(&self, image: Image<'_, f32>, axes: [bool; 2], height: usize) -> (Vec<f32>, [Vec<f32>; 2]) {
        let (width, blocks) = (self.width(), self.rows << self.doublings[1]);
        let needs_detail = |row: usize| self.wavelets[1].is_used(row, blocks);
        let mut wide = axes.map(|split| vec![0.0f32; if split { width * height } else { 0 }]);
        let [u, v] = wide.each_mut().map(|band| band.chunks_mut(width * ROWS_OF_A_TASK));
        let (mut u, mut v) = (u, v);
        let tasks = (0..height.div_ceil(ROWS_OF_A_TASK))
            .map(|_| ([&mut u, &mut v].map(|rows| rows.next().unwrap_or_default()), Vec::new()))
            .collect();
        let widen = |(bands, space): &mut ([&mut [f32]; 2], Vec<f32>), row: usize, found: &Row<'_, f32>| {
            for (band, detail) in bands.iter_mut().zip([found.along_u, found.along_v]) {
                if !detail.is_empty() {
                    self.widen(detail, found, space, &mut band[row * width..][..width]);
                }
            }
        };
        let smooth = split_rows(image, axes, needs_detail, tasks, widen);
        (smooth, wide.map(|wide| self.lengthen(&wide)))
    }

    /// The largest significant detail of a row per joined block.
    fn widen(&self, detail: &[f32], row: &Row<'_, f32>, padded: &mut Vec<f32>, target: &mut [f32]) {
        let across = self.wavelets[0];
        // The wavelets that start before the first block come first.
        let border = across.cells - 1;
        padded.clear();
        padded.resize(border, 0.0);
        if row.both.is_empty() {
            padded.extend(detail.iter().zip(row.smooth).map(|(d, s)| significant(d.abs(), *s)));
        } else {
            let values = detail.iter().zip(row.both).zip(row.smooth);
            padded.extend(values.map(|((d, b), s)| significant(d.abs().max(b.abs()), *s)));
        }
        for k in 0..border {
            padded[k] = padded[border + across.index(0, border - k)];
        }
        for at in across.last + 1..self.columns {
            padded[border + at] = padded[border + across.last];
        }
        let mut span = 1;
        while 2 * span <= across.cells {
            sliding_maximum(padded, span);
            span *= 2;
        }
        if span < across.cells {
            sliding_maximum(padded, across.cells - span);
        }
        let mut count = self.columns;
        for _ in 0..self.doublings[0] {
            count /= 2;
            for at in 0..count {
                padded[at] = (self.join)(padded[2 * at], padded[2 * at + 1]);
            }
        }
        target.copy_from_slice(&padded[..count]);
    }

    /// For each row of blocks, the maximum over the surrounding rows, joined.
    fn lengthen(&self, wide: &[f32]) -> Vec<f32> {
        if wide.is_empty() {
            return Vec::new();
        }
        let (down, width) = (self.wavelets[1], self.width());
        let around = |at: usize, target: &mut [f32]| {
            for before in 0..down.cells {
                let source = &wide[down.index(at, before) * width..][..width];
                for (value, other) in target.iter_mut().zip(source) {
                    *value = value.max(*other);
                }
            }
        };
        let mut largest = vec![0.0f32; width * self.rows];
        let rows = largest.par_chunks_exact_mut(width).enumerate();
        rows.for_each(|(row, target)| self.join_rows(row, self.doublings[1], target, &around));
        largest
    }

    /// Row `at` of blocks joined over `doublings` doublings; `single` computes the rows of single blocks.
    fn join_rows(&self, at: usize, doublings: u32, target: &mut [f32], single: &impl Fn(usize, &mut [f32])) {
        if doublings == 0 {
            return single(at, target);
        }
        self.join_rows(2 * at, doublings - 1, target, single);
        let mut second = vec![0.0; target.len()];
        self.join_rows(2 * at + 1, doublings - 1, &mut second, single);
        for (value, other) in target.iter_mut().zip(&second) {
            *value = (self.join)(*value, *other);
        }
    }
}

/// The coefficient, or 0 if it may be rounding of the corresponding smooth one.
fn significant(detail: f32, smooth: f32) -> f32 {
    if detail > ROUNDING * smooth.abs() { detail } else { 0.0 }
}

/// `values_i = max(values_i, values_(i + distance))`, where there is one.
fn sliding_maximum(values: &mut [f32], distance: usize) {
    for i in 0..values.len() - distance {
        values[i] = values[i].max(values[i + distance]);
    }
}

/// Maximum over a level and all coarser ones.
struct Maxima {
    shift: [u32; 2],
    width: usize,
    values: Vec<f32>,
}

impl Maxima {
    fn at(&self, column: usize, row: usize) -> f32 {
        self.values.get((row >> self.shift[1]) * self.width + (column >> self.shift[0])).copied().unwrap_or(0.0)
    }
}

/// Maxima per finest block: over all levels, and over all but the finest.
fn maxima(scales: &[Scale], columns: usize, rows: usize) -> (Vec<f32>, Maxima) {
    let mut coarser = Maxima { shift: [0; 2], width: 0, values: Vec::new() };
    let mut next = Maxima { shift: [0; 2], width: 0, values: Vec::new() };
    for scale in scales.iter().rev() {
        let height = rows.div_ceil(1 << scale.shift[1]);
        let mut values = vec![0.0f32; scale.width * height];
        values.par_chunks_exact_mut(scale.width).enumerate().for_each(|(row, target)| {
            for (column, value) in target.iter_mut().enumerate() {
                let at = row * scale.width + column;
                let own = [&scale.u, &scale.v].map(|band| band.get(at).copied().unwrap_or(0.0));
                let above = coarser.at(column << scale.shift[0], row << scale.shift[1]);
                *value = own[0].max(own[1]).max(above);
            }
        });
        next = std::mem::replace(&mut coarser, Maxima { shift: scale.shift, width: scale.width, values });
    }
    debug_assert_eq!(coarser.values.len(), if scales.is_empty() { 0 } else { columns * rows });
    (coarser.values, next)
}

/// Half the range of the means of an eighth of the image, along each axis.
fn variation(image: &[f32], [width, height]: [usize; 2]) -> [f32; 2] {
    let (across, down) = (width / MEANS, height / MEANS);
    let mut means = [[0.0f64; MEANS]; MEANS];
    for (row, values) in image.chunks_exact(width).enumerate() {
        for (mean, cell) in means[row / down].iter_mut().zip(values.chunks_exact(across)) {
            *mean += cell.iter().map(|value| f64::from(*value)).sum::<f64>();
        }
    }
    let count = (across * down) as f64;
    let range = |line: &dyn Fn(usize) -> f64| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..MEANS {
            (low, high) = (low.min(line(k)), high.max(line(k)));
        }
        let half = 0.5 * (high - low);
        if half > f64::from(ROUNDING) * low.abs().max(high.abs()) { half / count } else { 0.0 }
    };
    let largest = |line: &dyn Fn(usize, usize) -> f64| {
        (0..MEANS).map(|fixed| range(&|k| line(fixed, k))).fold(0.0, f64::max) as f32
    };
    [largest(&|row, k| means[row][k]), largest(&|column, k| means[k][column])]
}

#[cfg(test)]
mod tests;
