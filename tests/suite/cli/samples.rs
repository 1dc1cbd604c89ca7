//! `brdfc samples`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};
use brdfc_core::address::parse_synth;
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_importance::{HalfGrid, ImportanceRecipe, importance_samples};

fn samples(folder: &Folder, input: &str, more: &[&str]) -> (ImportancePack, serde_json::Value) {
    let ran = folder.run(&[&["samples", input, "-o", "s.ktx2", "--json"][..], more].concat()).succeeded();
    let report = ran.json();
    conforms("samples", &report);
    (ImportancePack::from_bytes(&folder.read("s.ktx2")).unwrap(), report)
}

const SMALL: [&str; 8] = ["--polar", "4", "--count", "32", "--rings", "12", "--cells", "8"];

#[test]
fn every_kind_of_material_has_samples() {
    let folder = Folder::new();
    for input in inputs(&folder) {
        let (pack, report) = samples(&folder, input, &SMALL);
        let isotropic = !input.starts_with("brushed") && !input.starts_with("synth:ward");
        let header = ImportanceHeader { polar: 4, azimuths: if isotropic { 1 } else { 16 }, samples: 32 };
        assert_eq!(pack.header(), header, "{input}");
        assert_eq!(report["bytes_on_disk"], folder.read("s.ktx2").len());
        let output = folder.run(&["info", "s.ktx2", "--json"]).succeeded().json();
        for key in ["kind", "polar", "azimuths", "samples", "gpu_bytes"] {
            assert_eq!(output[key], report[key], "{input}: {key}");
        }
    }
    let ran = folder.run(&[&["samples", "round.brdf", "-o", "s.ktx2"][..], &SMALL].concat()).succeeded();
    assert!(ran.stdout.contains("12 rings of 8 cells") && ran.stdout.contains("4 polar angles, isotropic"), "{ran:?}");
    assert!(ran.stderr.contains("note: ") && ran.stderr.contains("local fits"), "{}", ran.stderr);
}

/// Every flag reaches the recipe.
#[test]
fn flags_are_the_recipe() {
    let folder = Folder::new();
    let address = "synth:ward?ax=0.1&ay=0.4";
    let more = ["--azimuths", "8", "--defensive", "0.3"];
    let (pack, _) = samples(&folder, address, &[&SMALL[..], &more].concat());
    let recipe = ImportanceRecipe {
        isotropic_polar: 64,
        anisotropic_polar: 4,
        anisotropic_azimuths: 8,
        samples: 32,
        grid: HalfGrid { polar: 12, azimuths: 8 },
        defensive: 0.3,
    };
    let source = parse_synth(address).unwrap();
    assert!(importance_samples(source.as_ref(), &recipe).unwrap().0 == pack);
    let other = ImportanceRecipe { defensive: 0.2, ..recipe };
    assert!(importance_samples(source.as_ref(), &other).unwrap().0 != pack);
    let isotropic = parse_synth("synth:ggx").unwrap();
    let default = importance_samples(isotropic.as_ref(), &ImportanceRecipe::default()).unwrap().0;
    assert!(samples(&folder, "synth:ggx", &[]).0 == default);
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    let bytes = ["1", "3"].map(|jobs| {
        samples(&folder, "synth:ward?ay=0.5", &[&SMALL[..], &["--jobs", jobs]].concat());
        folder.read("s.ktx2")
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = Folder::new();
    let [table, ..] = inputs(&folder);
    let before = folder.files(".");
    for (code, input, more, expected) in [
        (2, "synth:ward", &["--count", "0"][..], "--count: found 0, expected 1 to 8192"),
        (2, "synth:ward", &["--polar", "1025"], "--polar: found 1025, expected 1 to 1024"),
        (2, "synth:ward", &["--azimuths", "6"], "--azimuths: found 6, expected 1, or a multiple of 4"),
        (
            2,
            "synth:ward",
            &["--azimuths", "1"],
            "--azimuths: found 1 of an anisotropic material, expected a multiple of 4",
        ),
        (
            2,
            "synth:ward",
            &["--polar", "64", "--azimuths", "256"],
            "--polar by --azimuths: found 16384, expected 1 to 8192",
        ),
        (
            2,
            "synth:ggx",
            &["--azimuths", "16"],
            "--azimuths does not apply to isotropic materials, only to anisotropic ones",
        ),
        (2, "synth:ward", &["--rings", "0"], "--rings: found 0, expected 1 to 4096"),
        (2, "synth:ward", &["--cells", "7"], "--cells: found 7, expected an even number"),
        (2, "synth:ward", &["--defensive", "0"], "--defensive: found 0, expected above 0"),
        (2, "synth:ward", &["--defensive", "200%"], "--defensive: found 200%, expected above 0"),
        (2, "synth:ward", &["--defensive", "NaN"], "--defensive: found NaN, expected above 0"),
        (2, "gone.binary", &["--count", "9000"], "--count: found 9000"),
        (3, "synth:nothing", &[], "synth:nothing: "),
        (4, "gone.binary", &[], "gone.binary: cannot read"),
    ] {
        let ran = folder.run(&[&["samples", input, "-o", "s.ktx2"][..], more].concat());
        assert_eq!(ran.code, code, "{input} {more:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected) && ran.stdout.is_empty(), "{input} {more:?}: {}", ran.stderr);
    }
    let ran = folder.run(&["samples", table, "-o", table]);
    assert!(ran.code == 2 && ran.stderr.contains("would overwrite the input "), "{}", ran.stderr);
    assert!(folder.files(".") == before);
}
