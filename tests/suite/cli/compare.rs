//! `brdfc compare`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

#[test]
fn an_input_equals_itself() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ward", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    for input in inputs(&folder).into_iter().chain(["p.ktx2"]) {
        let ran =
            folder.run(&["compare", input, input, "--directions", "500", "--max-error", "0", "--json"]).succeeded();
        let report = ran.json();
        conforms("compare", &report);
        for key in ["rms", "relative_mean", "relative_max", "log_rms", "cosine_log_rms"] {
            assert_eq!(report["norms"][key], 0.0, "{input} {key}");
        }
        assert_eq!(report["albedo_max_difference"], 0.0);
        assert!(report["mean"].as_f64().unwrap() > 0.0);
    }
}

#[test]
fn a_known_difference_is_measured() {
    let folder = Folder::new();
    let ran = folder.run(&["compare", "synth:lambert?kd=0.5", "synth:lambert?kd=0.6", "--json"]).succeeded();
    let report = ran.json();
    for (key, expected) in
        [("relative_mean", 0.2), ("relative_max", 0.2), ("rms", 0.1 / std::f64::consts::PI), ("log_rms", 1.2f64.ln())]
    {
        let found = report["norms"][key].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-9, "{key}: {found}");
    }
    assert_eq!((&report["pairs"], &report["norms"]["samples"]), (&65_536.into(), &65_536.into()));
    assert!((report["albedo_max_difference"].as_f64().unwrap() - 0.1).abs() < 1e-9);
}

#[test]
fn a_missed_limit_exits_with_1_after_the_table() {
    let folder = Folder::new();
    let arguments = ["compare", "synth:lambert?kd=0.5", "synth:lambert?kd=0.6", "--directions", "100", "--max-error"];
    let ran = folder.run(&[&arguments[..], &["0.19"]].concat());
    assert_eq!(ran.code, 1);
    assert!(ran.stdout.contains("ε_r, mean relative difference"), "{}", ran.stdout);
    assert_eq!(ran.stderr, "brdfc: --max-error: found 20.000 %, expected at most 19.000 %\n");
    folder.run(&[&arguments[..], &["0.21"]].concat()).succeeded();
}

#[test]
fn pairs_may_come_from_a_file() {
    let folder = Folder::new();
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n0.6,0,0.8,0,0.6,0.8\n");
    let ran = folder.run(&["compare", "synth:lewis", "synth:ward", "--directions", "pairs.csv", "--json"]).succeeded();
    assert_eq!(ran.json()["pairs"], 2);
    folder.write("empty.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n");
    let ran = folder.run(&["compare", "synth:lewis", "synth:ward", "--directions", "empty.csv"]);
    assert_eq!(ran.code, 3);
    assert_eq!(ran.stderr, "brdfc: empty.csv: no direction pairs; expected at least one row\n");
    let ran = folder.run(&["compare", "synth:lewis", "synth:ward", "--directions", "missing.csv"]);
    assert!(ran.code == 4 && ran.stderr.contains("missing.csv: cannot read: "), "{}", ran.stderr);
}

/// A black reference has no sample for a ratio: the check must fail, because it has nothing to measure.
#[test]
fn a_limit_that_rests_on_no_sample_is_missed() {
    let folder = Folder::new();
    let ran = folder.run(&["compare", "synth:lambert?kd=0", "synth:lambert?kd=0.5", "--max-error", "0.5"]);
    assert_eq!(ran.code, 1);
}

#[test]
fn an_output_never_replaces_an_input() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ward", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    let before = folder.read("p.ktx2");
    assert_eq!(folder.run(&["encode", "p.ktx2", "-o", "./p.ktx2", "--grid", "8"]).code, 2);
    assert!(folder.read("p.ktx2") == before);
}

