//! Cross-validation of scans: scans without some of their rows, and the distance of a direction pair from the rows.

use super::{Points, ScanSource, Tree};
use crate::scan::coordinates::{Anisotropic, Isotropic, Space};
use brdfc_core::source::{Completion, Fold, MAX_PARTS, MAX_PEAK, MAX_RISE, Parts, Repeats, Rise};
use brdfc_formats::direction::{DirectionPair, dot};
use kiddo::SquaredEuclidean;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::num::NonZero;

/// Incidences that round to the same multiple of this angle are equal, degrees.
const INCIDENCE: f64 = 1.0;
/// Angles that round to the same multiple of this are equal, radians.
const SAME: f64 = 1e-5;
/// Maximum difference of logarithms between a value and its copy, as opposed to a second measurement.
const COPY: f64 = 1e-6;
/// Width of the groups of incidences in which rows near the mirror direction are compared, degrees.
const STEP: f64 = 5.0;
/// Maximum polar angle of incidence of these groups, degrees; viewers may be 15 degrees lower.
const MAX_INCIDENCE: f64 = 62.5;
/// Minimum number of rows of such a group.
const MIN_RISE_ROWS: usize = 8;
/// Number of candidates for the nearest row by angles: the nearest ones in the search space.
const NEAREST: NonZero<usize> = NonZero::new(8).expect("positive");

impl ScanSource {
    /// Index of the incidence of each row, and the number of incidences. A row that equals another with light and viewer
    /// exchanged, value included, is a copy: both belong to whichever incidence has more rows.
    fn incidences(&self) -> (Vec<usize>, usize) {
        let degrees = |radians: f64| (radians.to_degrees() / INCIDENCE).round() as i32;
        let key = |pair: &DirectionPair| {
            let [x, y, z] = pair.incoming;
            let polar = degrees(x.hypot(y).atan2(z));
            let azimuth = if self.summary.isotropic || polar == 0 { 0 } else { degrees(y.atan2(x)) };
            (polar, azimuth)
        };
        let mut rows_of: BTreeMap<(i32, i32), usize> = BTreeMap::new();
        self.pairs.iter().for_each(|pair| *rows_of.entry(key(pair)).or_default() += 1);
        let rows: BTreeMap<_, usize> =
            self.pairs.iter().enumerate().map(|(row, pair)| (self.place(*pair), row)).collect();
        let is_copy = |row: usize, pair: DirectionPair| {
            let other = rows.get(&self.place(pair.exchanged())).filter(|other| **other != row)?;
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < COPY;
            self.values[row].iter().zip(&self.values[*other]).all(near).then(|| pair.exchanged())
        };
        let key_of = |(row, pair): (usize, &DirectionPair)| {
            let (own, other) = (key(pair), is_copy(row, *pair).map(|pair| key(&pair)));
            // Exchanged rows may have no incidence of their own.
            let count = |key: &(i32, i32)| (rows_of.get(key).copied().unwrap_or(0), std::cmp::Reverse(*key));
            other.filter(|other| count(other) > count(&own)).unwrap_or(own)
        };
        let keys: Vec<(i32, i32)> = self.pairs.iter().enumerate().map(key_of).collect();
        let mut numbers: BTreeMap<(i32, i32), usize> = keys.iter().map(|key| (*key, 0)).collect();
        numbers.values_mut().enumerate().for_each(|(number, of)| *of = number);
        (keys.iter().map(|key| numbers[key]).collect(), numbers.len())
    }

    /// Rounded angles of a direction pair, equal for pairs that the material's symmetries identify.
    fn place(&self, pair: DirectionPair) -> [i64; 4] {
        let rounded = |radians: f64| (radians / SAME).round() as i64;
        let polar = |[x, y, z]: [f64; 3]| x.hypot(y).atan2(z);
        let azimuth = |[x, y, _]: [f64; 3]| y.atan2(x);
        let [light, view] = [pair.incoming, pair.outgoing];
        if self.summary.isotropic {
            let turns = (azimuth(view) - azimuth(light)).rem_euclid(TAU);
            return [rounded(polar(light)), rounded(polar(view)), rounded(turns.min(TAU - turns)), 0];
        }
        [polar(light), azimuth(light), polar(view), azimuth(view)].map(rounded)
    }

