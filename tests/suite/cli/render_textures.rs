//! Textures of `brdfc render --adaptive` and of `brdfc build`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use crate::common::has_adapter;

/// A manifest whose plaster has a texture.
const SCENE: &str = "[scene]\nenvironment = 'sky.exr'\n[materials.plaster]\nsource = 'synth:lambert?kd=0.8'\ngrid = 8\n\
                     [[uses]]\nmaterial = 'plaster'\nmaps = ['bandwidth', 'samples']\ntexture = 'checks.png'\n\
                     texture_size = [0.5, 0.25]\n";

fn folder() -> Folder {
    let folder = Folder::new();
    let checks =
        image::GrayImage::from_fn(32, 16, |x, y| image::Luma([if (x / 8 + y / 8) % 2 == 0 { 240 } else { 60 }]));
    checks.save(folder.path().join("checks.png")).unwrap();
    let sky = image::Rgb32FImage::from_fn(32, 16, |_, y| image::Rgb([1.0, 0.9, if y < 8 { 1.5 } else { 0.2 }]));
    image::DynamicImage::ImageRgb32F(sky).save(folder.path().join("sky.exr")).unwrap();
    folder
}

/// The texture on a ball, by flags and by a manifest with its map from a build. The control has no bandwidth of the texture.
#[test]
fn a_texture_is_shaded_where_it_varies() {
    if !has_adapter() {
        return;
    }
    let folder = folder();
    let small = ["--adaptive", "--scene", "sphere", "--size", "96x96", "--truth", "64", "--forward", "8", "--json"];
    let drawn = |input: &str, more: &[&str]| {
        let report = folder.run(&[&["render", input][..], &small, more].concat()).succeeded().json();
        conforms("render-adaptive", &report);
        report
    };
    let texture = ["--texture", "checks.png", "--texture-size", "2x2", "-o", "a.png", "--environment", "sky.exr"];
    let report = drawn("synth:lambert?kd=0.8", &texture);
    let psnr = |shading: &str| report[shading]["psnr"].as_f64().unwrap();
    assert!(psnr("adaptive") > psnr("without_texture_bandwidth") + 3.0, "{report}");
    let [ours, ignored] = ["adaptive", "without_texture_bandwidth"].map(|of| report[of]["shaded"].as_u64().unwrap());
    assert!(ours > 2 * ignored, "{ours} {ignored}");
    let placed = &report["textures"][0];
    assert_eq!((&placed["texture"], &placed["metres"]), (&"checks.png".into(), &serde_json::json!([2.0, 2.0])));
    let shown = image::load_from_memory(&folder.read("a.png")).unwrap().to_luma8();
    let middle: Vec<u8> = (30..66).map(|x| shown.get_pixel(x, 38).0[0]).collect();
    assert!(middle.iter().max() > middle.iter().min().map(|least| least + 80).as_ref(), "{middle:?}");
    // Without a texture there is no such row.
    let plain = drawn("synth:lambert?kd=0.8", &["--environment", "sky.exr"]);
    assert!(plain.get("without_texture_bandwidth").is_none() && plain["textures"] == serde_json::json!([]), "{plain}");

    folder.write("scene.toml", SCENE.replace("[0.5, 0.25]", "[2, 2]"));
    let before = drawn("scene.toml", &[]);
    folder.run(&["build", "scene.toml"]).succeeded();
    let built = drawn("scene.toml", &[]);
    let samples = |report: &serde_json::Value| report["adaptive"]["samples"].clone();
    assert_eq!((samples(&before), &before["levels"]), (samples(&built), &built["levels"]));
    assert!(ours.abs_diff(built["adaptive"]["shaded"].as_u64().unwrap()) < ours / 20, "{built}");
}

