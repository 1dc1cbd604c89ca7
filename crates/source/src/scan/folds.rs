//! Cross-validation of scans: scans without some of their rows, and the distance of a direction pair from the rows.

use super::fit::{TERMS_3D, TERMS_4D};
use super::rise::rise_to_peaks;
use super::strength::Strength;
use super::{Points, ScanSource, Tree};
use crate::scan::coordinates::{Anisotropic, Identity, Isotropic, Space, polar};
use brdfc_core::Tally;
use brdfc_core::source::{Completion, Fold, MAX_PARTS, Parts, Repeats, Rise, Rounding, Samples, Saturation};
use brdfc_formats::direction::{DirectionPair, dot};
use kiddo::SquaredEuclidean;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::num::NonZero;

/// Incidences that round to the same multiple of this angle are equal, degrees.
const INCIDENCE: f64 = 1.0;
/// Maximum difference of logarithms between a value and its copy, as opposed to a second measurement.
const COPY: f64 = 1e-6;
/// Largest distance of an exchanged row from the rows as measured, degrees, for a comparison with their fit.
const NEAR: f64 = 5.0;
/// Largest polar angle of rows that are compared with exchanged ones, degrees: at grazing angles, real scans are not reciprocal.
const MAX_POLAR: f64 = 65.0;
/// Differences of exchanged rows up to this multiple of the mean left-out residual are the fit's.
const LEFT_OUT: f64 = 3.0;
/// Minimum and maximum number of rows that are compared with exchanged ones.
const COMPARED: [usize; 2] = [20, 1000];
/// Number of candidates for the nearest row by angles: the nearest ones in the search space.
const NEAREST: NonZero<usize> = NonZero::new(8).expect("positive");

impl ScanSource {
    /// Index of the incidence of each row, and the number of incidences. A row that equals another with light and
    /// viewer exchanged, value included, is a copy: both belong to whichever incidence has more rows.
    fn incidences(&self) -> &(Vec<usize>, usize) {
        self.incidences.get_or_init(|| self.count_incidences())
    }

