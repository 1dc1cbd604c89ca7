//! `brdfc render --environment` of materials, by their lobes.

use super::environment::{cube, sky};
use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::environment::EnvironmentPack;

const SMALL: [&str; 4] = ["--size", "48x48", "--samples", "1"];

#[test]
fn an_environment_lights_materials() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 300.0);
    folder.run(&["environment", "sky.exr", "-o", "sky.ktx2"]).succeeded();
    folder.write("cube.ktx2", cube(&EnvironmentPack::from_bytes(&folder.read("sky.ktx2")).unwrap()).to_bytes(true));
    folder.run(&["encode", "synth:ggx?alpha=0.3", "--codec", "lobes", "-o", "ggx.ktx2"]).succeeded();
    for (input, environment, source) in [
        ("ggx.ktx2", "sky.exr", None),
        ("ggx.ktx2", "cube.ktx2", None),
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
        // Faces of 64 texels: 32 N² + 5632 bytes. Each lobe has at least 192.
        assert_eq!(report["environment_bytes_on_gpu"], 136_704, "{report}");
        let own = report["parts"][0]["bytes_on_gpu"].as_u64().unwrap();
        assert!(own.is_multiple_of(192) && own < 8192, "{report}");
        // The reference is the integral over all directions.
        assert_eq!(mean("total").is_some(), source.is_some());
        assert!(mean("total").is_none_or(|total| total > 0.01 && total < 3.0), "{report}");
        assert!(image::open(folder.path().join("o.png")).is_ok());
    }
}

