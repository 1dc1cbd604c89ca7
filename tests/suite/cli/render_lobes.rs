//! `brdfc render --environment` of materials, by their lobes.

use super::environment::sky;
use super::schemas::conforms;
use crate::common::cli::Folder;

const SMALL: [&str; 4] = ["--size", "48x48", "--samples", "1"];

#[test]
fn an_environment_lights_materials() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 300.0);
    folder.run(&["environment", "sky.exr", "-o", "sky.ktx2"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "--codec", "lobes", "-o", "ggx.ktx2"]).succeeded();
    for (input, environment, source) in [
        ("ggx.ktx2", "sky.exr", None),
        ("ggx.ktx2", "sky.ktx2", Some("synth:ggx?alpha=0.3")),
        ("synth:ggx?alpha=0.3", "sky.exr", Some("synth:ggx?alpha=0.3")),
    ] {
        let mut arguments = vec!["render", input, "--environment", environment, "-o", "o.png", "--json"];
        arguments.extend(SMALL);
        if let (Some(source), true) = (source, input.ends_with("ktx2")) {
            arguments.extend(["--source", source]);
        }
        let report = folder.run(&arguments).succeeded().json();
        conforms("render", &report);
        let mean = |key: &str| report[key]["delta_e"]["mean"].as_f64();
        assert!(mean("shading").unwrap() < 0.1, "{report}");
        // The reference is the integral over all directions.
        assert_eq!(mean("total").is_some(), source.is_some());
        assert!(mean("total").is_none_or(|total| total > 0.01 && total < 3.0), "{report}");
        assert!(image::open(folder.path().join("o.png")).is_ok());
    }
}

/// Without a file, the sky of the scene lights lobes.
#[test]
fn the_sky_of_the_scene_lights_lobes_by_default() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lambert?kd=0.5", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    let arguments = ["render", "l.ktx2", "--source", "synth:lambert?kd=0.5", "-o", "l.png", "--json"];
    let report = folder.run(&[&arguments[..], &SMALL].concat()).succeeded().json();
    let mean = |key: &str| report[key]["delta_e"]["mean"].as_f64().unwrap();
    assert!(mean("shading") < 0.1 && mean("total") < 1.0, "{report}");
}

#[test]
fn what_does_not_apply_is_refused() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 0.4);
    folder.run(&["encode", "synth:lambert", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert", "-o", "t.ktx2", "--max-bytes", "4096"]).succeeded();
    folder.write("s.toml", b"[materials.a]\nsource = 'synth:lambert'\n[[uses]]\nmaterial = 'a'\n");
    for (arguments, code, expected) in [
        (
            &["l.ktx2", "--environment", "t.ktx2"][..],
            3,
            "t.ktx2: found a table pack, expected a prefiltered environment",
        ),
        (&["l.ktx2", "--environment", "sky.exr", "--exact"], 2, "--exact"),
        (&["l.ktx2", "--environment", "sky.exr", "--lod", "2"], 2, "--lod"),
        (&["t.ktx2", "--truth", "64"], 2, "--truth needs --adaptive, or --environment with a material or a --source"),
        (&["l.ktx2", "--environment", "sky.exr", "--truth", "64"], 2, "--truth needs --adaptive"),
        (&["l.ktx2", "--adaptive", "--environment", "sky.exr"], 2, "--adaptive does not apply"),
        (
            &["s.toml", "--environment", "sky.exr"],
            2,
            "--environment applies to materials, and with --adaptive to scenes",
        ),
        (
            &["t.ktx2", "--environment", "sky.exr", "--source", "synth:lambert"],
            2,
            "t.ktx2: --source needs a pack of lobes",
        ),
    ] {
        let ran = folder.run(&[&["render"], arguments, &["-o", "o.png"], &SMALL[..]].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {} {}", ran.code, ran.stderr);
    }
}
