//! `brdfc render`.

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use crate::common::has_adapter;
use serde_json::Value;

/// A scene of two materials.
pub(super) const MANIFEST: &str = "\
[materials.red]
source = 'synth:ward?kd=0.4,0.05,0.05&ax=0.3&ay=0.3'
grid = 8

[materials.blue]
source = 'synth:lambert?kd=0.1,0.2,0.6'
grid = 8

[[uses]]
material = 'red'

[render]
scene = 'table'
width = 48
height = 40
samples = 1
exposure = 0.5

[render.camera]
eye = [0.0, 1.5, 4.2]
field_of_view = 35.0

[[render.lights]]
position = [2.0, 3.0, 3.0]
intensity = 60.0

[[render.lights]]
position = [-2.0, 3.0, 3.0]
intensity = [10.0, 20.0, 30.0]

[render.materials]
ball = 'blue'
";

fn report(ran: &Ran) -> Value {
    let report = ran.json();
    conforms("render", &report);
    report
}

fn mean(report: &Value, of: &str) -> f64 {
    report[of]["delta_e"]["mean"].as_f64().unwrap_or_else(|| panic!("{of}: {report}"))
}

#[test]
fn every_scene_of_every_kind_of_input() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    folder.run(&["synth", "ward", "-o", "table.binary", "--dimensions", "10x10x20"]).succeeded();
    folder.run(&["encode", "table.binary", "-o", "p.ktx2", "--grid", "8"]).succeeded();
    let lit = ["sphere", "cloth", "table", "terrain", "plane", "bottle", "vase", "teapot"];
    for scene in lit.into_iter().chain(["bumpy-ball", "ribbed-torus"]) {
        for (input, more, has_source) in [
            ("p.ktx2", &[][..], false),
            ("p.ktx2", &["--source", "table.binary"][..], true),
            ("synth:lewis", &["--grid", "8", "--ratio", "2"][..], true),
        ] {
            // A pack is drawn identically with and without a comparison.
            if !has_source && scene != "sphere" {
                continue;
            }
            let arguments = [
                &["render", input, "--scene", scene, "--size", "40x30", "--samples", "1", "--json", "-o", "i.png"][..],
                more,
            ];
            let report = report(&folder.run(&arguments.concat()).succeeded());
            assert_eq!((&report["width"], &report["height"]), (&40.into(), &30.into()));
            assert_eq!(report["total"].is_null(), !has_source, "{input} {more:?}");
            assert!(mean(&report, "shading") < 1.0, "{scene}: {report}");
            let image = image::load_from_memory(&folder.read("i.png")).unwrap();
            assert_eq!((image.width(), image.height()), (40, 30));
        }
    }
}

#[test]
fn renderings_of_all_kinds_and_the_same_bytes_twice() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let draw = |prefix: &str| {
        let names = ["a.png", "b.exr", "c.png", "d.png"].map(|name| format!("{prefix}{name}"));
        let [output, reference, difference, sheet] = &names;
        folder
            .run(&[
                "render",
                "synth:ward",
                "--grid",
                "8",
                "--scene",
                "cloth",
                "--size",
                "50x40",
                "--samples",
                "1",
                "-o",
                output,
                "--reference",
                reference,
                "--difference",
                difference,
                "--sheet",
                sheet,
            ])
            .succeeded();
        names.map(|name| folder.read(&name))
    };
    let first = draw("1");
    assert_eq!(first, draw("2"));
    let sheet = image::load_from_memory(&first[3]).unwrap();
    assert_eq!((sheet.width(), sheet.height()), (3 * 50 + 2 * 4, 40));
    let exr = brdfc_render::rendering::from_exr(&first[1]).unwrap();
    assert_eq!((exr.width, exr.height), (50, 40));
    assert!(exr.pixels.iter().any(|pixel| pixel[0] > 0.0));
}

#[test]
fn a_manifest_says_what_is_shown() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    folder.write("scene.toml", MANIFEST);
    let drawn = report(&folder.run(&["render", "scene.toml", "--json", "-o", "a.png"]).succeeded());
    assert_eq!((&drawn["scene"], &drawn["exposure"]), (&"table".into(), &0.5.into()));
    let parts: Vec<[&str; 2]> = drawn["parts"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| ["part", "material"].map(|key| part[key].as_str().unwrap()))
        .collect();
    // Parts without an entry take the materials of the scene.
    assert_eq!(parts, [["top", "red"], ["cloth", "red"], ["vase", "red"], ["ball", "blue"]]);
    assert!(mean(&drawn, "codec") >= 0.0);
    for (key, value) in [("eye = [0.0, 1.5, 4.2]", "eye = [0.5, 1.5, 4.2]"), ("intensity = 60.0", "intensity = 30.0")] {
        folder.write("other.toml", MANIFEST.replace(key, value));
        folder.run(&["render", "other.toml", "-o", "b.png"]).succeeded();
        assert_ne!(folder.read("a.png"), folder.read("b.png"), "{value}");
    }
    // The command line overrides.
    let small =
        report(&folder.run(&["render", "scene.toml", "--json", "--size", "20x20", "--scene", "sphere"]).succeeded());
    assert_eq!((&small["width"], &small["scene"]), (&20.into(), &"sphere".into()));
}

