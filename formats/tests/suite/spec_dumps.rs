//! Dumps on the specification pages equal the bytes of files made by these tests.

use brdfc_formats::bindings::{Binding, Bindings, PackFile, Texels};
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::flat_btf::factored::shader::FactoredParameters;
use brdfc_formats::flat_btf::shader::FlatBtfParameters;
use brdfc_formats::flat_btf::{FlatBtfFile, LayerHeader, LayerMap, Sheet};
use brdfc_formats::pwt::shader::PwtParameters;
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_formats::wavelet::{Filter, RowScratch, WaveletDecoder, WaveletPack};
use brdfc_testing::codecs::flat_btf::{BASE, Factors, SMALL, Sizes, factored, file};
use brdfc_testing::packs::check_dump;
use std::collections::BTreeMap;

#[test]
fn containers() {
    let page = include_str!("../../src/container/spec.md");
    let bytes = brdfc_testing::codecs::wavelet::example().to_bytes(false);
    assert!(Texture::from_bytes(&bytes).is_ok());
    // The omitted bytes are on the page of wavelet packs.
    assert_eq!(check_dump(page, &bytes), 15);
}

/// The pack of a fictitious codec on the page of bindings.
fn stripes() -> Bindings<'static> {
    let texels = |width, bytes: &'static [u8]| Texels::new(TexelFormat::R8Unorm, Extent::D2([width, 1]), bytes);
    let width = [0.25f32, 0.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
    let all = [
        Binding::frame(),
        Binding::uniform(1, "stripes_width", width),
        Binding::texture(2, "stripes_texels", texels(2, &[0, 255]).of_file().sampled("stripes_sampler")),
        Binding::texture(3, "stripes_tint", texels(1, &[204])),
        Binding::sampler(4, "stripes_sampler", true),
    ];
    Bindings::new("stripes", 1, all)
}

#[test]
fn bindings() {
    let page = include_str!("../../src/bindings/spec.md");
    let bytes = stripes().to_file(BTreeMap::new(), false);
    assert_eq!(PackFile::from_bytes(&bytes).unwrap().bindings, stripes());
    assert_eq!(check_dump(page, &bytes), 35);
    for format in TexelFormat::ALL {
        assert!(page.contains(&format!("`{}`", format.name())), "{}", format.name());
    }
}

#[test]
fn wavelet_packs() {
    let page = include_str!("../../src/wavelet/spec.md");
    let bytes = brdfc_testing::codecs::wavelet::example().to_bytes(false);
    assert_eq!(WaveletPack::from_bytes(&bytes).unwrap(), brdfc_testing::codecs::wavelet::example());
    assert_eq!(check_dump(page, &bytes), 44);
}

/// A file with the layers of the page.
fn example_flat_btf() -> FlatBtfFile {
    let header = LayerHeader { size: 2, sheets: 1, levels: 2, heights: [-0.25, 0.75] };
    let layers = LayerMap::new(header, vec![51; 5], vec![[0.0; 2]; 1]).unwrap();
    file(layers, factored(Sizes { flat: 2, ..SMALL }, Factors { levels: 2, ..BASE }, 1))
}

#[test]
fn flat_btfs() {
    let page = include_str!("../../src/flat_btf/spec.md");
    let file = PackFile::from_bytes(&example_flat_btf().to_bytes(false)).unwrap();
    let entry = &file.entries["brdfc.flat-btf.layers"];
    assert_eq!(check_dump(page, entry), 2);
    for word in entry.as_chunks::<4>().0 {
        let [a, b, c, d] = word;
        assert!(page.contains(&format!("`{a:02x} {b:02x} {c:02x} {d:02x}`")), "{word:x?}");
    }
    for uniform in [FlatBtfParameters::SIZE, FactoredParameters::SIZE] {
        let factored = include_str!("../../src/flat_btf/factored/spec.md");
        let text = format!("a uniform block of {uniform} bytes");
        assert!([page, factored].iter().any(|page| page.contains(&text)), "{text}");
    }
}

/// The worked value after the dump.
#[test]
fn the_worked_value_of_the_flat_btf_page() {
    let decoder = example_flat_btf().decoder;
    let (point, parameters) = decoder.seen([0.2, 0.7], [0.6, 0.0, 0.8], 0.0);
    assert!((point.height - 0.2).abs() < 1e-6 && point.sheet == Sheet::Base, "{point:?}");
    for found in [point.at, parameters] {
        assert!((found[0] - 0.1625).abs() < 1e-6 && (found[1] - 0.7).abs() < 1e-6, "{found:?}");
    }
    assert!(include_str!("../../src/flat_btf/spec.md").contains("`(0.1625, 0.7)`"));
}

/// The worked values at the end of the page.
#[test]
fn the_worked_values_of_the_wavelet_page() {
    let page = include_str!("../../src/wavelet/spec.md");
    let (_, foot) = page.split_once("For `wi = (0, 0.6, 0.8)` and `wo = (0.6, 0, 0.8)`").expect("the pair");
    let decoder = WaveletDecoder::new(&brdfc_testing::codecs::wavelet::example());
    let pair = DirectionPair::new([0.0, 0.6, 0.8], [0.6, 0.0, 0.8]);
    for (filter, level, v, f) in [
        (Filter::Nearest, 1.0, "-0.676777", "0.249126"),
        (Filter::Nearest, 0.0, "-1 / 2", "0.298265"),
        (Filter::Bilinear, 1.0, "-0.241379", "0.387772"),
        (Filter::Bilinear, 0.0, "-0.219447", "0.396481"),
    ] {
        assert!(foot.contains(v) && foot.contains(f), "{v} {f}");
        let [found, ..] = decoder.log_value(pair, level, filter);
        let expected = v.parse().unwrap_or(-0.5f32);
        assert!((found - expected).abs() < 1e-6, "{found} {v}");
        let [found, ..] = decoder.eval(pair, level, filter);
        assert!((found - f.parse::<f32>().unwrap()).abs() < 1e-6, "{found} {f}");
    }
    // The same cells, decoded as a row.
    let mut row = [0.0; 4];
    decoder.decode_row(0, 0, &mut row, &mut RowScratch::default());
    let f = decoder.from_log(row[1]);
    assert!((row[1] + 0.676_777).abs() < 1e-6 && (f - 0.249_126).abs() < 1e-6, "{} {f}", row[1]);
}

#[test]
fn polynomial_wavelet_trees() {
    let page = include_str!("../../src/pwt/spec.md");
    let example = brdfc_testing::codecs::pwt::example();
    let bytes = example.to_bytes(false);
    assert_eq!(PwtPack::from_bytes(&bytes).unwrap(), example);
    assert_eq!(check_dump(page, &bytes), 105);
    assert!(page.contains(&format!("a uniform block of {} bytes", PwtParameters::SIZE)));
    // The worked values at the end of the page.
    let decoder = PwtDecoder::new(example);
    for (uv, expected) in [([0.25, 0.25], 0.09), ([0.5, 0.5], 0.49)] {
        let [value, ..] = decoder.value(uv, 0.0, [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]);
        assert!((value - expected).abs() < 1e-6 && page.contains(&format!("= {expected}`")), "{uv:?} {value}");
    }
}