    /// Compares the rows nearest to the mirror direction with the next ones at each polar angle of incidence, in steps of
    /// [`STEP`] degrees. Returns the angle at which the rows determine the peak least.
    fn rise_to_mirror(&self) -> Option<Rise> {
        let mut groups: BTreeMap<i32, Vec<(f64, f64)>> = BTreeMap::new();
        for (pair, value) in self.pairs.iter().zip(&self.values) {
            let polar = |[x, y, z]: [f64; 3]| x.hypot(y).atan2(z).to_degrees();
            let half = [0, 1, 2].map(|k| pair.incoming[k] + pair.outgoing[k]);
            let incidence = polar(pair.incoming);
            if incidence <= MAX_INCIDENCE && polar(pair.outgoing) <= MAX_INCIDENCE + 15.0 {
                let value = value.iter().map(|v| (v.exp() - self.bias).max(0.0)).sum::<f64>();
                let reflected = value * pair.incoming[2] * pair.outgoing[2];
                groups.entry((incidence / STEP).round() as i32).or_default().push((polar(half), reflected));
            }
        }
        let rises = groups.into_iter().filter_map(|(group, rows)| rise(f64::from(group) * STEP, rows));
        // The larger of both excesses.
        let unknown = |rise: &Rise| (rise.peak / MAX_PEAK).max(rise.ratio / MAX_RISE);
        rises.max_by(|a, b| unknown(a).total_cmp(&unknown(b)))
    }

    fn nearest<const D: usize, const S: usize, P: Space<D, S>>(
        &self,
        tree: &Tree<S>,
        pair: DirectionPair,
        distance: impl Fn(DirectionPair, DirectionPair) -> f64,
    ) -> f64 {
        let mut query = [0.0; S];
        query[..D].copy_from_slice(&P::place(pair));
        let found = tree.tree.query(&query).nearest_n::<SquaredEuclidean<f64>>(NEAREST).execute();
        let of_row = |row: DirectionPair| distance(pair, row).min(distance(pair, row.exchanged()));
        let rows = found.iter().map(|item| self.pairs[tree.value_of[item.item as usize] as usize]);
        rows.map(of_row).fold(f64::INFINITY, f64::min)
    }
}

impl Completion for ScanSource {
    fn fold_count(&self, parts: Parts) -> usize {
        folds_of(match parts {
            Parts::Samples => self.pairs.len(),
            Parts::Incidences => self.incidences().1,
        })
    }

    fn fold(&self, parts: Parts, number: usize) -> Option<Fold> {
        let rows = self.pairs.len();
        // Rows are in the order of their positions, so that every tenth of them is spread over all.
        let (of_row, count) = match parts {
            Parts::Samples => ((0..rows).collect(), rows),
            Parts::Incidences => self.incidences(),
        };
        let folds = folds_of(count);
        let value = |row: usize| self.values[row].map(|v| (v.exp() - self.bias).max(0.0));
        let (out, rest): (Vec<usize>, Vec<usize>) = (0..rows).partition(|row| of_row[*row] % folds == number);
        let pairs: Vec<DirectionPair> = rest.iter().map(|row| self.pairs[*row]).collect();
        let values: Vec<[f64; 3]> = rest.into_iter().map(value).collect();
        let source = Self::of_pairs(&pairs, &values, self.summary.isotropic).ok()?;
        let left_out = out.into_iter().map(|row| (self.pairs[row], value(row))).collect();
        Some(Fold { source: Box::new(source), left_out })
    }