#[test]
fn a_contact_sheet_shows_every_material_and_gates_hold_for_each() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    // A scene of three materials, whose rendering shows the first.
    let material = |name: &str, more: &str| {
        let source = format!("source = 'synth:lewis?kd=0.5&ks=0.2&n=30'\n{more}[[uses]]\nmaterial = '{name}'\n");
        format!("[materials.{name}]\n{source}\n")
    };
    let [fine, coarse, third] =
        [material("fine", ""), material("coarse", "codec = 'wavelet'\ngrid = 4\n"), material("third", "")];
    folder.write("scene.toml", [&fine[..], &coarse, &third, "[materials.spare]\nsource = 'gone.brdf'\n"].concat());
    let alone = folder.run(&["render", "scene.toml", "-o", "a.png", "--size", "32x32"]).succeeded();
    assert!(
        alone.stderr.contains("note: scene.toml: not drawn: fine, third; --contact draws every material"),
        "{}",
        alone.stderr
    );
    let contact = |more: &[&str]| {
        let arguments = ["render", "scene.toml", "--contact", "all.png", "--size", "48x40", "--samples", "1"];
        folder.run(&[&arguments[..], more].concat())
    };
    let ran = contact(&["--json", "--jobs", "1"]).succeeded();
    conforms("render-contact", &ran.json());
    let names = |report: &Value| -> Vec<String> {
        let materials = report["materials"].as_array().unwrap();
        materials.iter().map(|material| material["material"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&ran.json()), ["coarse", "fine", "third"]);
    let [of_coarse, of_fine] = [0, 1].map(|k| mean(&ran.json()["materials"][k], "total"));
    assert!(of_coarse > 2.0 * of_fine, "{of_coarse} {of_fine}");
    let first = folder.read("all.png");
    let image = image::load_from_memory(&first).unwrap();
    assert!(image.width() > 3 * 48 && image.height() > 2 * 40);
    let again = contact(&["--jobs", "2"]).succeeded();
    assert!(first == folder.read("all.png") && !again.stderr.contains("not drawn"));
    assert!(["coarse", "fine", "third", "of the shader"].iter().all(|words| again.stdout.contains(words)));

    // A limit between both: one fails by its name, and the sheet is still written.
    let limit = (0.5 * (of_coarse + of_fine)).to_string();
    let missed = contact(&["--json", "--max-delta-e", &limit]);
    let text = "coarse: --max-delta-e: found";
    assert!(missed.code == 1 && missed.stderr.contains(text), "{} {}", missed.code, missed.stderr);
    assert!(!missed.stderr.contains("fine: --max-delta-e"), "{}", missed.stderr);
    let passed = |k: usize| missed.json()["materials"][k]["gates"][0]["passed"].clone();
    assert_eq!([passed(0), passed(1), passed(2)], [false, true, true]);
    assert!(folder.read("all.png") != first, "the failed material is marked");
    // Another name is another label.
    folder.write("scene.toml", folder.text("scene.toml").replace("third", "other"));
    contact(&[]).succeeded();
    assert!(folder.read("all.png") != first);
    folder.run(&["render", "synth:ward", "--contact", "one.png", "--size", "32x32"]).succeeded();
    // Directions that a pack does not cover are excluded, and the label states the fraction.
    let sheet = |view: &str| {
        folder.write("scene.toml", [&fine[..], view].concat());
        let ran = contact(&["--json"]).succeeded();
        (ran.json()["materials"][0]["left_out"].as_f64().unwrap(), folder.read("all.png"))
    };
    let (whole, cropped) = (sheet("").0, sheet("view_elevation = [40, 90]\n"));
    assert!(whole == 0.0 && cropped.0 > 0.1, "{whole} {}", cropped.0);
}

