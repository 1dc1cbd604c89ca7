//! Committed packs, including those of other writers, decode to the values in their lists: see docs/goldens.md.

use brdfc_testing::codecs::{of_pack, tested};
use brdfc_testing::golden::corpus::{add, entries, entry, packs};
use brdfc_testing::golden::lists::{codecs, corpus, encodes, kind};
use brdfc_testing::golden::{Hashes, blessing, changes, foreign};
use brdfc_testing::packs::sealed;

/// Compares every codec's committed packs with their list. Blessing first adds packs that no encoder makes.
#[test]
fn committed_packs_are_read_to_the_same_values() {
    for codec in codecs() {
        if blessing() {
            tested(kind(codec)).committed().iter().for_each(|(name, bytes)| add(codec, name, bytes));
        }
        corpus(codec).check(entries(&packs(codec)), |_| String::new());
    }
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

/// Negative control: the comparison detects a changed texel and a rejected pack.
#[test]
fn a_changed_byte_of_any_pack_is_detected() {
    for codec in codecs() {
        let packs = packs(codec);
        let listed = entries(&packs);
        for (file, bytes) in packs.iter().filter(|(file, _)| !file.contains("foreign")) {
            let is_noticed = |back: usize| {
                let mut broken = bytes.clone();
                broken[bytes.len() - back] ^= 1;
                // With a valid checksum, which otherwise detects every bit.
                let broken = sealed(broken);
                let mut found = listed.clone();
                found.insert(file.clone(), entry(&broken));
                let moved: Vec<&str> = changes(&listed, &found).iter().map(|change| change.column).collect();
                assert!(moved.contains(&"file"), "{codec}/{file}: {moved:?}");
                moved.contains(&"values")
            };
            // A colour in the last texels of all formats, or the last block of a frame, or a byte before it: a frame
            // can encode a run of zeros in several ways.
            assert!(is_noticed(8) || is_noticed(32), "{codec}/{file}");
        }
    }
}

/// Messages for each set of changed hashes.
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
        (&["contents", "file", "values"][..], "pack: bytes and values changed: the encoder"),
        (&["contents", "errors", "file"], "pack: bytes changed, values did not: the encoder"),
        (&["errors", "file", "reflectances", "values"], "pack: values changed, stored data did not: the decoder"),
        (&["reflectances"], "pack: values changed, stored data did not: the decoder"),
        (&["errors", "file"], "pack: measured errors changed"),
        (&["file"], "pack: bytes of the file changed"),
    ] {
        assert!(said(encodes("wavelet"), moved).contains(half), "{moved:?}");
    }
    assert!(said(corpus("wavelet"), &["values"]).contains("the decoder changed"));
    assert!(said(corpus("wavelet"), &["file", "values"]).contains("not the one that was committed"));
}
