//! RGL materials with known `f_r`.

use std::f32::consts::{FRAC_PI_2, PI};

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{DirectionPair, half_vector};
use brdfc_readers::rgl::{Azimuths, Rgl};
use brdfc_source::rgl::RglSource;
use brdfc_testing::tensor::Material;

/// RGB weights of the two wavelengths of the spectral materials here.
fn weights(wavelengths: &[f64]) -> Result<Vec<[f64; 3]>, FormatError> {
    assert_eq!(wavelengths, [400.0, 700.0]);
    Ok(vec![[0.0, 0.25, 1.0], [1.0, 0.75, 0.0]])
}

fn source(material: &Material) -> RglSource {
    RglSource::new(Rgl::from_bytes(&material.container().build()).unwrap(), weights).unwrap()
}

fn eval(source: &RglSource, pair: DirectionPair) -> [f64; 3] {
    source.eval(pair, &mut Tally::default())
}

fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found} instead of {expected}");
}

/// General directions all over the hemisphere.
fn pairs() -> impl Iterator<Item = DirectionPair> {
    (0..400).map(|k| {
        let k = f64::from(k);
        DirectionPair::from_angles(
            (0.31 + k * 0.618_034).fract() * 1.5,
            0.1 + k * 2.4,
            (0.17 + k * 0.414_214).fract() * 1.5,
            0.3 + k * 1.7,
        )
    })
}

/// `(u, v)` of the half vector, with the azimuth relative to `from`.
fn half_coordinates(pair: DirectionPair, from: f64) -> [f64; 2] {
    let [x, y, z] = half_vector(pair);
    let v = (y.atan2(x) - from) / std::f64::consts::TAU + 0.5;
    [(z.acos() * std::f64::consts::FRAC_2_PI).sqrt(), v - v.floor()]
}

fn azimuth(d: [f64; 3]) -> f64 {
    d[1].atan2(d[0])
}

#[test]
fn constant_tables_give_colour_times_density_over_projected_area() {
    let with = source(&Material::default());
    let without = source(&Material { jacobian: false, ..Material::default() });
    for pair in pairs() {
        let cos_o = pair.outgoing[2];
        for (k, colour) in [0.5, 0.25, 0.125].into_iter().enumerate() {
            assert_close(eval(&with, pair)[k], colour * 2.0 / (4.0 * 0.5) / cos_o);
            assert_close(eval(&without, pair)[k], colour / cos_o);
        }
    }
}

#[test]
fn the_warp_follows_the_density_along_both_axes() {
    let coordinate = Material { jacobian: false, colour: |at| [at.s, at.t, 1.0][at.channel], ..Material::default() };
    let uniform = source(&coordinate);
    let along_u = source(&Material { vndf: |u, _| 1.0 + u, nodes: 9, ..coordinate });
    let coordinate = Material { jacobian: false, colour: |at| [at.s, at.t, 1.0][at.channel], ..Material::default() };
    let along_v = source(&Material { vndf: |_, v| 3.0 + 3.0 * v, nodes: 9, ..coordinate });
    let integral = |x: f64| (x + x * x / 2.0) / 1.5;
    for pair in pairs() {
        let [u, v] = half_coordinates(pair, azimuth(pair.incoming));
        for (source, s, t) in [(&uniform, u, v), (&along_u, integral(u), v), (&along_v, u, integral(v))] {
            let [r, g, b] = eval(source, pair);
            assert_close(r / b, s);
            assert_close(g / b, t);
        }
    }
}

#[test]
fn tables_are_linear_between_polar_angles_of_incidence() {
    let material = Material {
        theta_i: vec![0.0, 0.5, FRAC_PI_2],
        jacobian: false,
        colour: |at| [0.0, 0.5, 2.5][at.theta],
        ..Material::default()
    };
    let source = source(&material);
    assert!(source.is_grey());
    for pair in pairs() {
        let theta = pair.incoming[2].acos();
        let expected = if theta < 0.5 { theta } else { 0.5 + 2.0 * (theta - 0.5) / (f64::from(FRAC_PI_2) - 0.5) };
        assert_close(eval(&source, pair)[0] * pair.outgoing[2], expected);
    }
}

/// Red is the table of the azimuth of incidence (0, ½ and 1 along the axis), green is `t`, blue is 1.
fn anisotropic(phi_i: [f32; 3]) -> Material {
    let colour = |at: brdfc_testing::tensor::At| [at.phi as f32 / 2.0, at.t, 1.0][at.channel];
    Material { phi_i: phi_i.to_vec(), jacobian: false, colour, nodes: 3, ..Material::default() }
}