#[test]
fn a_limit_is_a_check() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let run = |limit: &str, more: &[&str]| {
        let arguments = ["render", "synth:ward", "--size", "40x40", "--ratio", "16", "--max-delta-e", limit];
        folder.run(&[&arguments[..], more].concat())
    };
    run("50", &[]).succeeded();
    let missed = run("0.001", &["-o", "image.png", "--json"]);
    assert_eq!(missed.code, 1);
    assert!(
        missed.stderr.contains("--max-delta-e: found") && missed.stderr.contains("expected at most 0.001"),
        "{}",
        missed.stderr
    );
    // Report and rendering are both still written.
    assert!(mean(&report(&missed), "total") > 0.001);
    assert!(!folder.read("image.png").is_empty());
    // A check with nothing to measure fails: an all-black or all-white rendering passes no limit.
    for exposure in ["1e-9", "1e-4", "1e6"] {
        let unseen = run("50", &["--exposure", exposure]);
        assert!(unseen.code == 1 && unseen.stderr.contains("neither black nor white at exposure"), "{}", unseen.stderr);
    }
    folder.write(
        "away.toml",
        MANIFEST.replace("eye = [0.0, 1.5, 4.2]", "eye = [0.0, 1.5, 40.0]\ntarget = [0.0, 1.5, 80.0]"),
    );
    let nothing = folder.run(&["render", "away.toml", "--max-delta-e", "5"]);
    assert_eq!(nothing.code, 1);
    assert!(nothing.stderr.contains("no visible surface"), "{}", nothing.stderr);
    let dark = folder.run(&["render", "synth:lambert?kd=0", "--grid", "4", "--size", "16x16"]).succeeded();
    for (gate, limit) in [("--max-delta-e", "100"), ("--max-delta-e-p95", "100"), ("--max-flip", "1")] {
        let closed = folder.run(&["render", "synth:lambert?kd=0", "--size", "16x16", "--quiet", gate, limit]);
        let words = format!("no light: all surfaces are black; expected at most {limit}");
        assert!(closed.code == 1 && closed.stderr.contains(&words), "{gate}: {}", closed.stderr);
    }
    let all = run("50", &["--max-delta-e-p95", "0.001", "--max-flip", "0.0001", "--json"]);
    assert!(
        all.code == 1 && all.stderr.contains("--max-delta-e-p95: found") && all.stderr.contains("; --max-flip: found")
    );
    assert_eq!(report(&all)["gates"].as_array().unwrap().len(), 3);
    assert!(
        dark.stderr.starts_with("note: synth:lambert?kd=0: the rendering shows no light: all surfaces are black"),
        "{}",
        dark.stderr
    );
}

#[test]
fn coarser_levels_of_detail_and_filters_change_the_rendering() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let error = |more: &[&str]| {
        let drawn = ["render", "synth:ward?ax=0.2&ay=0.2", "--size", "60x60", "--samples", "1", "--json"];
        let arguments = [&drawn[..], &["--ratio", "4"]].concat();
        mean(&report(&folder.run(&[&arguments[..], more].concat()).succeeded()), "total")
    };
    let finest = error(&[]);
    assert!(error(&["--lod", "2"]) > 2.0 * finest);
    assert!(error(&["--filter", "nearest"]) > finest);
    assert!((error(&["--exact"]) - finest).abs() < 0.3);
    assert!(error(&["--ranking", "visible"]) < finest);
}

#[test]
fn without_a_driver_it_says_what_to_install() {
    let folder = Folder::new();
    folder.write("scene.toml", MANIFEST);
    for arguments in [&["render", "synth:lewis", "-o", "image.png"][..], &["render", "scene.toml"]] {
        let output = folder
            .command(arguments)
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(5), "{arguments:?}: {stderr}");
        assert!(stderr.contains("no usable graphics adapter"), "{stderr}");
        assert!(stderr.contains("apt-get install mesa-vulkan-drivers libvulkan1"), "{stderr}");
        assert!(output.stdout.is_empty());
    }
    assert!(!folder.path().join("image.png").exists());
}

#[test]
fn an_adapter_that_is_not_there() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let ran = folder.run(&["render", "synth:lewis", "--adapter", "no such card"]);
    assert_eq!(ran.code, 5, "{}", ran.stderr);
    let unknown = "brdfc: graphics adapter: found \"no such card\", expected a part of the name or driver of ";
    assert!(ran.stderr.contains(unknown) && !ran.stderr.contains("apt-get"), "{}", ran.stderr);
}

