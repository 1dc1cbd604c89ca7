//! Quantisation of the basis to integers, and of weights to bytes.

use super::basis::Basis;
use brdfc_formats::flat_btf::factored::{GROUP, WeightRange};
use rayon::prelude::*;

/// Number of component groups with a 16-bit basis: as many as fit without additional texels. The first components need
/// the precision most.
pub(super) fn wide_groups(groups: u32) -> u32 {
    let texels = (groups + 1).div_ceil(4);
    (4 * texels - groups).min(groups)
}

/// Quantisation steps of a basis, by colour and component, scaled to the largest value of each.
pub(super) fn steps(basis: &Basis, wide_groups: u32) -> [Vec<f32>; 3] {
    let wide = wide_groups as usize * GROUP;
    [0, 1, 2].map(|colour| {
        let largest = |component: usize| {
            let rows = basis.values.chunks_exact(basis.components).skip(colour).step_by(3);
            rows.map(|row| row[component].abs()).fold(0.0, f32::max)
        };
        let most = |component: usize| if component < wide { 32767.0 } else { 127.0 };
        (0..basis.components).into_par_iter().map(|component| largest(component) / most(component)).collect()
    })
}

/// Quantises a value.
pub(super) fn integer(value: f32, step: f32) -> i32 {
    if step > 0.0 { (value / step).round_ties_even() as i32 } else { 0 }
}

/// The basis as a decoder reconstructs it.
pub(super) fn rounded(basis: &Basis, steps: &[Vec<f32>; 3]) -> Basis {
    let mut rounded = basis.clone();
    for (row, values) in rounded.values.chunks_exact_mut(basis.components).enumerate() {
        let steps = &steps[row % 3];
        values.iter_mut().zip(steps).for_each(|(value, step)| *value = integer(*value, *step) as f32 * step);
    }
    rounded
}

/// Shares of the smallest and largest weights that a range may clamp.
const CLAMPED_SHARES: [f64; 5] = [0.0, 1e-4, 3e-4, 1e-3, 3e-3];

/// Ranges of the weights of each component, texels x K, that minimise the sum of squared errors after clamping and
/// rounding to 8 bits.
pub(super) fn weight_ranges(weights: &[f32], components: usize) -> Vec<WeightRange> {
    let range = |component: usize| {
        let mut sorted: Vec<f32> = weights.iter().skip(component).step_by(components).copied().collect();
        sorted.sort_unstable_by(f32::total_cmp);
        let error = |range: &WeightRange| -> f64 {
            sorted.iter().map(|w| f64::from(range.of_byte(weight_byte(*w, *range)) - w).powi(2)).sum()
        };
        let candidate = |share: f64| {
            let skipped = ((sorted.len() as f64 * share) as usize).min((sorted.len() - 1) / 2);
            let (low, high) = (sorted[skipped], sorted[sorted.len() - 1 - skipped]);
            WeightRange { scale: high - low, low }
        };
        let measured = CLAMPED_SHARES.map(candidate).map(|range| (error(&range), range));
        measured.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("there are candidates").1
    };
    (0..components).into_par_iter().map(range).collect()
}

/// Quantises a weight.
pub(super) fn weight_byte(weight: f32, range: WeightRange) -> u8 {
    if range.scale > 0.0 { (255.0 * (weight - range.low) / range.scale).round().clamp(0.0, 255.0) as u8 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spare_words_become_wide() {
        // Words of a colour: groups and wide groups, in texels of four.
        for (groups, wide) in [(1, 1), (2, 2), (3, 1), (4, 4), (5, 3), (7, 1), (8, 4), (11, 1), (15, 1), (16, 4)] {
            assert_eq!(wide_groups(groups), wide, "{groups}");
            assert!(wide == groups || (groups + wide) % 4 == 0);
        }
    }

    #[test]
    fn a_rounded_basis_is_within_half_a_step() {
        let value = |k: usize| ((k * 7919) % 1009) as f32 - 504.5;
        let basis = Basis { views: 3, lights: 4, components: 12, values: (0..3 * 4 * 36).map(value).collect() };
        let steps = steps(&basis, 1);
        let rounded = rounded(&basis, &steps);
        for (at, (a, b)) in basis.values.iter().zip(&rounded.values).enumerate() {
            let step = steps[at / 12 % 3][at % 12];
            assert!((a - b).abs() <= 0.501 * step && integer(*a, step).abs() <= if at % 12 < 4 { 32767 } else { 127 });
        }
        assert!(steps[0][0] < 0.02 && steps[0][4] > 2.0);
        assert_eq!(integer(3.0, 0.0), 0);
    }

    #[test]
    fn outliers_are_clamped_where_that_pays() {
        let mut weights: Vec<f32> = (0..20_000).map(|k| (k % 100) as f32 / 100.0).collect();
        let all = weight_ranges(&weights, 2);
        assert!(all.iter().all(|range| range.low < 0.02 && range.scale > 0.95), "{all:?}");
        weights[4] = 20.0;
        let range = weight_ranges(&weights, 2)[0];
        // One outlier of 10,000 costs 19²; without clamping, all others would cost 0.02² each.
        assert_eq!(range.scale, 20.0);
        weights[4] = 3.0;
        (0..20).for_each(|k| weights[1000 * k + 1] = if k == 0 { 2.0 } else { weights[1] });
        let two = weight_ranges(&weights, 2);
        assert!(two[1].scale <= 2.0, "{two:?}");
    }
}
