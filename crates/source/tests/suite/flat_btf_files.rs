//! Flat BTFs as files: they round-trip, and other files are rejected.

use brdfc_formats::PackKind;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_source::flat_btf::{flat_btf_file, flat_view, open_flat_btf};
use brdfc_source::{Input, InputError, Kind};
use brdfc_testing::codecs::flat_btf::{BASE, Factors, SMALL, base_file, factored, file, layers, materials_file};
use std::path::Path;

fn example(seed: u64) -> FlatBtfFile {
    let factors = Factors { groups: 2, wide_groups: 1, residual: 2, ..BASE };
    file(layers(SMALL, seed), factored(SMALL, factors, seed))
}

fn error(path: &Path) -> String {
    open_flat_btf(path).expect_err("an error").to_string()
}

#[test]
fn files_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let whole = FlatBtfFile { report: "{}".to_owned(), ..example(3) };
    let file = folder.path().join("knit.blue.ktx2");
    for supercompress in [false, true] {
        std::fs::write(&file, whole.to_bytes(supercompress)).unwrap();
        // Other files do not matter.
        let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
        let other = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).unwrap().to_bytes(false);
        for (name, bytes) in [("readme.txt", &b"text"[..]), ("none.ktx2", b""), ("other.ktx2", &other)] {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        assert_eq!(open_flat_btf(folder.path()).unwrap(), whole);
        assert_eq!(open_flat_btf(&file).unwrap(), whole);
    }
    assert_eq!(flat_btf_file(&folder.path().into()).unwrap(), Input::from(file));
    assert_eq!(Kind::of(&folder.path().into()).unwrap(), Kind::Pack(PackKind::FlatBtf));
    let other = Input::from(folder.path().join("other.ktx2"));
    assert!(flat_btf_file(&other).is_err());
    assert_eq!(Kind::of(&other).unwrap(), Kind::Pack(PackKind::Importance));
    let asset = whole.decoder.parts().reflectance.factors().unwrap();
    assert_eq!(flat_view(&whole, 1).unwrap(), (Some(asset.view(1)), SMALL.views));
    assert_eq!(flat_view(&whole, SMALL.views).unwrap(), (None, SMALL.views));
}

#[test]
fn a_base_alone_has_no_views() {
    let folder = tempfile::tempdir().unwrap();
    for (name, whole) in [("base.ktx2", base_file()), ("materials.ktx2", materials_file())] {
        let path = folder.path().join(name);
        std::fs::write(&path, whole.to_bytes(true)).unwrap();
        let read = open_flat_btf(&path).unwrap();
        assert_eq!(read, whole);
        let error = flat_view(&read, 0).unwrap_err().to_string();
        let expected = "flat BTF: no sampled views; expected a flat BTF made with --reflectance factors";
        assert_eq!(error, expected);
    }
}

#[test]
fn no_flat_btf_or_several() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    assert!(error(path).contains("input: no flat BTF in this folder; expected "), "{}", error(path));
    for name in ["b.ktx2", "a.ktx2"] {
        std::fs::write(path.join(name), example(4).to_bytes(true)).unwrap();
    }
    assert!(error(path).contains("found a.ktx2, b.ktx2, expected a folder with one flat BTF"), "{}", error(path));
    assert!(open_flat_btf(path.join("b.ktx2")).is_ok());
    assert!(matches!(open_flat_btf(path.join("c.ktx2")), Err(InputError::Io { .. })));
    std::fs::write(path.join("text.ktx2"), b"not a texture").unwrap();
    assert!(error(&path.join("text.ktx2")).contains("input: not a flat BTF; expected "));
}

#[test]
fn broken_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.ktx2");
    let bytes = example(5).to_bytes(true);
    for at in [bytes.len() / 3, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 4;
        std::fs::write(&file, damaged).unwrap();
        assert!(error(folder.path()).contains("a.ktx2: "), "{}", error(folder.path()));
    }
    std::fs::write(&file, &bytes[..bytes.len() - 9]).unwrap();
    assert!(error(&file).contains("a.ktx2: "), "{}", error(&file));
}
