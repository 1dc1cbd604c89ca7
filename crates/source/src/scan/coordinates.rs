//! Coordinates for searching and fitting a scan: half and difference angles, warped so that distance means difference
//! in appearance.
//!
//! The half vector's polar angle enters as `x = 0.63 ln(1 + θh / 0.12)`: steps near the mirror direction have more
//! weight. The difference vector enters as `y = θd` and `z = r φd`, where `r = 0.20 s / (s + 0.03)`, `s = sin θd`, shrinks
//! the azimuth to zero where it is undefined (`θd = 0`).
//!
//! `φh` and `φd` have a pole at the mirror direction (`θh = 0`). The values of an isotropic material do not depend on `φd`
//! there, so that `r` also has the factor `θh / (θh + 0.01)`. An anisotropic material keeps the azimuth `ψ = φh + φd` instead
//! of `φd`: that of the difference vector after the shortest rotation from the half vector to the normal. It is continuous
//! at the pole, where it is the azimuth of the light.
//!
//! Every row also represents its reciprocal, [`RECIPROCAL_DISTANCE`] away along one more axis. Real scans are not
//! reciprocal to within their noise (values at 80 degrees of incidence and their reciprocals differ by up to a factor
//! of 4 in the scans of the Cornell laboratory), so exchanged rows fill gaps, and direct ones outweigh them where both
//! are near.
//!
//! The constants were tuned on held-out rows, rings and incidences of real scans; none of them is critical.

use brdfc_formats::direction::{DirectionPair, Vector, dot};
use std::f64::consts::{PI, TAU};

/// Distance between a measured row and its reciprocal.
pub const RECIPROCAL_DISTANCE: f64 = 0.2;
/// Radius within which an undefined azimuth counts as 0.
const TINY: f64 = 1e-9;
/// Width of the continuation of the azimuths' fold with images beyond each end, radians.
const BEYOND: f64 = 0.8;

/// A direction pair in half and difference angles.
#[derive(Debug, Clone, Copy)]
struct Angles {
    /// Warped polar angle of the half vector.
    x: f64,
    /// Azimuth of the half vector: cosine and sine.
    azimuth: [f64; 2],
    theta_d: f64,
    /// Scale of the difference azimuth.
    r: f64,
    /// The same for isotropic materials, 0 at the mirror direction.
    r_isotropic: f64,
    /// Difference azimuth, `(-π, π]`.
    phi_d: f64,
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
        let u = (d[0] * azimuth[0] + d[1] * azimuth[1]) * cos_h - d[2] * sin_h;
        let v = azimuth[0] * d[1] - azimuth[1] * d[0];
        Self {
            x: 0.63 * (theta_h / 0.12).ln_1p(),
            azimuth,
            theta_d: s.atan2(length / 2.0),
            r: 0.20 * s / (s + 0.03),
            r_isotropic: 0.20 * theta_h / (theta_h + 0.01) * s / (s + 0.03),
            phi_d: if u.hypot(v) < TINY { 0.0 } else { v.atan2(u) },
        }
    }

    /// Azimuth of the difference vector after the shortest rotation from the half vector to the normal, `(-π, π]`.
    fn psi(&self) -> f64 {
        let psi = self.phi_d + self.azimuth[1].atan2(self.azimuth[0]);
        if psi > PI {
            psi - TAU
        } else if psi <= -PI {
            psi + TAU
        } else {
            psi
        }
    }
}

/// Angles of a direction pair, in units of [`SAME`].
pub type Identity = [i32; 4];

/// Angles that round to the same multiple of this are equal, degrees: files in radians with four decimals are rounded to 0.003.
const SAME: f64 = 0.01;

fn steps(radians: f64) -> i32 {
    (radians.to_degrees() / SAME).round() as i32
}

/// Polar angle of a direction, radians.
pub fn polar([x, y, z]: Vector) -> f64 {
    x.hypot(y).atan2(z)
}

/// A space of `D` coordinates. The search space has one more, which is 0 for measured rows and for queries.
pub trait Space<const D: usize, const S: usize> {
    /// Coordinates of a pair; all symmetric pairs except the reciprocal one have the same.
    fn place(pair: DirectionPair) -> [f64; D];

    /// Angles, rounded, that are equal for pairs that the material's symmetries identify, except for the reciprocal one.
    fn identity(pair: DirectionPair) -> Identity;

