//! Cross-validation of scans: scans without some of their rows, and the distance of a direction pair from the rows.

use super::{Points, ScanSource, Tree};
use crate::scan::coordinates::{Anisotropic, Isotropic, Space};
use brdfc_core::source::{Completion, Fold, MAX_PARTS, Parts, Repeats};
use brdfc_formats::direction::{DirectionPair, dot};
use kiddo::SquaredEuclidean;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::num::NonZero;

/// Incidences that round to the same multiple of this angle are equal, degrees.
const INCIDENCE: f64 = 1.0;
/// Number of candidates for the nearest row by angles: the nearest ones in the search space.
const NEAREST: NonZero<usize> = NonZero::new(8).expect("positive");

impl ScanSource {
    /// Index of the incidence of each row, and the number of incidences.
    fn incidences(&self) -> (Vec<usize>, usize) {
        let degrees = |radians: f64| (radians.to_degrees() / INCIDENCE).round() as i32;
        let key = |pair: &DirectionPair| {
            let [x, y, z] = pair.incoming;
            let polar = degrees(x.hypot(y).atan2(z));
            let azimuth = if self.summary.isotropic || polar == 0 { 0 } else { degrees(y.atan2(x)) };
            (polar, azimuth)
        };
        let mut numbers: BTreeMap<(i32, i32), usize> = self.pairs.iter().map(|pair| (key(pair), 0)).collect();
        numbers.values_mut().enumerate().for_each(|(number, of)| *of = number);
        (self.pairs.iter().map(|pair| numbers[&key(pair)]).collect(), numbers.len())
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
