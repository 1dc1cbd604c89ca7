//! Needs of a scene: `build --explain` and `--dry-run`, and the packs of such scenes.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

const SCENE: &str = "\
[materials.floor]\nsource = 'synth:ggx?kd=0.2&f0=0.04&alpha=0.3'\ncodec = 'wavelet'\ngrid = 16\nratio = 2\n\
[materials.wall]\nsource = 'table.binary'\n\
[materials.spare]\nsource = 'none.binary'\n\
[[uses]]\nobject = 'courtyard'\nmaterial = 'floor'\nnearest = 20\nview_elevation = [35, 90]\nlight_elevation = [30, 90]\n\
[[uses]]\nmaterial = 'wall'\n";

fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("scene.toml", SCENE);
    folder
}

/// Hundreds of unused materials are one line.
#[test]
fn what_is_not_used_is_one_line() {
    let folder = Folder::new();
    let spare = |k: usize| format!("[materials.spare-{k:03}]\nsource = 'none.binary'\n");
    let used = "[materials.wall]\nsource = 'synth:lambert'\n[[uses]]\nmaterial = 'wall'\n";
    folder.write("scene.toml", (0..300).map(spare).collect::<String>() + used);
    let ran = folder.run(&["build", "scene.toml", "--dry-run", "--explain"]).succeeded();
    let all: Vec<&str> = ran.stdout.lines().collect();
    assert!(all.len() < 12, "{}", ran.stdout);
    let message = ran.stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in ["spare-000, spare-001", "and 294 more", "no use refers to these 300", "wall"] {
        assert!(message.contains(words), "{words}: {}", ran.stdout);
    }
    assert!(!message.contains("spare-010"), "{}", ran.stdout);
    // Scripts get each of them.
    let report = folder.run(&["build", "scene.toml", "--dry-run", "--explain", "--json"]).succeeded().json();
    assert_eq!(report["needs"].as_array().unwrap().len(), 301);
}

#[test]
fn each_need_is_reported_with_its_reason_and_savings() {
    let folder = folder();
    let planned = folder.run(&["build", "scene.toml", "--dry-run", "--explain", "--json"]).succeeded().json();
    conforms("build", &planned);
    assert!(!folder.path().join("packs").exists(), "nothing is done");
    let built = folder.run(&["build", "scene.toml", "--explain", "--json"]).succeeded().json();
    conforms("build", &built);
    let of = |report: &serde_json::Value, need: &str| {
        let all = report["needs"].as_array().expect("needs").clone();
        all.into_iter().find(|entry| entry["need"].as_str().is_some_and(|text| text.contains(need))).expect(need)
    };
    for report in [&planned, &built] {
        let levels = of(report, "levels of detail 0 to 3 of 4");
        assert!(levels["material"] == "floor" && levels["why"] == "nearest at 20: courtyard", "{levels}");
        assert_eq!(of(report, "light from 30° to 90°, seen from 35° to 90°")["why"], "courtyard");
        assert_eq!(of(report, "all levels of detail and directions")["why"], "uses[1]");
        assert_eq!(of(report, "nothing")["material"], "spare");
    }
    // The savings are known after the build.
    assert!(of(&planned, "seen from")["saved_bytes"].is_null());
    let saved = of(&built, "seen from")["saved_bytes"].as_u64().expect("bytes");
    let floor = &built["materials"][0]["report"];
    assert!(saved > 0 && floor["cropped_bytes"] == saved && floor["directions"]["view"]["from"] == 35.0, "{floor}");
    assert!(of(&built, "nothing")["saved_seconds"].as_f64().is_some_and(|seconds| seconds > 0.0));
    // The final report does not contain them.
    assert!(
        !folder.text("packs/report.json").contains("because") && !folder.text("packs/report.json").contains("needs")
    );

    let text = folder.run(&["build", "scene.toml", "--explain"]).succeeded().stdout;
    assert!(text.contains("because of") && text.contains("about"), "{text}");
}

/// The savings of a need in a search are known if the pack without it was made as well, and are not claimed otherwise.
#[test]
fn savings_are_against_what_was_made_without_the_need() {
    let folder = Folder::new();
    let material = "[materials.a]\nsource = 'synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.1'\nmax_bytes = '4KiB'\n";
    let explained = |limit: &str, range: &str| {
        let text = format!("{}[[uses]]\nmaterial = 'a'\n{range}", material.replace("max_bytes = '4KiB'", limit));
        folder.write("scene.toml", text);
        let report = folder.run(&["build", "scene.toml", "--explain", "--json"]).succeeded().json();
        conforms("build", &report);
        let bytes = report["materials"][0]["report"]["bytes_on_gpu"].as_u64().expect("bytes");
        (bytes, report["needs"][0]["saved_bytes"].as_u64())
    };
    let narrow = "view_elevation = [40, 90]\nlight_elevation = [40, 90]\n";
    let (_, before) = explained("max_delta_e = 0.3\nlevels = 1", narrow);
    let (whole, none) = explained("max_delta_e = 0.3\nlevels = 1", "");
    let (cropped, after) = explained("max_delta_e = 0.3\nlevels = 1", narrow);
    let saved = whole.checked_sub(cropped).filter(|bytes| *bytes > 0);
    assert!(none.is_none() && saved.is_some() && after == saved, "{whole} {cropped} {after:?}");
    assert!(before.is_none() || before == saved, "{before:?}");
    // With a budget of bytes, cropping leaves room for more nodes.
    let (_, filled) = explained("max_bytes = '4KiB'", narrow);
    assert_eq!(filled, None);
}

