//! `brdfc convert`: the output is readable by other programs, and its error is reported.

use super::schemas::conforms;
use crate::common::cli::Folder;

fn relative_error(report: &serde_json::Value) -> f64 {
    report["norms"]["relative_mean"].as_f64().unwrap()
}

#[test]
fn every_kind_of_file_is_read_again() {
    let folder = Folder::new();
    let red = brdfc_testing::testdata("demo/red_plastic.binary");
    folder.run(&["encode", &red, "-o", "red.ktx2"]).succeeded();
    for (input, output, more, kind, delta_e) in [
        ("synth:lewis", "lewis.binary", &["--dimensions", "45x45x90"][..], "merl", 0.1),
        ("red.ktx2", "red.binary", &["--dimensions", "30x30x60"], "merl", 1.5),
        ("red.ktx2", "red.bsdf", &[], "rgl", 0.2),
        ("synth:ward?kd=0.2&ax=0.2&ay=0.4", "ward.bsdf", &[], "rgl", 0.5),
        ("synth:lewis", "lewis.csv", &["--grid", "8x12x24"], "csv", 1.0),
        ("synth:ward?kd=0.2&ax=0.2&ay=0.4", "ward.csv", &["--grid", "6x8x16"], "csv", 6.0),
    ] {
        let report = folder.run(&[&["convert", input, "-o", output, "--json"], more].concat()).succeeded().json();
        conforms("convert", &report);
        assert_eq!((&report["kind"], &report["bytes_on_disk"]), (&kind.into(), &folder.read(output).len().into()));
        let found = report["rendering"]["delta_e"]["mean"].as_f64().unwrap();
        assert!(found < delta_e && report["values"].as_u64().unwrap() > 1000, "{output}: {found}");
        // The errors are those of the file.
        let compared = folder.run(&["compare", input, output, "--json"]).succeeded().json();
        assert_eq!(relative_error(&compared), relative_error(&report), "{output}");
    }
    // The output is an ordinary input.
    folder.run(&["encode", "red.bsdf", "-o", "again.ktx2"]).succeeded();
    let back = folder.run(&["compare", "red.ktx2", "again.ktx2", "--json"]).succeeded().json();
    assert!(back["rendering"]["delta_e"]["mean"].as_f64().unwrap() < 1.5, "{back}");
}

#[test]
fn threads_and_repetition_change_nothing() {
    let folder = Folder::new();
    for (output, grid) in [("a.bsdf", &[][..]), ("a.csv", &["--grid", "6x8x16"])] {
        let convert = |jobs| {
            folder.run(&[&["convert", "synth:ggx?alpha=0.2", "-o", output, "--jobs", jobs], grid].concat()).succeeded();
        };
        convert("1");
        let alone = folder.read(output);
        convert("3");
        assert!(alone == folder.read(output), "{output}");
    }
}

/// Wavelet packs do not state whether they are isotropic; their values do.
#[test]
fn wavelet_packs_of_isotropic_materials_become_merl_tables() {
    let folder = Folder::new();
    for (model, fits) in [
        ("synth:lambert?kd=0.5", true),
        ("synth:ggx?kd=0.1&alpha=0.3", true),
        ("synth:ggx?kd=0.2&alpha=0.1", true),
        ("synth:ward?kd=0.1&ax=0.2&ay=0.26", false),
        ("synth:ward?kd=0.2&ax=0.2&ay=0.4", false),
    ] {
        folder.run(&["encode", model, "--codec", "wavelet", "--ratio", "16", "-o", "it.ktx2"]).succeeded();
        let ran = folder.run(&["convert", "it.ktx2", "-o", "it.binary", "--dimensions", "30x30x60", "--json"]);
        assert_eq!(ran.code, if fits { 0 } else { 3 }, "{model}: {}", ran.stderr);
        if fits {
            let delta_e = ran.json()["rendering"]["delta_e"]["mean"].as_f64().unwrap();
            assert!(delta_e < 1.0, "{delta_e}");
        }
    }
}

#[test]
fn unsuitable_inputs_and_options_are_reported() {
    let folder = Folder::new();
    folder.write("some.csv", b"no scan");
    for (arguments, code, problem) in [
        (
            &["synth:ward?ax=0.1&ay=0.4", "-o", "w.binary"][..],
            3,
            "material: anisotropic, but MERL tables have no azimuth",
        ),
        (&["synth:lewis", "-o", "x.exr"], 2, "expected a name that ends in .binary, .bsdf or .csv, or - for stdout\n"),
        (&["synth:lewis", "-o", "x.PTM"], 2, ".bsdf or .csv, or - for stdout; 'brdfc pwt' writes .ptm\n"),
        (
            &["synth:lewis", "-o", "x.csv", "--dimensions", "8x8x8"],
            2,
            "--dimensions does not apply to x.csv, only to .binary files",
        ),
        (&["synth:lewis", "-o", "x.bsdf", "--grid", "8x8x8"], 2, "--grid does not apply to x.bsdf, only to .csv files"),
        (
            &["synth:lewis", "-o", "x.csv", "--grid", "1x8x8"],
            2,
            "--grid: found 1x8x8, expected three numbers from 2 to 1000",
        ),
        (&["synth:lewis", "-o", "x.csv", "--grid", "2x2x2"], 2, "--grid: found 2x2x2, which gives "),
        (&["synth:lewis", "-o", "x.binary", "--dimensions", "0x8x8"], 2, "--dimensions: found 0x8x8"),
        (&["some.csv", "-o", "some.csv"], 2, "--output: would overwrite the input some.csv"),
        (&["gone.brdf", "-o", "x.binary"], 4, "gone.brdf: cannot read"),
    ] {
        let ran = folder.run(&[&["convert"], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(problem) && ran.stdout.is_empty(), "{arguments:?}: {ran:?}");
    }
    assert_eq!(folder.files(".").len(), 1);
}

/// The file that standard input is redirected from has no name among the inputs.
#[cfg(unix)]
#[test]
fn standard_input_is_not_written_over() {
    let folder = Folder::new();
    folder.run(&["synth", "lambert", "-o", "in.binary", "--dimensions", "8x8x16"]).succeeded();
    let before = folder.read("in.binary");
    let input = std::fs::File::open(folder.path().join("in.binary")).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_brdfc"));
    command.current_dir(folder.path()).args(["convert", "-", "-o", "in.binary", "--dimensions", "4x4x8"]);
    let ran = command.stdin(input).output().unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(2), "{said}");
    assert!(said.contains("would overwrite in.binary, which is read from stdin"), "{said}");
    assert_eq!(folder.read("in.binary"), before);
}
