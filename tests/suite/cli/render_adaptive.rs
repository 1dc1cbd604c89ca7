//! `brdfc render --adaptive`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use crate::common::has_adapter;
use serde_json::Value;

const SMALL: [&str; 10] =
    ["--adaptive", "--scene", "bumpy-ball", "--size", "64x48", "--grid", "8", "--truth", "64", "--json"];

fn drawn(folder: &Folder, input: &str, more: &[&str]) -> Value {
    let report = folder.run(&[&["render", input][..], &SMALL, more].concat()).succeeded().json();
    conforms("render-adaptive", &report);
    report
}

/// Stripes around the sky, bright above.
fn sky(folder: &Folder, name: &str) {
    let image = image::Rgb32FImage::from_fn(64, 32, |x, y| {
        let stripe = if (x / 4) % 2 == 0 { 1.0 } else { 0.2 };
        image::Rgb([stripe, 0.8 * stripe, if y < 16 { 1.5 } else { 0.1 }])
    });
    image::DynamicImage::ImageRgb32F(image).save(folder.path().join(name)).unwrap();
}

#[test]
fn a_rendering_with_its_cost_its_error_and_its_maps() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    sky(&folder, "sky.exr");
    let images =
        ["-o", "a.png", "--reference", "b.exr", "--sheet", "c.png", "--maps", "d.png", "--difference", "e.png"];
    let report = drawn(&folder, "synth:ggx?alpha=0.3", &[&["--environment", "sky.exr"][..], &images].concat());
    assert_eq!(report["environment"], serde_json::json!([64, 32]));
    let [adaptive, forward] = ["adaptive", "forward"].map(|name| &report[name]);
    let points = report["surface_points"].as_u64().unwrap();
    assert!(points > 500 && forward["samples"] == 32 * points && forward["shaded"] == points, "{report}");
    let shaded: u64 = report["levels"].as_array().unwrap().iter().map(|l| l["shaded"].as_u64().unwrap()).sum();
    assert!(adaptive["shaded"] == shaded && shaded < points, "{report}");
    for shading in [adaptive, forward] {
        assert!(shading["psnr"].as_f64().unwrap() > 15.0 && shading["flip"].as_f64().unwrap() < 0.3, "{report}");
    }
    for (name, width) in [("a.png", 64), ("c.png", 3 * 64 + 8), ("d.png", 3 * 64 + 8), ("e.png", 64)] {
        let image = image::load_from_memory(&folder.read(name)).unwrap();
        assert_eq!((image.width(), image.height()), (width, 48), "{name}");
    }
    assert!(report.get("rates").is_none(), "{report}");
    // The same numbers and renderings again.
    let again = drawn(&folder, "synth:ggx?alpha=0.3", &["--environment", "sky.exr", "-o", "f.png"]);
    assert_eq!((&again["adaptive"]["psnr"], &again["levels"]), (&adaptive["psnr"], &report["levels"]));
    assert_eq!(folder.read("a.png"), folder.read("f.png"));
}

/// Texels of the image, counts of the report, and a caution so high that no pixel may be coarse.
#[test]
fn rates_of_tiles() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let rates = |more: &[&str], size: (u32, u32)| {
        let report = drawn(&folder, "synth:ggx?alpha=0.3", &[&["--rates", "r.png"][..], more].concat());
        let image = image::load_from_memory(&folder.read("r.png")).unwrap();
        let image::DynamicImage::ImageLuma8(image) = image else { panic!("{:?}", image.color()) };
        assert_eq!(image.dimensions(), size);
        let rates = report["rates"].clone();
        let mut sums = [0; 2];
        for (count, texel) in rates["counts"].as_array().unwrap().iter().zip([0, 5, 10]) {
            let tiles = image.pixels().filter(|pixel| pixel.0 == [texel]).count();
            assert_eq!((&count["texel"], &count["tiles"]), (&texel.into(), &tiles.into()), "{rates}");
            sums[0] += count["pixels"].as_u64().unwrap();
            sums[1] += count["shaded"].as_u64().unwrap();
        }
        (sums, report["surface_points"].as_u64().unwrap(), rates["psnr"].as_f64())
    };
    let coarse = ["--caution", "0.05"];
    let ([pixels, shaded], surface, psnr) = rates(&[&coarse[..], &["--rate-tile", "8"]].concat(), (8, 6));
    assert!(pixels == surface && 2 * shaded < pixels && psnr.unwrap() > 20.0, "{pixels} {shaded} {surface} {psnr:?}");
    // Larger tiles are finer; four points are still one pixel.
    let ([_, larger], ..) = rates(&[&coarse[..], &["--antialias", "4"]].concat(), (4, 3));
    assert!(larger >= shaded && larger < pixels, "{larger} {shaded} {pixels}");
    let ([pixels, all], _, psnr) = rates(&["--caution", "1000"], (4, 3));
    assert!(10 * all > 9 * pixels && psnr.is_none_or(|psnr| psnr > 40.0), "{all} {pixels} {psnr:?}");
}

