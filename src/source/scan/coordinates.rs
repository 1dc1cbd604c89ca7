//! Coordinates in which a scan is searched and fitted: half and difference angles, warped so that distance means
//! difference in appearance.
//!
//! The half vector's polar angle enters as `x = 0.63 ln(1 + θh / 0.12)`: steps near the mirror direction count for
//! more. The difference vector enters as `y = θd` and `z = r φd`, where `r = 0.30 θh / (θh + 0.01) · s / (s + 0.03)`,
//! `s = sin θd`, shrinks the azimuth to nothing where it means nothing (`θh = 0`, `θd = 0`). The constants were chosen on
//! held-out rows of real scans.

use brdfc_formats::direction::{DirectionPair, dot};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radius in which an azimuth that is undefined counts as 0.
const TINY: f64 = 1e-9;

/// A direction pair in half and difference angles.
#[derive(Debug, Clone, Copy)]
struct Angles {
    /// Warped polar angle of the half vector.
    x: f64,
    /// Azimuth of the half vector: cosine and sine.
    azimuth: [f64; 2],
    theta_d: f64,
    /// What the difference azimuth is multiplied by.
    r: f64,
    /// Components of the difference vector across the half vector: towards the normal's side, and sideways.
    u: f64,
    v: f64,
}

impl Angles {
    fn of(pair: DirectionPair) -> Self {
        let (i, o) = (pair.incoming, pair.outgoing);
        let h = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
        let d = [(i[0] - o[0]) / 2.0, (i[1] - o[1]) / 2.0, (i[2] - o[2]) / 2.0];
        let across = h[0].hypot(h[1]);
        let length = across.hypot(h[2]);
        let azimuth = if across > 1e-12 { [h[0] / across, h[1] / across] } else { [1.0, 0.0] };
        let (sin_h, cos_h) = if length > 0.0 { (across / length, h[2] / length) } else { (0.0, 1.0) };
        let theta_h = across.atan2(h[2]);
        let s = dot(d, d).sqrt();
        Self {
            x: 0.63 * (theta_h / 0.12).ln_1p(),
            azimuth,
            theta_d: s.atan2(length / 2.0),
            r: 0.30 * theta_h / (theta_h + 0.01) * s / (s + 0.03),
            u: (d[0] * azimuth[0] + d[1] * azimuth[1]) * cos_h - d[2] * sin_h,
            v: azimuth[0] * d[1] - azimuth[1] * d[0],
        }
    }

    fn phi_d(u: f64, v: f64) -> f64 {
        if u.hypot(v) < TINY { 0.0 } else { v.atan2(u) }
    }
}

/// A point, and what its last coordinate is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position<const D: usize> {
    /// Coordinates.
    pub point: [f64; D],
    phi_d: f64,
    r: f64,
}

impl<const D: usize> Position<D> {
    fn at(&self, phi_d: f64) -> [f64; D] {
        let mut point = self.point;
        point[D - 1] = self.r * phi_d;
        point
    }
}

/// Coordinates `(x, y, z)` of an isotropic, mirror-symmetric and reciprocal material. Rotation is left out by the
/// angles, reciprocity (`φd + π`) and mirror (`-φd`) by folding `φd` into `[0, π/2]`.
pub fn isotropic(pair: DirectionPair) -> Position<3> {
    let a = Angles::of(pair);
    let phi_d = Angles::phi_d(a.u.abs(), a.v.abs());
    Position { point: [a.x, a.theta_d, a.r * phi_d], phi_d, r: a.r }
}

/// Images of a folded point just outside the fold, so that neighbours are found across its ends.
pub fn isotropic_images(position: &Position<3>) -> impl Iterator<Item = [f64; 3]> {
    let below = (position.phi_d > 1e-4).then(|| position.at(-position.phi_d));
    let above = (position.phi_d < FRAC_PI_2 - 1e-4).then(|| position.at(PI - position.phi_d));
    below.into_iter().chain(above)
}

/// Coordinates `(x cos φh, x sin φh, y, z)` of a reciprocal material without other symmetry, `φd` folded into `[0, π)`.
pub fn anisotropic(pair: DirectionPair) -> Position<4> {
    let a = Angles::of(pair);
    let phi_d = Angles::phi_d(a.u, a.v).rem_euclid(PI);
    Position { point: [a.x * a.azimuth[0], a.x * a.azimuth[1], a.theta_d, a.r * phi_d], phi_d, r: a.r }
}

/// The image of a folded point on the other side of the nearer end of the fold.
pub fn anisotropic_images(position: &Position<4>) -> impl Iterator<Item = [f64; 4]> {
    let turn = if position.phi_d < FRAC_PI_2 { PI } else { -PI };
    std::iter::once(position.at(position.phi_d + turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near<const D: usize>(a: [f64; D], b: [f64; D]) -> bool {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-9)
    }

    proptest! {
        #[test]
        fn folding_is_exact(ti in 0.01f64..1.5, to in 0.01f64..1.5, p in 0.01f64..3.1, turn in 0.0f64..6.0) {
            let pair = DirectionPair::from_angles(ti, 0.0, to, p);
            let here = isotropic(pair).point;
            prop_assert!(near(here, isotropic(pair.exchanged()).point));
            prop_assert!(near(here, isotropic(DirectionPair::from_angles(ti, turn, to, turn + p)).point));
            prop_assert!(near(here, isotropic(DirectionPair::from_angles(ti, 0.0, to, -p)).point));
            let turned = DirectionPair::from_angles(ti, turn, to, turn + p);
            let (a, b) = (anisotropic(turned), anisotropic(turned.exchanged()));
            let meets = near(a.point, b.point) || anisotropic_images(&b).any(|image| near(a.point, image));
            prop_assert!(meets);
        }
    }
}
