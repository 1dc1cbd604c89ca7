//! Marks that a detector or a file's decimals leave in values: a plateau at the largest one, and a common step.

use super::LOG_BIAS;
use super::coordinates::polar;
use brdfc_core::source::{Rounding, Saturation};
use brdfc_formats::direction::{DirectionPair, half_vector};
use std::collections::BTreeSet;

/// Minimum number of samples of a plateau.
const MIN_SATURATED: usize = 8;
/// Largest relative difference of samples of a plateau: values are rounded, also after a division by a cosine.
const EQUAL: f64 = 1e-4;
/// Minimum range of their half angles, degrees: a peak has its largest value at one half angle, if at many incidences.
const MIN_RANGE: f64 = 1.0;
/// Minimum ratio of the number of samples at the largest value and at the next one: rounding makes as many equal at any value.
const MORE: usize = 3;
/// Minimum ratio of the largest value and the median: the values of matte materials are nearly equal.
const ABOVE_MEDIAN: f64 = 1.5;
/// Minimum number of distinct values of a channel that have a step; constants have none.
const MIN_DISTINCT: usize = 3;
/// Largest distance of a value from a multiple of the step, in steps.
const OFF_STEP: f64 = 0.01;

/// The plateau at the largest signal of `count` samples, in the channel with the widest one. Signals are values, or values times cosines,
/// and NaN if not measured.
pub(crate) fn saturation(
    count: usize,
    signal: impl Fn(usize) -> [f64; 3],
    pair: impl Fn(usize) -> DirectionPair,
) -> Option<Saturation> {
    let of_channel = |channel: usize| {
        let signal = |index: usize| signal(index)[channel];
        let below = |limit: f64| (0..count).map(signal).filter(|value| *value < limit).fold(0.0, f64::max);
        let equal =
            |limit: f64| (0..count).filter(move |index| (limit * (1.0 - EQUAL)..=limit).contains(&signal(*index)));
        let largest = below(f64::INFINITY);
        let plateau: Vec<usize> = if largest > 0.0 { equal(largest).collect() } else { Vec::new() };
        let angles = || plateau.iter().map(|index| polar(half_vector(pair(*index))).to_degrees());
        let [first, last] = [angles().fold(f64::INFINITY, f64::min), angles().fold(0.0, f64::max)];
        if plateau.len() < MIN_SATURATED || last - first < MIN_RANGE {
            return None;
        }
        let next = below(largest * (1.0 - EQUAL));
        let positive = (0..count).filter(|index| signal(*index) > 0.0).count();
        let bright = (0..count).filter(|index| ABOVE_MEDIAN * signal(*index) >= largest).count();
        let is_cut = 2 * bright < positive && plateau.len() >= MORE * equal(next).count().max(1);
        is_cut.then_some(Saturation { samples: plateau.len(), farthest: last })
    };
    (0..3).filter_map(of_channel).max_by_key(|found| found.samples)
}

/// Plateaus of a scan: a detector measures values, or values times one cosine or both.
pub(super) fn saturation_of_rows(values: &[[f64; 3]], pairs: &[DirectionPair]) -> Option<Saturation> {
    let signals: [fn(DirectionPair) -> f64; 4] =
        [|_| 1.0, |pair| pair.incoming[2], |pair| pair.outgoing[2], |pair| pair.incoming[2] * pair.outgoing[2]];
    let of_signal = |factor: fn(DirectionPair) -> f64| {
        saturation(values.len(), |row| values[row].map(|value| value * factor(pairs[row])), |row| pairs[row])
    };
    signals.into_iter().filter_map(of_signal).max_by_key(|found| found.samples)
}

