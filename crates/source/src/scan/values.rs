//! Marks that a detector or a file's decimals leave in values: a largest value that many samples share, and a common step.

use super::coordinates::{Identity, Isotropic, Space};
use brdfc_core::source::{Rounding, Saturation};
use brdfc_formats::direction::DirectionPair;
use std::collections::BTreeSet;

/// Minimum number of direction pairs with the largest value of a saturated detector.
const MIN_SATURATED: usize = 8;
/// Minimum ratio of the largest value and the median: a matte material has its largest value at many direction pairs.
const ABOVE_MEDIAN: f64 = 1.5;
/// Largest distance of a value from a multiple of the step, in steps.
const OFF_STEP: f64 = 0.01;

/// The channel with most direction pairs at its largest value, of `count` samples: values in 1/sr, NaN if not measured, and direction
/// pairs by index. Pairs that the symmetries of an isotropic material identify count once: simulated values of such pairs are equal.
pub(crate) fn saturation(
    count: usize,
    value: impl Fn(usize) -> [f64; 3],
    pair: impl Fn(usize) -> DirectionPair,
) -> Option<Saturation> {
    let of_channel = |channel: usize| {
        let mut positive: Vec<f64> = (0..count).map(|index| value(index)[channel]).filter(|v| *v > 0.0).collect();
        let largest = positive.iter().copied().fold(0.0, f64::max);
        let middle = positive.len() / 2;
        if positive.is_empty() || largest < ABOVE_MEDIAN * *positive.select_nth_unstable_by(middle, f64::total_cmp).1 {
            return None;
        }
        let at_limit = (0..count).filter(|index| value(*index)[channel] >= largest);
        let distinct: BTreeSet<Identity> = at_limit.map(|index| identity(pair(index))).collect();
        (distinct.len() >= MIN_SATURATED).then_some(Saturation { value: largest, pairs: distinct.len() })
    };
    (0..3).filter_map(of_channel).max_by_key(|found| found.pairs)
}

/// Identity that is equal for exchanged pairs, too.
fn identity(pair: DirectionPair) -> Identity {
    Isotropic::identity(pair).min(Isotropic::identity(pair.exchanged()))
}

/// The smallest difference of values, if all are multiples of it.
pub(super) fn rounding(values: &[[f64; 3]]) -> Option<Rounding> {
    let mut positive: Vec<f64> = values.iter().flatten().copied().filter(|v| *v > 0.0).collect();
    positive.sort_by(f64::total_cmp);
    let least = 1e-9 * positive.last()?;
    let steps = positive.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > least);
    let step = steps.fold(positive[0], f64::min);
    let off = |value: &f64| (value / step - (value / step).round()).abs();
    let error = positive.iter().map(|value| 0.25 * step / value).sum::<f64>() / positive.len() as f64;
    // Equal values, as of a matte model, have no step.
    (step < *positive.last()? && positive.iter().all(|value| off(value) <= OFF_STEP))
        .then_some(Rounding { step, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lobe(k: usize) -> f64 {
        0.1 + 2.0 * (-(k as f64 / 20.0).powi(2)).exp()
    }

    fn pair(k: usize) -> DirectionPair {
        DirectionPair::from_angles(0.3, 0.0, 0.005 * k as f64, 1.0)
    }

    #[test]
    fn a_largest_value_of_many_pairs_is_saturation() {
        let limited = |limit: f64| move |k| [lobe(k).min(limit), f64::NAN, 0.1];
        assert_eq!(saturation(200, limited(9.0), pair), None);
        assert_eq!(saturation(200, limited(1.0), pair).map(|found| found.value), Some(1.0));
        // Symmetric pairs count once, and matte materials have no peak.
        assert_eq!(saturation(200, limited(1.0), |_| pair(1)), None);
        assert_eq!(saturation(200, |_| [0.3; 3], pair), None);
        assert_eq!(saturation(200, |_| [0.0; 3], pair), None);
    }

    #[test]
    fn a_common_step_is_rounding() {
        let values = |step: f64| -> Vec<[f64; 3]> { (0..200).map(|k| [(lobe(k) / step).round() * step; 3]).collect() };
        for step in [0.05, 0.01] {
            let found = rounding(&values(step)).unwrap();
            assert!((found.step - step).abs() < 1e-9 && (4.0..10.0).contains(&(4.0 * found.error / step)), "{found:?}");
        }
        assert!(rounding(&values(1e-6)).unwrap().error < 1e-4);
        assert_eq!(rounding(&(0..200).map(|k| [lobe(k); 3]).collect::<Vec<_>>()), None);
        assert_eq!(rounding(&[[0.3; 3]; 20]), None);
        assert_eq!(rounding(&[[0.0; 3]; 20]), None);
    }
}
