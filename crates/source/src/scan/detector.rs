//! Marks that a detector or a file's decimals leave in values: a plateau at the largest one, and a common step.

use super::coordinates::polar;
use crate::smooth::log_bias;
use brdfc_core::source::{Rounding, Saturation};
use brdfc_formats::direction::{DirectionPair, dot, half_vector};
use std::array::from_fn;

/// Minimum number of samples of a plateau.
const MIN_SATURATED: usize = 8;
/// Depths of plateaus, relative to the largest value: values are rounded, also after a division by a cosine, and noisy.
const DEPTHS: [f64; 5] = [1e-4, 1e-3, 0.01, 0.03, 0.06];
/// Depth, in units of a plateau's, of the values that are compared with it. Within it, a quadratic peak in one dimension has twice as many
/// samples as within the plateau, and four times as many in two dimensions.
const COMPARED: f64 = 4.0;
/// Minimum ratio of the number of samples of a plateau and below it. Rounding makes as many equal at any value.
const MORE: usize = 3;
/// Minimum range of half angles of a plateau, degrees, and of the angles between light and half vector: at many incidences a highlight has
/// its largest value at one half angle, and a retroreflection at one angle between light and half vector.
const MIN_RANGE: f64 = 1.0;
/// Minimum ratio of the largest value and others: the values of matte materials are nearly equal.
const ABOVE_OTHERS: f64 = 1.5;
/// Minimum share of these others. Half angles of tables are dense in the highlight.
const OTHERS: f64 = 0.25;
/// Minimum number of distinct values of a channel that have a step; constants have none.
const MIN_DISTINCT: usize = 3;
/// Largest distance of a value from a multiple of the step, in steps.
const OFF_STEP: f64 = 0.01;
/// Relative difference below which values are equal: that of single precision.
const EQUAL: f64 = 1e-6;
/// Approximate number of values from which the step is found.
const FOR_STEP: usize = 4096;

