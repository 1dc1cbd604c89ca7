//! Studs whose caps overhang their necks, on a gently curved base.

use super::noise::{lattice, mix, periodic_fractal, smooth_step};
use super::relief::{HEIGHT, Pointwise, RESOLUTION, SEED, Sample, StructureInfo};
use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;
use std::f64::consts::FRAC_PI_2;

pub(super) const INFO: StructureInfo = StructureInfo {
    name: "button",
    meaning: "smooth studs whose caps overhang their necks; one glossy material",
    parameters: &[
        RESOLUTION,
        HEIGHT,
        SEED,
        Parameter::integer("count", [1.0, 8.0], 2.0, "studs along either side of the tile; staggered if even"),
        Parameter::number("overhang", [0.15, 0.6], 0.35, "how far caps reach over their necks, in cap radii"),
    ],
    materials: &["synth:lewis?kd=0.42,0.13,0.08&ks=0.1&n=40"],
    build: |values| Box::new(Buttons::new(values[2] as u64, values[3] as i64, values[4])),
};

/// Radius of the disc of parameters that becomes a stud, in distances between studs. Below one half, to allow for the
/// jitter of centres.
const DISC: f64 = 0.46;
/// Maximum displacement of a centre, per axis, in distances between studs.
const JITTER: f64 = 0.03;

struct Buttons {
    seed: u64,
    count: i64,
    /// The shape shared by all studs.
    profile: Profile,
}

impl Buttons {
    fn new(seed: u64, count: i64, overhang: f64) -> Self {
        Self { seed, count, profile: Profile::new(overhang) }
    }

    /// Centre of the stud of a cell, and its cap radius, in distances between studs.
    fn stud(&self, [column, row]: [i64; 2]) -> ([f64; 2], f64) {
        let wrapped = [column.rem_euclid(self.count), row.rem_euclid(self.count)];
        let random = |k: u64| lattice(wrapped[0], wrapped[1], self.seed ^ (k << 40));
        let stagger = if self.count % 2 == 0 && row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
        let moved = |k: u64| JITTER * (2.0 * random(k) - 1.0);
        let centre = [column as f64 + 0.25 + stagger + moved(1), row as f64 + 0.5 + moved(2)];
        (centre, mix(0.31, 0.365, random(3)))
    }

    /// The base under the studs, in tiles.
    fn base(&self, x: f64, y: f64) -> f64 {
        0.02 * periodic_fractal(x, y, self.seed ^ 0xba5e, [2, 2], 1, 0.5)
    }
}

impl Pointwise for Buttons {
    fn sample(&self, u: f64, v: f64) -> Sample {
        let scale = self.count as f64;
        let at = [u * scale, v * scale];
        let mut point = [u, v, 0.0];
        let mut lightness = 0.72;
        let row = at[1].floor() as i64;
        let column = at[0].floor() as i64;
        for cell in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [column + dx, row + dy])) {
            let (centre, radius) = self.stud(cell);
            let away = [at[0] - centre[0], at[1] - centre[1]];
            let distance = away[0].hypot(away[1]);
            if distance >= DISC {
                continue;
            }
            let [r, z] = self.profile.at(distance / DISC, DISC / radius);
            let stretch = if distance > 0.0 { radius * r / distance } else { 0.0 };
            (0..2).for_each(|k| point[k] = (centre[k] + stretch * away[k]) / scale);
            point[2] = radius * z / scale;
            // The base is a little darker than the studs.
            lightness = mix(0.72, 1.0, smooth_step(0.0, 0.25, z));
        }
        // A shear along z, which cannot cause self-intersections.
        point[2] += self.base(point[0], point[1]);
        let tint = [lightness as f32; 3];
        (point, VertexMaterial { tint, ..VertexMaterial::default() })
    }
}

/// The outline of a stud of cap radius 1 in the plane of radius and height: four quarter ellipses, joined with a common
/// tangent, and the level base.
///
/// Height never rises outward, and where it is level the radius grows. Therefore the outline does not meet itself, nor
/// does any blend of it with the identity.
struct Profile {
    /// Centre and half axes of the quarters: dome, rim, underside, foot.
    quarters: [Quarter; 4],
    /// Parameter consumed up to each point at equal steps of the quarters' angles.
    consumed: Vec<f64>,
}

/// The points `centre + (radial sin t, vertical cos t)`, `t` from `start` to `start + π / 2`.
#[derive(Clone, Copy)]
struct Quarter {
    centre: [f64; 2],
    radial: f64,
    vertical: f64,
    start: f64,
}

impl Quarter {
    fn at(&self, share: f64) -> [f64; 2] {
        let (sin, cos) = (self.start + FRAC_PI_2 * share).sin_cos();
        [self.centre[0] + self.radial * sin, self.centre[1] + self.vertical * cos]
    }
}

