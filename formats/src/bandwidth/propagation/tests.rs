//! Hand-computed propagation and known answers.

use super::*;

const fn bandwidth(spatial: f32, angular: f32) -> Bandwidth {
    Bandwidth { spatial, angular }
}

const SURFACE: BandwidthSurface =
    BandwidthSurface { cos_incoming: 0.5, cos_outgoing: 0.5, curvature: 2.0, lobe: 4.0, texture: 3.0 };

#[test]
fn each_operator_by_hand() {
    let v = bandwidth(3.0, 5.0);
    assert_eq!(v.flight(2.0), bandwidth(3.0, 11.0));
    assert_eq!(v.into_surface(0.25), bandwidth(0.75, 5.0));
    assert_eq!(v.curvature(2.0), bandwidth(13.0, 5.0));
    assert_eq!(v.reflection(4.0, 0.5), bandwidth(3.5, 4.0));
    assert_eq!(v.reflection(6.0, 0.0), v);
    assert_eq!(v.out_of_surface(0.25), bandwidth(12.0, 5.0));
}

#[test]
fn a_bounce_by_hand() {
    // 0, 10 -> 0, 10 -> 20, 10 -> 23, 4 -> 31, 4 -> 62, 4 -> 62, 128
    assert_eq!(Bandwidth::distant(10.0).one_bounce(0.0, SURFACE, 2.0), bandwidth(62.0, 128.0));
    // 1, 2 -> 1, 5 -> 0.5, 5 -> 10.5, 5 -> 13.5, 4 -> 21.5, 4 -> 43, 4 -> 43, 90
    assert_eq!(bandwidth(1.0, 2.0).one_bounce(3.0, SURFACE, 2.0), bandwidth(43.0, 90.0));
    // All parameters matter.
    for (changed, field) in [
        (BandwidthSurface { cos_incoming: 0.25, ..SURFACE }, "cos_incoming"),
        (BandwidthSurface { cos_outgoing: 0.25, ..SURFACE }, "cos_outgoing"),
        (BandwidthSurface { curvature: 1.0, ..SURFACE }, "curvature"),
        (BandwidthSurface { lobe: 3.0, ..SURFACE }, "lobe"),
        (BandwidthSurface { texture: 2.0, ..SURFACE }, "texture"),
    ] {
        assert_ne!(bandwidth(1.0, 2.0).one_bounce(3.0, changed, 2.0), bandwidth(43.0, 90.0), "{field}");
    }
}

#[test]
fn nothing_in_nothing_out() {
    let surface = BandwidthSurface { texture: 0.0, ..SURFACE };
    assert_eq!(Bandwidth::default().one_bounce(7.0, surface, 9.0), Bandwidth::default());
    assert_eq!(BandwidthAverage::default().mean(), Bandwidth::default());
    assert_eq!(BandwidthAverage::default().add(bandwidth(3.0, 4.0), 0.0).mean(), Bandwidth::default());
    assert_eq!(VarianceEstimate::default().relative(0.0), 0.0);
    assert_eq!(VarianceEstimate::default().add(0.0, 0.0, 5.0).relative(0.0), 0.0);
}

/// Around a sphere of radius ½ at a distance of 4, the viewer's angle to the normal turns by `1 + d' / (R cos θo)`.
#[test]
fn albedo_varies_with_the_viewers_angle() {
    let ball = BandwidthSurface { cos_outgoing: 0.5, curvature: 2.0, ..SURFACE };
    assert_eq!(ball.albedo(4.0).angular, 0.5 * (1.0 + 4.0 * 2.0 / 0.5));
    assert_eq!(BandwidthSurface { lobe: 0.0, ..ball }.albedo(4.0), Bandwidth::default());
    assert_eq!(BandwidthSurface { lobe: 0.25, ..ball }.albedo(4.0).angular, 0.25 * 17.0);
}

