//! `brdfc flatten`, from every kind of input.

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use serde_json::Value;

/// Small enough for seconds: 7 views and lights.
const SMALL: [&str; 8] = ["--texels", "16", "--views", "grid:2x6@50", "--indirection", "4x6", "--oversampling", "1"];

fn flatten(folder: &Folder, arguments: &[&str]) -> Ran {
    folder.run(&[&["flatten"], arguments, &SMALL, &["--json", "-j", "2"]].concat())
}

fn report(ran: Ran) -> Value {
    let report = ran.succeeded().json();
    conforms("flatten", &report);
    report
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

#[test]
fn every_structure_and_every_part() {
    let folder = Folder::new();
    for name in ["button", "folds", "knit", "sponge"] {
        let report = report(flatten(&folder, &[&format!("synth:{name}?resolution=48"), "-o", name]));
        for part in ["position", "normal", "diffuse", "reference", "indirection", "mask", "flat.000", "flat.006"] {
            let file = report["parts"][part]["file"].as_str().unwrap_or_else(|| panic!("{part}: {report}"));
            assert_eq!(file, format!("{name}.{part}.ktx2"));
            let length = std::fs::metadata(folder.path().join(name).join(file)).unwrap().len();
            assert_eq!(report["parts"][part]["bytes"], length);
        }
        assert_eq!(report["parts"].as_object().unwrap().len(), 13);
        assert_eq!(report["report"]["parameterisation"]["flipped"], 0);
        let errors = &report["report"]["errors"];
        assert!(number(&errors["at_samples"]["mean"]) < number(&errors["light_form"]["mean"]) + 5.0, "{errors}");
        let listed: Value =
            serde_json::from_slice(&std::fs::read(folder.path().join(name).join(format!("{name}.json"))).unwrap())
                .unwrap();
        conforms("flat-btf", &listed);
        assert_eq!(listed["parts"], report["parts"]);
    }
}

#[test]
fn a_matte_plane_is_exact() {
    let folder = Folder::new();
    folder.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    let plane = ["plane.obj", "--material", "synth:lambert?kd=0.5", "-o", "plane"];
    let report = report(flatten(&folder, &plane));
    assert!((number(&report["report"]["seen"]) - 1.0).abs() < 1e-12);
    let errors = &report["report"]["errors"];
    for kind in ["at_samples", "light_form"] {
        assert!(number(&errors[kind]["max"]) < 0.1, "{errors}");
    }
    // The cosine of lights is blended between samples 50 degrees apart.
    assert!((0.1..5.0).contains(&number(&errors["between_samples"]["mean"])), "{errors}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for (out, jobs) in [("one", "1"), ("three", "3")] {
        let input = ["flatten", "synth:folds?resolution=32", "--name", "folds", "-o", out, "-j", jobs];
        folder.run(&[&input[..], &SMALL].concat()).succeeded();
    }
    let (one, three) = (folder.files("one"), folder.files("three"));
    assert_eq!(one.len(), 14);
    assert!(one.values().eq(three.values()) && one.len() == three.len());
}

#[test]
fn meshes_written_by_synth_and_height_maps() {
    let folder = Folder::new();
    for kind in ["obj", "ply"] {
        let mesh = format!("folds.{kind}");
        folder.run(&["synth", "folds?resolution=32", "-o", &mesh]).succeeded();
        let report = report(flatten(&folder, &[&mesh, "-o", kind, "--material", "synth:lambert?kd=0.4"]));
        assert_eq!(report["report"]["mended"]["triangles"], 2 * 32 * 32);
        assert!(number(&report["report"]["mended"]["merged_vertices"]) > 60.0);
        assert_eq!(report["source"], mesh);
    }
    let mut bytes = Vec::new();
    let heights: Vec<u8> = (0..24 * 24).map(|i| if (i % 24) < 12 { 0 } else { 255 }).collect();
    image::write_buffer_with_format(
        &mut std::io::Cursor::new(&mut bytes),
        &heights,
        24,
        24,
        image::ColorType::L8,
        image::ImageFormat::Png,
    )
    .unwrap();
    folder.write("step.png", bytes);
    let report = report(flatten(&folder, &["step.png", "-o", "step", "--height-scale", "0.2"]));
    let heights = &report["report"]["heights"];
    assert!((number(&heights[0])).abs() < 1e-9 && (number(&heights[1]) - 0.2).abs() < 1e-9, "{heights}");
}

#[test]
fn height_maps_of_too_many_pixels_are_refused_before_any_work() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    image::write_buffer_with_format(
        &mut std::io::Cursor::new(&mut bytes),
        &vec![0; 1025 * 1024],
        1025,
        1024,
        image::ColorType::L8,
        image::ImageFormat::Png,
    )
    .unwrap();
    folder.write("large.png", bytes);
    let ran = flatten(&folder, &["large.png", "-o", "large"]);
    let expected = "large.png: PNG: found 1025 x 1024 pixels; allowed 4 to 8192 per side, and at most 1048576";
    assert!(ran.code == 3 && ran.stderr.contains(expected), "{ran:?}");
    assert!(!folder.path().join("large").exists());
}

