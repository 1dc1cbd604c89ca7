//! Encodes generated RTI captures and compares the bytes, and the decoded values, with the codec's list: see
//! docs/goldens.md.

use super::stacks::{lambert, polynomial, shiny, spiral};
use brdfc_formats::pwt::LightCoordinates;
use brdfc_pwt::{DomainName, LightSamples, PwtRecipe, Target, Wavelet, encode};
use brdfc_testing::golden::encodes::{Packs, check_encodes};

#[test]
fn polynomial_wavelet_trees() {
    let pack = |samples: &LightSamples, recipe: PwtRecipe| {
        encode(samples, &recipe).expect("images and recipe in range").pack.to_bytes(true)
    };
    let default = PwtRecipe::default();
    let hemisphere = PwtRecipe {
        coordinates: Some(LightCoordinates::Hemisphere),
        degree: Some(3),
        ridge: Some(1e-4),
        domain: Some(DomainName::CubeRoot),
        wavelet: Wavelet::Cdf97,
        depth: Some(3),
        packets: 2,
        max_fetches: None,
        target: Target::Energy(0.99),
    };
    let logarithm = PwtRecipe { domain: Some(DomainName::Log), wavelet: Wavelet::Daubechies4, ..default };
    let learned = PwtRecipe { coordinates: Some(LightCoordinates::Learned), degree: Some(4), ..default };
    let lights = spiral(20);
    let packs = [
        ("lambert-default", pack(&lambert([13, 10], lights.clone(), false), default)),
        ("shiny-learned", pack(&shiny([20, 14], lights.clone()), learned)),
        ("lambert-tile-hemisphere-cube-root", pack(&lambert([16, 16], lights.clone(), true), hemisphere)),
        (
            "lambert-log-bytes",
            pack(&lambert([12, 9], lights.clone(), false), PwtRecipe { target: Target::Bytes(900), ..logarithm }),
        ),
        (
            "polynomial-quality",
            pack(&polynomial([16, 8], lights, true), PwtRecipe { target: Target::Quality(40.0), ..default }),
        ),
    ];
    let packs: Packs = packs.into_iter().map(|(name, bytes)| (format!("{name}.ktx2"), bytes)).collect();
    check_encodes("pwt", &packs, |_| true);
}
