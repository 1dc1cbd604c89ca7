//! Rounding of nodes to texels.

use brdfc_formats::table::{Axes, KNOTS, TableHeader, TableSymmetry};
use brdfc_table::lattice::{Equations, Lattice};
use brdfc_table::quantise::{STEPS, rounded};

/// A flat table between two steps: rounding each node alone is off everywhere, joint rounding is right in the mean.
#[test]
fn rounding_errors_cancel() {
    let mut knots: [f32; KNOTS] = std::array::from_fn(|k| k as f32 / 16.0);
    knots[KNOTS - 1] = 1.0;
    let header = TableHeader {
        channels: 3,
        symmetry: TableSymmetry { mirror: true, ..TableSymmetry::default() },
        axes: Axes { half: 8, difference: 8, azimuth: 8, layers: 1 },
        mean: 1.0,
        bias: 1e-4,
        low: [0.0; 3],
        span: [1.0; 3],
        slope: 0.0,
        knots,
    };
    let lattice = Lattice::new(&header);
    let mut equations = Equations::<1>::new(lattice);
    let taps: Vec<_> = brdfc_metrics::sampling::random_pairs(20_000, 4)
        .into_iter()
        .map(|pair| lattice.taps(&header.position(pair)))
        .collect();
    taps.iter().for_each(|taps| equations.add(taps, [0.0], 1.0));
    let exact = vec![400.3 / STEPS; lattice.len()];
    let off = |shares: &[f32]| {
        let nodes: Vec<[f32; 1]> = shares.iter().map(|share| [*share]).collect();
        let square = |taps| (STEPS * lattice.value(taps, &nodes)[0] - 400.3).powi(2);
        (taps.iter().map(square).sum::<f32>() / taps.len() as f32).sqrt()
    };
    let alone: Vec<f32> = exact.iter().map(|share| (share * STEPS).round() / STEPS).collect();
    let together = rounded(&equations, &exact);
    assert!((off(&alone) - 0.3).abs() < 1e-3, "{}", off(&alone));
    assert!(off(&together) < 0.7 * off(&alone), "{} after {}", off(&together), off(&alone));
    assert!(together.iter().all(|share| ((share * STEPS) - (share * STEPS).round()).abs() < 1e-3));
}
