//! Errors of a pack by the angle of incoming light, and its worst direction pairs.

use super::sampling::PairSet;
use super::values::values_of_list;
use brdfc_core::Source;
use brdfc_formats::direction::{DirectionPair, dot};
use serde::{Deserialize, Serialize};

/// Width of a bin, degrees.
const BIN: f64 = 10.0;
const BINS: usize = 9;
/// Values below this share of the mean are excluded from ratios, as in `ε_r`.
const FLOOR: f64 = 1e-3;

/// Error of the pairs whose incoming direction has a polar angle within a bin of ten degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AngleError {
    /// Smallest polar angle of incoming light, degrees; the largest is ten more.
    pub from: f64,
    /// Number of samples above the floor.
    pub samples: u64,
    /// Mean of `|f' - f| / f` over them; 0 without any.
    pub relative_mean: f64,
}

/// A pair at which reference and approximation differ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct WorstPair {
    /// Direction to the light.
    pub incoming: [f64; 3],
    /// Direction to the viewer.
    pub outgoing: [f64; 3],
    /// `f_r` of the reference, 1/sr.
    pub reference: [f64; 3],
    /// `f_r` of the approximation, 1/sr.
    pub approximation: [f64; 3],
    /// Largest difference of `ln(1 + f cos θi)` over the channels.
    pub difference: f64,
}

/// Errors by incoming angle, and the pairs with the largest errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ByAngle {
    /// Bins from the normal to the horizon.
    pub angles: Vec<AngleError>,
    /// Worst pairs, the largest difference first, one per group of close pairs.
    pub worst: Vec<WorstPair>,
}

/// Cosine of the angle below which directions are close.
const CLOSE: f64 = 0.985;
const WORST: usize = 5;

/// Compares two sources at the pairs of a set. Negative values of the reference count as 0.
pub fn by_angle(reference: &dyn Source, approximation: &dyn Source, set: &PairSet) -> ByAngle {
    let (expected, _) = values_of_list(reference, &set.pairs);
    let (found, _) = values_of_list(approximation, &set.pairs);
    let all = || expected.iter().flatten().map(|f| f.max(0.0));
    let mean = all().sum::<f64>() / all().count().max(1) as f64;
    let mut sums = [(0u64, 0.0); BINS];
    let mut differences = Vec::with_capacity(set.pairs.len());
    for ((pair, f), g) in set.pairs.iter().zip(&expected).zip(&found) {
        let f = f.map(|value| value.max(0.0));
        let theta = pair.incoming[2].clamp(-1.0, 1.0).acos().to_degrees();
        let (count, sum) = &mut sums[((theta / BIN) as usize).min(BINS - 1)];
        for channel in 0..3 {
            if f[channel] > FLOOR * mean {
                *count += 1;
                *sum += (g[channel] - f[channel]).abs() / f[channel];
            }
        }
        differences.push(difference(pair, f, *g));
    }
    let mut worst: Vec<WorstPair> = Vec::new();
    while let Some(pair) = largest(&differences, |pair| !worst.iter().any(|other| is_close(other, &set.pairs[pair]))) {
        let DirectionPair { incoming, outgoing } = set.pairs[pair];
        let reference = expected[pair].map(|value| value.max(0.0));
        let difference = differences[pair];
        worst.push(WorstPair { incoming, outgoing, reference, approximation: found[pair], difference });
        if worst.len() == WORST {
            break;
        }
    }
    let angle = |(bin, (samples, sum)): (usize, &(u64, f64))| AngleError {
        from: BIN * bin as f64,
        samples: *samples,
        relative_mean: sum / (*samples).max(1) as f64,
    };
    ByAngle { angles: sums.iter().enumerate().map(angle).collect(), worst }
}

/// Largest difference of `ln(1 + f cos θi)` over the channels.
fn difference(pair: &DirectionPair, reference: [f64; 3], approximation: [f64; 3]) -> f64 {
    let seen = |f: f64| (f.max(0.0) * pair.incoming[2].max(0.0)).ln_1p();
    let differences = [0, 1, 2].map(|channel| (seen(approximation[channel]) - seen(reference[channel])).abs());
    differences.into_iter().fold(0.0, f64::max)
}

/// The first one of the largest differences above 0 among the pairs of which `may` holds.
fn largest(differences: &[f64], may: impl Fn(usize) -> bool) -> Option<usize> {
    let mut largest = (None, 0.0);
    for (pair, difference) in differences.iter().enumerate() {
        // The costly question last.
        if *difference > largest.1 && may(pair) {
            largest = (Some(pair), *difference);
        }
    }
    largest.0
}

fn is_close(a: &WorstPair, b: &DirectionPair) -> bool {
    dot(a.incoming, b.incoming) > CLOSE && dot(a.outgoing, b.outgoing) > CLOSE
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::{Symmetry, Tally};

    /// Correct, except that light from below 60 degrees is twice as bright, and one place is far too bright.
    struct Wrong;

    impl Source for Wrong {
        fn eval(&self, pair: DirectionPair, _: &mut Tally) -> [f64; 3] {
            if pair.incoming[2] > 0.999 && pair.outgoing[2] > 0.9 {
                return [40.0; 3];
            }
            if pair.incoming[2] < 0.5 { [0.6; 3] } else { [0.3; 3] }
        }

        fn symmetry(&self) -> Symmetry {
            Symmetry::NONE
        }
    }

    struct Right;

    impl Source for Right {
        fn eval(&self, _: DirectionPair, _: &mut Tally) -> [f64; 3] {
            [0.3; 3]
        }

        fn symmetry(&self) -> Symmetry {
            Symmetry::NONE
        }
    }

    #[test]
    fn errors_are_found_where_they_are() {
        let found = by_angle(&Right, &Wrong, &PairSet::comparison());
        assert_eq!(found.angles.len(), BINS);
        for angle in &found.angles[1..] {
            let expected = if angle.from >= 60.0 { 1.0 } else { 0.0 };
            assert!(angle.samples > 0 && (angle.relative_mean - expected).abs() < 1e-9, "{angle:?}");
        }
        let first = &found.worst[0];
        assert!(first.incoming[2] > 0.999 && first.approximation[0] == 40.0, "{first:?}");
        assert!(found.worst.windows(2).all(|two| two[0].difference >= two[1].difference));
        assert_eq!(found.worst.len(), WORST);
        for (number, WorstPair { incoming, outgoing, .. }) in found.worst.iter().enumerate() {
            let pair = DirectionPair { incoming: *incoming, outgoing: *outgoing };
            assert!(!found.worst[..number].iter().any(|other| is_close(other, &pair)), "{pair:?}");
        }
    }

    #[test]
    fn no_error_has_no_worst_pair() {
        let found = by_angle(&Right, &Right, &PairSet::comparison());
        assert!(found.worst.is_empty() && found.angles.iter().all(|angle| angle.relative_mean == 0.0));
    }
}
