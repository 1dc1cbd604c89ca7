//! Committed packs, those of other writers among them, are read to the values in their lists: see docs/goldens.md.

use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::container::Texture;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::flat_btf::factored::ShadowFormat;
use brdfc_formats::flat_btf::{DiffuseMap, FlatBtfDecoder, FlatBtfFile, FlatBtfParts, FlatValues};
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_testing::flat_btf::{Factors, SMALL, Sizes, displacements, factored, factored_example, mask, parts};
use brdfc_testing::golden::corpus::{add, entries, entry, packs};
use brdfc_testing::golden::lists::{codecs, corpus, encodes};
use brdfc_testing::golden::values::of_pack;
use brdfc_testing::golden::{Hashes, blessing, changes, foreign};
use brdfc_testing::packs::{Numbers, sealed};

/// Compares every codec's committed packs with their list. Blessing first adds those that are made here.
#[test]
fn committed_packs_are_read_to_the_same_values() {
    assert!(codecs().len() >= 5, "{:?}", codecs());
    for codec in codecs() {
        let made = match codec {
            "wavelet" => wavelet_packs(),
            "flat_btf" => flat_btfs(),
            "bandwidth" => bandwidth_maps(),
            "importance" => importance_samples(),
            "pwt" => polynomial_wavelet_trees(),
            _ => Vec::new(),
        };
        if blessing() {
            made.iter().for_each(|(name, bytes)| add(codec, name, bytes));
        }
        corpus(codec).check(entries(&packs(codec)), |_| String::new());
    }
}

/// Packs by name.
type Made = Vec<(String, Vec<u8>)>;

fn wavelet_packs() -> Made {
    // Texels of 12 bits that are no steps, and of the fourth component whatever there is.
    let twelve =
        brdfc_testing::packs::pack(brdfc_testing::packs::header(Parameterisation::HalfDifference, 2, 3, 12), 5, 1)
            .to_bytes(false);
    let mut coarse = brdfc_testing::packs::header(Parameterisation::TangentPole, 3, 1, 8);
    coarse.stored_levels = 1;
    let coarse = brdfc_testing::packs::pack(coarse, 3, 2);
    let mut made = vec![
        ("page-example".to_owned(), brdfc_testing::packs::example().to_bytes(false)),
        ("coarse-levels-8-grey".to_owned(), coarse.to_bytes(false)),
        ("coarse-levels-8-grey-zstandard".to_owned(), coarse.to_bytes(true)),
        ("any-texels-12-rgb".to_owned(), twelve.clone()),
    ];
    made.extend(foreign_forms("any-texels-12-rgb", &twelve));
    made
}

fn flat_btfs() -> Made {
    let mut numbers = Numbers::new(5);
    let made = parts(SMALL, 7);
    // A writer makes the least exponent that does; a reader takes any word.
    let texels = (0..SMALL.flat * SMALL.flat).map(|_| numbers.bits()).collect();
    let diffuse = DiffuseMap::new(SMALL.flat, texels).expect("any words");
    let light = FlatBtfParts { diffuse, values: FlatValues::None, ..made.clone() };
    let factors = Factors { levels: 3, groups: 3, wide_groups: 1, shadow: ShadowFormat::R8 };
    let values = FlatValues::Factored(Box::new(factored(SMALL, factors, 5)));
    // Two blocks along each side, for a reference of four texels.
    let Sizes { reference, .. } = SMALL;
    let fine = parts(Sizes { reference: 2 * reference, ..SMALL }, 13);
    let indirection = displacements(SMALL, reference, 17).into();
    let compact = FlatBtfParts { indirection, values, ..fine };
    // Its values follow rules that a decoder in another language was written for.
    let example = FlatBtfParts { values: FlatValues::Factored(Box::new(factored_example())), ..made };
    let file = |parts: FlatBtfParts, mask| {
        FlatBtfFile::new(FlatBtfDecoder::new(parts).expect("parts of one asset"), mask).expect("what a file has")
    };
    let files = [
        ("any-texels", file(light, Some(mask(SMALL, 11)))),
        ("factored", file(compact, Some(mask(SMALL, 11)))),
        ("example", file(example, None)),
    ];
    let mut packs: Made = Vec::new();
    for (name, file) in files {
        let bytes = file.to_bytes(false);
        packs.extend(foreign_forms(name, &bytes));
        packs.push((name.to_owned(), bytes));
    }
    packs
}

fn bandwidth_maps() -> Made {
    let mut numbers = Numbers::new(4);
    let values: Vec<f32> = (0..15).map(|_| numbers.between(0.0, 40.0) as f32).collect();
    let header = BandwidthHeader { kind: BandwidthKind::Environment, epsilon: 0.02, transformed: [64, 32] };
    let map = BandwidthMap::new(header, [5, 3], &values).expect("values in range").to_bytes(false);
    // A writer takes the least scale that does.
    let mut texture = Texture::from_bytes(&map).expect("our own map");
    let entry = texture.entries.get_mut("brdfc.bandwidth").expect("the entry of a map");
    entry[36..].copy_from_slice(&64f32.to_le_bytes());
    // The uniform block begins with it.
    let block = texture.entries.get_mut("brdfc.uniform.bandwidth_environment_parameters").expect("the block of a map");
    block[..4].copy_from_slice(&64f32.to_le_bytes());
    let scaled = sealed(texture.to_bytes(false));
    let mut made = vec![("environment-scaled".to_owned(), scaled.clone())];
    made.extend(foreign_forms("environment-scaled", &scaled));
    made
}