/// A build makes the map of a texture with the bandwidth of its material, and does not open the image otherwise.
#[test]
fn a_build_makes_the_map_of_a_texture_where_a_scene_needs_it() {
    let folder = folder();
    let build = |text: &str| {
        folder.write("scene.toml", text);
        folder.run(&["build", "scene.toml", "--json"]).succeeded().json()
    };
    let report = build(SCENE);
    conforms("build", &report);
    folder.run(&["bandwidth", "checks.png", "--size", "0.5x0.25", "-o", "alone.ktx2"]).succeeded();
    assert!(folder.read("alone.ktx2") == folder.read("packs/plaster.texture.ktx2"));
    let made = &report["materials"][0];
    assert_eq!(
        (&made["texture"], &made["maps"]["texture"]["facts"]["metres"]),
        (&"plaster.texture.ktx2".into(), &serde_json::json!([0.5, 0.25]))
    );
    assert!(folder.text("packs/plaster.json").contains("plaster.texture.ktx2"));
    let words = folder.run(&["build", "scene.toml"]).succeeded().stdout;
    assert!(words.contains("plaster.texture.ktx2"), "{words}");
    // Nothing changed; another image of the same name is read.
    assert!(build(SCENE)["materials"][0]["stages"].is_null());
    image::GrayImage::new(8, 8).save(folder.path().join("checks.png")).unwrap();
    let again = build(SCENE);
    let stages: Vec<&str> =
        again["materials"][0]["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap()).collect();
    assert_eq!(stages, ["read", "bandwidth map", "write"], "neither pack nor other maps");
    // Scenes that do not need the map never open the image.
    std::fs::remove_file(folder.path().join("checks.png")).unwrap();
    for (from, to) in [
        ("maps = ['bandwidth', 'samples']", "maps = ['samples']"),
        ("maps = ['bandwidth', 'samples']", "lighting = ['points']"),
        ("maps = ['bandwidth', 'samples']", ""),
    ] {
        let report = build(&SCENE.replace(from, to));
        assert!(report["materials"][0].get("texture").is_none(), "{to}: {report}");
        assert!(!folder.path().join("packs/plaster.texture.ktx2").exists(), "{to}");
    }
    folder.write("scene.toml", SCENE);
    let ran = folder.run(&["build", "scene.toml"]);
    assert!(ran.code == 4 && ran.stderr.contains("checks.png: cannot read"), "{}", ran.stderr);
}

#[test]
fn textures_that_cannot_be_used() {
    if !has_adapter() {
        return;
    }
    let folder = folder();
    folder.write("text.png", "not an image");
    let wide = image::GrayImage::new(4097, 1);
    wide.save(folder.path().join("wide.png")).unwrap();
    let size = ["--texture-size", "1x1"];
    let adaptive = |texture: &'static str| ["--adaptive", "--size", "16x16", "--texture", texture];
    for (more, code, expected) in [
        (vec!["--texture", "checks.png"], 2, "--adaptive"),
        ([&["--adaptive"][..], &size].concat(), 2, "--texture"),
        (adaptive("checks.png").to_vec(), 2, "--texture-size: required for textures; expected WIDTHxHEIGHT"),
        ([&adaptive("checks.png")[..], &["--texture-size", "0x1"]].concat(), 2, "--texture-size: found 0x1"),
        (
            [&adaptive("checks.png")[..], &["--texture-size", "1e-5x1"]].concat(),
            2,
            "found 1.000e-5 x 1.000 m, expected",
        ),
        ([&adaptive("checks.png")[..], &["--texture-size", "1x900"]].concat(), 2, "found 1.000 x 900.0 m, expected"),
        ([&adaptive("text.png")[..], &size].concat(), 3, "text.png: image: found text, expected a complete PNG"),
        (
            [&adaptive("wide.png")[..], &size].concat(),
            3,
            "wide.png: image: found 4097 x 1 pixels, expected at most 4096",
        ),
        ([&adaptive("gone.png")[..], &size].concat(), 4, "gone.png: cannot read"),
        ([&adaptive("checks.png")[..], &size, &["-o", "checks.png"]].concat(), 2, "checks.png"),
    ] {
        let ran = folder.run(&[&["render", "synth:lambert?kd=0.8"][..], &more].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{more:?}: {} {}", ran.code, ran.stderr);
    }
}

#[test]
fn uses_with_wrong_textures() {
    let folder = folder();
    let second = "[[uses]]\nmaterial = 'plaster'\n";
    for (text, expected) in [
        (
            SCENE.replace("texture_size = [0.5, 0.25]\n", ""),
            "line 9, uses[0].texture: needs texture_size = [width, height]",
        ),
        (SCENE.replace("texture = 'checks.png'\n", ""), "line 9, uses[0].texture_size: needs texture"),
        (
            SCENE.replace("[0.5, 0.25]", "[0.5, 0]"),
            "line 10, uses[0].texture_size: found [0.5, 0], expected [width, height]",
        ),
        (SCENE.replace("[0.5, 0.25]", "0.5"), "uses[0].texture_size"),
        (SCENE.replace("'checks.png'", "3"), "line 9, uses[0].texture"),
        (
            format!("{SCENE}{second}"),
            "uses[1].texture: found none, expected \"checks.png\" of [0.5, 0.25] m, as in uses[0]",
        ),
    ] {
        folder.write("scene.toml", &text);
        let ran = folder.run(&["build", "scene.toml"]);
        assert!(ran.code == 3 && ran.stderr.contains(expected), "{expected}: {} {}", ran.code, ran.stderr);
    }
}
