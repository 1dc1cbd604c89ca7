//! Encodes of committed inputs are the bytes, and decode to the values, in the codec's list: see docs/goldens.md.

use brdfc_metrics::fraction::Fraction;
use brdfc_source::open::open;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::options::EncodeOptions as Options;
use brdfc_wavelet::recipe::Recipe;

/// One wavelet pack with the options of the command line.
fn wavelet(input: &str, options: &Options, change: impl FnOnce(&mut Recipe)) -> Vec<u8> {
    let mut recipe = options.resolve(&Options::default()).expect("options in range");
    change(&mut recipe);
    let opened = open(input, None).unwrap_or_else(|error| panic!("{error}"));
    encode(opened.source.as_ref(), &recipe, &()).unwrap_or_else(|error| panic!("{error}")).bytes
}

#[test]
fn wavelet_packs() {
    let grey = "synth:ward?kd=0.2&ks=0.25&ax=0.2&ay=0.5".to_owned();
    let rgb = testdata("demo/red_plastic.binary");
    let options = |parameterisation: &str, bits: u32| Options {
        grid: Some(8),
        bits: Some(bits),
        parameterisation: Some(parameterisation.to_owned()),
        ratio: Some(8.0),
        ..Options::default()
    };
    let mut packs = Packs::new();
    for parameterisation in ["tangent-pole", "half-difference"] {
        for bits in [8, 16] {
            for (channels, input) in [("grey", &grey), ("rgb", &rgb)] {
                let pack = wavelet(input, &options(parameterisation, bits), |_| {});
                packs.insert(format!("{parameterisation}-{bits}-{channels}.ktx2"), pack);
            }
        }
    }
    // What else decides which slices there are and what is in them.
    let twelve = options("tangent-pole", 12);
    let fabric = "synth:velvet?kd=0.1,0.2,0.4";
    let visible = Options {
        ratio: None,
        max_error: Some(Fraction::bare(0.1)),
        ranking: Some("visible".to_owned()),
        ..twelve.clone()
    };
    packs.insert("visible-max-error-12-rgb.ktx2".to_owned(), wavelet(fabric, &visible, |_| {}));
    let smooth = Options { ratio: None, max_bytes: Some(4000), smooth: Some(true), bias: Some(0.001), ..twelve };
    packs.insert("smooth-max-bytes-12-rgb.ktx2".to_owned(), wavelet(fabric, &smooth, |_| {}));
    let coarse = wavelet(&grey, &options("tangent-pole", 8), |recipe| {
        (recipe.stored_levels, recipe.supercompress) = (2, false);
    });
    packs.insert("coarse-8-grey-uncompressed.ktx2".to_owned(), coarse);
    check_encodes("wavelet", &packs, |_| true);
}
