//! Bandwidth from light to pixel compared with the same in f64.

use super::fed::Numbers;
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_formats::bandwidth::propagation::{
    Bandwidth, BandwidthAverage, BandwidthSurface, SMALLEST_COSINE, UNLIMITED,
};

/// Roundings of one reflection and two flights: each step is a sum of two products, or a quotient.
const ROUNDINGS: f64 = 16.0;

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let count = if small { 2_000 } else { 200_000 };
    let mut numbers = Numbers::new(12);
    let [mut bounce, mut limits, mut mean] = [Worst::default(); 3];
    for _ in 0..count {
        let (bandwidth, surface, distances) = fed(&mut numbers);
        let found = (stages.one_bounce)(bandwidth, distances[0], surface, distances[1]);
        let exact = one_bounce(bandwidth, distances[0], surface, distances[1]);
        for (found, exact) in [(found.spatial, exact[0]), (found.angular, exact[1])] {
            limits.check((0.0..=UNLIMITED).contains(&found));
            // Products of the smallest numbers are denormal.
            bounce.add((f64::from(found) - exact) / (exact + f64::from(f32::MIN_POSITIVE)));
        }
        let weights = [numbers.wide() as f32, 1e12 * numbers.unit() as f32];
        let other = Bandwidth { spatial: numbers.wide() as f32, angular: UNLIMITED * numbers.unit() as f32 };
        let average =
            (stages.mean_bandwidth)(BandwidthAverage::default().add(bandwidth, weights[0]).add(other, weights[1]));
        let (low, high) = (bandwidth.angular.min(other.angular), bandwidth.angular.max(other.angular));
        let within = |v: f32| {
            f64::from(v) >= f64::from(low) * (1.0 - 8.0 * U) && f64::from(v) <= f64::from(high) * (1.0 + 8.0 * U)
        };
        mean.check(within(average.angular) && average.spatial.is_finite());
    }
    let mut level = Worst::default();
    for power in -126..=100 {
        let exact = 2f32.powi(power);
        for (bandwidth, log) in [(exact, f64::from(power)), (exact.next_up(), f64::from(power) + 1e-7)] {
            let expected = (-(log + 1.0)).floor().min(20.0);
            level.check(f64::from((stages.pyramid_level)(bandwidth, 20)) == expected);
        }
    }
    level.check((stages.pyramid_level)(0.0, 20) == 20 && (stages.pyramid_level)(1e-40, 20) == 20);
    vec![
        bounce.row(
            ["bandwidth over a reflection, f32", "1e-12 to 1e9, grazing cosines to 1e-12, no bandwidth, no distance"],
            Measure::Relative,
            ROUNDINGS * U,
            "sums and products of non-negative numbers: as many roundings as steps",
        ),
        limits.row(
            ["bandwidth over a reflection, f32", "the same"],
            Measure::Count,
            0.0,
            "finite, not negative, and at most the value for no limit",
        ),
        mean.row(["mean bandwidth, f32", "weights 1e-12 to 1e12"], Measure::Count, 0.0, "a mean is between its values"),
        level.row(
            ["level of the pyramid", "all powers of two and the adjacent numbers, denormals"],
            Measure::Count,
            0.0,
            "the logarithm is read from bits: exact",
        ),
    ]
}

fn fed(numbers: &mut Numbers) -> (Bandwidth, BandwidthSurface, [f32; 2]) {
    let mut number = || match numbers.below(5) {
        0 => 0.0,
        1 => UNLIMITED,
        _ => numbers.wide() as f32,
    };
    let bandwidth = Bandwidth { spatial: number(), angular: number() };
    let surface = BandwidthSurface {
        cos_incoming: number().min(1.0),
        cos_outgoing: number().min(1.0),
        curvature: number(),
        lobe: number(),
        texture: number(),
    };
    (bandwidth, surface, [number(), number()])
}

/// Equation 4 step by step: `(v_s, v_a)`.
fn one_bounce(from: Bandwidth, light: f32, surface: BandwidthSurface, image: f32) -> [f64; 2] {
    let limited = |v: f64| v.min(f64::from(UNLIMITED));
    let (mut spatial, mut angular) = (f64::from(from.spatial), f64::from(from.angular));
    angular = limited(angular + f64::from(light) * spatial);
    spatial = limited(spatial * f64::from(surface.cos_incoming));
    spatial = limited(spatial + f64::from(surface.curvature) * angular);
    spatial = limited(spatial + f64::from(surface.texture));
    angular = limited(angular.min(f64::from(surface.lobe)));
    spatial = limited(spatial + f64::from(surface.curvature) * angular);
    spatial = limited(spatial / f64::from(surface.cos_outgoing.max(SMALLEST_COSINE)));
    angular = limited(angular + f64::from(image) * spatial);
    [spatial, angular]
}
