//! Position of a direction pair in a table: half-difference angles, folded by the symmetry of the material.

use crate::direction::{DirectionPair, Vector, add_scaled, dot, polynomial_atan2};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Symmetries that map direction pairs to the same value. With one layer the table is also invariant under rotation
/// about the normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct TableSymmetry {
    /// Light and viewer can be exchanged: `φ_d` and `φ_d + π` are equivalent.
    pub reciprocal: bool,
    /// `φ_d` and `-φ_d` are equivalent. For isotropic materials: reflection in the plane of incidence.
    pub mirror: bool,
    /// `φ_h` and `φ_h + π` are equivalent.
    pub half_turn: bool,
    /// `(φ_h, φ_d)` and `(-φ_h, -φ_d)` are equivalent: tangent and bitangent are axes of symmetry, or only the tangent.
    pub reflected: bool,
}

impl TableSymmetry {
    /// Bits in a pack, one per field, in field order from the lowest.
    pub fn bits(self) -> u32 {
        let flags = [self.reciprocal, self.mirror, self.half_turn, self.reflected];
        flags.into_iter().rev().fold(0, |bits, flag| bits << 1 | u32::from(flag))
    }

    /// Symmetry with these [`Self::bits`]; `None` for bits that have no meaning.
    pub fn from_bits(bits: u32) -> Option<Self> {
        let flag = |k: u32| bits >> k & 1 == 1;
        (bits < 16).then(|| Self { reciprocal: flag(0), mirror: flag(1), half_turn: flag(2), reflected: flag(3) })
    }

    /// Largest `φ_d` of a table, where it is mirrored or repeats.
    pub fn difference_period(self) -> f32 {
        (if self.mirror { PI } else { TAU }) / (if self.reciprocal { 2.0 } else { 1.0 })
    }

    /// Largest `φ_h` of a table, where it is mirrored or repeats.
    pub fn half_period(self) -> f32 {
        (if self.reflected { PI } else { TAU }) / (if self.half_turn { 2.0 } else { 1.0 })
    }
}

/// Half-difference angles (Rusinkiewicz 1998), with `θ_d` as a fraction of its maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// `θ_h`, angle of the half vector to the normal, `0..=π/2`.
    pub theta_half: f32,
    /// `φ_h`, azimuth of the half vector from the tangent, `-π..=π`.
    pub phi_half: f32,
    /// `θ_d / θ_d,max`, `0..=1`. `θ_d` is the angle between half vector and light; `θ_d,max = atan2(cos θ_h, sin θ_h
    /// |cos φ_d|)` is the largest for which both directions are above the horizon.
    pub ratio: f32,
    /// `φ_d`, azimuth of the light about the half vector, measured from the great circle away from the normal,
    /// `-π..=π`. If the half vector is the normal, it is the azimuth of the light.
    pub phi_difference: f32,
}

impl Angles {
    /// Angles of a pair above the horizon. The f32 operations have a fixed order, which shaders follow.
    pub fn of(pair: DirectionPair) -> Self {
        let (angles, [x, y]) = Self::but_phi_half(pair);
        Self { phi_half: azimuth(y, x), ..angles }
    }

    /// Angles with `φ_h = 0`, and the tangent and bitangent components of the half vector, from which `φ_h` follows.
    pub(super) fn but_phi_half(pair: DirectionPair) -> (Self, [f32; 2]) {
        let (i, o) = (pair.incoming.map(|c| c as f32), pair.outgoing.map(|c| c as f32));
        let sum = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
        let apart = [i[0] - o[0], i[1] - o[1], i[2] - o[2]];
        let sum_length = length(sum);
        let h = [sum[0] / sum_length, sum[1] / sum_length, sum[2] / sum_length];
        let square = h[0] * h[0] + h[1] * h[1];
        let sine = square.sqrt();
        let theta_half = polynomial_atan2(sine, h[2]);
        let theta_difference = polynomial_atan2(length(apart), sum_length);
        // Both times sin θ_h: away from the normal, and to its left. x is (i · h) h.z - i.z without the difference of
        // nearly equal numbers.
        let x = h[2] * (i[0] * h[0] + i[1] * h[1]) - i[2] * square;
        let y = i[1] * h[0] - i[0] * h[1];
        let (x, y) = if sine > 0.0 { (x, y) } else { (i[0], i[1]) };
        let across = (x * x + y * y).sqrt();
        let cosine = if across > 0.0 { x.abs() / across } else { 1.0 };
        let largest = polynomial_atan2(h[2], sine * cosine);
        let ratio = if theta_difference < largest { theta_difference / largest } else { 1.0 };
        (Self { theta_half, phi_half: 0.0, ratio, phi_difference: azimuth(y, x) }, [h[0], h[1]])
    }

