//! Parallel cylinders, a model with anisotropy from geometry.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, weighted_sum};
use super::quadrature::integrate;
use brdfc_formats::direction::{DirectionPair, Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

/// Cylinders of radius 1 along the tangent x, their centres `d` apart along y at `z = 0`, with a flat floor at `z = h`
/// between them (Poulin and Fournier 1990, "A model for anisotropic reflection").
///
/// The local reflectance is `f_local = kd / π + ks (n + 2) / 2π max(N·H, 0)^n` with the local normal `N` and the half
/// vector `H`. Over the part of one period of the profile that is both lit and visible, light reflected once gives
///
/// `f_r = 1 / (d cos θi cos θo) ∫ f_local (N·wi) (N·wo) dl`.
///
/// A part is lit (and likewise visible) if the direction is above its local horizon and no cylinder occludes it. That
/// is one interval of the profile angle `β` (`N = (0, cos β, sin β)`) on the arc above the floor, and one of `y` on the
/// floor; with `α` the angle of the direction in the profile plane from +y, and for `cos α >= 0` (else mirrored):
///
/// - arc: `α + asin max(-1, 1 - d sin α) < β < α + π/2`,
/// - floor: `y < d - (1 - h cos α) / sin α` where the ray that touches the right cylinder does so above the floor
///   (`cos α > h`), and `y > (1 + h cos α) / sin α` where the one on the left does (`-cos α > h`).
///
/// Interreflection between cylinders is ignored, so a white surface absorbs some light. With `h = 1` the cylinders are
/// below the floor and the material is flat.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Poulin {
    /// Local diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
    /// Weight of the local lobe, linear RGB, 0 to 1; for large `n` its albedo is about four times that.
    pub ks: [f64; 3],
    /// Distance `d` between the centres of neighbours in radii, 2 (touching) to 100.
    pub spacing: f64,
    /// Height `h` of the floor above the centres in radii, -1 to 1.
    pub floor: f64,
    /// Exponent `n` of the local lobe, 0 to 10000.
    pub exponent: f64,
}

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "poulin",
    meaning: "parallel cylinders over a floor",
    parameters: &[
        Parameter::colour("kd", 0.2, DIFFUSE),
        Parameter::colour("ks", 0.1, "weight of the local lobe"),
        Parameter::number("d", [2.0, 100.0], 2.5, "distance between cylinders, in radii"),
        Parameter::number("h", [-1.0, 1.0], 0.0, "height of the floor over the centres, in radii"),
        Parameter::number("n", [0.0, 10_000.0], 20.0, "exponent of the local lobe"),
    ],
    shorthands: &[],
    build: |v| Box::new(Poulin { kd: v[0], ks: v[1], spacing: v[2][0], floor: v[3][0], exponent: v[4][0] }),
};

type Interval = [f64; 2];

fn intersection(a: Interval, b: Interval) -> Interval {
    [a[0].max(b[0]), a[1].min(b[1])]
}

impl Poulin {
    /// Angles of the arc that direction `w` reaches (empty if the end is not after the start).
    fn open_arc(&self, w: Vector) -> Interval {
        let angle = w[2].atan2(w[1]);
        // acos(1 - d sin α), in a form that stays accurate at the horizon.
        let sine = w[2] / w[1].hypot(w[2]);
        let width = 2.0 * (0.5 * self.spacing * sine).min(1.0).sqrt().asin();
        let own = if w[1] >= 0.0 {
            [angle + FRAC_PI_2 - width, angle + FRAC_PI_2]
        } else {
            [angle - FRAC_PI_2, angle - FRAC_PI_2 + width]
        };
        let foot = self.floor.asin();
        intersection(own, [foot, PI - foot])
    }

    /// Part in y of the floor between the cylinders at 0 and `d` that direction `w` reaches.
    fn open_floor(&self, w: Vector) -> Interval {
        let length = w[1].hypot(w[2]);
        let (cosine, sine) = (w[1] / length, w[2] / length);
        let foot = (1.0 - self.floor * self.floor).sqrt();
        let from = if -cosine > self.floor { (1.0 + self.floor * cosine) / sine } else { foot };
        let to = if cosine > self.floor { (1.0 - self.floor * cosine) / sine } else { foot };
        [from, self.spacing - to]
    }