/// The smallest difference of values, if all are multiples of it. Channels without light do not count.
pub(super) fn rounding(values: &[[f64; 3]]) -> Option<Rounding> {
    let channel = |channel: usize| values.iter().map(move |value| value[channel]);
    let lit = (0..3).filter(|k| channel(*k).any(|value| value > 0.0));
    let all: Vec<f64> = lit.flat_map(channel).collect();
    let mut positive: Vec<f64> = all.iter().copied().filter(|value| *value > 0.0).collect();
    positive.sort_by(f64::total_cmp);
    let largest = *positive.last()?;
    let steps = positive.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-9 * largest);
    // Without the rounding of differences.
    let step = largest / (largest / steps.fold(positive[0], f64::min)).round();
    let is_multiple = |value: &f64| (value / step - (value / step).round()).abs() <= OFF_STEP;
    let distinct = |k: usize| channel(k).map(f64::to_bits).collect::<BTreeSet<_>>().len();
    if !positive.iter().all(is_multiple) || (0..3).all(|k| distinct(k) < MIN_DISTINCT) {
        return None;
    }
    let floor = LOG_BIAS * positive[positive.len() / 2];
    let error = all.iter().map(|value| 0.25 * step / value.max(floor)).sum::<f64>() / all.len() as f64;
    Some(Rounding { step, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of an incidence of 30 degrees in its plane, and half angles up to 25 degrees.
    fn pair(k: usize) -> DirectionPair {
        DirectionPair::from_angles(0.52, 0.0, 0.52 - 0.0043 * k as f64, std::f64::consts::PI)
    }

    fn lobe(k: usize) -> f64 {
        0.1 + 2.0 * (-(k as f64 / 40.0).powi(2)).exp()
    }

    #[test]
    fn a_plateau_at_the_largest_value_is_saturation() {
        let of = |signal: &dyn Fn(usize) -> f64| saturation(200, |k| [signal(k), f64::NAN, 0.1], pair);
        assert_eq!(of(&lobe), None);
        let found = of(&|k| lobe(k).min(1.0)).unwrap();
        assert!(found.samples == 36 && (found.farthest - 4.3).abs() < 0.1, "{found:?}");
        // Matte materials are flat, rounded values have plateaus everywhere, and exact peaks are at one half angle.
        assert_eq!(of(&|_| 0.3), None);
        assert_eq!(of(&|_| 0.0), None);
        assert_eq!(of(&|k| (10.0 * lobe(k)).round()), None);
        assert_eq!(saturation(200, |k| [lobe(k / 20); 3], |k| pair(k / 20)), None);
    }

    /// A detector is saturated by light, which is the value times the cosine of the incidence.
    #[test]
    fn saturated_signals_are_found() {
        let pairs: Vec<DirectionPair> = (0..400)
            .map(|k| {
                DirectionPair::from_angles(0.2 * (k / 100) as f64, 0.0, 0.015 * (k % 100) as f64, std::f64::consts::PI)
            })
            .collect();
        let value = |pair: &DirectionPair, limit: f64| {
            let cosine = pair.incoming[2];
            let light = 2.0 * (-(polar(half_vector(*pair)) / 0.15).powi(2)).exp() * cosine;
            [(light.min(limit) / cosine * 1e7).round() * 1e-7; 3]
        };
        let values = |limit: f64| pairs.iter().map(|pair| value(pair, limit)).collect::<Vec<_>>();
        assert_eq!(saturation_of_rows(&values(9.0), &pairs), None);
        let found = saturation_of_rows(&values(1.0), &pairs).unwrap();
        assert!(found.samples > 80 && (found.farthest - 7.0).abs() < 0.5, "{found:?}");
    }

    #[test]
    fn a_common_step_is_rounding() {
        let values = |step: f64| -> Vec<[f64; 3]> { (0..200).map(|k| [(lobe(k) / step).round() * step; 3]).collect() };
        for step in [0.05, 0.01] {
            let found = rounding(&values(step)).unwrap();
            assert!(
                (found.step - step).abs() < 1e-12 && (3.0..10.0).contains(&(4.0 * found.error / step)),
                "{found:?}"
            );
        }
        assert!(rounding(&values(1e-6)).unwrap().error < 1e-4);
        // Values that are rounded to 0 are the worst.
        let dark: Vec<[f64; 3]> = values(0.05).iter().map(|v| v.map(|f| ((f - 0.1) / 0.05).round() * 0.05)).collect();
        assert!(rounding(&dark).unwrap().error > 0.1);
        assert_eq!(rounding(&(0..200).map(|k| [lobe(k); 3]).collect::<Vec<_>>()), None);
        assert_eq!(rounding(&[[0.3, 0.1, 0.2]; 20]), None);
        assert_eq!(rounding(&[[0.0; 3]; 20]), None);
    }
}