    /// Pair with these angles, the inverse of [`Self::of`].
    pub fn pair(self) -> DirectionPair {
        let [theta_half, phi_half, ratio, phi_difference] =
            [self.theta_half, self.phi_half, self.ratio, self.phi_difference].map(f64::from);
        let (sine, cosine) = theta_half.sin_cos();
        let largest = cosine.atan2(sine * phi_difference.cos().abs());
        let theta_difference = ratio * largest;
        let half = [sine * phi_half.cos(), sine * phi_half.sin(), cosine];
        let away = [cosine * phi_half.cos(), cosine * phi_half.sin(), -sine];
        let left = [-phi_half.sin(), phi_half.cos(), 0.0];
        let across: Vector = add_scaled(away.map(|c| c * phi_difference.cos()), phi_difference.sin(), left);
        let incoming = add_scaled(half.map(|c| c * theta_difference.cos()), theta_difference.sin(), across);
        let outgoing = add_scaled(incoming.map(|c| -c), 2.0 * dot(incoming, half), half);
        DirectionPair::new(incoming, outgoing)
    }

    /// `φ_h` and `φ_d` as fractions of their periods after folding by the symmetry, each `0..=1`.
    pub fn folded(self, symmetry: TableSymmetry) -> [f32; 2] {
        let (mut half, mut difference) = (self.phi_half, self.phi_difference);
        if symmetry.reflected {
            if symmetry.half_turn {
                if half < 0.0 {
                    half += PI;
                }
                if half > FRAC_PI_2 {
                    half = PI - half;
                    difference = -difference;
                }
            } else if half < 0.0 {
                half = -half;
                difference = -difference;
            }
        }
        if symmetry.mirror {
            difference = difference.abs();
            if symmetry.reciprocal && difference > FRAC_PI_2 {
                difference = PI - difference;
            }
        }
        let half = half / symmetry.half_period();
        let difference = difference / symmetry.difference_period();
        [
            if symmetry.reflected { half.min(1.0) } else { half - half.floor() },
            if symmetry.mirror { difference.min(1.0) } else { difference - difference.floor() },
        ]
    }
}

/// Angles after folding, shared by all tables with the same symmetry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Folded {
    /// Square root of `θ_h` as a fraction of `π/2`, `0..=1`.
    pub root: f32,
    /// `θ_d / θ_d,max`, `0..=1`, as [`Angles::ratio`].
    pub ratio: f32,
    /// `φ_h` as a fraction of its period, `0..=1`.
    pub half_share: f32,
    /// `φ_d` as a fraction of its period, `0..=1`.
    pub difference_share: f32,
}

impl Folded {
    /// Folds angles by a symmetry.
    pub fn new(angles: Angles, symmetry: TableSymmetry) -> Self {
        let [half_share, difference_share] = angles.folded(symmetry);
        let root = (angles.theta_half / FRAC_PI_2).min(1.0).sqrt();
        Self { root, ratio: angles.ratio, half_share, difference_share }
    }
}

/// Position of a value in the texture, in nodes from the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Position along `θ_h`, in nodes from the first.
    pub column: f32,
    /// Position along `θ_d`, in nodes from the first.
    pub row: f32,
    /// Along `φ_d`, within a layer.
    pub slice: f32,
    /// Layers on both sides of `φ_h`.
    pub layers: [u32; 2],
    /// Weight of the second layer.
    pub layer_weight: f32,
}