/// Standard input may be the environment, and all three kinds give the same rendering.
#[test]
fn environments_come_from_stdin_and_as_cube_maps() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 300.0);
    folder.run(&["environment", "sky.exr", "-o", "sky.ktx2"]).succeeded();
    folder.write("cube.ktx2", cube(&EnvironmentPack::from_bytes(&folder.read("sky.ktx2")).unwrap()).to_bytes(true));
    folder.run(&["encode", "synth:ggx?alpha=0.3", "--codec", "lobes", "-o", "l.ktx2"]).succeeded();
    let render = |environment: &str, stdin: Vec<u8>| {
        let arguments = ["render", "l.ktx2", "--environment", environment, "--exposure", "1", "-o", "o.png"];
        let ran = folder.command(&[&arguments[..], &SMALL].concat()).write_stdin(stdin).output().unwrap();
        let [stdout, stderr] = [&ran.stdout, &ran.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
        assert!(ran.status.success() && stdout.contains("environment: 133.5 KiB"), "{stdout} {stderr}");
        image::open(folder.path().join("o.png")).unwrap().into_rgb8()
    };
    let expected = render("sky.ktx2", Vec::new());
    for environment in ["sky.ktx2", "cube.ktx2", "sky.exr"] {
        assert_eq!(render("-", folder.read(environment)), render(environment, Vec::new()), "{environment}");
    }
    let most = |found: &image::RgbImage| found.iter().zip(expected.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(most(&render("cube.ktx2", Vec::new())) <= 1);
    sky(&folder, "dim.exr", 0.4, 0.4);
    assert!(most(&render("dim.exr", Vec::new())) > 3);
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

/// Light of points and of the environment add up in the scene of a manifest, on the shader, on the CPU and in the reference.
#[test]
fn the_environment_of_a_scene_lights_its_materials() {
    let folder = Folder::new();
    sky(&folder, "sky.exr", 0.4, 300.0);
    let manifest = |environment: &str, lights: &str| {
        format!(
            "[scene]\n{environment}[materials.a]\nsource = 'synth:ggx?alpha=0.3'\nmax_delta_e = 0.5\n\
             [materials.b]\nsource = 'synth:lambert?kd=0.5'\n[[uses]]\nmaterial = 'a'\n[[uses]]\nmaterial = 'b'\n\
             [render]\nscene = 'table'\nexposure = 0.3\n{lights}"
        )
    };
    let (lit, dark) = ("environment = 'sky.exr'\n", "lights = []\n");
    for (name, environment, lights) in
        [("points.toml", "", ""), ("sky.toml", lit, dark), ("both.toml", lit, ""), ("none.toml", "", dark)]
    {
        folder.write(name, manifest(environment, lights).as_bytes());
    }
    let draw = |input: &str, more: &[&str]| {
        let output = format!("{input}{}.exr", more.join(""));
        let report =
            folder.run(&[&["render", input, "-o", &output, "--json"], more, &SMALL].concat()).succeeded().json();
        conforms("render", &report);
        let image = image::open(folder.path().join(&output)).unwrap().into_rgb32f();
        (image.pixels().map(|pixel| f64::from(pixel.0[1])).sum::<f64>(), report)
    };
    // The files of a build are those of both scenes with an environment.
    folder.run(&["build", "both.toml", "--out", "packs"]).succeeded();
    let built = ["--packs", "packs", "--truth", "64"];
    let [(points, _), (none, _)] = ["points.toml", "none.toml"].map(|name| draw(name, &[]));
    let [(sky, _), (both, report)] = ["sky.toml", "both.toml"].map(|name| draw(name, &built));
    assert!(points > 1.1 * none && sky > 1.1 * none, "{points} {sky} {none}");
    // Points add the same light to both; the mirror reflects the environment of its scene once.
    assert!(((both - sky) / (points - none) - 1.0).abs() < 0.02, "{both} {sky} {points} {none}");
    let mean = |key: &str| report[key]["delta_e"]["mean"].as_f64().unwrap();
    assert!(mean("shading") < 0.1 && mean("total") < 3.0, "{report}");
    // The light of the command line lights a scene without one. Its lobes are fitted for the rendering.
    let (given, _) = draw("points.toml", &["--environment", "sky.exr"]);
    assert!((given / both - 1.0).abs() < 1e-3, "{given} {both}");
    // A use that only the environment lights gets no light of points; one without lobes none of the environment.
    let uses = |keys: &str| manifest(lit, "").replace("[[uses]]\n", &format!("[[uses]]\n{keys}\n"));
    folder.write("only.toml", uses("lighting = ['environment']").as_bytes());
    let (only, _) = draw("only.toml", &built);
    assert!((only / sky - 1.0).abs() < 1e-6, "{only} {sky}");
    folder.write("maps.toml", uses("maps = ['bandwidth']").as_bytes());
    let ran = folder.run(&[&["render", "maps.toml", "-o", "maps.exr", "--quiet"], &SMALL[..]].concat()).succeeded();
    assert!(ran.stderr.is_empty(), "{}", ran.stderr);
    let ran = folder.run(&[&["render", "maps.toml", "-o", "maps.exr"], &SMALL[..]].concat()).succeeded();
    // Once, although two parts of the scene have the material.
    let noted = ran.stderr.matches("note: a: the environment does not light it").count();
    assert_eq!(noted, 1, "{}", ran.stderr);
    let sheet = ["render", "both.toml", "--contact", "all.png", "--size", "32x32", "--samples", "1"];
    folder.run(&[&sheet[..], &built].concat()).succeeded();
    assert!(image::open(folder.path().join("all.png")).is_ok());
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
            "t.ktx2: environment: found a table pack, expected a latitude-longitude image (.exr, .hdr), a cube map or a",
        ),
        (&["l.ktx2", "--environment", "sky.exr", "--exact"], 2, "--exact"),
        (&["l.ktx2", "--environment", "sky.exr", "--lod", "2"], 2, "--lod"),
        (&["l.ktx2", "--environment", "sky.exr", "--ratio", "8"], 2, "--ratio does not apply to l.ktx2, lit by"),
        (&["-", "--environment", "-"], 2, "INPUT and --environment: both are -; only one can be stdin"),
        (&["t.ktx2", "--truth", "64"], 2, "or --environment with a material or a --source"),
        (&["l.ktx2", "--environment", "sky.exr", "--truth", "64"], 2, "--truth needs --adaptive"),
        (&["l.ktx2", "--adaptive", "--environment", "sky.exr"], 2, "--adaptive does not apply"),
        (&["s.toml", "--truth", "64"], 2, "--truth needs --adaptive, an environment in [scene]"),
        (&["s.toml", "--environment", "none.ktx2"], 4, "none.ktx2: cannot read"),
        (&["s.toml", "--environment", "none.exr"], 4, "none.exr: cannot read"),
        (&["s.toml", "--environment", "t.ktx2"], 3, "t.ktx2: environment: found a table pack, expected"),
        (
            &["t.ktx2", "--environment", "sky.exr", "--source", "synth:lambert"],
            2,
            "t.ktx2: --source needs a pack of lobes",
        ),
    ] {
        let ran = folder.run(&[&["render"], arguments, &["-o", "o.png"], &SMALL[..]].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {} {}", ran.code, ran.stderr);
    }
    let ran = folder.run(&["render", "s.toml", "--contact", "all.png", "--truth", "64"]);
    assert!(ran.code == 2 && ran.stderr.contains("--truth needs --adaptive"), "{}", ran.stderr);
    // Materials that points light have no lobes; an environment for them lights nothing.
    folder
        .write("p.toml", "[materials.a]\nsource = 'synth:lambert'\n[[uses]]\nmaterial = 'a'\nlighting = ['points']\n");
    let ran = folder.run(&[&["render", "p.toml", "--environment", "sky.exr", "-o", "o.png"], &SMALL[..]].concat());
    assert!(ran.code == 0 && ran.stderr.contains("sky.exr: lights no material"), "{} {}", ran.code, ran.stderr);
}
