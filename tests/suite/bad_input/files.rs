//! MERL tables, RGL materials, names, addresses.

use super::{accepted, bad_file, refused};
use crate::common::cli::{Folder, rgl_bytes};
use crate::common::tensor::Material;

const CELLS: usize = 2 * 3 * 4;

/// A table of 2 x 3 x 4 cells.
fn merl() -> Vec<u8> {
    let header = [2i32, 3, 4].into_iter().flat_map(i32::to_le_bytes);
    header.chain((0..3 * CELLS).flat_map(|k| (100.0 + k as f64).to_le_bytes())).collect()
}

fn with(mut bytes: Vec<u8>, at: usize, new: &[u8]) -> Vec<u8> {
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

#[test]
fn the_valid_files_of_these_tests_are_valid() {
    assert_eq!(accepted("a.binary", &merl())["valid_cells"], CELLS);
    assert_eq!(accepted("a.bsdf", &rgl_bytes())["kind"], "rgl");
}

#[test]
fn empty_files_and_wrong_magic() {
    bad_file("a.binary", b"", &["file length: found 0 bytes, expected at least 12 bytes"]);
    bad_file("a.bsdf", b"", &["byte 0, magic: end of data"]);
    bad_file("a.ktx2", b"", &["container: ends after 0 bytes; expected a complete KTX2 file"]);
    bad_file("a.brdf", b"", &["wavelength count: end of data"]);
    bad_file("a.csv", b"", &["header: empty file"]);
    bad_file("a.bsdf", &with(rgl_bytes(), 0, b"Tensor"), &["byte 0, magic: found ", "expected tensor_file"]);
    bad_file("a.bsdf", &with(rgl_bytes(), 12, &[2]), &["byte 12, version: found 2.0, expected 1.0"]);
    bad_file("a.ktx2", &[b'x'; 500], &["identifier"]);
    bad_file("a.ktx2", &merl(), &["identifier"]);
    bad_file("a.binary", &rgl_bytes(), &["byte 0, theta_h count: found "]);
}

#[test]
fn merl_cut_at_every_boundary() {
    let bytes = merl();
    let plane = 8 * CELLS;
    for length in [1, 4, 8, 11, 12, 12 + 8, 12 + plane - 1, 12 + plane, 12 + 2 * plane, bytes.len() - 1] {
        let found = format!("file length: found {length} bytes");
        bad_file("a.binary", &bytes[..length], &[found.as_str(), " bytes"]);
    }
    bad_file("a.binary", &[&bytes[..], &[0]].concat(), &["file length: found 589 bytes, expected 588 bytes"]);
}

#[test]
fn merl_dimensions() {
    for (axis, name) in ["theta_h", "theta_d", "phi_d"].into_iter().enumerate() {
        for value in [0, -1, i32::MIN, 4097, i32::MAX] {
            let expected = format!("byte {}, {name} count: found {value}, expected 1 to 4096", 4 * axis);
            bad_file("a.binary", &with(merl(), 4 * axis, &value.to_le_bytes()), &[expected.as_str()]);
        }
        let other = with(merl(), 4 * axis, &5i32.to_le_bytes());
        bad_file("a.binary", &other, &["file length: found 588 bytes, expected ", "for a table of "]);
    }
    // 588 bytes announce 1.6 TB: rejected before any memory is allocated.
    let huge: Vec<u8> = [4096i32; 3].into_iter().flat_map(i32::to_le_bytes).chain(merl().split_off(12)).collect();
    bad_file("a.binary", &huge, &["expected 1649267441676 bytes for a table of 4096 x 4096 x 4096"]);
}

#[test]
fn merl_numbers() {
    for (number, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf"), (1e300, "1")] {
        for cell in [0, CELLS + 3, 3 * CELLS - 1] {
            let at = 12 + 8 * cell;
            let place = format!("byte {at}, ");
            let found = format!("found {shown}");
            bad_file("a.binary", &with(merl(), at, &number.to_le_bytes()), &[place.as_str(), found.as_str()]);
        }
    }
    let none: Vec<u8> =
        merl()[..12].iter().copied().chain((0..3 * CELLS).flat_map(|_| (-1f64).to_le_bytes())).collect();
    bad_file("a.binary", &none, &["table: no valid measurement", "expected at least one cell"]);
    let one = with(none, 12 + 8 * 5, &1f64.to_le_bytes());
    bad_file("a.binary", &one, &["table: no valid measurement"]);
    let mut one = one;
    for channel in 0..3 {
        one = with(one, 12 + 8 * (channel * CELLS + 5), &1f64.to_le_bytes());
    }
    assert_eq!(accepted("a.binary", &one)["valid_cells"], 1, "one whole cell is enough");
}

#[test]
fn rgl_cut_at_every_boundary() {
    let container = Material::default().container();
    let bytes = container.build();
    let boundaries = [0, 11, 12, 14, 17].into_iter().chain(container.header_offsets()).chain(container.data_offsets());
    for length in boundaries.chain([bytes.len() - 1]) {
        bad_file("a.bsdf", &bytes[..length], &["byte "]);
    }
}

#[test]
fn rgl_numbers_and_extents() {
    for (number, shown) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        let mut container = Material::default().container();
        container.field("rgb").data[4..8].copy_from_slice(&number.to_le_bytes());
        let found = format!("rgb element 1: found {shown}, expected ");
        bad_file("a.bsdf", &container.build(), &["byte ", found.as_str()]);
    }
    for extent in [0, 1 << 40, u64::MAX] {
        let mut container = Material::default().container();
        container.field("vndf").shape[2] = extent;
        bad_file("a.bsdf", &container.build(), &["vndf"]);
    }
    for missing in ["rgb", "phi_i", "theta_i", "ndf", "sigma", "vndf"] {
        bad_file("a.bsdf", &Material::default().container().without(missing).build(), &[missing]);
    }
}

