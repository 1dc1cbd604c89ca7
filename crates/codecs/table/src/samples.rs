//! Samples that a table is fitted to: values of the source at directions spread over all visible pairs.

use brdfc_core::pair_list::PairList;
use brdfc_core::{Source, Tally};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::{DirectionPair, Vector};
use brdfc_formats::table::Angles;
use brdfc_metrics::sampling::points;
use brdfc_metrics::values::{values_at, values_of_list};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::{Arc, OnceLock};

/// Minimum number of samples of a table.
pub const MIN_SAMPLES: usize = 1 << 15;
/// Start in the sequence of points; the pairs of error measurements come before it.
const FIRST: u32 = 1 << 20;
/// Number of samples in three that are distributed as on a ball under light from anywhere.
const ON_BALL: usize = 2;
/// Lowest `z` of a direction.
const LEAST_COSINE: f64 = 0.005;
/// At least one in this many pairs that are spread over the angles must be within a range of directions.
const MAX_REFUSED: usize = 32;
/// Pairs per unit of parallel work.
const BLOCK: usize = 4096;
/// Largest value of a sample, 1/sr: far above any reflectance, far below the maximum of f32.
const LARGEST: f64 = 1e30;

/// Values of a source at direction pairs.
#[derive(Debug, Clone)]
pub struct Samples {
    /// Half-difference angles of each pair.
    pub angles: Vec<Angles>,
    /// `cos θi` of each pair.
    pub cosines: Vec<f32>,
    /// `f_r` of each pair, not negative.
    pub values: Vec<[f32; 3]>,
    /// Repairs of the values.
    pub tally: Tally,
}

impl Samples {
    /// Evaluates `source` at `count` pairs. Two in three have the directions of points on a ball under distant light
    /// from anywhere, so that common directions count most. The third is spread over the angles of the table, denser
    /// towards the mirror direction. With `reciprocal` values are symmetrised.
    ///
    /// Negative values, NaN and values beyond 1e30 are clamped and counted.
    pub fn draw(source: &dyn Source, count: usize, reciprocal: bool) -> Self {
        Self::within(source, count, reciprocal, DirectionRange::ALL)
    }

    /// Same as [`Self::draw`], within a range of directions. If hardly any pair over the angles is within a narrow
    /// range, the rest of the third is distributed as on a ball.
    pub fn within(source: &dyn Source, count: usize, reciprocal: bool, directions: DirectionRange) -> Self {
        let pairs = Self::pairs(count, directions);
        let (values, mut tally) = values_of_list(source, &pairs);
        let mut values = repaired(values, &mut tally);
        if reciprocal {
            let exchanged: Vec<DirectionPair> = pairs.iter().map(|pair| pair.exchanged()).collect();
            let (others, more) = values_at(source, &exchanged);
            tally += more;
            for (value, other) in values.iter_mut().zip(repaired(others, &mut tally)) {
                *value = std::array::from_fn(|k| 0.5 * (value[k] + other[k]));
            }
        }
        let values = values.into_iter().map(|value| value.map(|v| v as f32)).collect();
        let blocks: Vec<&[Angles]> =
            (0..pairs.block_count()).into_par_iter().map(|k| pairs.block(k).of_tables()).collect();
        let angles = pairs.in_order(blocks.concat());
        let cosines = pairs.iter().map(|pair| pair.incoming[2] as f32).collect();
        Self { angles, cosines, values, tally }
    }