fn length(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// `atan2(y, x)`, `-π..=π`.
fn azimuth(y: f32, x: f32) -> f32 {
    let angle = polynomial_atan2(y.abs(), x);
    if y < 0.0 { -angle } else { angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::from_polar;
    use proptest::prelude::*;

    fn symmetry(bits: u32) -> TableSymmetry {
        TableSymmetry::from_bits(bits).expect("four bits")
    }

    #[test]
    fn flags_are_bits() {
        for bits in 0..16 {
            assert_eq!(symmetry(bits).bits(), bits);
        }
        assert_eq!(symmetry(1), TableSymmetry { reciprocal: true, ..TableSymmetry::default() });
        assert_eq!(TableSymmetry::from_bits(16), None);
    }

    #[test]
    fn known_pairs() {
        let sixth = std::f64::consts::FRAC_PI_6;
        // The mirror direction: the half vector is the normal.
        let mirrored = Angles::of(DirectionPair::from_angles(sixth, 0.5, sixth, 0.5 + std::f64::consts::PI));
        assert!(mirrored.theta_half < 1e-4 && (mirrored.ratio - 1.0 / 3.0).abs() < 1e-4, "{mirrored:?}");
        // Light and viewer together: no difference.
        let together = Angles::of(DirectionPair::from_angles(sixth, 0.5, sixth, 0.5));
        assert!((together.theta_half - sixth as f32).abs() < 1e-6 && together.ratio < 1e-6, "{together:?}");
        assert!((together.phi_half - 0.5).abs() < 1e-6);
        // In the plane of incidence, the light lower than the viewer: away from the normal.
        let steeper = Angles::of(DirectionPair::from_angles(2.0 * sixth, 0.0, 0.0, 0.0));
        assert!(steeper.phi_difference.abs() < 1e-3, "{steeper:?}");
        assert!((steeper.theta_half - sixth as f32).abs() < 1e-6);
        // 30 of the 60 degrees that are between the half vector and the horizon.
        assert!((steeper.ratio - 0.5).abs() < 1e-5);
        let exchanged = Angles::of(DirectionPair::from_angles(0.0, 0.0, 2.0 * sixth, 0.0));
        assert!((exchanged.phi_difference.abs() - PI).abs() < 1e-3, "{exchanged:?}");
    }

    #[test]
    fn a_direction_at_the_horizon_has_the_largest_difference() {
        for phi in [0.3, 1.0, 2.0, 3.0] {
            let angles =
                Angles::of(DirectionPair::new(from_polar(0.999_999 * f64::from(FRAC_PI_2), phi), from_polar(0.4, 0.0)));
            assert!((angles.ratio - 1.0).abs() < 1e-5, "{angles:?}");
        }
    }

    proptest! {
        #[test]
        fn pairs_round_trip(theta in 1e-3f32..1.5, phi in -3.1f32..3.1, ratio in 0.02f32..0.99, turn in -3.1f32..3.1) {
            let angles = Angles { theta_half: theta, phi_half: phi, ratio, phi_difference: turn };
            let pair = angles.pair();
            prop_assert!(pair.is_above_horizon());
            let found = Angles::of(pair);
            prop_assert!((found.theta_half - theta).abs() < 1e-5, "{found:?}");
            prop_assert!((found.phi_half - phi).abs() < 1e-4 / theta.min(1.0), "{found:?}");
            prop_assert!((found.ratio - ratio).abs() < 1e-4, "{found:?}");
            prop_assert!((found.phi_difference - turn).abs() < 1e-5 / (ratio * theta.min(1.0)), "{found:?}");
        }

        /// Each symmetry maps a pair and its image to the same position, and no other pair.
        #[test]
        fn symmetric_pairs_fold_together(
            theta in 0.1f64..1.4, phi in -3.0f64..3.0, other in 0.1f64..1.4, turn in -3.0f64..3.0,
        ) {
            let pair = DirectionPair::from_angles(theta, phi, other, turn);
            let at = |pair, bits| Angles::of(pair).folded(symmetry(bits));
            let near = |a: [f32; 2], b: [f32; 2]| {
                // Periods wrap around.
                let apart = |a: f32, b: f32| ((a - b).abs()).min(1.0 - (a - b).abs());
                apart(a[0], b[0]) < 1e-3 && apart(a[1], b[1]) < 1e-3
            };
            let reflected = |v: Vector| [v[0], -v[1], v[2]];
            let turned = |v: Vector| [-v[0], -v[1], v[2]];
            let both = |f: &dyn Fn(Vector) -> Vector| DirectionPair::new(f(pair.incoming), f(pair.outgoing));
            for (bits, image) in [(1, pair.exchanged()), (4, both(&turned)), (8, both(&reflected))] {
                for others in 0..16 {
                    let folded = near(at(pair, others), at(image, others));
                    prop_assert!(folded || others & bits == 0, "{others:b} {bits}");
                }
            }
            // The mirror of isotropic materials leaves `φ_h` open.
            let mirrored = Angles::of(both(&reflected));
            let of = Angles::of(pair);
            prop_assert!((mirrored.folded(symmetry(2))[1] - of.folded(symmetry(2))[1]).abs() < 1e-3);
            prop_assert!((mirrored.ratio - of.ratio).abs() < 1e-4);
        }
    }
}