#[test]
fn an_ordinary_btf_goes_out_and_comes_in_again() {
    let folder = Folder::new();
    let sponge = "synth:sponge?resolution=48&height=0.6";
    let images = ["--write-images", "images", "--image-format", "exr", "--flat-texels", "32"];
    let first = report(flatten(&folder, &[&[sponge, "-o", "first"], &images[..]].concat()));
    assert_eq!(folder.files("images").len(), 49);
    let again = ["images", "--geometry", sponge, "-o", "second", "--flat-texels", "32"];
    let second = report(flatten(&folder, &again));
    assert_eq!(second["settings"]["views"][1], 7);
    let seen = |report: &Value| number(&report["report"]["seen"]);
    assert!((seen(&first) - seen(&second)).abs() < 1e-9);
    // Over a plane the same images keep their parallax in the texels: less of them fits together.
    let plane = report(flatten(&folder, &["images", "-o", "plane", "--flat-texels", "32"]));
    assert!((seen(&plane) - 1.0).abs() < 1e-12);
    let error = |report: &Value| number(&report["report"]["errors"]["light_form"]["mean"]);
    assert!(error(&second) < error(&plane), "{} {}", error(&second), error(&plane));
}

#[test]
fn the_light_form_writes_no_views_and_the_same_colours() {
    let folder = Folder::new();
    for (out, form) in [("full", "full"), ("light", "light")] {
        flatten(&folder, &["synth:button?resolution=32", "-o", out, "--name", "b", "--form", form]).succeeded();
    }
    let (full, light) = (folder.files("full"), folder.files("light"));
    assert_eq!((full.len(), light.len()), (14, 7));
    for part in ["b.diffuse.ktx2", "b.normal.ktx2", "b.indirection.ktx2"] {
        let find = |files: &std::collections::BTreeMap<String, Vec<u8>>| {
            files.iter().find(|(path, _)| path.ends_with(part)).map(|(_, bytes)| bytes.clone()).unwrap()
        };
        assert_eq!(find(&full), find(&light), "{part}");
    }
}

#[test]
fn fewer_views_leave_no_stale_files() {
    let folder = Folder::new();
    flatten(&folder, &["synth:knit?resolution=32", "-o", "knit"]).succeeded();
    let fewer = ["flatten", "synth:knit?resolution=32", "-o", "knit", "--texels", "8", "--views", "grid:2x3@40"];
    folder.run(&[&fewer[..], &["--indirection", "4x6"]].concat()).succeeded();
    assert_eq!(folder.files("knit").len(), 6 + 4 + 1);
}

#[test]
fn options_change_what_they_say() {
    let folder = Folder::new();
    let mean = |report: &Value| number(&report["report"]["parameterisation"]["after"]["l2"]);
    let button = "synth:button?resolution=40";
    let plain = report(flatten(&folder, &[button, "-o", "a"]));
    let even = report(flatten(&folder, &[button, "-o", "b", "--stretch-rounds", "8"]));
    assert!(mean(&even) < 0.95 * mean(&plain), "{} {}", mean(&even), mean(&plain));
    let bounced = report(flatten(&folder, &[button, "-o", "c", "--bounces", "4", "--fill", "push-pull"]));
    assert!(bounced["report"]["errors"].as_object().unwrap().is_empty());
    assert_eq!(bounced["settings"]["fill"], "push-pull");
}