#[test]
fn outside_the_measured_half_both_directions_turn_by_half_a_turn() {
    for first in [-PI, 0.0, -FRAC_PI_2, FRAC_PI_2, PI] {
        let material = anisotropic([first, first + FRAC_PI_2, first + PI]);
        assert_eq!(Rgl::from_bytes(&material.container().build()).unwrap().azimuths, Azimuths::HalfTurn);
        let source = source(&material);
        for pair in pairs() {
            let half_turn = std::f64::consts::PI;
            let along = (azimuth(pair.incoming) - f64::from(first)).rem_euclid(2.0 * half_turn);
            let turned = along >= half_turn;
            let [_, v] = half_coordinates(pair, if turned { half_turn } else { 0.0 });
            let [r, g, b] = eval(&source, pair);
            assert_close(r / b, if turned { along - half_turn } else { along } / half_turn);
            assert_close(g / b, v);
        }
    }
}

#[test]
fn outside_the_measured_quadrant_both_directions_are_mirrored() {
    for quadrant in 0..4u8 {
        let first = -PI + f32::from(quadrant) * FRAC_PI_2;
        let material = anisotropic([first, first + FRAC_PI_2 / 2.0, first + FRAC_PI_2]);
        assert_eq!(Rgl::from_bytes(&material.container().build()).unwrap().azimuths, Azimuths::Quadrant);
        let source = source(&material);
        // Quadrants counted from -π: x is negative in the outer two, y in the first two.
        let (x_sign, y_sign) =
            (if matches!(quadrant, 0 | 3) { -1.0 } else { 1.0 }, if quadrant < 2 { -1.0 } else { 1.0 });
        for pair in pairs() {
            let flip = [pair.incoming[0].signum() * x_sign, pair.incoming[1].signum() * y_sign, 1.0];
            let mirror = |d: [f64; 3]| [d[0] * flip[0], d[1] * flip[1], d[2]];
            let inside = DirectionPair::new(mirror(pair.incoming), mirror(pair.outgoing));
            let [r, g, b] = eval(&source, pair);
            let along = (azimuth(inside.incoming) - f64::from(first)) / f64::from(FRAC_PI_2);
            assert!((0.0..=1.0).contains(&along));
            assert_close(r / b, along);
            assert_close(g / b, half_coordinates(inside, 0.0)[1]);
            assert_eq!(eval(&source, inside), [r, g, b]);
        }
    }
}

#[test]
fn known_answers_of_the_reductions() {
    // Light at azimuth 2.5: half a turn takes it to 2.5 - π, mirroring to -2.5 (y only).
    let pair = DirectionPair::from_angles(0.5, 2.5, 0.0, 0.0);
    let half = source(&anisotropic([-PI, -FRAC_PI_2, 0.0]));
    let [r, g, b] = eval(&half, pair);
    assert_close(r / b, 2.5 / std::f64::consts::PI);
    assert_close(g / b, (2.5 - std::f64::consts::PI) / std::f64::consts::TAU + 0.5);
    let quadrant = source(&anisotropic([-PI, -0.75 * PI, -FRAC_PI_2]));
    let [r, g, b] = eval(&quadrant, pair);
    assert_close(r / b, 2.0 * (std::f64::consts::PI - 2.5) / std::f64::consts::PI);
    assert_close(g / b, 0.5 - 2.5 / std::f64::consts::TAU);
}

#[test]
fn a_whole_circle_is_looked_up_as_it_is_and_its_ends_meet() {
    let source = source(&anisotropic([-PI, 0.0, PI]));
    for pair in pairs() {
        let [r, _, b] = eval(&source, pair);
        assert_close(r / b, 0.5 + azimuth(pair.incoming) / std::f64::consts::TAU);
    }
    // Azimuth +π is at the end of the half -π to 0 that is written -π.
    let half = self::source(&anisotropic([-PI, -FRAC_PI_2, 0.0]));
    let [r, _, b] = eval(&half, DirectionPair::new([-0.6, 0.0, 0.8], [0.0, 0.6, 0.8]));
    assert_close(r / b, 0.0);
}

