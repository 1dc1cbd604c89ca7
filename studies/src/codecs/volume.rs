//! Sources from tables of numbers over half-difference angles, for codecs without a pack format.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::{Angles, Axes, KNOTS, TableHeader, TableSymmetry};
use brdfc_metrics::values::values_at;
use brdfc_table::lattice::Lattice;
use std::f32::consts::FRAC_PI_2;

/// Meaning of the numbers of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// `ln(f / μ + ε)`.
    Logarithm,
    /// `f`.
    Value,
}

/// Numbers at the nodes of a table, `[layer][slice][row][column]` without the repeated slice.
#[derive(Debug, Clone)]
pub(super) struct Volume {
    pub(super) header: TableHeader,
    pub(super) nodes: Vec<[f32; 3]>,
    pub(super) meaning: Meaning,
}

impl Volume {
    /// A table as dense as those of the MERL database: isotropic, 90 angles each, steps of one degree of `φ_d`, columns
    /// in steps of the square root of `θ_h`. Each node has the source's value.
    pub(super) fn dense(source: &dyn Source, symmetry: TableSymmetry, mean: f32, bias: f32) -> Self {
        let degrees = symmetry.difference_period().to_degrees().round() as u32;
        let axes = Axes { half: 90, difference: 90, azimuth: degrees, layers: 1 };
        let mut knots: [f32; KNOTS] = std::array::from_fn(|k| k as f32 / (KNOTS - 1) as f32);
        knots[KNOTS - 1] = 1.0;
        let header =
            TableHeader { channels: 3, symmetry, axes, mean, bias, low: [0.0; 3], span: [0.0; 3], slope: 0.0, knots };
        let values = at_nodes(source, &header);
        let nodes = values.into_iter().map(|f| f.map(|f| (f / mean + bias).ln())).collect();
        Self { header, nodes, meaning: Meaning::Logarithm }
    }
}

/// Values of a source at the nodes of an isotropic table, not negative.
fn at_nodes(source: &dyn Source, header: &TableHeader) -> Vec<[f32; 3]> {
    let Axes { half, difference, azimuth, .. } = header.axes;
    let period = header.symmetry.difference_period();
    let steps = if header.symmetry.mirror { azimuth - 1 } else { azimuth };
    let mut pairs = Vec::with_capacity((half * difference * azimuth) as usize);
    for slice in 0..azimuth {
        for row in 0..difference {
            for column in 0..half {
                let share = column as f32 / (half - 1) as f32;
                let angles = Angles {
                    // Slightly inside the ends, where a direction would be at the horizon.
                    theta_half: (share * share * FRAC_PI_2).min(0.9995 * FRAC_PI_2),
                    phi_half: 0.0,
                    ratio: (row as f32 / (difference - 1) as f32).min(0.9995),
                    phi_difference: period * slice as f32 / steps as f32,
                };
                pairs.push(angles.pair());
            }
        }
    }
    let (values, _) = values_at(source, &pairs);
    values.into_iter().map(|f| f.map(|f| f.max(0.0) as f32)).collect()
}

impl Source for Volume {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        let lattice = Lattice::new(&self.header);
        let value = lattice.value(&lattice.taps(&self.header.position(pair)), &self.nodes);
        value.map(|v| match self.meaning {
            Meaning::Logarithm => f64::from((self.header.mean * (v.exp() - self.header.bias)).clamp(0.0, f32::MAX)),
            Meaning::Value => f64::from(v),
        })
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry { isotropic: self.header.isotropic(), ..Symmetry::NONE }
    }

    fn is_grey(&self) -> bool {
        false
    }
}
