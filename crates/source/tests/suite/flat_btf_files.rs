//! Flat BTFs in folders: what is written is read, and what is missing is said.

use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, FlatValues, SampledDirections, view_part};
use brdfc_source::InputError;
use brdfc_source::flat_btf::{check_flat_btf, open_flat_btf};
use brdfc_testing::flat_btf::{SMALL, parts};
use std::path::Path;

fn write(folder: &Path, name: &str, parts: &FlatBtfParts) {
    let mut listed = serde_json::Map::new();
    let mut write = |part: &str, bytes: Vec<u8>| {
        let file = format!("{name}.{part}.ktx2");
        std::fs::write(folder.join(&file), &bytes).unwrap();
        let hash = blake3::hash(&bytes).to_hex().to_string();
        listed.insert(part.to_owned(), serde_json::json!({ "file": file, "bytes": bytes.len(), "blake3": hash }));
    };
    write("reference", parts.reference.to_bytes(true));
    write("indirection", parts.indirection.samples().unwrap().to_bytes(true));
    write("normal", parts.normal.to_bytes(false));
    write("diffuse", parts.diffuse.to_bytes(true));
    for (view, flat) in (0..).zip(parts.values.views()) {
        write(&view_part(view, parts.values.views().len() as u32), flat.to_bytes(true));
    }
    let directions = SampledDirections::of(&parts.values).unwrap();
    write("directions", directions.expect("it has views").to_bytes(true));
    let list = serde_json::json!({ "parts": listed });
    std::fs::write(folder.join(format!("{name}.json")), list.to_string()).unwrap();
}

fn error(path: &Path, views: bool) -> String {
    open_flat_btf(path, views).expect_err("an error").to_string()
}

#[test]
fn parts_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let whole = parts(SMALL, 3);
    write(folder.path(), "knit.blue", &whole);
    // Other files do not matter.
    for other in ["readme.txt", "other.ktx2", "other.mask.ktx2", "flat.000.ktx2"] {
        std::fs::write(folder.path().join(other), "").unwrap();
    }
    assert_eq!(open_flat_btf(folder.path(), true).unwrap(), whole);
    assert_eq!(open_flat_btf(&folder.path().join("knit.blue.json"), true).unwrap(), whole);
    assert!(FlatBtfDecoder::new(whole.clone()).is_ok());
    // Without views their files are not even looked at.
    for view in 0..SMALL.views {
        std::fs::remove_file(folder.path().join(format!("knit.blue.{}.ktx2", view_part(view, SMALL.views)))).unwrap();
    }
    let light = FlatBtfParts { values: FlatValues::None, ..whole };
    assert_eq!(open_flat_btf(folder.path(), false).unwrap(), light);
    let text = error(folder.path(), true);
    assert!(text.contains("no knit.blue.flat.000.ktx2"), "{text}");
}

#[test]
fn missing_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a", &parts(SMALL, 3));
    for part in ["flat.001", "flat.002"] {
        std::fs::remove_file(folder.path().join(format!("a.{part}.ktx2"))).unwrap();
    }
    assert!(open_flat_btf(folder.path(), false).is_ok());
    let text = error(folder.path(), true);
    assert!(text.contains("found no a.flat.001.ktx2, a.flat.002.ktx2; allowed all of its files"), "{text}");
    for part in ["normal", "reference"] {
        std::fs::remove_file(folder.path().join(format!("a.{part}.ktx2"))).unwrap();
    }
    let text = error(folder.path(), true);
    assert!(text.contains("found no a.reference.ktx2, a.normal.ktx2, a.flat.001.ktx2, a.flat.002.ktx2;"), "{text}");
}

#[test]
fn no_flat_btf_or_several() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    assert!(error(path, false).contains("found no files NAME.PART.ktx2"), "{}", error(path, false));
    for name in ["b", "a"] {
        write(path, name, &parts(SMALL, 3));
    }
    assert!(error(path, false).contains("found a, b; allowed one in a folder"), "{}", error(path, false));
    assert!(open_flat_btf(&path.join("b.json"), true).is_ok());
    assert!(matches!(open_flat_btf(&path.join("c"), true), Err(InputError::Io { .. })));
    assert!(matches!(open_flat_btf(&path.join("c.json"), true), Err(InputError::Io { .. })));
    let text = error(&path.join("a.normal.ktx2"), true);
    assert!(text.contains("found a.normal.ktx2; allowed a folder, or NAME.json"), "{text}");
}

#[test]
fn broken_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a", &parts(SMALL, 3));
    std::fs::write(folder.path().join("a.flat.002.ktx2"), b"not a texture").unwrap();
    let text = error(folder.path(), true);
    assert!(text.contains("a.flat.002.ktx2: part of a flat BTF: found 13 bytes; allowed "), "{text}");
    assert!(open_flat_btf(folder.path(), false).is_ok());
    assert!(check_flat_btf(folder.path()).is_err());
    std::fs::copy(folder.path().join("a.normal.ktx2"), folder.path().join("a.diffuse.ktx2")).unwrap();
    assert!(error(folder.path(), false).contains("a.diffuse.ktx2: "), "{}", error(folder.path(), false));
}

#[test]
fn parts_of_another_asset_are_refused() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    write(one.path(), "a", &parts(SMALL, 3));
    write(two.path(), "a", &parts(SMALL, 4));
    let normal = |folder: &tempfile::TempDir| folder.path().join("a.normal.ktx2");
    let lengths = [&one, &two].map(|folder| std::fs::metadata(normal(folder)).unwrap().len());
    assert_eq!(lengths[0], lengths[1], "only the bytes differ");
    assert!(check_flat_btf(one.path()).is_ok());
    std::fs::copy(normal(&two), normal(&one)).unwrap();
    for text in [error(one.path(), false), check_flat_btf(one.path()).unwrap_err().to_string()] {
        assert!(text.contains("a.normal.ktx2") && text.contains("a part of another asset"), "{text}");
    }
}

#[test]
fn a_folder_without_its_list_or_with_a_damaged_one() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "a", &parts(SMALL, 3));
    let list = folder.path().join("a.json");
    for damaged in ["{}", "[]", "{\"parts\": []}", "{\"parts\": {\"normal\": {\"fi"] {
        std::fs::write(&list, damaged).unwrap();
        let text = error(folder.path(), false);
        assert!(text.contains("a.json: list of parts: found "), "{text}");
    }
    std::fs::write(&list, "{\"parts\": {}}").unwrap();
    assert!(error(folder.path(), false).contains("found no a.reference.ktx2, a.indirection.ktx2"));
    std::fs::remove_file(&list).unwrap();
    let text = error(folder.path(), false);
    assert!(text.contains("found no a.json; allowed a finished asset"), "{text}");
}