/// The plateau at the largest signal of `count` samples, in the channel with the widest one. Signals are values, or values times cosines,
/// and NaN if not measured.
pub(crate) fn saturation(
    count: usize,
    signal: impl Fn(usize) -> [f64; 3],
    pair: impl Fn(usize) -> DirectionPair,
) -> Option<Saturation> {
    let mut largest = [0.0f64; 3];
    for index in 0..count {
        largest = from_fn(|channel| signal(index)[channel].max(largest[channel]));
    }
    let mut near: [Vec<f64>; 3] = Default::default();
    let (mut positive, mut others) = ([0usize; 3], [0usize; 3]);
    let starts = largest.map(|value| value * (1.0 - COMPARED * DEPTHS[DEPTHS.len() - 1]));
    for index in 0..count {
        for (channel, value) in signal(index).into_iter().enumerate().filter(|(_, value)| *value > 0.0) {
            positive[channel] += 1;
            others[channel] += usize::from(value * ABOVE_OTHERS < largest[channel]);
            if value >= starts[channel] {
                near[channel].push(value);
            }
        }
    }
    let of_channel = |channel: usize| {
        let (largest, near) = (largest[channel], &near[channel]);
        if others[channel] as f64 <= OTHERS * positive[channel] as f64 {
            return None;
        }
        let is_plateau = |depth: &f64| {
            let end = largest * (1.0 - depth);
            let within = |start: f64, end: f64| near.iter().filter(|value| (start..end).contains(value)).count();
            let next = near.iter().copied().filter(|value| *value < end).fold(0.0, f64::max);
            let start = (largest * (1.0 - COMPARED * depth)).min(next * (1.0 - depth));
            let samples = within(end, f64::INFINITY);
            samples >= MIN_SATURATED && samples >= MORE * within(start, end).max(1)
        };
        let end = largest * (1.0 - DEPTHS.iter().find(|depth| is_plateau(depth))?);
        let pairs = || (0..count).filter(|index| signal(*index)[channel] >= end).map(&pair);
        let range = |angle: fn(DirectionPair) -> f64| {
            let angles = || pairs().map(|pair| angle(pair).to_degrees());
            [angles().fold(f64::INFINITY, f64::min), angles().fold(0.0, f64::max)]
        };
        let half = range(|pair| polar(half_vector(pair)));
        let difference = range(|pair| 0.5 * dot(pair.incoming, pair.outgoing).clamp(-1.0, 1.0).acos());
        let is_wide = [half, difference].iter().all(|[first, last]| last - first >= MIN_RANGE);
        is_wide.then(|| Saturation { samples: pairs().count(), farthest: half[1] })
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

/// Rounding of `count` values, whose step is known from decimals, or else found in each channel. Values are NaN if not measured.
pub(crate) fn rounding(count: usize, value: impl Fn(usize) -> [f64; 3], known: Option<f64>) -> Option<Rounding> {
    let values = |channel: usize| {
        let value = &value;
        move |step: usize| {
            (0..count).step_by(step).map(move |index| value(index)[channel]).filter(|value| !value.is_nan())
        }
    };
    let step = |channel: usize| match known {
        // A constant is no rounded value.
        Some(_) => known.filter(|_| values(channel)(1).any(|other| other != value(0)[channel])),
        None => step_of(count, values(channel)),
    };
    let steps: Vec<(usize, f64)> = (0..3).filter_map(|channel| Some((channel, step(channel)?))).collect();
    if steps.is_empty() {
        return None;
    }
    let measured: Vec<[f64; 3]> = (0..count).map(&value).filter(|value| !value[0].is_nan()).collect();
    let floor = log_bias(&measured);
    let error = |channel: usize, step: f64| {
        measured.iter().map(|value| 0.25 * step / value[channel].max(floor)).sum::<f64>() / measured.len() as f64
    };
    let is_lit = |channel: &usize| measured.iter().any(|value| value[*channel] > 0.0);
    let lit = (0..3).filter(is_lit).count();
    let found = steps.into_iter().filter(|(channel, _)| is_lit(channel));
    let found: Vec<(f64, f64)> = found.map(|(channel, step)| (step, error(channel, step))).collect();
    let (step, _) = *found.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Rounding { step, error: found.iter().map(|(_, error)| error).sum::<f64>() / lit as f64 })
}

/// The smallest difference of positive values, if all are multiples of it. The argument of `values` is a step through them.
fn step_of<I: Iterator<Item = f64>>(count: usize, values: impl Fn(usize) -> I) -> Option<f64> {
    let mut some: Vec<f64> = values((count / FOR_STEP).max(1)).filter(|value| *value > 0.0).collect();
    some.sort_by(f64::total_cmp);
    let largest = *some.last()?;
    let steps = some.windows(2).filter(|pair| pair[1] - pair[0] > EQUAL * pair[1]).map(|pair| pair[1] - pair[0]);
    let distinct = 1 + steps.clone().count();
    // The first one, because differences of small values are the most exact ones.
    let least = steps.clone().fold(some[0], f64::min);
    let step = steps.into_iter().find(|step| *step <= least * (1.0 + OFF_STEP)).unwrap_or(least);
    let step = largest / (largest / step).round();
    let is_multiple = |value: f64| (value / step - (value / step).round()).abs() <= OFF_STEP;
    (distinct >= MIN_DISTINCT && some.iter().copied().all(is_multiple) && values(1).all(is_multiple)).then_some(step)
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
        // With noise.
        for noise in [1e-4, 3e-3, 0.01] {
            let noisy = |k: usize| lobe(k).min(1.0) * (1.0 + noise * (2.7 * k as f64).sin());
            assert!(of(&noisy).unwrap().samples >= 36, "{noise}");
            assert_eq!(of(&|k| lobe(k) * (1.0 + noise * (2.7 * k as f64).sin())), None, "{noise}");
        }
        // A retroreflection of incidences up to 57 degrees.
        let retro = |k: usize| {
            let incidence = 0.05 * (k / 10) as f64;
            DirectionPair::from_angles(incidence, 0.0, incidence + 0.02 * (k % 10) as f64, 0.0)
        };
        assert_eq!(saturation(200, |k| [if k % 10 == 0 { 1.0 } else { 0.1 }; 3], retro), None);
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
        let rounding = |values: &[[f64; 3]], known| rounding(values.len(), |index| values[index], known);
        let values = |step: f64| -> Vec<[f64; 3]> { (0..200).map(|k| [(lobe(k) / step).round() * step; 3]).collect() };
        for step in [0.05, 0.01] {
            let found = rounding(&values(step), None).unwrap();
            assert!(
                (found.step - step).abs() < 1e-12 && (3.0..10.0).contains(&(4.0 * found.error / step)),
                "{found:?}"
            );
        }
        assert!(rounding(&values(1e-6), None).unwrap().error < 1e-4);
        // Channels with gains of their own, and decimals of spectra.
        let gains: Vec<[f64; 3]> = values(0.01).iter().map(|v| [1.0, 1.07, 0.93].map(|gain| gain * v[0])).collect();
        assert!((rounding(&gains, None).unwrap().step - 0.01).abs() < 1e-3);
        let exact: Vec<[f64; 3]> = (0..200).map(|k| [lobe(k); 3]).collect();
        let known = rounding(&exact, Some(0.05)).unwrap();
        assert!((known.error / rounding(&values(0.05), None).unwrap().error - 1.0).abs() < 0.1, "{known:?}");
        // In single precision, with a highlight.
        let narrow = |k: usize| 0.05 + 70.0 * (-(k as f64 / 20.0).powi(2)).exp();
        let single: Vec<[f64; 3]> =
            (0..200).map(|k| [f64::from(((100.0 * narrow(k)).round() / 100.0) as f32); 3]).collect();
        assert!((rounding(&single, None).unwrap().step - 0.01).abs() < 1e-8);
        // Values that are rounded to 0 are the worst.
        let dark: Vec<[f64; 3]> = values(0.05).iter().map(|v| v.map(|f| ((f - 0.1) / 0.05).round() * 0.05)).collect();
        assert!(rounding(&dark, None).unwrap().error > 0.1);
        assert_eq!(rounding(&(0..200).map(|k| [lobe(k); 3]).collect::<Vec<_>>(), None), None);
        assert_eq!(rounding(&[[0.3, 0.1, 0.2]; 20], None), None);
        assert_eq!(rounding(&[[0.0; 3]; 20], None), None);
    }
}