    /// `∫ (N·wi) (N·wo) / (cos θi cos θo) dl` over the lit and visible part of a period, plain and with `(N·H)^n`.
    fn profile_integrals(&self, pair: DirectionPair) -> [f64; 2] {
        let (i, o) = (pair.incoming, pair.outgoing);
        let half = half_vector(pair);
        let (slope_i, slope_o) = (i[1] / i[2], o[1] / o[2]);
        let arc = intersection(self.open_arc(i), self.open_arc(o));
        let floor = intersection(self.open_floor(i), self.open_floor(o));
        let width = (floor[1] - floor[0]).max(0.0);
        let mut sum = [width, width * half[2].powf(self.exponent)];

        // (N·H)^n is close to a Gaussian of deviation 1 / sqrt(n): six deviations to each side get their own nodes.
        let peak = half[2].atan2(half[1]);
        let reach = 6.0 / (self.exponent + 1.0).sqrt();
        let ends = [arc[0], peak - reach, peak, peak + reach, arc[1]].map(|angle| angle.max(arc[0]).min(arc[1]));
        for panel in ends.windows(2) {
            let [plain, lobe] = integrate(panel[0], panel[1], |angle| {
                let (sine, cosine) = angle.sin_cos();
                // Positive inside the interval except for rounding at its ends.
                let facing = (slope_i * cosine + sine).max(0.0) * (slope_o * cosine + sine).max(0.0);
                [facing, facing * (half[1] * cosine + half[2] * sine).max(0.0).powf(self.exponent)]
            });
            sum[0] += plain;
            sum[1] += lobe;
        }
        sum
    }
}

/// Selects the pair or its mirror image in `y = 0`, so that both have the same value to the last bit.
fn on_one_side(pair: DirectionPair) -> DirectionPair {
    let (i, o) = (pair.incoming, pair.outgoing);
    if i[1] + o[1] >= 0.0 {
        return pair;
    }
    DirectionPair::new([i[0], -i[1], i[2]], [o[0], -o[1], o[2]])
}