#[test]
fn spectra_become_weighted_sums_and_a_flat_spectrum_is_grey() {
    let flat = Material { wavelengths: Some(vec![400.0, 700.0]), colour: |_| 0.3, ..Material::default() };
    let flat = source(&flat);
    let steep =
        Material { wavelengths: Some(vec![400.0, 700.0]), colour: |at| [2.0, 4.0][at.channel], ..Material::default() };
    let steep = source(&steep);
    assert!(flat.is_grey() && !steep.is_grey());
    for pair in pairs() {
        let cos_o = pair.outgoing[2];
        assert_close(eval(&flat, pair)[0] * cos_o, 0.3);
        let [r, g, b] = eval(&steep, pair);
        assert_close(r * cos_o, 4.0);
        assert_close(g * cos_o, 3.5);
        assert_close(b * cos_o, 2.0);
    }
}

#[test]
fn weights_are_checked() {
    let material = Material { wavelengths: Some(vec![400.0, 700.0]), colour: |_| 3e38, ..Material::default() };
    let rgl = Rgl::from_bytes(&material.container().build()).unwrap();
    let error = RglSource::new(rgl.clone(), |_| Ok(vec![[1.0; 3]])).unwrap_err();
    assert_eq!(error.to_string(), "colour weights: found 1 weights, expected 2, one per wavelength");
    let error = RglSource::new(rgl.clone(), |_| Ok(vec![[1.0; 3]; 2])).unwrap_err();
    assert_eq!(error.field, "linear RGB");
    let error = RglSource::new(rgl, |_| Err(FormatError::whole("wavelengths", "a gap", "none"))).unwrap_err();
    assert_eq!(error.field, "wavelengths");
}

#[test]
fn nothing_is_reflected_below_the_horizon_and_every_evaluation_counts() {
    let source = source(&Material::default());
    let mut tally = Tally::default();
    let (up, down, flat) = ([0.0, 0.6, 0.8], [0.0, 0.6, -0.8], [1.0, 0.0, 0.0]);
    for (i, o) in [(up, down), (down, up), (flat, up), (up, flat)] {
        assert_eq!(source.eval(DirectionPair::new(i, o), &mut tally), [0.0; 3]);
    }
    assert_eq!(tally, Tally { evaluations: 4, ..Tally::default() });
}

#[test]
fn a_projected_area_of_zero_at_the_horizon_stays_finite() {
    let mut container = Material::default().container();
    container.field("sigma").data = [1.0f32, 0.0, 1.0, 0.0].into_iter().flat_map(f32::to_le_bytes).collect();
    let source = RglSource::new(Rgl::from_bytes(&container.build()).unwrap(), weights).unwrap();
    for z in [1e-3f64, 1e-9, 1e-18, 1e-300, f64::MIN_POSITIVE] {
        let pair = DirectionPair::new([(1.0 - z * z).sqrt(), 0.0, z], [0.0, 0.6, 0.8]);
        assert!(eval(&source, pair).iter().all(|v| v.is_finite()), "{z}");
    }
}

#[test]
fn symmetry_is_claimed_only_where_the_tables_have_it() {
    let isotropic = Symmetry { isotropic: true, ..Symmetry::NONE };
    assert_eq!(source(&Material::default()).symmetry(), isotropic);
    let equal = Material { phi_i: vec![0.0, 1.0], ..Material::default() };
    assert_eq!(source(&equal).symmetry(), isotropic);
    let unequal = Material { phi_i: vec![0.0, 1.0], colour: |at| at.phi as f32, ..Material::default() };
    assert_eq!(source(&unequal).symmetry(), Symmetry::NONE);
    assert_eq!(source(&anisotropic([-PI, -FRAC_PI_2, 0.0])).symmetry(), Symmetry::NONE);
    let mut uneven = Material::default().container();
    uneven.field("sigma").data = [1.0f32, 0.5, 0.9, 0.5].into_iter().flat_map(f32::to_le_bytes).collect();
    let uneven = RglSource::new(Rgl::from_bytes(&uneven.build()).unwrap(), weights).unwrap();
    assert_eq!(uneven.symmetry(), Symmetry::NONE);
}

#[test]
fn directions_without_an_azimuth_do_not_see_rounding_noise() {
    let source = source(&Material { colour: |at| at.t, ..Material::default() });
    for k in 0..50 {
        let phi = f64::from(k) * 0.37;
        let mirror = DirectionPair::from_angles(0.7, phi, 0.7, phi + std::f64::consts::PI);
        let normal = DirectionPair::from_angles(0.0, phi, 0.7, 2.0 * phi);
        assert_close(eval(&source, mirror)[0] * mirror.outgoing[2], 0.5);
        assert_close(eval(&source, normal)[0] * normal.outgoing[2], 0.5);
    }
}
