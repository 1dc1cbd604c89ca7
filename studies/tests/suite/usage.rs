//! Help and wrong usage.

use super::folder;
use brdfc_testing::program::Folder;

#[track_caller]
fn refused(folder: &Folder, arguments: &[&str], code: i32, expected: &[&str]) {
    let ran = folder.run(arguments);
    assert_eq!((ran.code, ran.stdout.as_str()), (code, ""), "{arguments:?}: {}", ran.stderr);
    for text in expected {
        assert!(ran.stderr.contains(text), "{arguments:?}: {}", ran.stderr);
    }
}

#[test]
fn the_help_has_examples_and_short_lines() {
    let help = folder().run(&["--help"]).succeeded().stdout;
    assert!(help.contains("\n  brdfc-bench --study rays synth:folds\n"), "{help}");
    for line in help.lines() {
        assert!(line.chars().count() <= 120, "{line}");
    }
}

#[test]
fn flags_that_do_not_apply_to_the_study() {
    let folder = folder();
    folder.write("m.obj", "no folder");
    refused(&folder, &["--study", "rays", "--out", "m.obj"], 4, &["cannot write: not a folder"]);
    refused(&folder, &["--study", "rays", "--directions", "ubo2003"], 2, &["expected with --study flat-btf"]);
    refused(&folder, &["--study", "rays", "--indirection", "8x8"], 2, &["expected with --study flat-btf"]);
    let flat = |option: [&str; 2], expected: &[&str]| {
        refused(&folder, &[&["--study", "flat-btf", "synth:knit"][..], &option].concat(), 2, expected);
    };
    flat(["--indirection", "1x8"], &["--indirection: found 1x8, expected 2 to 256 polar angles x 4 to 256"]);
    flat(["--indirection", "256x256"], &["--texels x --indirection: found a map of 1073741824 samples"]);
    flat(["--largest-angle", "90"], &["--largest-angle: found 90, expected above 0, up to 89 degrees"]);
    refused(
        &folder,
        &["synth:knit"],
        2,
        &["flat-btf, measured-btf, relief and rays (structures)", "images: materials"],
    );
    refused(&folder, &["synth:lewis"], 2, &["expected with the studies that draw"]);
    refused(&folder, &["--out", "x"], 2, &["--study level-of-detail"]);
}

/// A negative number is parsed as a value, and the error gives the expected range.
#[test]
fn negative_numbers_are_values() {
    let folder = folder();
    for (flag, study) in [
        ("--texels", "flat-btf"),
        ("--flat-texels", "flat-btf"),
        ("--indirection", "flat-btf"),
        ("--largest-angle", "flat-btf"),
        ("--pixels", "adaptive"),
        ("--truth", "adaptive"),
        ("--jobs", "rays"),
    ] {
        for value in ["-1", "-.5", "-1e3", "-5%", "-1x2"] {
            refused(&folder, &["--study", study, flag, value], 2, &["brdfc-bench: ", ": found ", ", expected "]);
        }
    }
}

#[cfg(feature = "render")]
#[test]
fn without_a_driver_the_error_names_the_packages_to_install() {
    let folder = folder();
    let mut command = folder.command(&["--study", "throughput"]);
    let output =
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent").output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(5), "{stderr}");
    assert!(stderr.contains("no usable graphics adapter"), "{stderr}");
    assert!(stderr.contains("apt-get install mesa-vulkan-drivers libvulkan1"), "{stderr}");
}