#[test]
fn contents_of_a_file_do_not_control_the_terminal() {
    let folder = Folder::new();
    let mut container = Material::default().container();
    container.field("description").data = b"\x1b[2J".to_vec();
    container.field("description").shape = vec![4];
    folder.write("a.bsdf", container.build());
    let info = folder.run(&["info", "a.bsdf"]).succeeded().stdout;
    assert!(info.contains("\\u{1b}[2J") && !info.contains('\x1b'), "{info:?}");
}

#[test]
fn names_and_folders() {
    let folder = Folder::new();
    folder.write("folder/file.txt", b"x");
    refused(&folder, &["info", "gone.binary"], 4, &["brdfc: gone.binary: cannot read: "]);
    refused(&folder, &["info", "folder"], 3, &["brdfc: folder: input: found a folder, expected .binary (MERL), "]);
    let words = ["brdfc: folder: input: found a folder, expected .binary (MERL), ", "use 'brdfc build' for a folder"];
    refused(&folder, &["encode", "folder", "-o", "p.ktx2"], 3, &words);
    refused(&folder, &["info", "folder/file.txt"], 3, &["file name: found extension .txt, expected .binary (MERL)"]);
    refused(&folder, &["info", "folder/file.txt/x.brdf"], 4, &["cannot read: "]);
    refused(&folder, &["info", ""], 4, &["cannot read: "]);
    refused(&folder, &["build", "gone.toml"], 4, &["brdfc: gone.toml: cannot read: "]);
    refused(&folder, &["encode", "synth:lewis", "-o", "folder", "--grid", "2"], 4, &["brdfc: folder: cannot write: "]);
    refused(&folder, &["encode", "synth:lewis", "-o", "no/p.ktx2", "--grid", "2"], 4, &["no/p.ktx2: cannot write: "]);
}

#[test]
fn addresses() {
    let folder = Folder::new();
    for (address, expected) in [
        (
            "synth:lewiss",
            "model: found \"lewiss\", expected lambert, lewis, ward, poulin, ggx or velvet; did you mean lewis?",
        ),
        ("synth:phong", "model: found \"phong\", expected lambert,"),
        ("synth:", "model: found \"\", expected lambert,"),
        ("synth:ggx?alpah=1", "parameter of ggx: found \"alpah\", expected kd, f0,"),
        ("synth:ggx?alpah=1", "did you mean alpha?"),
        ("synth:lewis?n=-1", "n of lewis: found -1, expected 0 to 10000"),
        ("synth:lewis?n=1&n=2", "n of lewis: repeated; expected one value"),
        ("synth:lambert?kd=0.1,0.2", "kd of lambert: found 0.1,0.2, expected one number, or three with commas"),
        ("synth:lambert?kd=\u{1b}[31m", "found \"\\u{1b}[31m\""),
    ] {
        for arguments in
            [["info", address].as_slice(), &["encode", address, "-o", "p.ktx2"], &["compare", address, "synth:ggx"]]
        {
            refused(&folder, arguments, 3, &[expected]);
        }
        let model = &address["synth:".len()..];
        refused(&folder, &["synth", model, "-o", "a.binary"], 3, &[expected]);
    }
}
