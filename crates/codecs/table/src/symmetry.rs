//! Symmetries of a material, measured from its values: a file may declare others.

use super::samples::{over_angles, repaired};
use brdfc_core::pair_list::PairList;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, half_vector};
use brdfc_formats::table::TableSymmetry;
use brdfc_metrics::sampling::points;
use brdfc_metrics::values::values_of_list;
use std::sync::LazyLock;

/// Number of pairs that are compared with their images.
const PAIRS: usize = 1024;
/// Largest mean difference of a value and its image, relative to the mean value, that counts as symmetric. Folding a
/// measured plastic that was off by 1.8 % trebled the difference of its rendering.
const TOLERANCE: f64 = 0.003;

/// Mean difference between values and the values of their images, weighted by `cos θi`, over the mean value: 0 where
/// the symmetry holds, 0 for black materials.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct Asymmetry {
    /// Exchange of light and viewer.
    pub reciprocal: f64,
    /// Reflection at the plane of half vector and normal.
    pub mirror: f64,
    /// Rotation by 180 degrees about the normal.
    pub half_turn: f64,
    /// Reflection at the plane of tangent and normal.
    pub reflected: f64,
}

impl Asymmetry {
    /// Measures a source over all directions, and near the mirror direction, where a narrow lobe would be missed
    /// otherwise. The larger value counts.
    pub fn of(source: &dyn Source) -> Self {
        static PROBES: LazyLock<[Probes; 2]> = LazyLock::new(|| {
            let even = |[a, b, c, d]: [f64; 4]| DirectionPair::new(direction(a, b), direction(c, d));
            [Probes::new(even), Probes::new(over_angles)]
        });
        let [even, near] = PROBES.each_ref().map(|probes| Self::over(source, probes));
        Self {
            reciprocal: even.reciprocal.max(near.reciprocal),
            mirror: even.mirror.max(near.mirror),
            half_turn: even.half_turn.max(near.half_turn),
            reflected: even.reflected.max(near.reflected),
        }
    }

    fn over(source: &dyn Source, probes: &Probes) -> Self {
        let values = |pairs: &PairList| repaired(values_of_list(source, pairs).0, &mut Tally::default());
        let expected = values(&probes.pairs);
        let against = |images: &PairList| {
            let (mut difference, mut sum) = (0.0, 0.0);
            for ((pair, value), other) in probes.pairs.iter().zip(&expected).zip(values(images)) {
                for channel in 0..3 {
                    difference += (value[channel] - other[channel]).abs() * pair.incoming[2];
                    sum += 0.5 * (value[channel] + other[channel]) * pair.incoming[2];
                }
            }
            if sum > 0.0 { difference / sum } else { 0.0 }
        };
        Self {
            reciprocal: against(&probes.exchanged),
            mirror: against(&probes.mirrored),
            half_turn: against(&probes.turned),
            reflected: against(&probes.reflected),
        }
    }

    /// Symmetries that may be folded. Azimuths of the half vector do not matter for isotropic materials.
    pub fn folds(&self, isotropic: bool) -> TableSymmetry {
        TableSymmetry {
            reciprocal: self.reciprocal <= TOLERANCE,
            mirror: self.mirror <= TOLERANCE,
            half_turn: !isotropic && self.half_turn <= TOLERANCE,
            reflected: !isotropic && self.reflected <= TOLERANCE,
        }
    }
}

/// Pairs that are compared with their images.
struct Probes {
    pairs: PairList,
    exchanged: PairList,
    mirrored: PairList,
    turned: PairList,
    reflected: PairList,
}

impl Probes {
    fn new(pair: impl Fn([f64; 4]) -> DirectionPair) -> Self {
        let pairs: Vec<DirectionPair> = points(1 << 19)
            .map(pair)
            .filter(|pair| pair.incoming[2] > 0.1 && pair.outgoing[2] > 0.1)
            .take(PAIRS)
            .collect();
        let images = |image: &dyn Fn(DirectionPair) -> DirectionPair| {
            PairList::new(pairs.iter().map(|pair| image(*pair)).collect())
        };
        let both =
            |pair: DirectionPair, f: &dyn Fn(Vector) -> Vector| DirectionPair::new(f(pair.incoming), f(pair.outgoing));
        Self {
            exchanged: images(&DirectionPair::exchanged),
            mirrored: images(&mirrored),
            turned: images(&|pair| both(pair, &|[x, y, z]| [-x, -y, z])),
            reflected: images(&|pair| both(pair, &|[x, y, z]| [x, -y, z])),
            pairs: PairList::new(pairs),
        }
    }
}

fn direction(z: f64, turn: f64) -> Vector {
    let (radius, phi) = ((1.0 - z * z).max(0.0).sqrt(), std::f64::consts::TAU * turn);
    [radius * phi.cos(), radius * phi.sin(), z]
}

/// Reflects a pair at the plane of half vector and normal.
fn mirrored(pair: DirectionPair) -> DirectionPair {
    let half = half_vector(pair);
    let length = half[0].hypot(half[1]);
    if length == 0.0 {
        return pair;
    }
    let (tx, ty) = (-half[1] / length, half[0] / length);
    let reflect = |v: Vector| {
        let twice = 2.0 * (v[0] * tx + v[1] * ty);
        [v[0] - twice * tx, v[1] - twice * ty, v[2]]
    };
    DirectionPair::new(reflect(pair.incoming), reflect(pair.outgoing))
}