/// `encode`, `report.json`, `info` and `compare` report the same number, for any grid.
#[test]
fn the_same_question_has_the_same_answer() {
    let folder = Folder::new();
    let [table, scan, ..] = inputs(&folder);
    for (input, grid) in [(table, "8"), (scan, "4")] {
        let encoded = folder.run(&["encode", input, "-o", "p.ktx2", "--grid", grid, "--json"]).succeeded().json();
        let compared = folder.run(&["compare", input, "p.ktx2", "--json"]).succeeded().json();
        for key in ["norms", "mean", "rendering", "albedo_max_difference", "reciprocity"] {
            assert_eq!(compared[key], encoded["off_grid"][key], "{input}, {key}");
        }
        assert_eq!(compared["pairs"], 65_536);
        let info = folder.run(&["info", "p.ktx2", "--json"]).succeeded().json();
        let [stored, measured] = [&info["off_grid"]["relative_mean"], &encoded["off_grid"]["norms"]["relative_mean"]];
        let [stored, measured] = [stored, measured].map(|value| value.as_f64().unwrap());
        assert!(measured > 0.0 && (stored - measured).abs() < 1e-6 * measured, "{stored} {measured}");
        folder.write("s.toml", format!("[materials.a]\nsource = '{input}'\ngrid = {grid}\n[[uses]]\nmaterial = 'a'\n"));
        folder.run(&["build", "s.toml"]).succeeded();
        let report: serde_json::Value = serde_json::from_str(&folder.text("packs/report.json")).unwrap();
        assert_eq!(report["materials"][0]["report"]["off_grid"], encoded["off_grid"], "{input}");
    }
}

#[test]
fn limits_may_be_percentages() {
    let folder = Folder::new();
    let check = |limit: &str| {
        let inputs = ["synth:lambert?kd=0.5", "synth:lambert?kd=0.6"];
        folder.run(&["compare", inputs[0], inputs[1], "--directions", "100", "--max-error", limit])
    };
    assert_eq!(["21%", "0.21", "19%", "0.19", "21"].map(|limit| check(limit).code), [0, 0, 1, 1, 2]);
    assert!(
        check("21").stderr.contains("--max-error: found 21, expected a fraction or a percentage; write 0.21 or 21%")
    );
}

/// A flat BTF equals itself, another form or one of fewer bytes is close to it, and another surface is not.
#[test]
fn flat_btfs_are_compared() {
    let folder = Folder::new();
    let small = ["--texels", "16", "--flat-texels", "32", "--views", "grid:2x3@40", "--lights", "grid:3x6@60"];
    for (name, surface, form) in [
        ("whole", "synth:button?resolution=48", &["--reflectance", "factors"][..]),
        ("small", "synth:button?resolution=48", &["--reflectance", "factors", "--max-bytes", "26KiB"]),
        ("knit", "synth:knit?resolution=48", &["--reflectance", "factors"]),
        ("brdf", "synth:button?resolution=48", &["--reflectance", "brdf"]),
    ] {
        folder.run(&[&["flatten", surface, "-o", name], form, &small].concat()).succeeded();
    }
    let mean = |a: &str, b: &str| {
        let report = folder.run(&["compare", a, b, "--json"]).succeeded().json();
        assert_eq!((&report["kind"], &report["version"]), (&"flat-btf".into(), &1.into()));
        assert!(report["errors"]["shown"].as_u64().unwrap() > 10_000, "{report}");
        assert_eq!(report["errors"]["samples"], 65_536, "{report}");
        report["errors"]["mean"].as_f64().unwrap()
    };
    for name in ["whole", "brdf"] {
        assert_eq!(mean(name, &format!("{name}/{name}.ktx2")), 0.0, "{name}");
    }
    let far = mean("whole", "knit");
    for near in [mean("whole", "small"), mean("whole", "brdf"), mean("brdf", "whole")] {
        assert!(near > 0.0 && near < 0.5 * far, "{near} {far}");
    }
    let table = folder.run(&["compare", "whole", "small", "--max-delta-e", "100"]).succeeded().stdout;
    assert!(table.contains("look-ups") && table.contains("mean ΔE") && table.contains("65536"), "{table}");
    folder.write("cut.ktx2", &folder.read("whole/whole.ktx2")[..1000]);
    for (code, arguments, expected) in [
        (1, &["whole", "knit", "--max-delta-e", "0.1"][..], ", expected at most 0.1"),
        (2, &["whole", "small", "--max-delta-e", "-1"], "--max-delta-e: found -1, expected 0 to 1000"),
        (2, &["whole", "small", "--max-error", "5%"], "--max-error does not apply to flat BTFs"),
        (
            3,
            &["whole", "synth:lewis"],
            "synth:lewis: input: found an analytic model, expected a flat BTF, because A is one",
        ),
        (4, &["whole", "gone.ktx2"], "gone.ktx2: cannot read"),
        (4, &["whole", "gone"], "gone: cannot read"),
        (3, &["whole", "cut.ktx2"], "cut.ktx2: container: ends after 1000 bytes"),
    ] {
        let ran = folder.run(&[&["compare"][..], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {ran:?}");
    }
}