impl Analytic for Poulin {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd, self.ks, [self.spacing; 3], [self.floor; 3], [self.exponent; 3]]
    }

    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3] {
        let [diffuse, lobe] = self.profile_integrals(on_one_side(pair));
        let lobe_scale = (self.exponent + 2.0) / TAU;
        weighted_sum(self.kd, FRAC_1_PI * diffuse / self.spacing, self.ks, lobe_scale * lobe / self.spacing)
    }

    fn is_isotropic(&self) -> bool {
        self.floor == 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Source as _, Tally};
    use brdfc_formats::direction::{dot, from_polar};
    use proptest::prelude::*;

    fn surface(spacing: f64, floor: f64, exponent: f64) -> Poulin {
        Poulin { kd: [1.0; 3], ks: [1.0; 3], spacing, floor, exponent }
    }

    fn upper() -> impl Strategy<Value = Vector> {
        (0.01f64..1.5, 0.0..TAU).prop_map(|(theta, phi)| from_polar(theta, phi))
    }

    /// Returns true if the ray from a point of the profile meets no cylinder (starting slightly above the surface).
    fn is_open(shape: &Poulin, point: [f64; 2], normal: [f64; 2], w: Vector) -> bool {
        let facing = normal[0] * w[1] + normal[1] * w[2];
        facing > 0.0
            && (-60..=60).all(|k| {
                let (y, z) = (point[0] - f64::from(k) * shape.spacing, point[1]);
                let (a, b, c) = (w[1] * w[1] + w[2] * w[2], y * w[1] + z * w[2], y * y + z * z - 1.0);
                let discriminant = b * b - a * c;
                discriminant <= 1e-9 || (-b + discriminant.sqrt()) / a < 1e-4
            })
    }

    /// The profile integrals as a plain sum over ray-cast points.
    fn by_ray_casting(shape: &Poulin, pair: DirectionPair, points: usize) -> [f64; 2] {
        let half = half_vector(pair);
        let foot = shape.floor.asin();
        let (arc_step, floor_width) = ((PI - 2.0 * foot) / points as f64, shape.spacing - 2.0 * foot.cos());
        let mut sum = [0.0; 2];
        let mut add = |point: [f64; 2], normal: [f64; 2], length: f64| {
            if is_open(shape, point, normal, pair.incoming) && is_open(shape, point, normal, pair.outgoing) {
                let n = [0.0, normal[0], normal[1]];
                let facing = dot(n, pair.incoming) * dot(n, pair.outgoing) / (pair.incoming[2] * pair.outgoing[2]);
                sum[0] += length * facing;
                sum[1] += length * facing * dot(n, half).powf(shape.exponent);
            }
        };
        for k in 0..points {
            let angle = foot + (k as f64 + 0.5) * arc_step;
            add([angle.cos(), angle.sin()], [angle.cos(), angle.sin()], arc_step);
            let y = foot.cos() + (k as f64 + 0.5) / points as f64 * floor_width;
            add([y, shape.floor], [0.0, 1.0], floor_width / points as f64);
        }
        sum
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn intervals_agree_with_ray_casting(i in upper(), o in upper(), d in 2.0f64..6.0, h in -0.99f64..0.99) {
            let (shape, pair) = (surface(d, h, 10.0), DirectionPair::new(i, o));
            let (fast, slow) = (shape.profile_integrals(pair), by_ray_casting(&shape, pair, 2000));
            for k in 0..2 {
                let scale = 0.01 / (i[2] * o[2]);
                prop_assert!((fast[k] - slow[k]).abs() < scale, "{k}: {fast:?} {slow:?}");
            }
        }

        #[test]
        fn visible_parts_cover_the_period(w in upper(), d in 2.0f64..20.0, h in -1.0f64..1.0) {
            let shape = surface(d, h, 1.0);
            let floor = shape.open_floor(w);
            let arc = shape.open_arc(w);
            let [seen] = integrate(arc[0], arc[1], |b| [w[1] * b.cos() + w[2] * b.sin()]);
            let projected = seen + (floor[1] - floor[0]).max(0.0) * w[2];
            prop_assert!((projected - d * w[2]).abs() < 1e-12 * d, "{projected} {}", d * w[2]);
        }
    }

    #[test]
    fn nodes_are_enough_for_narrow_lobes() {
        for exponent in [0.0, 1.0, 5.5, 50.0, 300.0, 10_000.0] {
            let shape = surface(2.5, 0.2, exponent);
            for (i, o) in [((0.2, 0.3), (0.5, 2.0)), ((1.2, 1.5), (0.9, 4.4)), ((0.7, 1.0), (1.4, 1.2))] {
                let pair = DirectionPair::new(from_polar(i.0, i.1), from_polar(o.0, o.1));
                let arc = intersection(shape.open_arc(pair.incoming), shape.open_arc(pair.outgoing));
                let half = half_vector(pair);
                let floor = intersection(shape.open_floor(pair.incoming), shape.open_floor(pair.outgoing));
                let mut fine = (floor[1] - floor[0]).max(0.0) * half[2].powf(exponent);
                let step = (arc[1] - arc[0]).max(0.0) / 400.0;
                for k in 0..400 {
                    let from = arc[0] + f64::from(k) * step;
                    let [part] = integrate(from, from + step, |b| {
                        let n = [0.0, b.cos(), b.sin()];
                        let facing = dot(n, pair.incoming) * dot(n, pair.outgoing);
                        [facing / (pair.incoming[2] * pair.outgoing[2]) * dot(n, half).powf(exponent)]
                    });
                    fine += part;
                }
                let found = shape.profile_integrals(pair)[1];
                assert!((found - fine).abs() <= 1e-9 * fine, "n {exponent}: {found:e} {fine:e}");
            }
        }
    }

    #[test]
    fn the_value_is_continuous_where_intervals_change() {
        for (d, h) in [(2.0, -0.5), (2.5, 0.0), (3.0, 0.6)] {
            let (shape, mut tally) = (surface(d, h, 40.0), Tally::default());
            let incoming = from_polar(0.8, 1.2);
            let mut before: Option<f64> = None;
            for k in 0..40_000 {
                let theta = -1.4 + 2.8 * (f64::from(k) + 0.5) / 40_000.0;
                let outgoing = from_polar(theta, 1.5);
                let value = shape.eval(DirectionPair::new(incoming, outgoing), &mut tally)[0];
                assert!(
                    before.is_none_or(|b| (b - value).abs() < 5e-3),
                    "d {d} h {h} theta {theta}: {before:?} {value}"
                );
                before = Some(value);
            }
        }
    }
}
