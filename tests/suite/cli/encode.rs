//! `brdfc encode`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

fn encode(folder: &Folder, input: &str, more: &[&str]) -> serde_json::Value {
    let ran = folder.run(&[&["encode", input, "-o", "pack.ktx2", "--json"][..], more].concat()).succeeded();
    let report = ran.json();
    conforms("encode", &report);
    assert_eq!(report["bytes_on_disk"], folder.read("pack.ktx2").len());
    report
}

#[test]
fn every_kind_of_input_becomes_a_pack() {
    let folder = Folder::new();
    for input in inputs(&folder) {
        let report = encode(&folder, input, &["--grid", "4", "--ratio", "2"]);
        assert_eq!(
            (&report["grid"], &report["slices_kept"], &report["slices_in_all"]),
            (&4.into(), &8.into(), &16.into())
        );
        let samples = report["samples_in"].as_u64().unwrap();
        assert_eq!(samples == 0, input.starts_with("synth:"), "{input}: {samples}");
        let pack = folder.run(&["info", "pack.ktx2", "--json"]).succeeded().json();
        assert_eq!(pack["slices_kept"], 8);
        assert_eq!(pack["gpu_bytes"], report["bytes_on_gpu"]);
        let [told, stored] = [&report["off_grid"]["norms"]["relative_mean"], &pack["off_grid"]["relative_mean"]]
            .map(|v| v.as_f64().unwrap());
        assert!((told - stored).abs() <= 1e-6 * told, "{told} {stored}");
    }
}

#[test]
fn options_reach_the_pack() {
    let folder = Folder::new();
    let more = ["--grid", "8", "--bits", "12", "--parameterisation", "half-difference", "--smooth"];
    let report = encode(&folder, "synth:lewis", &more);
    assert_eq!((&report["bits"], &report["smoothed"]), (&12.into(), &true.into()));
    assert_eq!(report["parameterisation"], "half-difference");
    let compressed = folder.read("pack.ktx2").len();
    encode(&folder, "synth:lewis", &[&more[..], &["--no-supercompression"]].concat());
    assert!(folder.read("pack.ktx2").len() > compressed);
    let info = folder.run(&["info", "pack.ktx2"]).succeeded().stdout;
    assert!(info.contains("half-difference") && info.contains("1 channels, 12 bits"), "{info}");
}

#[test]
fn targets_are_met_and_tight() {
    let folder = Folder::new();
    let report = encode(&folder, "synth:lewis", &["--grid", "8", "--max-error", "0.05"]);
    let kept = report["slices_kept"].as_u64().unwrap();
    assert!(report["on_grid"]["norms"]["relative_mean"].as_f64().unwrap() <= 0.05 && kept < 64, "{report}");
    let fewer = format!("{}", 64.0 / (kept - 1) as f64);
    let report = encode(&folder, "synth:lewis", &["--grid", "8", "--ratio", &fewer]);
    assert_eq!(report["slices_kept"], kept - 1);
    assert!(report["on_grid"]["norms"]["relative_mean"].as_f64().unwrap() > 0.05, "one slice fewer misses it");

    let report = encode(&folder, "synth:lewis", &["--grid", "8", "--max-bytes", "2000"]);
    let bytes = report["bytes_on_gpu"].as_u64().unwrap();
    assert!(bytes <= 2000 && bytes + 64 > 2000, "a slice of 64 bytes more does not fit: {bytes}");
}

#[test]
fn targets_out_of_reach_exit_with_1_and_write_nothing() {
    let folder = Folder::new();
    for (more, expected) in [
        (["--max-error", "0.000001"], "error budget: found "),
        (["--max-bytes", "10"], "byte budget: found 10 bytes; allowed at least "),
    ] {
        let ran = folder.run(&[&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "4"][..], &more].concat());
        assert_eq!((ran.code, ran.stdout.as_str()), (1, ""), "{}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    }
    assert!(folder.files(".").is_empty());
}

#[test]
fn the_table_goes_to_stdout_and_remarks_to_stderr() {
    let folder = Folder::new();
    let [_, scan, ..] = inputs(&folder);
    let arguments = ["encode", scan, "--grid", "4", "-o", "p.ktx2"];
    let loud = folder.run(&arguments).succeeded();
    assert!(loud.stdout.starts_with("pack ") && loud.stdout.lines().count() == 2, "{}", loud.stdout);
    let quiet = folder.run(&[&arguments[..], &["--quiet"]].concat()).succeeded();
    assert_eq!(quiet.stderr, "");
    assert!(!loud.stdout.contains("note:"));
    assert!(!loud.stderr.is_empty() && loud.stderr.lines().all(|line| line.starts_with("note: ")), "{}", loud.stderr);
}

#[test]
fn an_existing_pack_is_replaced_whole_or_kept() {
    let folder = Folder::new();
    folder.write("p.ktx2", b"old");
    assert_eq!(folder.run(&["encode", "synth:nothing", "-o", "p.ktx2"]).code, 3);
    assert_eq!(folder.read("p.ktx2"), b"old");
    folder.run(&["encode", "synth:lambert", "-o", "p.ktx2", "--grid", "2"]).succeeded();
    assert!(folder.run(&["info", "p.ktx2"]).succeeded().stdout.contains("wavelet pack"));
    assert_eq!(folder.files(".").len(), 1);
}
