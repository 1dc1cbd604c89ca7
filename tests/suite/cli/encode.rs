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
            {
                let wavelet = &report["codec"]["wavelet"];
                (&wavelet["grid"], &wavelet["slices_retained"], &wavelet["slices_in_all"])
            },
            (&4.into(), &8.into(), &16.into())
        );
        let samples = report["samples_in"].as_u64().unwrap();
        assert_eq!(samples == 0, input.starts_with("synth:"), "{input}: {samples}");
        let pack = folder.run(&["info", "pack.ktx2", "--json"]).succeeded().json();
        assert_eq!(pack["slices_retained"], 8);
        assert_eq!(pack["gpu_bytes"], report["bytes_on_gpu"]);
        let [reported, stored] = [&report["off_grid"]["norms"]["relative_mean"], &pack["off_grid"]["relative_mean"]]
            .map(|v| v.as_f64().unwrap());
        assert!((reported - stored).abs() <= 1e-6 * reported, "{reported} {stored}");
    }
}

#[test]
fn options_reach_the_pack() {
    let folder = Folder::new();
    let more = ["--grid", "8", "--bits", "12", "--parameterisation", "tangent-pole"];
    let report = encode(&folder, "synth:lewis", &more);
    let wavelet = &report["codec"]["wavelet"];
    assert_eq!(wavelet["bits"], 12);
    assert_eq!(wavelet["parameterisation"], "tangent-pole");
    let compressed = folder.read("pack.ktx2").len();
    encode(&folder, "synth:lewis", &[&more[..], &["--no-supercompression"]].concat());
    assert!(folder.read("pack.ktx2").len() > compressed);
    let info = folder.run(&["info", "pack.ktx2"]).succeeded().stdout;
    assert!(info.contains("tangent-pole") && info.contains("1 channel, 12 bits"), "{info}");
}

#[test]
fn targets_are_met_and_tight() {
    let folder = Folder::new();
    let report = encode(&folder, "synth:lewis", &["--grid", "8", "--max-error", "0.05"]);
    let retained = report["codec"]["wavelet"]["slices_retained"].as_u64().unwrap();
    assert!(
        report["codec"]["wavelet"]["on_grid"]["norms"]["relative_mean"].as_f64().unwrap() <= 0.05 && retained < 64,
        "{report}"
    );
    let fewer = format!("{}", 64.0 / (retained - 1) as f64);
    let report = encode(&folder, "synth:lewis", &["--grid", "8", "--ratio", &fewer]);
    assert_eq!(report["codec"]["wavelet"]["slices_retained"], retained - 1);
    assert!(
        report["codec"]["wavelet"]["on_grid"]["norms"]["relative_mean"].as_f64().unwrap() > 0.05,
        "one slice fewer misses it"
    );

    // One more slice of the finest tree takes a slice of up to three other trees along.
    for (flags, slices) in [
        (&["--grid", "8", "--max-bytes", "2000"][..], 4),
        (&["--grid", "8", "--max-bytes", "2000", "--plain-levels"], 1),
    ] {
        let report = encode(&folder, "synth:lewis", flags);
        let bytes = report["bytes_on_gpu"].as_u64().unwrap();
        assert!(bytes <= 2000 && bytes + 64 * slices > 2000, "{slices} slices of 64 bytes more do not fit: {bytes}");
    }
}

#[test]
fn bytes_are_written_as_people_write_them() {
    let folder = Folder::new();
    for (text, most) in [("4096", 4096), ("4KiB", 4096), ("4k", 4096), ("100 KiB", 100 << 10)] {
        let report = encode(&folder, "synth:lambert?kd=0.5", &["--codec", "table", "--max-bytes", text]);
        let bytes = report["bytes_on_gpu"].as_u64().unwrap();
        assert!(bytes <= most && bytes > most / 2, "{text}: {bytes}");
    }
}

