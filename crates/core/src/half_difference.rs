//! Half-difference angles in the layout of MERL tables.

use brdfc_formats::direction::{DirectionPair, dot, half_vector};
use std::f64::consts::FRAC_PI_2;

/// Position of a pair in a table of any size in the layout of MERL.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfDifference {
    /// Root of `theta_h` as a share of `π/2`.
    pub half_root: f64,
    /// `theta_d` as a share of `π/2`.
    pub difference_share: f64,
    /// `phi_d`, radians in `[-π, π]`.
    pub phi_difference: f64,
}

impl HalfDifference {
    /// Position of a pair.
    pub fn of(pair: DirectionPair) -> Self {
        let [theta_h, theta_d, phi_difference] = half_difference_angles(pair);
        Self { half_root: (theta_h / FRAC_PI_2).sqrt(), difference_share: theta_d / FRAC_PI_2, phi_difference }
    }
}

/// Angles `(theta_h, theta_d, phi_d)` of a pair, radians: polar angle of the half vector, and the difference vector in
/// the frame of the half vector (Rusinkiewicz 1998). `phi_d` is in `[-π, π]`.
pub fn half_difference_angles(pair: DirectionPair) -> [f64; 3] {
    let (i, o) = (pair.incoming, pair.outgoing);
    let h = half_vector(pair);
    let sum = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
    let difference = [i[0] - o[0], i[1] - o[1], i[2] - o[2]];
    let theta_h = (h[0] * h[0] + h[1] * h[1]).sqrt().atan2(h[2]);
    let theta_d = (dot(difference, difference) / dot(sum, sum)).sqrt().atan();
    let x = dot(i, h) * h[2] - i[2];
    let y = i[1] * h[0] - i[0] * h[1];
    [theta_h, theta_d, y.atan2(x)]
}
