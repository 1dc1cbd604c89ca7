//! `brdfc encode --codec lobes`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::lobes::LobesPack;

const GLOSSY: &str = "synth:ggx?alpha=0.1";

#[test]
fn the_fewest_look_ups_within_the_limit_are_selected() {
    let folder = Folder::new();
    let encode = ["encode", GLOSSY, "--codec", "lobes", "-o", "lobes.ktx2"];
    let report = folder.run(&[&encode[..], &["--json"]].concat()).succeeded().json();
    conforms("encode-lobes", &report);
    let pack = LobesPack::from_bytes(&folder.read("lobes.ktx2")).unwrap();
    let (tried, best) = (report["tried"].as_array().unwrap(), &report["pack"]);
    assert_eq!(best["fetches"], pack.fetches());
    assert!(best["delta_e"]["mean"].as_f64().unwrap() <= 1.0 && tried.last() == Some(best), "{report}");
    assert!(tried[..tried.len() - 1].iter().all(|one| one["delta_e"]["mean"].as_f64().unwrap() > 1.0));
    assert!(best["gpu_bytes"].as_u64().unwrap() <= 2048);
    let output = folder.run(&["info", "lobes.ktx2", "--json"]).succeeded().json();
    conforms("info", &output);
    assert_eq!((&output["kind"], &output["fetches"]), (&"lobes".into(), &best["fetches"]));
    // The same bytes again, and a table to read.
    let first = folder.read("lobes.ktx2");
    let ran = folder.run(&encode).succeeded();
    assert!(first == folder.read("lobes.ktx2") && ran.stdout.contains("meets the limits"), "{}", ran.stdout);
}

#[test]
fn limits_are_kept_or_reported() {
    let folder = Folder::new();
    let run = |more: &[&str]| folder.run(&[&["encode", "--codec", "lobes", "-o", "l.ktx2"], more].concat());
    let fetches = |more: &[&str]| -> usize {
        run(&[&[GLOSSY], more].concat()).succeeded();
        LobesPack::from_bytes(&folder.read("l.ktx2")).unwrap().fetches()
    };
    assert!(fetches(&["--max-fetches", "2"]) <= 2);
    std::fs::remove_file(folder.path().join("l.ktx2")).unwrap();
    for (more, code, expected) in [
        (&[GLOSSY, "--max-fetches", "33"][..], 2, "--max-fetches: found 33, expected 1 to 32 for lobes"),
        (&[GLOSSY, "--max-delta-e", "0"], 2, "--max-delta-e: found 0, expected 1e-6 to 100"),
        (&[GLOSSY, "--max-delta-e", "1e9"], 2, "--max-delta-e: found 1000000000, expected 1e-6 to 100"),
        (
            &[GLOSSY, "--max-bytes", "2048"],
            2,
            "--max-bytes does not apply to --codec lobes, which takes --max-delta-e, --max-fetches, --max-fit-error and",
        ),
        (&[GLOSSY, "--levels", "0"], 2, "--levels does not apply to --codec lobes"),
        (&["synth:gone"], 3, "synth:gone"),
    ] {
        let ran = run(more);
        assert!(ran.code == code && ran.stderr.contains(expected), "{more:?}: {}", ran.stderr);
        assert!(!folder.path().join("l.ktx2").exists(), "{more:?}");
    }
    // The closest pack is written, as for tables.
    let ran = run(&[GLOSSY, "--max-fetches", "1", "--max-delta-e", "0.1"]);
    assert!(ran.code == 1 && ran.stderr.contains("--max-delta-e: found a ΔE of "), "{}", ran.stderr);
    assert_eq!(LobesPack::from_bytes(&folder.read("l.ktx2")).unwrap().fetches(), 1);
}

#[test]
fn lobes_are_among_the_codecs() {
    let folder = Folder::new();
    let ran = folder.run(&["encode", GLOSSY, "--codec", "lobs", "-o", "l.ktx2"]);
    let expected = "--codec: found \"lobs\", expected auto, table, factored, wavelet or lobes; did you mean lobes?";
    assert!(ran.code == 2 && ran.stderr.contains(expected), "{}", ran.stderr);
    let ran = folder.run(&["encode", "--help"]).succeeded();
    let help = ran.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(help.contains("or lobes (only for 'brdfc encode'"), "{help}");
    // No other command takes them.
    let ran = folder.run(&["build", GLOSSY, "--codec", "lobs", "--out", "packs"]);
    assert!(ran.code == 2 && ran.stderr.contains("expected auto, table, factored or wavelet"), "{}", ran.stderr);
}