    fn pairs(count: usize, directions: DirectionRange) -> Arc<PairList> {
        // The pairs of most tables are cached for the next source.
        static FEWEST: OnceLock<Arc<PairList>> = OnceLock::new();
        if count == MIN_SAMPLES && directions.is_all() {
            PairList::cached(&FEWEST, || drawn(count, directions))
        } else {
            Arc::new(PairList::new(drawn(count, directions)))
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.angles.len()
    }

    /// Returns true if there are no samples.
    pub fn is_empty(&self) -> bool {
        self.angles.is_empty()
    }

    /// Returns true if a sample is distributed as on a ball: uniform over light directions.
    pub fn is_on_ball(index: usize) -> bool {
        index % 3 < ON_BALL
    }
}

fn drawn(count: usize, directions: DirectionRange) -> Vec<DirectionPair> {
    let on_balls = (0..count).filter(|k| Samples::is_on_ball(*k)).count();
    let mut angles = placed(count - on_balls, MAX_REFUSED, directions, over_angles);
    let ball = placed(count - angles.len(), usize::MAX, directions, |point| on_ball(point, directions));
    angles.extend(&ball[on_balls..]);
    let (mut ball, mut angles) = (ball.into_iter(), angles.into_iter());
    (0..count).filter_map(|k| if Samples::is_on_ball(k) { ball.next() } else { angles.next() }).collect()
}

/// The first pairs of the sequence of points that are within a range, and above the horizon by more than
/// [`LEAST_COSINE`]; fewer if the attempts per pair exceed the limit.
fn placed(
    count: usize,
    most_refused: usize,
    directions: DirectionRange,
    place: impl Fn([f64; 4]) -> DirectionPair + Sync,
) -> Vec<DirectionPair> {
    // For a range along the horizon, which a pack may have, half is enough.
    let [light, view] = [directions.light, directions.view].map(|range| LEAST_COSINE.min(range.sines()[1] / 2.0));
    let above = |pair: &DirectionPair| pair.incoming[2] > light && pair.outgoing[2] > view;
    let visible = |pair: &DirectionPair| above(pair) && (directions.is_all() || directions.contains(*pair));
    let mut pairs = Vec::with_capacity(count + BLOCK);
    let mut first = FIRST;
    let last = (count + BLOCK).saturating_mul(most_refused);
    while pairs.len() < count && ((first - FIRST) as usize) < last {
        let blocks = (count - pairs.len()).div_ceil(BLOCK) as u32;
        let block = |k: u32| points(first + k * BLOCK as u32).take(BLOCK).map(&place).filter(visible).collect();
        let more: Vec<Vec<DirectionPair>> = (0..blocks).into_par_iter().map(block).collect();
        pairs.extend(more.into_iter().flatten());
        first += blocks * BLOCK as u32;
    }
    pairs.truncate(count);
    pairs
}

/// Clamps values to 0 to [`LARGEST`], NaN to 0, and counts repairs.
pub(super) fn repaired(mut values: Vec<[f64; 3]>, tally: &mut Tally) -> Vec<[f64; 3]> {
    for value in &mut values {
        tally.negative_raised += u64::from(value.iter().any(|v| v.is_nan() || *v < 0.0));
        tally.largest_lowered += u64::from(value.iter().any(|v| *v > LARGEST));
        // NaN becomes 0, too.
        *value = value.map(|v| if v >= 0.0 { v.min(LARGEST) } else { 0.0 });
    }
    values
}

/// Maps a point to a pair: the outgoing direction as on the visible disc of a ball, the incoming one uniform over the
/// hemisphere, both within a range.
fn on_ball([a, b, c, d]: [f64; 4], directions: DirectionRange) -> DirectionPair {
    let ([light_low, light_high], [view_low, view_high]) = (directions.light.sines(), directions.view.sines());
    let turned = |radius: f64, z: f64, turn: f64| -> Vector {
        let phi = std::f64::consts::TAU * turn;
        [radius * phi.cos(), radius * phi.sin(), z]
    };
    let z = light_low + (light_high - light_low) * c;
    // Squares of the sine of the polar angle, in which areas are uniform.
    let a = 1.0 - view_high.powi(2) + (view_high.powi(2) - view_low.powi(2)) * a;
    DirectionPair::new(turned((1.0 - z * z).sqrt(), z, d), turned(a.sqrt(), (1.0 - a).sqrt(), b))
}

pub(super) fn over_angles([a, b, c, d]: [f64; 4]) -> DirectionPair {
    let [a, b, c, d] = [a, b, c, d].map(|x| x as f32);
    let angles =
        Angles { theta_half: a * a * 0.995 * FRAC_PI_2, phi_half: d * TAU, ratio: 0.999 * b, phi_difference: c * TAU };
    angles.pair()
}
