//! Direction maps and their inverses.

use super::fed::{directions, pairs};
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_formats::direction::{DirectionPair, Parameterisation, Vector, dot, from_tangent_pole};

fn apart(a: Vector, b: Vector) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

fn pairs_apart(a: DirectionPair, b: DirectionPair) -> f64 {
    apart(a.incoming, b.incoming).max(apart(a.outgoing, b.outgoing))
}

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let mut pole = Worst::default();
    for direction in directions(small) {
        pole.add(apart(from_tangent_pole((stages.to_tangent_pole)(direction)), direction));
    }
    let (mut half, mut angles) = (Worst::default(), Worst::default());
    for pair in pairs(small) {
        let sum: Vector = std::array::from_fn(|k| pair.incoming[k] + pair.outgoing[k]);
        let (outer, inner) = (stages.to_half_difference)(pair);
        let back = Parameterisation::HalfDifference.from_axes(outer, inner);
        half.add(pairs_apart(back, pair) * dot(sum, sum).sqrt());
        angles.add(pairs_apart((stages.angles)(pair).pair(), pair) * sum[2]);
    }
    let mut atan2 = Worst::default();
    let sizes = [0.0, 1e-45, 1e-38, 1e-12, 1e-6, 0.3, 0.999_999, 1.0, 1.000_001, 3.0, 1e6, 1e38];
    let steps = if small { 64 } else { 4096 };
    let turned = (0..=steps).map(|k| {
        let angle = std::f64::consts::PI * f64::from(k) / f64::from(steps);
        [angle.sin().max(0.0) as f32, angle.cos() as f32]
    });
    let ends = sizes.into_iter().flat_map(|y| sizes.into_iter().flat_map(move |x| [[y, x], [y, -x]]));
    for [y, x] in ends.chain(turned).filter(|[y, x]| *y > 0.0 || *x != 0.0) {
        atan2.add(f64::from((stages.atan2)(y, x)) - f64::from(y).atan2(f64::from(x)));
    }
    vec![
        pole.row(
            ["tangent-pole grid, f64", "poles, the normal, rings 1e-12 above the horizon"],
            Measure::Absolute,
            8.0 * f64::EPSILON,
            "two angles up to π, each rounded a few times",
        ),
        half.row(
            ["half and difference vectors, f64", "all pairs of these, nearly equal and nearly opposite ones"],
            Measure::Absolute,
            32.0 * f64::EPSILON,
            "roundings divided by the length of wi + wo: nearly opposite directions have no half vector",
        ),
        atan2.row(
            ["angles of decoders, f32", "0 to 1e38 on both axes, denormals"],
            Measure::Absolute,
            3e-7,
            "the documented bound: the polynomial, and the rounding of π",
        ),
        angles.row(
            ["angles of tables, f32", "the same pairs"],
            Measure::Relative,
            64.0 * U,
            "roundings divided by the height of wi + wo: the angles are undefined for a horizontal half vector",
        ),
    ]
}