/// Outputs that cannot be written are detected before encoding.
#[test]
fn unfit_outputs_are_refused_at_once() {
    let folder = Folder::new();
    for (output, code, expected) in [
        ("x.png", 2, "--output: found x.png, expected a name that ends in .ktx2"),
        ("nosuch/x.ktx2", 4, "nosuch/x.ktx2: cannot write: there is no folder nosuch"),
    ] {
        let ran = folder.run(&["encode", "no-such-input.brdf", "-o", output]);
        assert!(ran.code == code && ran.stderr.contains(expected), "{output}: {} {}", ran.code, ran.stderr);
    }
    assert!(folder.files(".").is_empty());
}

#[test]
fn energy_preserving_packs_are_marked() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    for (more, is_preserving) in [(&[][..], true), (&["--plain-levels"], false)] {
        let report = encode(&folder, "synth:ggx?alpha=0.3", &[&["--codec", "wavelet", "--grid", "8"], more].concat());
        let wavelet = &report["codec"]["wavelet"];
        // At the finest level, both have the same fetches.
        assert_eq!((&wavelet["energy_preserving"], report["fetches"].as_u64()), (&is_preserving.into(), Some(4 * 13)));
        let info = folder.run(&["info", "pack.ktx2"]).succeeded().stdout;
        assert_eq!(info.contains("3, stored up to 3, energy-preserving"), is_preserving, "{info}");
        bytes.push(report["bytes_on_gpu"].as_u64().unwrap());
    }
    // Trees of 1, 4 and 16 slices of 64 texels, and three rows of the index map.
    assert_eq!(bytes[0] - bytes[1], 21 * 64 + 3 * 8 * 16);
}

/// Repairs and the cost of averaging are reported.
#[test]
fn raised_rows_and_averaging_are_reported() {
    let folder = Folder::new();
    let mut text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n".to_owned();
    for (k, angles) in [
        "0,0,0,0",
        "0.5,0,0.5,3",
        "0.5,0,0.1,1.5",
        "1,0,1,3",
        "1,0,0.3,0.7",
        "0.2,0,0.9,1",
        "0.7,0,0.2,2",
        "1.3,0,1.2,3",
    ]
    .iter()
    .enumerate()
    {
        text += &format!("{angles},{},0.2,0.1\n", if k == 2 { -0.01 } else { 0.1 + 0.1 * k as f64 });
    }
    folder.write("scan.csv", text);
    let ran = folder.run(&["encode", "scan.csv", "-o", "p.ktx2", "--codec", "table", "--reciprocal"]).succeeded();
    assert!(ran.stderr.contains("1 of 8 rows (12.5 %) had a negative channel"), "{}", ran.stderr);
    assert!(ran.stderr.contains("symmetrising alone causes a ΔE of "), "{}", ran.stderr);
}