/// Detected before any work, with or without a driver.
#[test]
fn wrong_arguments() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    folder.write("scene.toml", MANIFEST);
    for (arguments, code, expected) in [
        (
            &["render", "p.ktx2", "-o", "image.jpg"][..],
            2,
            "--output: found image.jpg, expected a name that ends in .png or .exr",
        ),
        (
            &["render", "p.ktx2", "--difference", "d.exr"],
            2,
            "--difference: found d.exr, expected a name that ends in .png",
        ),
        (&["render", "p.ktx2", "-o", "no/image.png"], 4, "there is no folder no"),
        (&["render", "p.ktx2", "--size", "800"], 2, "--size: found 800, expected WIDTHxHEIGHT"),
        (&["render", "p.ktx2", "--size", "0x5"], 2, "each 1 to 8192"),
        (&["render", "p.ktx2", "--size", "99999x5"], 2, "each 1 to 8192"),
        (&["render", "p.ktx2", "--size", "8192x8192"], 2, "expected at most 33554432"),
        (&["render", "p.ktx2", "--samples", "17"], 2, "--samples: found 17, expected 1 to 16"),
        (&["render", "p.ktx2", "--exposure", "0"], 2, "--exposure: found 0"),
        (&["render", "p.ktx2", "--lod", "7"], 2, "--lod: found 7, expected 0 to 6"),
        (&["render", "p.ktx2", "--max-delta-e", "nan"], 2, "--max-delta-e: found NaN"),
        (
            &["render", "p.ktx2", "--max-delta-e-p95", "-1e99"],
            2,
            "--max-delta-e-p95: found -1e99, expected a number, 0 or",
        ),
        (&["render", "p.ktx2", "--max-flip", "1.5"], 2, "--max-flip: found 1.5, expected 0 to 1"),
        (&["render", "p.ktx2", "--ratio", "8"], 2, "--ratio does not apply to p.ktx2"),
        (&["render", "p.ktx2", "--pack-delta-e", "1"], 2, "--pack-delta-e does not apply to p.ktx2"),
        (&["render", "p.ktx2", "--no-supercompression"], 2, "--no-supercompression does not apply to p.ktx2"),
        (&["render", "p.ktx2", "--table"], 2, "--source"),
        (&["render", "p.ktx2", "--packs", "packs"], 2, "--packs does not apply to p.ktx2, only to manifests"),
        (&["render", "p.ktx2", "--contact", "c.jpg"], 2, "--contact: found c.jpg, expected a name that ends in .png"),
        (&["render", "p.ktx2", "--contact", "c.png", "-o", "i.png"], 2, "cannot be used with"),
        (&["render", "p.ktx2", "--contact", "c.png", "--repeat", "3"], 2, "--repeat does not apply to p.ktx2"),
        (&["render", ".", "--contact", "c.png"], 3, ".: input: found a folder"),
        (&["render", "synth:lewis", "--source", "p.ktx2"], 2, "--source does not apply to synth:lewis"),
        (&["render", "synth:lewis", "--ranking", "loud"], 2, "expected energy or visible"),
        (&["render", "synth:lewis", "--pack-delta-e", "0"], 2, "--pack-delta-e: found 0, expected 1e-6 to 100"),
        (
            &["render", "synth:lewis", "--codec", "wavelet", "--pack-delta-e", "0.5"],
            2,
            "--pack-delta-e: does not apply to the codec wavelet",
        ),
        (&["render", "synth:lewis", "--max-bytes", "3"], 1, "synth:lewis: --max-bytes: found 3 bytes, expected at"),
    ] {
        let ran = folder.run(arguments);
        assert_eq!(ran.code, code, "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}

#[test]
fn wrong_manifests_name_the_line() {
    let folder = Folder::new();
    for (change, to, expected) in [
        ("scene = 'table'", "scene = 'tabel'", "line 13, render.scene: found \"tabel\""),
        ("scene = 'table'", "scene = 'tabel'", "did you mean table?"),
        ("width = 48", "width = 0", "line 14, render.width: found 0, expected 1 to 8192"),
        ("width = 48", "widht = 48", "did you mean width?"),
        ("exposure = 0.5", "exposure = -1", "line 17, render.exposure"),
        ("field_of_view = 35.0", "field_of_view = 0.0", "line 21, render.camera.field_of_view: found 0"),
        ("eye = [0.0, 1.5, 4.2]", "eye = [0.0, nan, 4.2]", "line 20, render.camera.eye"),
        ("eye = [0.0, 1.5, 4.2]", "up = [0.0, 0.0, 0.0]", "vectors that span a view"),
        ("intensity = 60.0", "intensity = -60.0", "intensities of 0 or more"),
        ("ball = 'blue'", "bal = 'blue'", "line 32, part in [render.materials]: found \"bal\""),
        ("ball = 'blue'", "ball = 'bleu'", "line 32, render.materials.ball: found \"bleu\""),
        ("exposure = 0.5", "environment = 'sky.exr'", "sky.exr: cannot read"),
    ] {
        assert!(MANIFEST.contains(change));
        folder.write("scene.toml", MANIFEST.replace(change, to));
        let ran = folder.run(&["render", "scene.toml"]);
        assert_eq!(ran.code, if to.contains("exr") { 4 } else { 3 }, "{to}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{to}: {}", ran.stderr);
    }
    folder.write("scene.toml", "[render]\n");
    let ran = folder.run(&["render", "scene.toml"]);
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    assert!(ran.stderr.contains("no materials to draw"), "{}", ran.stderr);
    folder.write("sky.exr", "not an image");
    let mirrored = MANIFEST.replace("exposure = 0.5", "environment = 'sky.exr'");
    folder.write("scene.toml", &mirrored);
    assert_eq!(folder.run(&["render", "scene.toml"]).code, 3);
    // The environment of the light is also that of mirrors by default.
    let lit = |text: &str| format!("[scene]\nenvironment = 'gone.hdr'\n{text}");
    for (text, code, expected) in [(MANIFEST, 4, "gone.hdr: cannot read"), (&mirrored, 3, "sky.exr: EXR")] {
        folder.write("scene.toml", lit(text));
        let ran = folder.run(&["render", "scene.toml"]);
        assert!(ran.code == code && ran.stderr.contains(expected), "{}", ran.stderr);
    }
}

#[test]
fn flat_btfs_are_drawn_with_parallax() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let flatten = |name: &str, more: &[&str]| {
        let button = ["flatten", "synth:button?resolution=48", "-o", name, "--flat-texels", "64"];
        folder.run(&[&button[..], more].concat()).succeeded();
    };
    flatten("button", &["--texels", "32"]);
    flatten("factors", &["--texels", "32", "--views", "grid:3x8@70", "--reflectance", "factors"]);
    flatten("coarse", &["--texels", "8"]);
    let plane = |name: &str, more: &[&str]| {
        let run = ["render", name, "--scene", "plane", "--size", "80x60", "--repeat", "2", "--json"];
        report(&folder.run(&[&run[..], more].concat()).succeeded())
    };
    let full = plane("button", &["--sheet", "s.png", "-o", "p.exr"]);
    let [factors, coarse] = ["factors", "coarse"].map(|name| plane(name, &[]));
    for (name, drawn) in [("button (brdf)", &full), ("factors (factors)", &factors), ("coarse (brdf)", &coarse)] {
        assert_eq!(drawn["parts"][0]["material"], name);
        assert!(mean(drawn, "shading") < 0.1, "{drawn}");
    }
    // Finer layers are closer to the surface itself with its shadows, for any form of the reflectance.
    for drawn in [&full, &factors] {
        assert!(mean(drawn, "total") < 0.7 * mean(&coarse, "total"), "{drawn} {coarse}");
    }
    assert!(folder.path().join("s.png").is_file() && folder.path().join("p.exr").is_file());
    for scene in ["bottle", "vase", "teapot", "sphere"] {
        let ran = folder.run(&["render", "button/button.ktx2", "--scene", scene, "--size", "80x80", "--json"]);
        let drawn = report(&ran.succeeded());
        // Few texels and few pixels.
        assert!(mean(&drawn, "shading") < 0.3 && (0.5..12.0).contains(&mean(&drawn, "total")), "{drawn}");
    }
    let info = folder.run(&["info", "button"]).succeeded().stdout;
    assert!(info.contains("synth:button?resolution=48") && info.contains("brdf: "), "{info}");
    assert_eq!(folder.run(&["info", "button/button.ktx2"]).succeeded().stdout, info);
    let views = folder.run(&["info", "factors"]).succeeded().stdout;
    assert!(views.contains("texels seen by one view") && !info.contains("texels seen by one view"), "{views}");
    for (wrong, expected) in [
        (["render", "button", "--lod", "2"], "a flat BTF"),
        (["render", "synth:lambert", "--repeat", "2"], "only to flat BTFs"),
        (["render", "button", "--repeat", "0"], "1 to 1024"),
    ] {
        let ran = folder.run(&wrong);
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{ran:?}");
    }
    let mut file = folder.read("button/button.ktx2");
    let middle = file.len() / 2;
    file[middle] ^= 1;
    folder.write("button/button.ktx2", file);
    let ran = folder.run(&["render", "button", "--scene", "plane"]);
    assert!(ran.code == 3 && ran.stderr.contains("button.ktx2: checksum of the file: found "), "{ran:?}");
}