#[test]
fn parts_of_sums_add_up() {
    let light = DirectedLight::of(2.0, 5.0, 3.0);
    assert_eq!(light.moments(), [2.0, 6.0, 5.0, 15.0]);
    assert_eq!(DirectedLight::from_moments(light.moments()), light);
    assert_eq!(DirectedLight::from_moments([0.0; 4]), DirectedLight::default());
    // One direction as a range is that direction.
    let start = VarianceEstimate::default().add(1.0, 2.0, 4.0);
    assert_eq!(start.add_range(DirectedLight::of(3.0, 9.0, 5.0), 7.0), start.add(5.0, 7.0, 3.0));
    assert_eq!(start.join(VarianceEstimate::default().add(5.0, 7.0, 3.0)), start.add(5.0, 7.0, 3.0));
    assert_eq!(start.add(5.0, 7.0, 2.0).mean(), 3.0);
    let average = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 3.0);
    let other = BandwidthAverage::default().add(bandwidth(5.0, 7.0), 1.0);
    assert_eq!(average.join(other), average.add(bandwidth(5.0, 7.0), 1.0));
    assert_eq!(average.join(other).mean(), bandwidth(2.0, 3.25));
}

#[test]
fn a_plane_under_a_distant_light_varies_with_direction_alone() {
    let plane = BandwidthSurface { curvature: 0.0, texture: 0.0, ..SURFACE };
    for (light, lobe) in [(10.0, 4.0), (3.0, 4.0)] {
        let seen = Bandwidth::distant(light).one_bounce(0.0, BandwidthSurface { lobe, ..plane }, 50.0);
        assert_eq!(seen, bandwidth(0.0, lobe.min(light)));
    }
    // A texture, a curved surface or a close light do vary in space.
    let textured = BandwidthSurface { texture: 1.0, ..plane };
    assert_eq!(Bandwidth::distant(3.0).one_bounce(0.0, textured, 50.0), bandwidth(2.0, 103.0));
    assert!(Bandwidth::distant(3.0).one_bounce(0.0, BandwidthSurface { curvature: 0.1, ..plane }, 50.0).spatial > 0.0);
    assert!(bandwidth(1.0, 3.0).one_bounce(1.0, plane, 50.0).spatial > 0.0);
}

/// In a mirror sphere of radius R at distance d', a pixel's angle α moves by `d' α / cos θo` on the sphere; the normal
/// turns by that over R, the reflected ray by twice as much plus α.
#[test]
fn a_mirror_sphere_agrees_with_geometry() {
    for (radius, distance, cosine, light) in [(0.5, 4.0, 1.0, 3.0), (0.1, 2.0, 0.5, 7.0), (2.0, 0.25, 0.25, 1.5)] {
        let ball = BandwidthSurface {
            cos_incoming: cosine,
            cos_outgoing: cosine,
            curvature: 1.0 / radius,
            lobe: UNLIMITED,
            texture: 0.0,
        };
        let seen = Bandwidth::distant(light).one_bounce(0.0, ball, distance).angular;
        let expected = light * (1.0 + 2.0 * distance / (radius * cosine));
        assert!((seen / expected - 1.0).abs() < 1e-6, "{seen} {expected}");
    }
}

#[test]
fn everything_stays_finite() {
    let all = [0.0, 1e-40, 1.0, 1e3, UNLIMITED];
    for spatial in all {
        for angular in all {
            for texture in all {
                for cosine in [0.0, 1e-30, 1.0] {
                    let surface = BandwidthSurface {
                        cos_incoming: cosine,
                        cos_outgoing: cosine,
                        curvature: 1e9,
                        lobe: UNLIMITED,
                        texture,
                    };
                    let seen = bandwidth(spatial, angular).one_bounce(1e9, surface, 1e9);
                    assert!(seen.spatial <= UNLIMITED && seen.angular <= UNLIMITED, "{seen:?}");
                    let mut variance = VarianceEstimate::default();
                    let mut average = BandwidthAverage::default();
                    for contribution in [0.0, 1e-30, 1e-18, 1.0, 1e38] {
                        variance = variance.add(angular, spatial, contribution);
                        average = average.add(seen, contribution);
                        assert!(variance.relative(0.0) <= UNLIMITED);
                        assert!(average.mean().angular <= UNLIMITED && average.mean().spatial <= UNLIMITED);
                    }
                }
            }
        }
    }
}