#[test]
fn sizes_are_predicted_and_then_known() {
    let folder = folder();
    let report = || folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    let predicted = |report: &serde_json::Value, k: usize| {
        let found = &report["materials"][k]["predicted"];
        [&found["least"], &found["most"]].map(|bytes| bytes.as_u64().expect("bytes"))
    };
    let before = report();
    let text = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded().stdout;
    assert!(text.contains("searched, up to "), "{text}");
    folder.run(&["build", "scene.toml"]).succeeded();
    let built = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
    let after = report();
    for k in 0..2 {
        let made = built["materials"][k]["report"]["bytes_on_gpu"].as_u64().expect("bytes");
        let [least, most] = predicted(&before, k);
        assert!(least <= made && made <= most && least < most, "{least} {made} {most}");
        assert_eq!(predicted(&after, k), [made; 2]);
        assert!(before["materials"][k]["cached"].is_null() && after["materials"][k]["cached"] == true);
    }
    let text = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded().stdout;
    assert!(text.contains("cached"), "{text}");
    // A dry run leaves the folder unchanged, and ignores the cache with --no-cache.
    let text = folder.run(&["build", "scene.toml", "--dry-run", "--no-cache"]).succeeded().stdout;
    assert!(!text.contains("cached"), "{text}");
}

#[test]
fn a_pack_says_what_it_is_for_and_is_compared_there() {
    let folder = folder();
    folder.run(&["build", "scene.toml"]).succeeded();
    let info = folder.run(&["info", "packs/floor.brdf.ktx2"]).succeeded().stdout;
    assert!(info.contains("light from 30° to 90°, seen from 35° to 90°; errors are measured there"), "{info}");
    let address = "synth:ggx?kd=0.2&f0=0.04&alpha=0.3";
    let ran = folder.run(&["compare", address, "packs/floor.brdf.ktx2", "--json"]).succeeded();
    assert!(ran.stderr.contains("compared only at directions that both contain: light from 30°"), "{}", ran.stderr);
    assert!(ran.json()["directions"]["light"]["from"] == 30.0, "{}", ran.stdout);
    let text = folder.run(&["compare", address, "packs/floor.brdf.ktx2"]).succeeded().stdout;
    assert!(
        text.starts_with("directions: light from 30°") && text.contains("ΔE within the directions, mean"),
        "{text}"
    );
    let text = folder.run(&["compare", address, "table.binary"]).succeeded().stdout;
    assert!(text.starts_with("norm") && text.contains("ΔE of a ball, mean"), "{text}");
    let within = ran.json()["norms"]["relative_mean"].as_f64().expect("a number");
    let list =
        folder.run(&["compare", address, "packs/floor.brdf.ktx2", "--directions", "20000", "--json"]).succeeded();
    let everywhere = list.json()["norms"]["relative_mean"].as_f64().expect("a number");
    assert!(within < 0.7 * everywhere, "{within} {everywhere}");

    // Its packs are unsuitable for other uses.
    folder.run(&["encode", "packs/floor.brdf.ktx2", "-o", "again.ktx2", "--max-bytes", "2000"]).succeeded();
    let again = folder.run(&["info", "again.ktx2"]).succeeded().stdout;
    assert!(again.contains("seen from 35° to 90°; errors are measured there"), "{again}");
    let eval = folder.run(&["samples", "packs/floor.brdf.ktx2", "--count", "64", "-o", "samples.ktx2"]).succeeded();
    assert!(eval.stderr.contains("the pack covers light from 30°"), "{}", eval.stderr);

    folder.write("above.toml", SCENE.replace("view_elevation = [35, 90]", "view_elevation = [0, 30]"));
    folder.run(&["build", "above.toml", "--out", "above"]).succeeded();
    let apart = folder.run(&["compare", "above/floor.brdf.ktx2", "packs/floor.brdf.ktx2"]);
    assert!(apart.code == 1 && apart.stderr.contains("no directions in common: A covers "), "{}", apart.stderr);
}