#[test]
fn targets_out_of_reach_exit_with_1_and_write_nothing() {
    let folder = Folder::new();
    for (more, expected) in [
        (["--max-error", "0.000001"], "--max-error: found ε_r "),
        (["--max-bytes", "10"], "--max-bytes: found 10 bytes, expected at least "),
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
fn an_existing_pack_is_replaced_completely_or_not_at_all() {
    let folder = Folder::new();
    folder.write("p.ktx2", b"old");
    assert_eq!(folder.run(&["encode", "synth:nothing", "-o", "p.ktx2"]).code, 3);
    assert_eq!(folder.read("p.ktx2"), b"old");
    folder.run(&["encode", "synth:lambert", "-o", "p.ktx2", "--grid", "2"]).succeeded();
    assert!(folder.run(&["info", "p.ktx2"]).succeeded().stdout.contains("wavelet pack"));
    assert_eq!(folder.files(".").len(), 1);
}

/// Without options: the smallest pack that meets the limits, and the candidates before it.
#[test]
fn without_options_the_smallest_pack_that_looks_right_is_selected() {
    let folder = Folder::new();
    let report = encode(&folder, "synth:ggx?kd=0.3,0.1,0.05&alpha=0.15", &[]);
    let tried = report["tried"].as_array().unwrap();
    let (last, before) = tried.split_last().unwrap();
    assert!(before.iter().all(|trial| trial["meets"] == false) && last["meets"] == true, "{report}");
    assert_eq!((&last["bytes_on_gpu"], &last["codec"]), (&report["bytes_on_gpu"], &"table".into()));
    assert_eq!(last["delta_e"], report["off_grid"]["rendering"]["delta_e"]["mean"]);
    assert!(last["delta_e"].as_f64().unwrap() <= 0.5 && report["missed"].is_null(), "{report}");
    assert_eq!((&report["fetches"], report["bytes_on_gpu"].as_u64().unwrap() <= 16 << 10), (&1.into(), true));
    let trials = report["stages"].as_array().unwrap().iter().filter(|stage| stage["stage"] == "try").count();
    assert_eq!(trials, tried.len(), "a time for each");
    // A tighter budget needs more bytes, a budget of bytes is used up, and the text lists the candidates.
    let closer = encode(&folder, "synth:ggx?kd=0.3,0.1,0.05&alpha=0.15", &["--max-delta-e", "0.1"]);
    assert!(closer["bytes_on_gpu"].as_u64() > report["bytes_on_gpu"].as_u64(), "{closer}");
    let filled = encode(&folder, "synth:lewis", &["--max-bytes", "3000"]);
    let bytes = filled["bytes_on_gpu"].as_u64().unwrap();
    assert!(bytes <= 3000, "{bytes}");
    let text = folder.run(&["encode", "synth:lewis", "-o", "p.ktx2"]).succeeded().stdout;
    assert!(text.starts_with("tried") && text.contains("meets the limits"), "{text}");
    // A codec that is given is not searched for.
    let wavelet = encode(&folder, "synth:lewis", &["--codec", "wavelet", "--grid", "8"]);
    assert!(wavelet["codec"]["wavelet"]["grid"] == 8 && wavelet["tried"].as_array().unwrap().is_empty());
    let table = encode(&folder, "synth:lewis", &["--codec", "table", "--max-bytes", "1000", "--reciprocal"]);
    assert!(table["codec"]["table"]["symmetry"]["reciprocal"] == true && table["bytes_on_gpu"].as_u64() <= Some(1000));
}

/// If no pack meets the limits, the best one is selected and reported, and the exit code is 1.
#[test]
fn a_budget_that_nothing_meets_keeps_the_best() {
    let folder = Folder::new();
    let input = "synth:ggx?kd=0.3,0.1,0.05&alpha=0.05";
    let ran = folder.run(&["encode", input, "-o", "p.ktx2", "--max-delta-e", "0.05", "--max-bytes", "3000", "--json"]);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    let expected = "no tried pack of at most 3000 bytes meets the limits; the closest one has a mean ΔE of ";
    assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    let report = ran.json();
    conforms("encode", &report);
    assert!(report["missed"].is_string() && report["bytes_on_disk"] == folder.read("p.ktx2").len(), "{report}");
    assert!(report["tried"].as_array().unwrap().iter().all(|trial| trial["meets"] == false));
}

#[test]
fn spectra_of_a_part_of_the_visible_range_are_reported() {
    let folder = Folder::new();
    folder.run(&["synth", "lambert?kd=0.6,0.1,0.05", "-o", "full.brdf", "--rows", "240"]).succeeded();
    let full = folder.run(&["encode", "full.brdf", "-o", "p.ktx2"]).succeeded();
    assert!(!full.stderr.contains("visible range"), "{full:?}");
    let lines = folder.text("full.brdf");
    let cut: String = lines
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            [count] if *count == "31" => "16\n".to_owned(),
            [first, ..] if first.starts_with('#') => format!("{line}\n"),
            words @ [_, ..] if words.len() == 31 => words[..16].join(" ") + "\n",
            words => words[..words.len().min(20)].join(" ") + "\n",
        })
        .collect();
    folder.write("cut.brdf", cut);
    let ran = folder.run(&["encode", "cut.brdf", "-o", "p.ktx2"]).succeeded();
    assert!(ran.stderr.contains("spectra cover 400 to 550 nm"), "{ran:?}");
}

