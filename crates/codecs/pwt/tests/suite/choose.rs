//! Tests choices with a known optimum.

use super::stacks::{polynomial, spiral};
use brdfc_formats::pwt::{LightBasis, LightCoordinates};
use brdfc_pwt::candidates::decibels;
use brdfc_pwt::choose::choose;
use brdfc_pwt::degrees::degrees;
use brdfc_pwt::design::Design;
use brdfc_pwt::image::Plane;
use brdfc_pwt::tree::{PacketTree, Transform};
use brdfc_pwt::{Border, DomainName, PwtRecipe, Wavelet};

#[test]
fn the_original_basis_is_found() {
    let samples = polynomial([16, 16], spiral(30), false);
    let fixed = PwtRecipe { domain: Some(DomainName::Linear), ..PwtRecipe::default() };
    let found = choose(&samples, &fixed).unwrap().candidates;
    let best = found[0];
    assert_eq!((best.coordinates, best.domain), (LightCoordinates::Projected, DomainName::Linear));
    assert!(best.degree >= 1 && best.held_out_psnr > Some(55.0), "{best:?}");
    assert_eq!(found.len(), 3, "one for each pair of domain and coordinates");
    assert!(found.windows(2).all(|pair| pair[0].held_out_psnr >= pair[1].held_out_psnr));
    // Requested settings are always used.
    let asked =
        PwtRecipe { coordinates: Some(LightCoordinates::Hemisphere), degree: Some(0), ridge: Some(0.5), ..fixed };
    let found = choose(&samples, &asked).unwrap().candidates;
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].coordinates, found[0].degree, found[0].ridge), (LightCoordinates::Hemisphere, 0, 0.5));
    assert!(found[0].held_out_psnr.unwrap() < best.held_out_psnr.unwrap() - 20.0, "{found:?}");
    // All domains, if none is requested.
    let all = choose(&samples, &PwtRecipe::default()).unwrap().candidates;
    assert!(DomainName::ALL.iter().all(|domain| all.iter().any(|candidate| candidate.domain == *domain)));
}

#[test]
fn decibels_by_hand() {
    assert!((decibels(0.01) - 20.0).abs() < 1e-9 && decibels(1.0).abs() < 1e-9);
    assert!((decibels(0.0) - 96.33).abs() < 0.01);
}

/// The low-pass subband follows the light with degree 2; details are noise independent of the light.
#[test]
fn subbands_have_the_degree_that_predicts_them() {
    let lights = spiral(40);
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 4 };
    let design = Design::new(basis, &lights, 1e-8);
    let transform = Transform { wavelet: Wavelet::Haar, border: Border::Periodic, depth: 2 };
    let tree = PacketTree::pyramid(transform, [32, 32]);
    let mut state = 1u32;
    let mut noise = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut plane = |light: &[f32; 3]| {
        let terms = basis.evaluate(*light);
        let low = |k: usize| terms[0] + k as f32 * 0.01 * terms[1] - 0.5 * terms[3] + terms[5];
        let values = (0..1024).map(|k| 3.0 * low(k % 32 / 4 + k / 128) + 0.01 * noise());
        Plane { size: [32, 32], values: values.collect() }
    };
    let planes = lights.iter().map(&mut plane).collect();
    let found = degrees(&design, &tree, planes, None);
    assert_eq!(found.len(), 7);
    assert_eq!(found[0].degree, Some(2), "{:?}", found[0]);
    assert!(found[0].held_out < 1e-3 * found[0].energy);
    for detail in &found[1..] {
        assert!(detail.degree.is_none_or(|degree| degree == 0), "{detail:?}");
        assert!(detail.held_out <= detail.energy && detail.held_out > 0.5 * detail.energy, "{detail:?}");
    }
}