/// Heights in cap radii: top of the dome, widest place, lowest place of the underside, narrowest place.
const TOP: f64 = 0.88;
const WIDEST: f64 = 0.6;
const UNDERSIDE: f64 = 0.46;
const NARROWEST: f64 = 0.26;
/// Width of the foot around the neck, in cap radii.
const FOOT: f64 = 0.26;
/// Points of the outline per quarter at which lengths are tabulated.
const STEPS: usize = 64;
/// Parameter consumed by one radian of turning, as a length in cap radii: bends get more vertices.
const TURNING: f64 = 0.12;

impl Profile {
    fn new(overhang: f64) -> Self {
        let neck = 1.0 - overhang;
        // Junction of the rim and the neck on the underside.
        let middle = 1.0 - 0.45 * overhang;
        let quarters = [
            Quarter { centre: [0.0, WIDEST], radial: 1.0, vertical: TOP - WIDEST, start: 0.0 },
            Quarter { centre: [middle, WIDEST], radial: 1.0 - middle, vertical: WIDEST - UNDERSIDE, start: FRAC_PI_2 },
            Quarter { centre: [middle, NARROWEST], radial: neck - middle, vertical: UNDERSIDE - NARROWEST, start: 0.0 },
            Quarter { centre: [neck + FOOT, NARROWEST], radial: -FOOT, vertical: NARROWEST, start: FRAC_PI_2 },
        ];
        let mut profile = Self { quarters, consumed: vec![0.0] };
        let (mut before, mut heading) = (profile.point(0), 0.0);
        for k in 1..=4 * STEPS {
            let here = profile.point(k);
            let step = [here[0] - before[0], here[1] - before[1]];
            let turned: f64 = step[1].atan2(step[0]) - heading;
            heading += turned;
            // Headings of -π and π are the same.
            let turned = turned.abs().min((std::f64::consts::TAU - turned.abs()).abs());
            profile.consumed.push(profile.consumed[k - 1] + step[0].hypot(step[1]) + TURNING * turned);
            before = here;
        }
        profile
    }

    /// The point number `k` of `4 STEPS` steps along the quarters.
    fn point(&self, k: usize) -> [f64; 2] {
        let quarter = (k / STEPS).min(3);
        self.quarters[quarter].at((k - quarter * STEPS) as f64 / STEPS as f64)
    }

    /// Radius and height at parameter `s`: 0 at the axis, 1 at the edge of the disc, there `[rim, 0]`.
    fn at(&self, s: f64, rim: f64) -> [f64; 2] {
        let curved = self.consumed[4 * STEPS];
        let foot = self.quarters[3].at(1.0)[0];
        let sought = s * (curved + rim - foot);
        if sought >= curved {
            return [foot + sought - curved, 0.0];
        }
        let k = self.consumed.partition_point(|consumed| *consumed <= sought).clamp(1, 4 * STEPS) - 1;
        let within = (sought - self.consumed[k]) / (self.consumed[k + 1] - self.consumed[k]);
        let quarter = k / STEPS;
        self.quarters[quarter].at(((k % STEPS) as f64 + within) / STEPS as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_is_smooth_and_ends_at_the_rim() {
        for overhang in [0.15, 0.35, 0.6] {
            let profile = Profile::new(overhang);
            let rim = 1.3;
            assert_eq!(profile.at(0.0, rim), [0.0, TOP]);
            let end = profile.at(1.0, rim);
            assert!((end[0] - rim).abs() < 1e-12 && end[1] == 0.0, "{end:?}");
            let (mut widest, mut heading) = (0.0f64, None::<[f64; 2]>);
            let mut narrowest_below_cap = f64::INFINITY;
            for k in 1..=4000 {
                let [before, here] = [k - 1, k].map(|k| profile.at(f64::from(k) / 4000.0, rim));
                let step = [here[0] - before[0], here[1] - before[1]];
                assert!(step[1] <= 1e-12 && (step[1] < -1e-12 || step[0] > 0.0), "{before:?} {here:?}");
                let length = step[0].hypot(step[1]);
                let direction = step.map(|d| d / length);
                if let Some(heading) = heading {
                    assert!(heading[0] * direction[0] + heading[1] * direction[1] > 0.99, "a corner at {here:?}");
                }
                heading = Some(direction);
                widest = widest.max(if here[1] > 0.3 { here[0] } else { 0.0 });
                narrowest_below_cap = narrowest_below_cap.min(if here[1] < WIDEST { here[0] } else { 1.0 });
            }
            assert!((widest - 1.0).abs() < 1e-3 && (narrowest_below_cap - (1.0 - overhang)).abs() < 1e-3);
        }
    }
}