#[test]
fn budgets_that_say_nothing_are_refused() {
    let folder = Folder::new();
    for (input, more, code, expected) in [
        ("synth:lewis", &["--max-bytes", "150"][..], 1, "--max-bytes: found 150 bytes, expected at least"),
        ("synth:lewis", &["--max-bytes", "0"], 2, "--max-bytes: found 0, expected 1 or more"),
        ("synth:lewis", &["--max-fetches", "0"], 2, "--max-fetches: found 0, expected 1 or more"),
        ("synth:lewis", &["--max-delta-e", "0"], 2, "--max-delta-e: found 0, expected 1e-6 to 100"),
        ("synth:lewis", &["--max-delta-e=-1"], 2, "--max-delta-e: found -1, expected 1e-6 to 100"),
        ("synth:lewis", &["--max-delta-e", "nan"], 2, "--max-delta-e: found NaN, expected 1e-6 to 100"),
        (
            "synth:lewis",
            &["--max-error", "3"],
            2,
            "--max-error: found 3, expected a fraction or a percentage; write 0.03 or 3%",
        ),
        ("synth:ward?ax=0.1&ay=0.4", &["--max-fetches", "1"], 1, "--max-fetches: found 1, expected at least 2; an "),
        ("synth:lambert?kd=0", &["--max-error", "1%"], 1, "black everywhere"),
        ("synth:lambert?kd=0", &["--max-delta-e", "0.5"], 1, "black everywhere"),
        ("synth:lambert?kd=1e-310", &["--max-delta-e", "0.5"], 1, "black everywhere"),
        ("synth:lewis", &["--codec", "jpeg"], 2, "--codec: found \"jpeg\", expected auto, table, factored"),
        (
            "synth:lewis",
            &["--codec", "table", "--grid", "8"],
            2,
            "--grid: does not apply to the codec table; use the codec wavelet",
        ),
        (
            "synth:lewis",
            &["--codec", "table", "--plain-levels"],
            2,
            "--plain-levels: does not apply to the codec table; use the codec wavelet",
        ),
        ("synth:lewis", &["--codec", "max_error"], 2, "--codec: found \"max_error\", expected auto, table, factored"),
        (
            "synth:lewis",
            &["--codec", "wavelet", "--max-error", "1%", "--max-bytes", "2000"],
            2,
            "--max-error: several limits; set only one of --ratio, --max-error and --max-bytes\n",
        ),
        ("synth:lewis", &["--max-bytes", "16XB"], 2, "expected a whole number of bytes, such as 16384, 16KiB or 1MiB"),
        (
            "synth:lewis",
            &["--grid", "8", "--max-delta-e", "1"],
            2,
            "--max-delta-e: conflicts with --grid, an option of the codec wavelet; use the codec auto, table or ",
        ),
        (
            "synth:lewis",
            &["--ratio", "4", "--reciprocal"],
            2,
            "--reciprocal: conflicts with --ratio, an option of the codec wavelet; use the codec auto, table or ",
        ),
    ] {
        let ran = folder.run(&[&["encode", input, "-o", "p.ktx2"], more].concat());
        assert_eq!((ran.code, ran.stdout.as_str()), (code, ""), "{more:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{more:?}: {}", ran.stderr);
    }
    assert!(folder.files(".").is_empty());
    // Names that contain keys of options stay as they are.
    for (name, more, expected) in [
        ("levels.csv", ["--max-bytes", "3"], "levels.csv: --max-bytes: found 3 bytes, expected at least "),
        ("my_max_error.csv", ["--max-bytes", "3"], "my_max_error.csv: --max-bytes: found 3 bytes, expected at least "),
    ] {
        folder.run(&["synth", "lewis", "-o", name]).succeeded();
        let ran = folder.run(&[&["encode", name, "-o", "p.ktx2"], &more[..]].concat());
        assert!(ran.code != 0 && ran.stderr.contains(expected), "{name}: {ran:?}");
    }
    // Black without any statement about errors is black.
    let report = encode(&folder, "synth:lambert?kd=0", &[]);
    assert_eq!(report["off_grid"]["norms"]["rms"], 0.0);
    assert!(report["bytes_on_gpu"].as_u64() <= Some(1024), "{report}");
}

