//! `brdfc build`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

const SCENE: &str = "\
[scene]
name = 'two'
[defaults]
grid = 4
[materials.model]
source = 'synth:ward?kd=0.2,0.1,0.1'
ratio = 2
[materials.table]
source = 'data/table.binary'
[materials.spare]
source = 'not-there.binary'
[[uses]]
object = 'wall'
material = 'model'
nearest = 30
[[uses]]
material = 'table'
";

fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("data/table.binary", folder.read("table.binary"));
    folder.write("scene.toml", SCENE);
    folder
}

#[test]
fn packs_lists_and_the_report_are_written() {
    let folder = folder();
    let ran = folder.run(&["build", "scene.toml", "--json"]).succeeded();
    let report = ran.json();
    conforms("build", &report);
    assert_eq!((&report["scene"], &report["skipped"]), (&"two".into(), &vec!["spare"].into()));
    let names: Vec<_> = folder.products("packs").into_keys().collect();
    assert_eq!(names, ["model.brdf.ktx2", "model.json", "report.json", "table.brdf.ktx2", "table.json"]);

    let without_run_details: serde_json::Value = serde_json::from_str(&folder.text("packs/report.json")).unwrap();
    conforms("build", &without_run_details);
    for (retained, printed) in
        without_run_details["materials"].as_array().unwrap().iter().zip(report["materials"].as_array().unwrap())
    {
        assert_eq!(retained["report"], printed["report"]);
        assert!(printed["cached"] == false && printed["stages"].as_array().is_some_and(|s| s.len() >= 9), "{printed}");
        assert!(retained.get("cached").is_none() && retained.get("stages").is_none());
        let name = retained["material"].as_str().unwrap();
        let list: serde_json::Value = serde_json::from_str(&folder.text(&format!("packs/{name}.json"))).unwrap();
        conforms("material", &list);
        assert_eq!(list["report"], retained["report"]);
        let pack = format!("packs/{}", list["parts"]["brdf"].as_str().unwrap());
        assert_eq!(retained["report"]["bytes_on_disk"], folder.read(&pack).len());
        let info = folder.run(&["info", &pack, "--json"]).succeeded().json();
        assert_eq!(info["slices_retained"], retained["report"]["codec"]["wavelet"]["slices_retained"]);
    }
    // At distance 30 a grid of 2 levels loses log2(4.5) levels: all that fit.
    assert_eq!(report["materials"][0]["report"]["codec"]["wavelet"]["stored_levels"], 0);
    assert_eq!(report["materials"][1]["report"]["codec"]["wavelet"]["stored_levels"], 2);
}

#[test]
fn the_table_goes_to_stdout_and_progress_to_stderr() {
    let folder = folder();
    let ran = folder.run(&["build", "scene.toml"]).succeeded();
    let first: Vec<&str> = ran.stdout.lines().map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(first, ["material", "model", "table"]);
    assert!(ran.stderr.contains("1 of 2: ") && ran.stderr.contains("2 of 2: "), "{}", ran.stderr);
    assert!(ran.stderr.contains("not used by the scene and not opened: spare"), "{}", ran.stderr);
    assert_eq!(folder.run(&["build", "scene.toml", "--quiet", "--no-cache"]).succeeded().stderr, "");
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = folder();
    let before = folder.files(".");
    let ran = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
    for words in
        ["2:1", "0 of 2", "4:1", "2 of 2", "data/table.binary", "packs/model.brdf.ktx2", "not used by the scene: spare"]
    {
        assert!(ran.stdout.contains(words), "{words}: {}", ran.stdout);
    }
    let report = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    conforms("build", &report);
    assert_eq!(report["materials"].as_array().unwrap().len(), 2);
    assert!(folder.files(".") == before, "{:?}", folder.files(".").keys());
    folder.write("scene.toml", SCENE.replace("ratio = 2", "ratio = 0"));
    assert_eq!(folder.run(&["build", "scene.toml", "--dry-run"]).code, 3);
}

