//! `brdfc info`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};
use brdfc_formats::pack::{ImportanceHeader, ImportancePack};

#[test]
fn every_kind_is_named_with_its_sizes() {
    let folder = Folder::new();
    let [table, round, brushed, rgl, model] = inputs(&folder);
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    for (input, kind, words) in [
        (table, "merl", "12 x 12 x 24"),
        (round, "scan", "31 wavelengths, 400 to 700 nm"),
        (brushed, "scan", "anisotropic"),
        (rgl, "rgl", "4 x 4"),
        (model, "synth", "synth:ward?kd=0.2,0.1,0.1&ks=0.1&ax=0.15&ay=0.5"),
        ("p.ktx2", "wavelet-pack", "4 x 4 per hemisphere"),
    ] {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        conforms("info", &report);
        assert_eq!(report["kind"], kind);
        let ran = folder.run(&["info", input]).succeeded();
        assert!(ran.stdout.contains(words) && ran.stderr.is_empty(), "{input}: {}", ran.stdout);
    }
}

#[test]
fn symmetries_are_told() {
    let folder = Folder::new();
    let symmetry = |input: &str| {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        ["isotropic", "mirror", "reciprocal"].map(|key| report["symmetry"][key].as_bool().unwrap())
    };
    assert_eq!(symmetry("synth:ggx"), [true; 3]);
    assert_eq!(symmetry("synth:ward"), [false, true, true]);
    folder.run(&["synth", "ggx", "-o", "a.binary", "--dimensions", "6x6x12"]).succeeded();
    assert_eq!(symmetry("a.binary"), [true; 3]);
    let mut bytes = folder.read("a.binary");
    // One cell off the plane of incidence, twice as bright in red: its mirror image is another cell.
    let cell = 12 + 8 * (2 * 6 * 12 + 2 * 12 + 3);
    let red = f64::from_le_bytes(bytes[cell..cell + 8].try_into().unwrap());
    assert!(red > 0.0);
    bytes[cell..cell + 8].copy_from_slice(&(2.0 * red).to_le_bytes());
    folder.write("b.binary", &bytes);
    assert_eq!(symmetry("b.binary"), [true, false, true]);
}

#[test]
fn the_extension_decides_whatever_its_case() {
    let folder = Folder::new();
    folder.run(&["synth", "ggx", "-o", "a.binary", "--dimensions", "6x6x12"]).succeeded();
    folder.write("B.BINARY", folder.read("a.binary"));
    folder.run(&["info", "B.BINARY"]).succeeded();
    folder.write("c.dat", folder.read("a.binary"));
    let ran = folder.run(&["info", "c.dat"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("c.dat: file name: found extension .dat; allowed .binary (MERL)"), "{}", ran.stderr);
}

#[test]
fn importance_samples_are_told_from_other_packs() {
    let folder = Folder::new();
    let header = ImportanceHeader { polar: 2, azimuths: 4, samples: 3 };
    let bytes = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 24]).unwrap().to_bytes(true);
    folder.write("p.ktx2", &bytes);
    let report = folder.run(&["info", "p.ktx2", "--json"]).succeeded().json();
    conforms("info", &report);
    assert_eq!((&report["kind"], &report["samples"]), (&"importance-pack".into(), &3.into()));
    let text = folder.run(&["info", "p.ktx2"]).succeeded().stdout;
    assert!(text.contains("2 polar angles x 4 azimuths") && text.contains("384 B"), "{text}");
    // A broken one is still told what it is, and other commands say what is missing.
    let mut texels = vec![[0.0, 0.0, 1.0, 1.0]; 24];
    texels[5][3] = 2.0;
    let bytes = ImportancePack::new(header, texels).unwrap().to_bytes(false);
    let at = bytes.windows(4).rposition(|word| word == 2.0f32.to_le_bytes()).unwrap();
    folder.write("q.ktx2", [&bytes[..at], &(-2.0f32).to_le_bytes(), &bytes[at + 4..]].concat());
    let ran = folder.run(&["info", "q.ktx2"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("q.ktx2: importance texel (2, 1)"), "{}", ran.stderr);
    let ran = folder.run(&["compare", "p.ktx2", "synth:ggx"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("allowed the entries of a wavelet pack"), "{}", ran.stderr);
}