/// A scan of one incidence has no information about others: the limit is not met unless the fit is trusted.
#[test]
fn limits_are_those_against_the_material() {
    let folder = Folder::new();
    let mut scan = "theta_i,phi_i,theta_o,phi_o,r,g,b\n".to_owned();
    for k in 0..19 {
        let (theta_o, value) = (0.07 * f64::from(k), 0.3 + 0.01 * f64::from(k));
        scan += &format!("0.6,0,{theta_o},3.1,{value},{value},{value}\n");
    }
    folder.write("one.csv", scan);
    let encode = |more: &[&str]| folder.run(&[&["encode", "one.csv", "-o", "one.ktx2", "--json"], more].concat());
    // The default was not requested.
    let ran = encode(&[]).succeeded();
    assert!(ran.stderr.contains("a fit to samples, which is less accurate than the pack: "), "{}", ran.stderr);
    conforms("encode", &ran.json());
    assert!(ran.json()["fit"]["ball"]["uncovered"].as_f64().unwrap() > 0.5, "{}", ran.stdout);
    let ran = encode(&["--max-delta-e", "5"]);
    assert!(ran.code == 1 && ran.stderr.contains("fit: no reliable fit: "), "{ran:?}");
    assert_eq!(ran.json()["gates"][0]["passed"], false);
    encode(&["--max-delta-e", "5", "--trust-fit"]).succeeded();
    let ran = encode(&["--max-fit-error", "0.01%", "--trust-fit"]);
    assert!(ran.code == 1 && ran.stderr.contains("one.csv: --max-fit-error: found "), "{ran:?}");
    // One incidence predicts no other.
    let ran = encode(&["--max-fit-error", "1000%"]);
    assert!(ran.code == 1 && ran.stderr.contains(", extrapolated: "), "{ran:?}");
    encode(&["--max-fit-error", "1000%", "--trust-fit"]).succeeded();
    let ran = folder.run(&["render", "one.csv", "-o", "one.png", "--trust-fit"]);
    assert!(ran.code == 2 || ran.code == 5, "{ran:?}");
}

/// The highlight is a limit in addition to the ΔE and does not replace it.
#[test]
fn highlights_are_retained_without_other_losses() {
    let folder = Folder::new();
    let encode = |model: &str, more: &[&str]| {
        folder.run(&[&["encode", model, "-o", "x.ktx2", "--json"], more].concat()).succeeded().json()
    };
    let delta_e = |report: &serde_json::Value| report["off_grid"]["rendering"]["delta_e"]["mean"].as_f64().unwrap();
    let retained = |report: &serde_json::Value| report["off_grid"]["highlight"]["light"].as_f64().unwrap();
    let model = "synth:ggx?kd=0.3,0.1,0.05&alpha=0.03";
    let (without, with) = (encode(model, &["--min-highlight", "0"]), encode(model, &["--min-highlight", "0.97"]));
    assert!(
        retained(&with) >= 0.97 && retained(&with) >= retained(&without),
        "{} {}",
        retained(&without),
        retained(&with)
    );
    assert!(delta_e(&with) <= 0.5 && delta_e(&without) <= 0.5);
    // With bytes alone the best pack that fits is still selected.
    let bytes = encode(model, &["--max-bytes", "16KiB", "--min-highlight", "0.5"]);
    let plain = encode(model, &["--max-bytes", "16KiB"]);
    assert!(delta_e(&bytes) <= delta_e(&plain) + 1e-9 && retained(&bytes) >= 0.5);
}
