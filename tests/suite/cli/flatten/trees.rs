//! `brdfc flatten --reflectance pwt`.

use super::{file, flatten, number, report};
use crate::common::cli::Folder;
use serde_json::Value;

const KNIT: &str = "synth:knit?resolution=32";
const TREES: [&str; 2] = ["--reflectance", "pwt"];

/// A flat BTF of trees, with its report.
fn made(folder: &Folder, name: &str, more: &[&str]) -> Value {
    report(flatten(folder, &[&[KNIT, "-o", name], &TREES[..], more].concat()))
}

fn mean(report: &Value) -> f64 {
    number(&report["report"]["errors"]["from_surface"]["mean"])
}

#[test]
fn trees_are_a_third_form_of_reflectance() {
    let folder = Folder::new();
    let report = made(&folder, "trees", &[]);
    assert_eq!((&report["report"]["reflectance"], &report["settings"]["reflectance"]), (&"pwt".into(), &"pwt".into()));
    assert!(report["report"].get("factored").is_none() && report["images"].get("factored_weights").is_none());
    let trees = &report["trees"];
    assert_eq!((&trees["views"], &trees["size"]), (&7.into(), &vec![16, 16].into()));
    let images = report["images"].as_object().unwrap();
    let of_trees: u64 =
        images.iter().filter(|(name, _)| !name.starts_with("flat_btf")).filter_map(|(_, b)| b.as_u64()).sum();
    assert_eq!(trees["gpu_bytes"], of_trees);
    assert!(mean(&report) < 9.0 && number(&report["report"]["seen"]) > 0.5, "{report}");
    let file = file(&folder, "trees");
    let stored = file.decoder.parts().reflectance.trees().unwrap();
    assert!(!stored.has_shadows() && file.directions.is_none());
    assert!((stored.lowest_light() - 50f32.to_radians().cos()).abs() < 1e-6);
}

/// The commands for flat BTFs take the file.
#[test]
fn all_commands_take_the_file() {
    let folder = Folder::new();
    made(&folder, "trees", &[]);
    flatten(&folder, &[KNIT, "-o", "plain"]).succeeded();
    let info = folder.run(&["info", "trees"]).succeeded();
    for words in ["pwt: ", "light", "domain", "fetches", "PSNR", "7 (grid:2x6@50) x 7"] {
        assert!(info.stdout.contains(words), "{words}: {}", info.stdout);
    }
    folder.write(
        "places.csv",
        "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0.3,0.6,0,0.6,0.8,0.6,0,0.8\n0.3,0.6,0,0.6,-0.8,0.6,0,0.8\n",
    );
    let [trees, plain] = ["trees", "plain"].map(|name| {
        let values = folder.run(&["eval", name, "--directions", "places.csv"]).succeeded().stdout;
        let rows: Vec<Vec<f64>> = values
            .lines()
            .skip(1)
            .map(|line| line.split(',').skip(8).map(|number| number.parse().unwrap()).collect())
            .collect();
        assert_eq!(rows[1], [0.0; 3], "{values}");
        rows[0].clone()
    });
    for (found, expected) in trees.iter().zip(&plain) {
        assert!((found - expected).abs() < 0.15, "{trees:?} {plain:?}");
    }
    let differs = folder.run(&["compare", "plain", "trees", "--json"]).succeeded().json();
    assert!((0.5..12.0).contains(&number(&differs["errors"]["mean"])), "{differs}");
    assert_eq!(number(&folder.run(&["compare", "trees", "trees", "--json"]).succeeded().json()["errors"]["mean"]), 0.0);
    folder.run(&["report", "trees", "-o", "report.html"]).succeeded();
    let page = folder.text("report.html");
    assert!(page.contains("pwt_texture_0") && page.contains("alt=\"seen from 60°"), "{page}");
    folder.run(&["view", "trees", "plain", "-o", "page.html"]).succeeded();
    let shader = folder.run(&["shader", "trees", "--language", "wgsl"]).succeeded();
    assert!(shader.stdout.contains("fn flat_trees_value("));
    let refused = folder.run(&["pwt", "trees", "--view", "all", "-o", "again.ktx2"]);
    let words = "flat BTF: trees; expected a flat BTF made with --reflectance factors";
    assert!(refused.code == 3 && refused.stderr.contains(words), "{refused:?}");
    let other = folder.run(&["encode", "trees/trees.ktx2", "-o", "other.ktx2"]);
    assert!(other.code == 3 && other.stderr.contains("a flat BTF has no single BRDF"), "{other:?}");
    #[cfg(feature = "render")]
    if crate::common::has_adapter() {
        let drawn = folder.run(&["render", "trees", "--size", "24x24", "--json"]).succeeded().json();
        assert_eq!(drawn["parts"][0]["material"], "trees (pwt)", "{drawn}");
    }
}