#[test]
fn a_failed_material_does_not_stop_the_others() {
    let folder = folder();
    for (change, code, words) in [
        (["data/table.binary", "data/gone.binary"], 4, "table: data/gone.binary: cannot read: "),
        (
            ["data/table.binary", "scene.toml"],
            3,
            "table: scene.toml: input: found a manifest, expected .binary (MERL), ",
        ),
        (["data/table.binary", "synth:lewisss"], 3, "did you mean lewis?"),
        (
            ["data/table.binary'", "data/table.binary'\nmax_error = 1e-9"],
            1,
            "table: max_error (--max-error): found ε_r ",
        ),
    ] {
        let out = folder.path().join("packs");
        let _ = std::fs::remove_dir_all(out);
        folder.write("scene.toml", SCENE.replace(change[0], change[1]));
        let ran = folder.run(&["build", "scene.toml", "--json"]);
        assert_eq!(ran.code, code, "{}", ran.stderr);
        assert!(ran.stderr.contains(words) && ran.stderr.contains("1 of 2 materials failed"), "{}", ran.stderr);
        let report = ran.json();
        conforms("build", &report);
        assert!(report["materials"][1]["error"].is_string() && report["materials"][1].get("pack").is_none());
        let names: Vec<_> = folder.products("packs").into_keys().collect();
        assert_eq!(names, ["model.brdf.ktx2", "model.json", "report.json"]);
        folder.run(&["info", "packs/model.brdf.ktx2"]).succeeded();
    }
}

#[test]
fn limits_are_named_by_key_and_flag() {
    let folder = folder();
    folder.write("levels.binary", folder.read("table.binary"));
    folder.write("my_max_error.binary", folder.read("table.binary"));
    for (input, words) in [
        ("scene.toml", "brdfc: table: max_bytes (--max-bytes): found 3 bytes, expected at least "),
        ("my_max_error.binary", "brdfc: my_max_error: --max-bytes: found 3 bytes, expected at least "),
        ("levels.binary", "brdfc: levels: --max-bytes: found 3 bytes, expected at least "),
    ] {
        let ran = folder.run(&["build", input, "--out", "limited", "--max-bytes", "3"]);
        assert!(ran.code == 1 && ran.stderr.contains(words), "{input}: {ran:?}");
    }
}

#[test]
fn a_material_that_is_only_spare_needs_no_file() {
    let folder = Folder::new();
    folder.write("scene.toml", "[materials.spare]\nsource = 'gone.binary'\n");
    for scene in ["[materials.spare]\nsource = 'gone.binary'\n", "", "[scene]\nenvironment = 'gone.exr'\n"] {
        folder.write("scene.toml", scene);
        for arguments in [["build", "scene.toml"].as_slice(), &["build", "scene.toml", "--dry-run"]] {
            let ran = folder.run(arguments);
            let words = ran.stderr.contains(": nothing to build: ");
            assert!(ran.code == 1 && words && ran.stdout.is_empty(), "{}", ran.stderr);
        }
    }
    assert!(!folder.path().join("packs").exists());
    folder.write("scene.toml", SCENE.replace("data/table.binary", "synth:lambert"));
    let ran = folder.run(&["build", "scene.toml"]).succeeded();
    assert!(ran.stderr.contains("not opened: spare"), "{}", ran.stderr);
}

#[test]
fn the_demo_scene_is_planned() {
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/demo/scene.toml");
    let report = Folder::new().run(&["build", demo, "--dry-run", "--json"]).succeeded().json();
    let names: Vec<_> = report["materials"].as_array().unwrap().iter().map(|m| m["material"].clone()).collect();
    assert_eq!(names, ["blue_paint", "brushed_metal", "red_plastic", "satin"]);
}

/// A small environment.
fn sky(folder: &Folder, name: &str) {
    let wave = |x: u32| 0.5 + 0.4 * (std::f32::consts::TAU * (x as f32 + 0.5) / 8.0).sin();
    let image = image::Rgb32FImage::from_fn(32, 16, |x, _| image::Rgb([wave(x), 1.0, 1.0]));
    image::DynamicImage::ImageRgb32F(image).save(folder.path().join(name)).unwrap();
}

/// [`SCENE`] with an environment.
fn lit(file: &str) -> String {
    SCENE.replace("name = 'two'", &format!("name = 'two'\nenvironment = '{file}'"))
}

/// [`lit`] with maps for adaptive shading instead of lobes.
fn adaptive(file: &str) -> String {
    lit(file).replace("[[uses]]", "[[uses]]\nmaps = ['bandwidth', 'samples']")
}