fn importance_samples() -> Made {
    let header = ImportanceHeader { polar: 2, azimuths: 4, samples: 3 };
    let mut numbers = Numbers::new(6);
    let mut texel = |_| {
        let [p, q] = [0; 2].map(|_| numbers.between(-0.7, 0.7));
        let square = p * p + q * q;
        // Not quite of length 1.
        let length = numbers.between(0.999_997, 1.000_003) / (1.0 + square);
        let half = [2.0 * p, 2.0 * q, 1.0 - square].map(|c| (c * length) as f32);
        [half[0], half[1], half[2], numbers.between(0.01, 90.0) as f32]
    };
    let texels = (0..header.rows() * header.samples).map(&mut texel).collect();
    let bytes = ImportancePack::new(header, texels).expect("half vectors with densities").to_bytes(false);
    let mut made = vec![("any-samples".to_owned(), bytes.clone())];
    made.extend(foreign_forms("any-samples", &bytes));
    made
}

fn polynomial_wavelet_trees() -> Made {
    let packs = brdfc_testing::pwt::packs();
    let mut made = vec![("page-example".to_owned(), brdfc_testing::pwt::example().to_bytes(false))];
    made.extend(packs.iter().map(|(name, pack)| (format!("any-texels-{name}"), pack.to_bytes(false))));
    let (name, pack) = &packs[0];
    made.push((format!("any-texels-{name}-zstandard"), pack.to_bytes(true)));
    made.extend(foreign_forms(&format!("any-texels-{name}"), &pack.to_bytes(false)));
    made
}

/// The same texture in every other form of file.
fn foreign_forms(name: &str, bytes: &[u8]) -> Made {
    let form = |k: usize| (format!("{name}-foreign-{}", foreign::FORMS[k]), foreign::form(k, bytes));
    (0..foreign::FORMS.len()).map(form).collect()
}

#[test]
fn every_pack_is_read_alike_in_every_form_of_file() {
    for codec in codecs() {
        let packs = packs(codec);
        let ours: Vec<_> = packs.iter().filter(|(file, _)| !file.contains("foreign")).collect();
        assert!(!ours.is_empty(), "no packs of {codec}");
        for (file, bytes) in ours {
            let values = |bytes: &[u8]| of_pack(bytes).unwrap_or_else(|error| panic!("{file}: {error}"));
            for (k, form) in foreign::FORMS.into_iter().enumerate() {
                let other = foreign::form(k, bytes);
                assert!(other != *bytes, "{file}, {form}: the same file");
                assert_eq!(values(&other), values(bytes), "{codec}/{file}, {form}");
            }
        }
    }
}

/// The negative control: a list notices a texel that is another, and a pack that a reader refuses.
#[test]
fn a_changed_byte_of_any_pack_is_noticed() {
    for codec in codecs() {
        let packs = packs(codec);
        let listed = entries(&packs);
        for (file, bytes) in packs.iter().filter(|(file, _)| !file.contains("foreign")) {
            let is_noticed = |back: usize| {
                let mut broken = bytes.clone();
                broken[bytes.len() - back] ^= 1;
                // Behind the checksum, which notices every bit.
                let broken = sealed(broken);
                let mut found = listed.clone();
                found.insert(file.clone(), entry(&broken));
                let moved: Vec<&str> = changes(&listed, &found).iter().map(|change| change.column).collect();
                assert!(moved.contains(&"file"), "{codec}/{file}: {moved:?}");
                moved.contains(&"values")
            };
            // A colour in the last texels of all formats, or the last block of a frame, or a byte before: a frame may tell a
            // run of zeros in several ways.
            assert!(is_noticed(8) || is_noticed(32), "{codec}/{file}");
        }
    }
}

/// What a message says, from which hashes moved.
#[test]
fn failures_name_the_half_that_moved() {
    let said = |list: brdfc_testing::golden::List, moved: &[&str]| {
        let hash = |column: &str, then: bool| if then || !moved.contains(&column) { "old" } else { "new" }.to_owned();
        let hashes = |then| -> Hashes { list.columns.iter().map(|c| (c.name, hash(c.name, then))).collect() };
        let entries = |then| [("pack".to_owned(), hashes(then))].into();
        let text = list.explain(&changes(&entries(true), &entries(false)));
        moved.iter().for_each(|column| assert!(text.contains(&format!("{column} old -> new")), "{text}"));
        text
    };
    for (moved, half) in [
        (&["contents", "file", "values"][..], "pack: bytes and values moved: the forward half"),
        (&["contents", "errors", "file"], "pack: bytes moved, values hold: the forward half"),
        (&["errors", "file", "reflectances", "values"], "pack: values moved, what is stored holds: the inverse half"),
        (&["reflectances"], "pack: values moved, what is stored holds: the inverse half"),
        (&["errors", "file"], "pack: measured errors moved"),
        (&["file"], "pack: bytes of the file moved"),
    ] {
        assert!(said(encodes("wavelet"), moved).contains(half), "{moved:?}");
    }
    assert!(said(corpus("wavelet"), &["values"]).contains("the inverse half"));
    assert!(said(corpus("wavelet"), &["file", "values"]).contains("not the one that was committed"));
}