    fn count_incidences(&self) -> (Vec<usize>, usize) {
        let degrees = |radians: f64| (radians.to_degrees() / INCIDENCE).round() as i32;
        let key = |pair: &DirectionPair| {
            let [x, y, _] = pair.incoming;
            let polar = degrees(polar(pair.incoming));
            let azimuth = if self.summary.isotropic || polar == 0 { 0 } else { degrees(y.atan2(x)) };
            (polar, azimuth)
        };
        let mut rows_of: BTreeMap<(i32, i32), usize> = BTreeMap::new();
        self.pairs.iter().for_each(|pair| *rows_of.entry(key(pair)).or_default() += 1);
        let rows: BTreeMap<_, usize> =
            self.pairs.iter().enumerate().map(|(row, pair)| (self.identity(*pair), row)).collect();
        let is_copy = |row: usize, pair: DirectionPair| {
            let other = rows.get(&self.identity(pair.exchanged())).filter(|other| **other != row)?;
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < COPY;
            self.measured[row].iter().zip(&self.measured[*other]).all(near).then(|| pair.exchanged())
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

    /// Identity of a direction pair, equal for pairs that the material's symmetries identify.
    fn identity(&self, pair: DirectionPair) -> Identity {
        if self.summary.isotropic { Isotropic::identity(pair) } else { Anisotropic::identity(pair) }
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

impl ScanSource {
    /// Mean difference of rows from the fit to the rows without their exchanged images, at exchanged directions, less the noise;
    /// 0 if the fit to the other rows alone explains it.
    fn difference_of_exchanged<const D: usize, const S: usize, const M: usize, P: Space<D, S>>(
        &self,
        tree: &Tree<S>,
        distance: impl Fn(DirectionPair, DirectionPair) -> f64,
    ) -> Option<f64> {
        let images = tree.positions.iter().copied().zip(tree.value_of.iter().copied());
        let measured = Tree::new(images.filter(|(at, _)| at[D] == 0.0).unzip());
        let rows = self.rows(&measured);
        let values = |logs: [f64; 3]| logs.map(|v| (v.exp() - self.bias).max(0.0));
        let difference = |row: usize| {
            let (own, pair) = (self.pairs[row], self.pairs[row].exchanged());
            let is_low = [own.incoming, own.outgoing].into_iter().any(|v| polar(v).to_degrees() > MAX_POLAR);
            if is_low || self.identity(own) == self.identity(pair) {
                return None;
            }
            let (neighbourhood, nearest) = rows.around::<D, M, P>(pair, self.neighbours);
            let nearest = nearest.map(|other| distance(pair, self.pairs[other])).fold(f64::INFINITY, f64::min);
            if nearest.to_degrees() > NEAR {
                return None;
            }
            let (fitted, own) =
                (values(neighbourhood.fit(rows.channels, &mut Tally::default())), values(rows.values[row]));
            let sum = |of: fn(f64, f64) -> f64| (0..rows.channels).map(|c| of(own[c], fitted[c])).sum::<f64>();
            let larger = sum(f64::max);
            let difference = if larger > 0.0 { sum(|a, b| (a - b).abs()) / larger } else { 0.0 };
            let residual = rows.fit_row::<D, M, P>(row, self.neighbours).residual;
            let left_out = residual[..rows.channels].iter().map(|r| 1.0 - (-r.abs()).exp()).sum::<f64>();
            Some((difference, left_out / rows.channels as f64))
        };
        let [least, most] = COMPARED;
        let step = self.pairs.len().div_ceil(most);
        let found: Vec<(f64, f64)> = (0..self.pairs.len()).step_by(step).filter_map(difference).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>() / found.len() as f64;
        (found.len() >= least).then(|| {
            let (difference, left_out) = (mean(|row| row.0), mean(|row| row.1));
            let excess = difference - self.summary.noise;
            if difference > LEFT_OUT * left_out { excess.max(0.0) } else { 0.0 }
        })
    }
}

impl Samples for ScanSource {
    fn distance(&self, pair: DirectionPair) -> f64 {
        match &self.points {
            Points::Isotropic(tree) => self.nearest::<3, 4, Isotropic>(tree, pair, isotropic_distance),
            Points::Anisotropic(tree) => self.nearest::<4, 5, Anisotropic>(tree, pair, distance),
        }
    }

    fn rise(&self) -> Option<Rise> {
        let luminance = |value: &[f64; 3]| value.iter().map(|v| (v.exp() - self.bias).max(0.0)).sum::<f64>();
        rise_to_peaks(self.pairs.iter().copied().zip(self.measured.iter().map(luminance)))
    }

    fn saturation(&self) -> Option<Saturation> {
        self.saturation
    }

    fn rounding(&self) -> Option<Rounding> {
        self.rounding
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
        let of_row = |row: usize| match parts {
            Parts::Samples => row,
            Parts::Incidences => self.incidences().0[row],
        };
        let folds = self.fold_count(parts);
        let value = |row: usize| self.measured[row].map(|v| (v.exp() - self.bias).max(0.0));
        let (out, rest): (Vec<usize>, Vec<usize>) = (0..rows).partition(|row| of_row(*row) % folds == number);
        let pairs: Vec<DirectionPair> = rest.iter().map(|row| self.pairs[*row]).collect();
        let values: Vec<[f64; 3]> = rest.iter().map(|row| value(*row)).collect();
        // The strength of the whole scan.
        let strength = match &self.smoothed {
            Some((sizes, _)) => Strength::OfRows(rest.iter().map(|row| sizes[*row]).collect()),
            None => Strength::Neighbours(self.neighbours),
        };
        let source = Self::of_pairs(&pairs, &values, self.summary.isotropic, &strength).ok()?;
        let left_out = out.into_iter().map(|row| (self.pairs[row], value(row))).collect();
        Some(Fold { source: Box::new(source), left_out })
    }

    fn repeats(&self) -> Option<Repeats> {
        self.repeats
    }

    fn exchanged(&self) -> Option<f64> {
        match &self.points {
            Points::Isotropic(tree) => {
                self.difference_of_exchanged::<3, 4, { TERMS_3D }, Isotropic>(tree, isotropic_distance)
            }
            Points::Anisotropic(tree) => {
                self.difference_of_exchanged::<4, 5, { TERMS_4D }, Anisotropic>(tree, distance)
            }
        }
    }
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

/// Angle between a direction pair and a sample of an isotropic, mirror-symmetric material: the larger of the angles
/// between lights and between viewers, with the sample rotated so that one of them is in the same plane with the
/// normal.
pub(crate) fn isotropic_distance(pair: DirectionPair, sample: DirectionPair) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Three incidences of an isotropic material. Every row is also there with light and viewer exchanged, and with its
    /// value multiplied by `times`; 0 for no such rows.
    fn scan(times: f64) -> ScanSource {
        let (mut pairs, mut values) = (Vec::new(), Vec::new());
        for incidence in [0.0, 30.0, 60.0f64] {
            for k in 0..20 {
                let (view, azimuth) = (0.31 + 0.05 * f64::from(k), 0.7 * f64::from(k % 5));
                let incidence = incidence.to_radians();
                let value = 0.1 + incidence.cos() * view.cos();
                pairs.push(DirectionPair::from_angles(incidence, 0.0, view, azimuth));
                values.push([value; 3]);
                if times > 0.0 {
                    pairs.push(DirectionPair::from_angles(view, 0.0, incidence, azimuth));
                    values.push([times * value; 3]);
                }
            }
        }
        ScanSource::of_pairs(&pairs, &values, true, &Strength::Chosen { least_noise: 0.05 }).unwrap()
    }

    #[test]
    fn exchanged_copies_are_left_out_with_their_originals() {
        let (plain, copied) = (scan(0.0), scan(1.0));
        assert_eq!([plain.fold_count(Parts::Incidences), copied.fold_count(Parts::Incidences)], [3, 3]);
        for number in 0..3 {
            let left_out = |scan: &ScanSource| scan.fold(Parts::Incidences, number).unwrap().left_out.len();
            assert_eq!(left_out(&copied), 2 * left_out(&plain), "{number}");
        }
        // Other values are measurements of their own.
        assert!(scan(1.01).fold_count(Parts::Incidences) > 3);
    }

    #[test]
    fn reciprocity_is_checked_by_exchanged_rows() {
        let exchanged = |value: fn(f64, f64) -> f64| {
            let angles = (1..=6).flat_map(|i| (0..=10).flat_map(move |o| (0..12).map(move |a| [i, o, a])));
            let angles: Vec<[f64; 3]> = angles
                .map(|[i, o, a]| [10 * i, 6 * o, 30 * a].map(|degrees: i32| f64::from(degrees).to_radians()))
                .collect();
            let pairs: Vec<DirectionPair> =
                angles.iter().map(|[i, o, a]| DirectionPair::from_angles(*i, 0.0, *o, *a)).collect();
            let values: Vec<[f64; 3]> = angles.iter().map(|[i, o, _]| [value(i.cos(), o.cos()); 3]).collect();
            ScanSource::of_pairs(&pairs, &values, true, &Strength::Neighbours(14)).unwrap().exchanged().unwrap()
        };
        assert_eq!(exchanged(|i, o| 0.1 + i * o), 0.0);
        // As of an anisotropic material, and of values times a cosine.
        assert!(exchanged(|i, _| 0.1 + 0.3 * i * i) > 0.1);
        assert!(exchanged(|i, o| (0.1 + i * o) * o) > 0.1);
        assert_eq!(scan(0.0).exchanged(), None);
    }
}