#[test]
fn the_mean_is_weighted() {
    let average = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 3.0).add(bandwidth(5.0, 6.0), 1.0);
    assert_eq!(average.mean(), bandwidth(2.0, 3.0));
    // Scaling all weights changes nothing; a maximum would be (5, 6).
    let dim = BandwidthAverage::default().add(bandwidth(1.0, 2.0), 0.375).add(bandwidth(5.0, 6.0), 0.125);
    assert_eq!(dim.mean(), average.mean());
}

#[test]
fn pixels_by_hand() {
    // 1/128 radian per pixel across and 1/256 down; then 1/256 across and 1/128 down.
    assert_eq!(pixel_bandwidth(25.0, [1.0, 0.5], [128.0, 128.0], 0.5), 0.1953125);
    assert_eq!(pixel_bandwidth(25.0, [1.0, 0.5], [256.0, 64.0], 0.5), 0.1953125);
    assert_eq!(pixel_bandwidth(1e6, [1.0, 0.5], [128.0, 128.0], largest_pixel_bandwidth(0)), 0.5);
    assert_eq!(pixel_bandwidth(1e6, [1.0, 0.5], [128.0, 128.0], largest_pixel_bandwidth(2)), 2.0);
    assert_eq!(pixel_bandwidth(0.0, [1.0, 0.5], [128.0, 128.0], 0.5), 0.0);
}

#[test]
fn levels_by_hand() {
    for (bandwidth, level) in [
        (0.5, 0),
        (0.4, 0),
        (0.25, 1),
        (0.250_000_03, 0),
        (0.249_999_98, 1),
        (0.125, 2),
        (0.001, 8),
        (1.0, -1),
        (2.0, -2),
        (1.5, -2),
        (0.0, 9),
        (1e-45, 9),
        (1e-6, 9),
    ] {
        assert_eq!(pyramid_level(bandwidth, 9), level, "{bandwidth}");
    }
    // The Nyquist rate is met, and the next coarser level would miss it.
    for step in 1..2000 {
        let bandwidth = step as f32 * 7.7e-4;
        let level = pyramid_level(bandwidth, 100);
        let rate = (-level as f32).exp2();
        assert!(rate >= 2.0 * bandwidth && 0.5 * rate < 2.0 * bandwidth, "{bandwidth}: {level}");
    }
}

#[test]
fn variance_by_hand() {
    let even = VarianceEstimate::default().add(3.0, 1.0, 2.0).add(3.0, 1.0, 2.0);
    assert_eq!(even.relative(0.0), 4.0);
    // All light from one direction gives twice the variance. The printed sum of the paper does not change.
    let uneven = VarianceEstimate::default().add(3.0, 1.0, 4.0).add(3.0, 1.0, 0.0);
    assert_eq!(uneven.relative(0.0), 8.0);
    // Exposure changes nothing, unless the pixel is below `darkest`.
    let dim = VarianceEstimate::default().add(3.0, 1.0, 0.25).add(3.0, 1.0, 0.25);
    assert_eq!((dim.relative(0.0), dim.relative(0.125), dim.relative(0.5)), (4.0, 4.0, 1.0));
}

#[test]
fn samples_by_hand() {
    assert_eq!(sample_count(4.0, 2.5, 4, 64), 10);
    assert_eq!(sample_count(4.1, 2.5, 4, 64), 11);
    assert_eq!((sample_count(0.0, 2.5, 4, 64), sample_count(1e9, 1e9, 4, 64)), (4, 64));
    let scale = sample_scale(8.0, 100.0);
    assert_eq!((scale, sample_count(8.0, scale, 1, 1000)), (12.5, 100));
    assert_eq!(sample_scale(0.0, 100.0), 0.0);
}