    /// Positions of a row in the search space, the row itself first: images across the ends of the azimuth's fold, so
    /// that neighbours are found there, and the reciprocals of all of them.
    fn images(pair: DirectionPair) -> Vec<[f64; S]>;
}

/// `(x, y, z)` of an isotropic, mirror-symmetric material: the angles are invariant to rotation, and folding `φd` into
/// `[0, π]` makes them invariant to the mirror (`-φd`).
pub struct Isotropic;

impl Space<3, 4> for Isotropic {
    fn place(pair: DirectionPair) -> [f64; 3] {
        let a = Angles::of(pair);
        [a.x, a.theta_d, a.r_isotropic * a.phi_d.abs()]
    }

    /// The polar angles, and the azimuth between the directions in `[0, π]`.
    fn identity(pair: DirectionPair) -> Identity {
        let ([ix, iy, _], [ox, oy, _]) = (pair.incoming, pair.outgoing);
        let [light, view] = [pair.incoming, pair.outgoing].map(|v| steps(polar(v)));
        let between = steps((ix * oy - iy * ox).atan2(ix * ox + iy * oy)).abs();
        [light, view, if light == 0 || view == 0 { 0 } else { between }, 0]
    }

    fn images(pair: DirectionPair) -> Vec<[f64; 4]> {
        let a = Angles::of(pair);
        let folded = a.phi_d.abs();
        let mut images = Vec::with_capacity(4);
        for (phi_d, distance) in [(folded, 0.0), (PI - folded, RECIPROCAL_DISTANCE)] {
            for (k, image) in [phi_d, -phi_d, TAU - phi_d].into_iter().enumerate() {
                let new = k == 0 || (image - phi_d).abs() > 1e-4 && image > -BEYOND && image < PI + BEYOND;
                if new {
                    images.push([a.x, a.theta_d, a.r_isotropic * image, distance]);
                }
            }
        }
        images
    }
}

/// `(x cos φh, x sin φh, y, z)` of a material without symmetry, `ψ` in `(-π, π]` for `φd`.
pub struct Anisotropic;

impl Space<4, 5> for Anisotropic {
    fn place(pair: DirectionPair) -> [f64; 4] {
        let a = Angles::of(pair);
        [a.x * a.azimuth[0], a.x * a.azimuth[1], a.theta_d, a.r * a.psi()]
    }

    /// Polar angle and azimuth of both directions.
    fn identity(pair: DirectionPair) -> Identity {
        let of = |direction: Vector| {
            let polar = steps(polar(direction));
            let azimuth = steps(direction[1].atan2(direction[0])).rem_euclid(steps(TAU));
            [polar, if polar == 0 { 0 } else { azimuth }]
        };
        let ([light, of_light], [view, of_view]) = (of(pair.incoming), of(pair.outgoing));
        [light, of_light, view, of_view]
    }

    fn images(pair: DirectionPair) -> Vec<[f64; 5]> {
        let a = Angles::of(pair);
        let mut images = Vec::with_capacity(4);
        let own = a.psi();
        let exchanged = if own > 0.0 { own - PI } else { own + PI };
        for (psi, distance) in [(own, 0.0), (exchanged, RECIPROCAL_DISTANCE)] {
            let around = if psi > 0.0 { psi - TAU } else { psi + TAU };
            for image in [psi, around] {
                if image.abs() < PI + BEYOND {
                    images.push([a.x * a.azimuth[0], a.x * a.azimuth[1], a.theta_d, a.r * image, distance]);
                }
            }
        }
        images
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near(a: &[f64], b: &[f64]) -> bool {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-9)
    }