#[test]
fn budget_caution_and_antialiasing_do_what_they_say() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let cost = |more: &[&str]| {
        let report = drawn(&folder, "synth:ggx?alpha=0.3", more);
        [&report["adaptive"]["samples"], &report["adaptive"]["shaded"]].map(|value| value.as_u64().unwrap())
    };
    let usual = cost(&[]);
    let (more, sharper, finer) = (cost(&["--budget", "256"]), cost(&["--caution", "2"]), cost(&["--antialias", "4"]));
    assert!(more[0] > 2 * usual[0] && more[1] == usual[1], "{usual:?} {more:?}");
    assert!(sharper[1] > usual[1] && finer[1] > usual[1] && finer[1] < 4 * usual[1], "{usual:?} {sharper:?} {finer:?}");
}

#[test]
fn packs_manifests_and_what_a_build_wrote() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    sky(&folder, "sky.exr");
    folder.write(
        "scene.toml",
        b"[scene]\nenvironment = 'sky.exr'\n[materials.m]\nsource = 'synth:ggx?alpha=0.3'\ngrid = 8\n[[uses]]\nmaterial = 'm'\n\
          maps = ['bandwidth', 'samples']\n",
    );
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    let manifest = |more: &[&str]| {
        let scene = ["--adaptive", "--scene", "bumpy-ball", "--size", "32x24", "--truth", "16", "--json"];
        let report = folder.run(&[&["render", "scene.toml"][..], &scene, more].concat()).succeeded().json();
        conforms("render-adaptive", &report);
        report
    };
    let (fresh, built) = (manifest(&[]), manifest(&["--packs", "packs"]));
    assert_eq!(fresh["environment"], serde_json::json!([64, 32]));
    assert_eq!(fresh["levels"], built["levels"], "what the build wrote is what is made afresh");
    // A pack alone: its own lobes are looked up.
    let pack = "packs/m.brdf.ktx2";
    let scene = ["--adaptive", "--scene", "bumpy-ball", "--size", "32x24", "--truth", "16", "--json"];
    conforms("render-adaptive", &folder.run(&[&["render", pack][..], &scene].concat()).succeeded().json());
    // A map of another material in its place is not used.
    std::fs::copy(folder.path().join("packs/m.samples.ktx2"), folder.path().join("packs/m.bandwidth.ktx2")).unwrap();
    let ran = folder.run(&[&["render", "scene.toml", "--packs", "packs"][..], &scene].concat()).succeeded();
    assert!(ran.stderr.contains("note: m: m.bandwidth.ktx2 is out of date"), "{}", ran.stderr);
    assert_eq!(ran.json()["levels"], built["levels"]);
}

#[test]
fn wrong_flags_are_named() {
    let folder = Folder::new();
    let lambert = ["render", "synth:lambert"];
    for (more, expected) in [
        (&["--adaptive", "--budget", "0"][..], "--budget: found 0, expected 0.01 to 1024"),
        (&["--adaptive", "--caution", "nan"], "--caution: found NaN, expected 0.001 to 1000"),
        (&["--adaptive", "--antialias", "2"], "--antialias: found 2, expected 1, 4 or 16"),
        (&["--adaptive", "--truth", "1"], "--truth: found 1, expected 16 to 65536"),
        (&["--adaptive", "--forward", "0"], "--forward: found 0, expected 1 to 1024"),
        (&["--adaptive", "--samples", "2"], "--samples does not apply to --adaptive"),
        (&["--adaptive", "--bandwidth-directions", "0"], "--bandwidth-directions: found 0, expected 1 to 4096"),
        (&["--adaptive", "--rates", "r.png", "--rate-tile", "12"], "--rate-tile: found 12, expected 8, 16 or 32"),
        (&["--budget", "4"], "--adaptive"),
        (&["--rates", "r.png"], "--adaptive"),
        (&["--adaptive", "--maps", "maps.exr"], "--maps: found maps.exr, expected a name that ends in .png"),
    ] {
        let ran = folder.run(&[&lambert[..], more].concat());
        assert_eq!(ran.code, 2, "{more:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{more:?}: {}", ran.stderr);
    }
    let ran = folder.run(&[&lambert[..], &["--adaptive", "--environment", "none.exr"]].concat());
    assert!(ran.code == 3 || ran.code == 4, "{} {}", ran.code, ran.stderr);
    assert!(ran.stderr.contains("none.exr"), "{}", ran.stderr);
}

#[test]
fn a_limit_that_is_missed_is_exit_code_1() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new();
    let code = |limit| folder.run(&[&["render", "synth:lambert"][..], &SMALL, &["--min-psnr", limit]].concat()).code;
    assert_eq!((code("5"), code("99")), (0, 1));
}