    fn distance(&self, pair: DirectionPair) -> f64 {
        match &self.points {
            Points::Isotropic(tree) => self.nearest::<3, 4, Isotropic>(tree, pair, isotropic_distance),
            Points::Anisotropic(tree) => self.nearest::<4, 5, Anisotropic>(tree, pair, distance),
        }
    }

    fn repeats(&self) -> Option<Repeats> {
        self.repeats
    }

    fn rise(&self) -> Option<Rise> {
        self.rise_to_mirror()
    }
}

/// Compares the rows of one incidence (half angle in degrees, reflected light) nearest to the mirror direction with the next
/// ones. Returns `None` if there are few rows or no highlight.
fn rise(incidence: f64, mut rows: Vec<(f64, f64)>) -> Option<Rise> {
    if rows.len() < MIN_RISE_ROWS {
        return None;
    }
    let mut reflected: Vec<f64> = rows.iter().map(|row| row.1).collect();
    reflected.sort_by(f64::total_cmp);
    let diffuse = reflected[reflected.len() / 5];
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mean = |first: f64, last: f64| {
        let within = rows.iter().filter(|(half, _)| (first..=last).contains(half));
        let (sum, count) = within.fold((0.0, 0usize), |(sum, count), (_, value)| (sum + value, count + 1));
        sum / count.max(1) as f64 - diffuse
    };
    let nearest = rows[0].0;
    let apart = (1.75 * nearest).max(nearest + 0.5);
    let next = rows.iter().find(|(half, _)| *half >= apart)?.0;
    let at_nearest = mean(nearest, 1.25 * nearest);
    if at_nearest < 0.5 * diffuse || at_nearest <= 0.0 {
        return None;
    }
    let ratio = (at_nearest / mean(next, 1.4 * next).max(1e-3 * at_nearest).max(0.02 * diffuse)).max(1.0);
    // D(θ) ∝ 1 / (1 + x)² with x ∝ θ²: x at the nearest, from the ratio and that of the squared angles.
    let (steps, root) = ((next / nearest.max(1e-6)).powi(2), ratio.sqrt());
    let x = if root < steps { ((root - 1.0) / (steps - root)).min(9.0) } else { 9.0 };
    Some(Rise { incidence, nearest, next, ratio, peak: (1.0 + x).powi(2) })
}

/// Number of folds for `count` rows or incidences.
fn folds_of(count: usize) -> usize {
    if count < 2 { 0 } else { count.min(MAX_PARTS) }
}

/// The larger of the angles between lights and between viewers, radians.
fn distance(pair: DirectionPair, sample: DirectionPair) -> f64 {
    let angle = |a, b| dot(a, b).clamp(-1.0, 1.0).acos();
    angle(pair.incoming, sample.incoming).max(angle(pair.outgoing, sample.outgoing))
}

/// Angle between a direction pair and a sample of an isotropic, mirror-symmetric material: the larger of those between
/// lights and between viewers, with the sample rotated so that one of them is in the same plane with the normal.
fn isotropic_distance(pair: DirectionPair, sample: DirectionPair) -> f64 {
    let polar = |v: [f64; 3]| v[0].hypot(v[1]).atan2(v[2]);
    let turn = |pair: DirectionPair| {
        let [a, b] = [pair.incoming, pair.outgoing].map(|v| v[1].atan2(v[0]));
        let turns = (b - a).rem_euclid(TAU);
        turns.min(TAU - turns)
    };
    let [[light, view], [of_light, of_view]] = [pair, sample].map(|pair| [polar(pair.incoming), polar(pair.outgoing)]);
    let turned = turn(pair) - turn(sample);
    let between = |a: f64, b: f64| (a.cos() * b.cos() + a.sin() * b.sin() * turned.cos()).clamp(-1.0, 1.0).acos();
    let by_light = (light - of_light).abs().max(between(view, of_view));
    let by_view = (view - of_view).abs().max(between(light, of_light));
    by_light.min(by_view)
}