    proptest! {
        #[test]
        fn folding_is_exact(ti in 0.01f64..1.5, to in 0.01f64..1.5, p in 0.01f64..3.1, turn in 0.0f64..6.0) {
            let pair = DirectionPair::from_angles(ti, 0.0, to, p);
            let here = Isotropic::place(pair);
            prop_assert!(near(&here, &Isotropic::place(DirectionPair::from_angles(ti, turn, to, turn + p))));
            prop_assert!(near(&here, &Isotropic::place(DirectionPair::from_angles(ti, 0.0, to, -p))));
            let mut exchanged = Isotropic::images(pair.exchanged()).into_iter();
            prop_assert!(exchanged.any(|image| near(&here, &image[..3]) && image[3] == RECIPROCAL_DISTANCE));
            let turned = DirectionPair::from_angles(ti, turn, to, turn + p);
            let mut exchanged = Anisotropic::images(turned.exchanged()).into_iter();
            let here = Anisotropic::place(turned);
            prop_assert!(exchanged.any(|image| near(&here, &image[..4]) && image[4] == RECIPROCAL_DISTANCE));
        }

        #[test]
        fn a_row_is_its_own_first_image(ti in 0.0f64..1.5, to in 0.0f64..1.5, p in -3.0f64..3.0) {
            let pair = DirectionPair::from_angles(ti, 0.3, to, p);
            prop_assert!(near(&Isotropic::place(pair), &Isotropic::images(pair)[0][..3]));
            prop_assert!(near(&Anisotropic::place(pair), &Anisotropic::images(pair)[0][..4]));
            prop_assert_eq!(Isotropic::images(pair)[0][3], 0.0);
        }

        /// A light turns about the normal. Mirror directions are as far apart as pairs next to them; without anisotropy
        /// they are one place.
        #[test]
        fn mirror_directions_keep_their_azimuth(polar in 0.2f64..1.5, turn in 0.1f64..3.0, first in -3.0f64..3.0) {
            let at = |azimuth: f64, off: f64| DirectionPair::from_angles(polar, azimuth, polar + off, azimuth + PI);
            let images = |pair: DirectionPair| Anisotropic::images(pair).into_iter().filter(|image| image[4] == 0.0);
            let apart = |a: DirectionPair, b: DirectionPair| {
                let place = Anisotropic::place(a);
                let squares = |image: [f64; 5]| place.iter().zip(image).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                images(b).map(|image| squares(image).sqrt()).fold(f64::INFINITY, f64::min)
            };
            let mirrored = apart(at(first, 0.0), at(first + turn, 0.0));
            prop_assert!(mirrored > 0.15 * turn, "{mirrored}");
            // Continuous across the pole.
            for off in [1e-7, -1e-7] {
                prop_assert!((apart(at(first, off), at(first + turn, -off)) - mirrored).abs() < 1e-5);
                prop_assert!(apart(at(first, off), at(first, -off)) < 1e-5);
            }
            let places = [0.0, turn].map(|turn| Isotropic::place(at(first + turn, 0.0)));
            prop_assert!(near(&places[0], &places[1]));
        }

        #[test]
        fn identities_are_those_of_the_symmetries(ti in 0.0f64..1.5, to in 0.1f64..1.5, p in 0.1f64..3.0, turn in 0.1f64..6.0) {
            let pair = DirectionPair::from_angles(ti, 0.0, to, p);
            let turned = DirectionPair::from_angles(ti, turn, to, turn + p);
            let mirrored = DirectionPair::from_angles(ti, 0.0, to, -p);
            for other in [turned, mirrored] {
                prop_assert_eq!(Isotropic::identity(pair), Isotropic::identity(other));
                prop_assert_ne!(Anisotropic::identity(pair), Anisotropic::identity(other));
            }
            let other = DirectionPair::from_angles(ti + 1e-3, 0.0, to, p);
            prop_assert_ne!(Isotropic::identity(pair), Isotropic::identity(other));
        }
    }

    /// Mirrored rows of a grid, in radians with four decimals.
    #[test]
    fn rounded_angles_are_equal() {
        let rounded = |degrees: f64| (1e4 * degrees.to_radians()).round() / 1e4;
        let identity = |azimuth: f64| {
            let pair = DirectionPair::from_angles(rounded(10.0), rounded(45.0), rounded(20.0), rounded(45.0 + azimuth));
            (Isotropic::identity(pair), Anisotropic::identity(pair))
        };
        for step in 1..24 {
            let azimuth = 7.5 * f64::from(step);
            let [(one, apart), (other, other_apart)] = [azimuth, 360.0 - azimuth].map(identity);
            assert_eq!(one, other);
            assert_ne!(apart, other_apart);
        }
        // The azimuth at the pole is no difference.
        let [a, b] = [0.3, 2.0].map(|azimuth| DirectionPair::from_angles(1e-5, azimuth, 0.7, 0.1));
        assert_eq!(
            (Isotropic::identity(a), Anisotropic::identity(a)),
            (Isotropic::identity(b), Anisotropic::identity(b))
        );
    }
}