/// Names of the stages of an entry of a report; none if it was cached.
fn stages(entry: &serde_json::Value) -> Vec<String> {
    let all = entry.get("stages").and_then(|stages| stages.as_array()).into_iter().flatten();
    all.map(|stage| stage["stage"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn an_environment_asks_for_lobes() {
    let folder = folder();
    sky(&folder, "sky.hdr");
    let model = "[materials.model]\nlobes = { max_fetches = 2 }";
    folder.write("scene.toml", lit("sky.hdr").replace("[materials.model]", model));
    let planned = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    conforms("build", &planned);
    let words = folder.run(&["build", "scene.toml", "--dry-run", "--explain"]).succeeded().stdout;
    for line in [
        "lit by sky.hdr: packs/environment.prefiltered.ktx2",
        "up to 2 look-ups   192 B to 1.5 KiB  packs/model.lobes.ktx2",
        "ΔE 1, up to 16 look-ups  192 B to 12.0 KiB  packs/table.lobes.ktx2",
        "lit by the environment: wall",
    ] {
        assert!(words.contains(line), "{line}: {words}");
    }
    assert!(!folder.path().join("packs").exists());

    let report = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
    conforms("build", &report);
    let names: Vec<_> = folder.products("packs").into_keys().collect();
    let mut expected = vec!["environment.prefiltered.ktx2".to_owned(), "report.json".to_owned()];
    for name in ["model", "table"] {
        expected.extend(["brdf.ktx2", "json", "lobes.ktx2"].map(|part| format!("{name}.{part}")));
    }
    expected.sort();
    assert_eq!(names, expected, "no bandwidth maps and no samples");
    // Each file is identical to the output of its own command and to its entries in the lists.
    let same = |arguments: &[&str], pack: &str| {
        folder.run(&[arguments, &["-o", "alone.ktx2"]].concat()).succeeded();
        assert!(folder.read("alone.ktx2") == folder.read(&format!("packs/{pack}")), "{pack}");
    };
    same(&["environment", "sky.hdr"], "environment.prefiltered.ktx2");
    let encode = |source| ["encode", source, "--codec", "lobes"];
    let model = encode("synth:ward?kd=0.2,0.1,0.1");
    same(&[&model[..], &["--max-fetches", "2"]].concat(), "model.lobes.ktx2");
    same(&encode("data/table.binary"), "table.lobes.ktx2");
    for (number, name) in ["model", "table"].into_iter().enumerate() {
        let (made, plan) = (&report["materials"][number], &planned["materials"][number]);
        let list: serde_json::Value = serde_json::from_str(&folder.text(&format!("packs/{name}.json"))).unwrap();
        conforms("material", &list);
        let file = format!("{name}.lobes.ktx2");
        assert!(list["parts"]["lobes"] == file && made["lobes"] == file && plan["lobes"] == file, "{made} {plan}");
        let lobes = &made["maps"]["lobes"];
        assert_eq!((&list["maps"]["lobes"], lobes["missed"].is_null()), (lobes, true));
        assert_eq!(lobes["bytes_on_disk"], folder.read(&format!("packs/{file}")).len());
        let [mean, p95] = ["mean", "p95"].map(|key| lobes["facts"]["delta_e"][key].as_f64().unwrap());
        assert!(0.0 < mean && mean < p95, "{lobes}");
        let bytes = |key: &str| plan["predicted_lobes"][key].as_u64().unwrap();
        assert!((bytes("least")..=bytes("most")).contains(&lobes["facts"]["gpu_bytes"].as_u64().unwrap()), "{lobes}");
    }
    assert_eq!(report["materials"][0]["maps"]["lobes"]["facts"]["fetches"], 2);
    folder.run(&["verify", "packs"]).succeeded();

    // Nothing is built again, and other limits fit lobes alone again.
    let again = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
    assert!(again["materials"].as_array().unwrap().iter().all(|made| made["cached"] == true), "{again}");
    assert_eq!(again["environment"]["cached"], true);
    folder.write(
        "scene.toml",
        lit("sky.hdr").replace("[defaults]", "[defaults]\nlobes = { max_delta_e = 0.001, max_fetches = 3 }"),
    );
    let ran = folder.run(&["build", "scene.toml", "--json"]);
    let made = &ran.json()["materials"];
    for number in [0, 1] {
        let stages = stages(&made[number]);
        assert!(
            stages.first().unwrap() == "read" && stages.ends_with(&["fit lobes".into(), "write".into()]),
            "{stages:?}"
        );
        assert!(!stages.contains(&"pack".to_owned()), "{stages:?}");
    }
    // A missed limit is in the report and the exit code.
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    for line in [
        "brdfc: table: lobes.max_delta_e: found a ΔE of ",
        "look-ups, expected at most 0.001",
        "brdfc: 2 materials miss their limits",
    ] {
        assert!(ran.stderr.contains(line), "{line}: {}", ran.stderr);
    }
    assert!(made[1]["maps"]["lobes"]["missed"].is_string() && folder.path().join("packs/table.lobes.ktx2").exists());
}

/// A batch takes the environment from the command line.
#[test]
fn a_batch_has_an_environment() {
    let folder = folder();
    sky(&folder, "sky.hdr");
    let build = ["build", "synth:lambert", "--max-bytes", "1KiB"];
    folder.run(&[&build[..], &["--environment", "sky.hdr"]].concat()).succeeded();
    let names: Vec<_> = folder.products("packs").into_keys().collect();
    let files =
        ["environment.prefiltered.ktx2", "lambert.brdf.ktx2", "lambert.json", "lambert.lobes.ktx2", "report.json"];
    assert_eq!(names, files);
    for (inputs, code, words) in [
        (
            &["synth:lambert", "--environment", "sky.png"][..],
            2,
            "--environment: found sky.png, expected an .exr, .hdr or .ktx2",
        ),
        (
            &["scene.toml", "--environment", "sky.hdr"],
            2,
            "--environment does not apply to manifests; set environment in",
        ),
        (&["synth:lambert", "--codec", "lobes"], 2, "factored or wavelet; builds make lobes, next to packs, where"),
    ] {
        let ran = folder.run(&[&["build"], inputs].concat());
        assert!(ran.code == code && ran.stderr.contains(words), "{}", ran.stderr);
    }
}

#[test]
fn uses_ask_for_maps() {
    let folder = folder();
    sky(&folder, "data/sky.hdr");
    folder.write("scene.toml", adaptive("data/sky.hdr"));
    let planned = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    conforms("build", &planned);
    let words = folder.run(&["build", "scene.toml", "--dry-run"]).succeeded().stdout;
    assert!(words.contains("lit by data/sky.hdr: packs/environment.bandwidth.ktx2"), "{words}");
    assert!(!folder.path().join("packs").exists());

    let ran = folder.run(&["build", "scene.toml", "--json"]).succeeded();
    let report = ran.json();
    conforms("build", &report);
    assert!(ran.stderr.contains("of 3: environment done"), "{}", ran.stderr);
    let mut names: Vec<_> = folder.products("packs").into_keys().collect();
    let mut expected = vec!["environment.bandwidth.ktx2".to_owned(), "report.json".to_owned()];
    for name in ["model", "table"] {
        expected.extend(["bandwidth.ktx2", "brdf.ktx2", "json", "samples.ktx2"].map(|part| format!("{name}.{part}")));
    }
    names.sort();
    expected.sort();
    assert_eq!(names, expected);
    assert_eq!(report["environment"]["source"], "data/sky.hdr");
    let without_run_details: serde_json::Value = serde_json::from_str(&folder.text("packs/report.json")).unwrap();
    conforms("build", &without_run_details);
    assert!(
        without_run_details["environment"].get("stages").is_none()
            && without_run_details["environment"]["bandwidth"].is_string()
    );

    // Each file is identical to the output of its own command and to its entries in the lists.
    let same = |arguments: &[&str], pack: &str| {
        folder.run(&[arguments, &["-o", "alone.ktx2"]].concat()).succeeded();
        assert!(folder.read("alone.ktx2") == folder.read(&format!("packs/{pack}")), "{pack}");
    };
    same(&["bandwidth", "data/sky.hdr"], "environment.bandwidth.ktx2");
    for (number, (name, source)) in
        [("model", "synth:ward?kd=0.2,0.1,0.1"), ("table", "data/table.binary")].into_iter().enumerate()
    {
        same(&["bandwidth", source], &format!("{name}.bandwidth.ktx2"));
        same(&["samples", source], &format!("{name}.samples.ktx2"));
        let (made, plan) = (&report["materials"][number], &planned["materials"][number]);
        let list: serde_json::Value = serde_json::from_str(&folder.text(&format!("packs/{name}.json"))).unwrap();
        conforms("material", &list);
        assert_eq!((&list["maps"], list["parts"].as_object().unwrap().len()), (&made["maps"], 3));
        for part in ["bandwidth", "samples"] {
            let file = list["parts"][part].as_str().unwrap();
            assert!(made[part] == file && plan[part] == file, "{made} {plan}");
            assert_eq!(made["maps"][part]["bytes_on_disk"], folder.read(&format!("packs/{file}")).len());
            let info = folder.run(&["info", &format!("packs/{file}"), "--json"]).succeeded().json();
            assert_eq!(info["gpu_bytes"], made["maps"][part]["facts"]["gpu_bytes"]);
        }
        let stages: Vec<_> = made["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap()).collect();
        assert!(stages.ends_with(&["write", "bandwidth map", "importance samples", "write"]), "{stages:?}");
    }
    let words = folder.run(&["build", "scene.toml"]).succeeded().stdout;
    let first: Vec<&str> = words.lines().map(|line| line.split_whitespace().next().unwrap_or("")).collect();
    let maps = ["map", "environment.bandwidth.ktx2", "model.bandwidth.ktx2", "model.samples.ktx2"];
    assert!(first.windows(4).any(|lines| lines == maps), "{words}");
}

/// Packs and maps are cached separately: requesting maps as well does not rebuild the packs.
#[test]
fn maps_are_cached_like_packs() {
    let folder = folder();
    sky(&folder, "sky.exr");
    let build = |text: &str| {
        folder.write("scene.toml", text);
        let report = folder.run(&["build", "scene.toml", "--json"]).succeeded().json();
        [&report["materials"][0], &report["materials"][1], &report["environment"]].map(stages)
    };
    let maps = ["read", "bandwidth map", "importance samples", "write"];
    let nothing: [&str; 0] = [];
    build(SCENE);
    let dark = folder.products("packs");
    assert!(dark.keys().all(|name| !name.contains("bandwidth") && !name.contains("samples")), "{:?}", dark.keys());
    let [model, table, environment] = build(&adaptive("sky.exr"));
    assert!(model == maps && table == maps, "the packs are there: {model:?} {table:?}");
    assert_eq!(environment, ["read", "bandwidth map", "write"]);
    let first = folder.products("packs");
    assert!(dark.iter().all(|(name, bytes)| name.ends_with(".json") || first[name] == *bytes));
    assert!(build(&adaptive("sky.exr")).iter().all(|stages| *stages == nothing));

    // A broken file is replaced; if the store lost it as well, it is built again.
    for (file, number) in [("model.samples.ktx2", 0), ("table.bandwidth.ktx2", 1), ("environment.bandwidth.ktx2", 2)] {
        let retained = format!("packs/.brdfc-cache/objects/{}", blake3::hash(&first[file]).to_hex());
        for breaks_both in [false, true] {
            folder.write(&format!("packs/{file}"), b"broken");
            if breaks_both {
                folder.write(&retained, b"broken");
            }
            let made = build(&adaptive("sky.exr"));
            for (other, stages) in made.iter().enumerate() {
                assert_eq!(!stages.is_empty(), breaks_both && other == number, "{file}: {made:?}");
            }
            assert!(folder.products("packs") == first, "{file}");
        }
    }
    // Another image of the same name, another source of the same name.
    sky(&folder, "other.hdr");
    folder.write("sky.exr", folder.read("sky.exr").into_iter().chain([0]).collect::<Vec<_>>());
    let [model, table, environment] = build(&adaptive("sky.exr"));
    assert!(model == nothing && table == nothing && environment.len() == 3, "{environment:?}");
    let [model, table, _] = build(&adaptive("sky.exr").replace("kd=0.2,0.1,0.1", "kd=0.2,0.1,0.2"));
    assert!(model.len() > 9 && model.contains(&"importance samples".to_owned()) && table == nothing, "{model:?}");
    // Maps that are no longer needed are removed.
    build(SCENE);
    assert!(folder.products("packs").keys().all(|name| !name.contains("samples")));
    assert!(!folder.text("packs/table.json").contains("samples.ktx2"));
}

#[test]
fn environments_that_cannot_be_used() {
    let folder = folder();
    folder.write("broken.exr", "not an image");
    for (file, code, words) in [
        ("gone.exr", 4, "environment: gone.exr: cannot read: "),
        ("broken.exr", 3, "environment: broken.exr: EXR: "),
        ("data", 3, "line 3, scene.environment: found \"data\", expected an .exr, .hdr or .ktx2 file"),
        ("sky.png", 3, "line 3, scene.environment: found \"sky.png\", expected an .exr, .hdr or .ktx2 file"),
    ] {
        let _ = std::fs::remove_dir_all(folder.path().join("packs"));
        folder.write("scene.toml", lit(file).replace("ratio = 2", "grid = 2"));
        let ran = folder.run(&["build", "scene.toml", "--json"]);
        assert!(ran.code == code && ran.stderr.contains(words), "{file}: {}", ran.stderr);
        if !ran.stdout.is_empty() {
            assert!(ran.stderr.contains("brdfc: the environment failed"), "{}", ran.stderr);
            conforms("build", &ran.json());
            let names: Vec<_> = folder.products("packs").into_keys().collect();
            assert!(names.contains(&"table.lobes.ktx2".to_owned()), "materials are made: {names:?}");
            assert!(!names.contains(&"environment.prefiltered.ktx2".to_owned()));
        }
    }
    folder.write("scene.toml", lit("gone.exr").replace("environment =", "enviroment ="));
    let ran = folder.run(&["build", "scene.toml"]);
    assert!(ran.code == 3 && ran.stderr.contains("; did you mean environment?"), "{}", ran.stderr);
    // Its files would collide with those of the scene.
    let named = |text: &str| text.replace("materials.spare", "materials.Environment");
    folder.write("scene.toml", named(&lit("gone.exr")));
    let ran = folder.run(&["build", "scene.toml"]);
    assert!(ran.code == 3 && ran.stderr.contains("line 11, materials.Environment: found the name"), "{}", ran.stderr);
    folder.write("scene.toml", named(SCENE));
    folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
}

/// On a small grid; the scan is excluded when lobes are built, because its fits take long.
#[test]
fn the_demo_scene_has_lobes_only_under_an_environment() {
    let folder = Folder::new();
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/demo")).unwrap() {
        let path = entry.unwrap().path();
        folder.write(path.file_name().unwrap().to_str().unwrap(), std::fs::read(&path).unwrap());
    }
    let demo =
        folder.text("scene.toml").replace("grid = 32", "grid = 4").replace("max_error = 0.02", "max_error = 0.5");
    folder.write("scene.toml", &demo);
    folder.run(&["build", "scene.toml"]).succeeded();
    let dark: Vec<_> = folder.products("packs").into_keys().collect();
    assert!(
        dark.len() == 9 && dark.iter().all(|name| name.ends_with(".json") || name.ends_with(".brdf.ktx2")),
        "{dark:?}"
    );

    sky(&folder, "sky.exr");
    let lit = demo.replace("name = \"demo\"", "name = \"demo\"\nenvironment = \"sky.exr\"");
    // Lobes of parallel fibres have larger errors.
    let lit = lit.replace("reciprocal = true", "reciprocal = true\nlobes.max_delta_e = 4");
    folder.write("scene.toml", &lit);
    let planned = folder.run(&["build", "scene.toml", "--dry-run", "--json"]).succeeded().json();
    assert!(planned["materials"].as_array().unwrap().iter().all(|m| m["lobes"].is_string()), "{planned}");
    folder.write("scene.toml", lit.replace("object = \"car body\"\nmaterial = \"blue_paint\"", "material = \"satin\""));
    // In the same folder, whose packs are reused.
    folder.run(&["build", "scene.toml"]).succeeded();
    let all: Vec<_> = folder.products("packs").into_keys().collect();
    for name in ["red_plastic", "brushed_metal", "satin"] {
        for part in ["brdf", "lobes"] {
            assert!(all.contains(&format!("{name}.{part}.ktx2")), "{name} {part}: {all:?}");
        }
    }
    assert!(all.contains(&"environment.prefiltered.ktx2".to_owned()) && all.len() == 11, "{all:?}");
}

/// Defaults of the manifest that do not apply to a codec of the command line are ignored.
#[test]
fn options_of_the_command_line_win_over_defaults_of_another_codec() {
    let folder = Folder::new();
    folder.write(
        "scene.toml",
        "[defaults]\nmax_delta_e = 1.0\n[materials.m]\nsource = 'synth:lambert'\n[[uses]]\nmaterial = 'm'\n",
    );
    for options in [["--codec", "wavelet"], ["--grid", "8"]] {
        let ran = folder.run(&[&["build", "scene.toml", "--dry-run"][..], &options].concat()).succeeded();
        assert!(ran.stdout.contains("wavelet"), "{options:?}: {}", ran.stdout);
    }
}