/// Over an indirection map and with bounced light, values include shadows; ordinary BTFs likewise.
#[test]
fn shadows_are_in_trees_or_from_rays() {
    let folder = Folder::new();
    let has_shadows =
        |name: &str| file(&folder, name).decoder.parts().reflectance.trees().map(|trees| trees.has_shadows());
    let map = made(&folder, "map", &["--relief", "vdim"]);
    assert_eq!((has_shadows("map"), map["images"].get("flat_btf_shadows")), (Some(true), None));
    let bare = made(&folder, "bare", &["--relief", "vdim", "--shadows", "none"]);
    assert_eq!(has_shadows("bare"), Some(false));
    assert!(mean(&map) != mean(&bare), "{} {}", mean(&map), mean(&bare));
    made(&folder, "bounced", &["--bounces", "4"]);
    assert_eq!(has_shadows("bounced"), Some(true));
    flatten(&folder, &[KNIT, "-o", "first", "--write-images", "images"]).succeeded();
    let measured = report(flatten(&folder, &[&["images", "--geometry", KNIT, "-o", "measured"], &TREES[..]].concat()));
    assert_eq!(has_shadows("measured"), Some(true));
    assert!(number(&measured["report"]["errors"]["from_images"]["mean"]) < 9.0, "{measured}");
}

#[test]
fn limits_apply_to_trees() {
    let folder = Folder::new();
    let small = made(&folder, "small", &["--max-bytes", "20KiB"]);
    assert!(small["trees"]["gpu_bytes"].as_u64().unwrap() <= 20 << 10, "{small}");
    let large = made(&folder, "large", &["--max-bytes", "1MiB"]);
    let delta_e = |report: &Value| number(&report["trees"]["errors"]["delta_e"]);
    assert!(delta_e(&large) < delta_e(&small), "{small} {large}");
    let tight = ["--max-bytes", "1KiB"];
    let refused = flatten(&folder, &[&[KNIT, "-o", "never"], &TREES[..], &tight].concat());
    assert!(refused.code == 1 && refused.stderr.contains("--max-bytes: found 1024, expected "), "{refused:?}");
    assert!(folder.files("never").is_empty());
    let missed = flatten(&folder, &[&[KNIT, "-o", "missed"], &TREES[..], &["--max-delta-e", "0.001"]].concat());
    assert!(missed.code == 1 && missed.stderr.contains("--max-delta-e: found a mean ΔE of "), "{missed:?}");
    // All values at the default size do not fit into memory.
    let ran = folder.run(&[&["flatten", KNIT, "-o", "never"], &TREES[..]].concat());
    assert!(ran.code == 2 && ran.stderr.contains("memory: found 12.9 GiB, expected at most 8.0 GiB"), "{ran:?}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    for threads in ["1", "3"] {
        let base = ["flatten", KNIT, "-o", threads, "--name", "trees", "--texels", "16", "--views", "grid:2x6@50"];
        folder.run(&[&base[..], &TREES, &["-j", threads]].concat()).succeeded();
    }
    assert_eq!(folder.files("1"), folder.files("3"));
}
