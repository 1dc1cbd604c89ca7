//! Encodings of committed inputs have the bytes, and decode to the values, in the codec's list: see docs/goldens.md.

use brdfc_formats::direction::Parameterisation;
use brdfc_source::open::open;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::{Ranking, Recipe, Target};

fn wavelet(input: &str, recipe: &Recipe) -> Vec<u8> {
    let opened = open(input, None).unwrap_or_else(|error| panic!("{error}"));
    encode(opened.source.as_ref(), recipe, &()).unwrap_or_else(|error| panic!("{error}")).bytes
}

#[test]
fn wavelet_packs() {
    let grey = "synth:ward?kd=0.2&ks=0.25&ax=0.2&ay=0.5".to_owned();
    let rgb = testdata("demo/red_plastic.binary");
    let recipe = |parameterisation, bits| Recipe {
        levels: 3,
        stored_levels: 3,
        bits,
        parameterisation,
        target: Target::Ratio(8.0),
        ..Recipe::default()
    };
    let mut packs = Packs::new();
    for (name, parameterisation) in Parameterisation::NAMES {
        for bits in [8, 16] {
            for (channels, input) in [("grey", &grey), ("rgb", &rgb)] {
                packs.insert(format!("{name}-{bits}-{channels}.ktx2"), wavelet(input, &recipe(parameterisation, bits)));
            }
        }
    }
    // Other options that decide the slices and their contents.
    let twelve = recipe(Parameterisation::TangentPole, 12);
    let fabric = "synth:velvet?kd=0.1,0.2,0.4";
    let visible = Recipe { target: Target::MaxError(0.1), ranking: Ranking::Visible, ..twelve.clone() };
    packs.insert("visible-max-error-12-rgb.ktx2".to_owned(), wavelet(fabric, &visible));
    let small = Recipe { target: Target::MaxBytes(4000), bias: 0.001, ..twelve };
    packs.insert("max-bytes-12-rgb.ktx2".to_owned(), wavelet(fabric, &small));
    let coarse = Recipe { stored_levels: 2, supercompress: false, ..recipe(Parameterisation::TangentPole, 8) };
    packs.insert("coarse-8-grey-uncompressed.ktx2".to_owned(), wavelet(&grey, &coarse));
    let energy_preserving = |bits| Recipe { energy_preserving: true, ..recipe(Parameterisation::TangentPole, bits) };
    packs.insert("energy_preserving-8-grey.ktx2".to_owned(), wavelet(&grey, &energy_preserving(8)));
    packs.insert("energy_preserving-12-rgb.ktx2".to_owned(), wavelet(&rgb, &energy_preserving(12)));
    check_encodes("wavelet", &packs, |_| true);
}
