//! `brdfc render` of assets that cover a whole scene: packs of RTI captures, and assets that a manifest names.

use super::schemas::conforms;
use crate::common::cli::{Folder, Ran};
use crate::common::has_adapter;
use brdfc_formats::pwt::Domain;
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_pwt::{LightSamples, PwtRecipe, encode};
use serde_json::Value;

const SIZE: [usize; 2] = [48, 32];

/// A matte relief whose left half is red.
fn samples() -> LightSamples {
    let ring = |z: f32, count: usize| {
        (0..count).map(move |k| {
            let (sine, cosine) = (std::f32::consts::TAU * k as f32 / count as f32).sin_cos();
            let r = (1.0 - z * z).sqrt();
            [r * cosine, r * sine, z]
        })
    };
    let lights: Vec<[f32; 3]> = ring(0.9, 8).chain(ring(0.5, 12)).collect();
    let rendering = |light: &[f32; 3]| {
        let pixel = |at: usize| {
            let slope = 0.5 * ((at % SIZE[0]) as f32 / 2.0).sin();
            let cosine = (light[2] - slope * light[0]).max(0.0) / (1.0 + slope * slope).sqrt();
            let colour = if at % SIZE[0] < 24 { [0.8, 0.2, 0.1] } else { [0.3, 0.4, 0.6] };
            colour.map(|c| Domain::Linear.encode(c * cosine))
        };
        (0..SIZE[0] * SIZE[1]).map(pixel).collect()
    };
    let images: Vec<Vec<[f32; 3]>> = lights.iter().map(rendering).collect();
    LightSamples::new(SIZE, lights, images)
}

/// A folder with the RTI capture `stack` and its pack `relief.ktx2`.
fn folder() -> Folder {
    let folder = Folder::new();
    let samples = samples();
    let stack = folder.path().join("stack");
    std::fs::create_dir(&stack).unwrap();
    write_rti_capture(&stack, &samples.lights, SIZE, StackFormat::Exr, |light| {
        samples.images[light].clone().into_linear()
    })
    .unwrap();
    folder.write("relief.ktx2", encode(&samples, &PwtRecipe::default()).unwrap().pack.to_bytes(true));
    folder
}

fn report(ran: &Ran) -> Value {
    let report = ran.json();
    conforms("render", &report);
    report
}

fn mean(report: &Value, of: &str) -> f64 {
    report[of]["delta_e"]["mean"].as_f64().unwrap_or_else(|| panic!("{of}: {report}"))
}

#[test]
fn a_rendering_under_any_light() {
    if !has_adapter() {
        return;
    }
    let folder = folder();
    let ran = folder.run(&["render", "relief.ktx2", "-o", "relief.png", "--source", "stack", "--json"]).succeeded();
    let drawn = report(&ran);
    assert_eq!(
        (drawn["scene"].as_str(), drawn["width"].as_u64(), drawn["height"].as_u64()),
        (Some("plane"), Some(512), Some(342))
    );
    assert!(mean(&drawn, "shading") < 0.3 && mean(&drawn, "total") < 2.0, "{drawn}");
    assert!(ran.stderr.contains("its light is 0.0° from"), "{}", ran.stderr);
    let rendering = image::open(folder.path().join("relief.png")).unwrap().to_rgb8();
    let [left, right] = [100, 400].map(|x| rendering.get_pixel(x, 170).0);
    assert!(left[0] > left[2] && right[2] > right[0], "{left:?} {right:?}");

    let exact = folder.run(&["render", "relief.ktx2", "--exact", "--size", "48x32", "--json"]).succeeded();
    assert!(mean(&report(&exact), "shading") < 0.05, "{}", exact.stdout);
    let ball = folder.run(&["render", "relief.ktx2", "--scene", "sphere", "--size", "40x40", "--json"]).succeeded();
    assert!(mean(&report(&ball), "shading") < 0.5);
}

#[test]
fn wrong_flags_of_renderings_are_refused() {
    let folder = folder();
    folder.run(&["synth", "lambert", "-o", "l.binary", "--dimensions", "4x4x8"]).succeeded();
    for (arguments, expected) in [
        (&["render", "stack"][..], "stack: RTI captures are not drawn; draw a pack"),
        (&["render", "stack/dirs.lp"], "stack/dirs.lp: RTI captures are not drawn; draw a pack"),
        (&["render", "relief.ktx2", "--lod", "2"], "--lod does not apply to relief.ktx2, a pack of an RTI capture"),
        (&["render", "relief.ktx2", "--contact", "c.png"], "--contact does not apply to relief.ktx2"),
        (&["render", "relief.ktx2", "--adaptive"], "--adaptive does not apply to relief.ktx2"),
        (&["render", "relief.ktx2", "--source", "l.binary"], "l.binary"),
    ] {
        let ran = folder.run(arguments);
        assert!([2, 3, 4].contains(&ran.code) && ran.stderr.contains(expected), "{arguments:?}: {ran:?}");
    }
}

const MANIFEST: &str = "\
[render]
asset = 'relief.ktx2'
width = 60
height = 40

[render.camera]
eye = [0.0, 3.0, 2.0]

[[render.lights]]
position = [-4.0, 4.0, 0.0]
intensity = 60.0
";

#[test]
fn a_manifest_names_camera_and_lights_of_an_asset() {
    if !has_adapter() {
        return;
    }
    let folder = folder();
    let drawn = |name: &str, text: &str| {
        folder.write("scene.toml", text);
        let drawn = report(&folder.run(&["render", "scene.toml", "-o", name, "--json"]).succeeded());
        assert!(mean(&drawn, "shading") < 0.5, "{drawn}");
        folder.read(name)
    };
    let first = drawn("a.png", MANIFEST);
    assert_eq!(first, drawn("b.png", MANIFEST));
    assert_ne!(first, drawn("c.png", &MANIFEST.replace("eye = [0.0, 3.0, 2.0]", "eye = [1.0, 3.0, 2.0]")));
    assert_ne!(first, drawn("d.png", &MANIFEST.replace("position = [-4.0,", "position = [4.0,")));

    let flatten = ["flatten", "synth:button?resolution=32", "-o", "button", "--texels", "32"];
    let ran = folder.run(&flatten);
    assert_eq!(ran.code, 0, "{ran:?}");
    let flat = MANIFEST.replace("'relief.ktx2'", "'button'\nscene = 'plane'");
    assert_ne!(drawn("e.png", &flat), drawn("f.png", &flat.replace("position = [-4.0,", "position = [4.0,")));
}

#[test]
fn wrong_assets_are_reported() {
    let folder = folder();
    folder.run(&["synth", "lambert", "-o", "l.binary", "--dimensions", "4x4x8"]).succeeded();
    for (change, to, expected) in [
        ("'relief.ktx2'", "''", "line 2, render.asset: found \"\", expected "),
        ("'relief.ktx2'", "3", "line 2, render.asset"),
        ("'relief.ktx2'", "'nothing.ktx2'", "nothing.ktx2"),
        ("'relief.ktx2'", "'l.binary'", "l.binary: render.asset: expected a flat BTF"),
        ("'relief.ktx2'", "'stack'", "stack: RTI captures are not drawn"),
        ("asset", "aset", "did you mean asset?"),
        ("width = 60", "materials = { sphere = 'red' }", "render.materials: sphere does not apply with render.asset"),
    ] {
        folder.write("scene.toml", MANIFEST.replace(change, to));
        let ran = folder.run(&["render", "scene.toml"]);
        assert!([3, 4].contains(&ran.code) && ran.stderr.contains(expected), "{to}: {ran:?}");
    }
}
