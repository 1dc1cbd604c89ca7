//! `brdfc bandwidth`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};
use crate::common::shared_data;
use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};

fn map(folder: &Folder, input: &str, more: &[&str]) -> (BandwidthMap, serde_json::Value) {
    let ran = folder.run(&[&["bandwidth", input, "-o", "map.ktx2", "--json"][..], more].concat()).succeeded();
    let report = ran.json();
    conforms("bandwidth", &report);
    (BandwidthMap::from_bytes(&folder.read("map.ktx2")).unwrap(), report)
}

/// Stripes of 8 pixels, in an image of 64 x 32.
fn stripes(folder: &Folder, name: &str) {
    let wave = |x: u32| 0.5 + 0.4 * (std::f32::consts::TAU * (x as f32 + 0.5) / 8.0).sin();
    if name.ends_with(".png") {
        let image = image::RgbImage::from_fn(64, 32, |x, _| image::Rgb([(255.0 * wave(x)) as u8, 128, 128]));
        image.save(folder.path().join(name)).unwrap();
    } else {
        let image = image::Rgb32FImage::from_fn(64, 32, |x, _| image::Rgb([wave(x), 1.0, 1.0]));
        image::DynamicImage::ImageRgb32F(image).save(folder.path().join(name)).unwrap();
    }
}

#[test]
fn every_kind_of_material_has_a_map() {
    let folder = Folder::new();
    for input in inputs(&folder) {
        let (map, report) = map(&folder, input, &["--resolution", "32"]);
        assert_eq!((map.header().kind, map.size(), map.header().transformed), (BandwidthKind::Brdf, [256; 2], [32; 2]));
        assert_eq!((&report["of"], &report["unit"]), (&"brdf".into(), &"cycles per radian".into()));
        assert!(report["largest"].as_f64().unwrap() > 0.1, "{report}");
    }
    let (constant, report) = map(&folder, "synth:lambert", &[]);
    assert!(constant.values().iter().all(|value| *value == 0.0));
    assert_eq!((&report["largest"], &report["constant"]), (&0.0.into(), &1.0.into()));
}

#[test]
fn images_are_environments_or_textures() {
    let folder = Folder::new();
    for name in ["sky.exr", "sky.hdr", "cloth.png"] {
        stripes(&folder, name);
    }
    for name in ["sky.exr", "sky.hdr"] {
        let (map, report) = map(&folder, name, &[]);
        assert_eq!((map.header().kind, map.size()), (BandwidthKind::Environment, [32, 16]));
        // 8 cycles around the equator.
        let found = map.environment([1.0, 0.0, 0.2]) * std::f32::consts::TAU;
        assert!(found > 8.0 && found < 20.0, "{found}");
        assert_eq!(report["metres"], serde_json::Value::Null);
    }
    // A prefiltered environment counts as its finest level, four faces wide.
    folder.run(&["environment", "sky.exr", "-o", "sky.ktx2"]).succeeded();
    let (of_cube, _) = map(&folder, "sky.ktx2", &["--kind", "environment"]);
    let found = of_cube.environment([1.0, 0.0, 0.2]) * std::f32::consts::TAU;
    assert!(of_cube.header().kind == BandwidthKind::Environment && found > 8.0 && found < 20.0, "{found}");
    let (cloth, report) = map(&folder, "cloth.png", &["--size", "0.5x0.25"]);
    assert_eq!(cloth.header().kind, BandwidthKind::Texture { metres: [0.5, 0.25], tiles: true });
    let found = cloth.texture([0.4, 0.4]);
    assert!(found > 16.0 && found < 32.0, "16 cycles per metre: {found}");
    assert_eq!((&report["unit"], &report["tiles"]), (&"cycles per metre".into(), &true.into()));
    let (alone, _) = map(&folder, "cloth.png", &["--size", "0.5x0.25", "--no-tile"]);
    assert_eq!(alone.header().kind, BandwidthKind::Texture { metres: [0.5, 0.25], tiles: false });
    assert_eq!(map(&folder, "cloth.png", &["--kind", "environment"]).0.header().kind, BandwidthKind::Environment);
    let placed = ["--kind", "texture", "--size", "1x1"];
    assert!(matches!(map(&folder, "sky.exr", &placed).0.header().kind, BandwidthKind::Texture { .. }));
}

#[test]
fn info_tells_what_a_map_is() {
    let folder = Folder::new();
    let (_, report) = map(&folder, "synth:ggx?alpha=0.3", &["--epsilon", "0.02"]);
    let mut output = folder.run(&["info", "map.ktx2", "--json"]).succeeded().json();
    conforms("bandwidth", &output);
    // Fields that only the command that made it knows.
    for field in ["seconds", "repaired"] {
        assert!(output[field].is_null() && !report[field].is_null(), "{field}");
        output[field] = report[field].clone();
    }
    assert_eq!(output, report);
    let text = folder.run(&["info", "map.ktx2"]).succeeded().stdout;
    assert!(text.contains("bandwidth map") && text.contains("cycles per radian") && text.contains("0.02"), "{text}");
    // It is not a material.
    let ran = folder.run(&["encode", "map.ktx2", "-o", "pack.ktx2"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("pack: found a bandwidth map, expected a pack of a BRDF"), "{}", ran.stderr);
}

/// 'auto' finds the number of pixels that a lobe needs, and a note reports when it is too small.
#[test]
fn narrow_lobes_get_more_pixels_until_they_are_not_limited() {
    let folder = Folder::new();
    let of = |material: &str, more: &[&str]| {
        let (map, report) = map(&folder, material, more);
        let output = folder.run(&["info", "map.ktx2", "--json"]).succeeded().json();
        assert_eq!(output["limited"], report["limited"]);
        (map.header().transformed[0], report["limited"].as_f64().unwrap(), folder.read("map.ktx2"))
    };
    let (wide, narrow) = ("synth:ggx?alpha=0.3", "synth:ggx?alpha=0.1");
    let (side, limited, bytes) = of(wide, &["--resolution", "auto"]);
    assert_eq!((side, limited), (64, 0.0));
    assert!(bytes == of(wide, &[]).2, "the bytes of 64 pixels");
    let (side, limited, bytes) = of(narrow, &["--resolution", "auto"]);
    assert_eq!((side, limited), (256, 0.0));
    assert!(bytes == of(narrow, &["--resolution", "256"]).2);
    let (side, limited, _) = of(narrow, &[]);
    assert!(side == 64 && limited > 0.001, "{limited}");
    let ran = folder.run(&["bandwidth", narrow, "-o", "map.ktx2"]).succeeded();
    assert!(
        ran.stderr.contains("of 65536 values may be too low, because lobes have only 64 x 64 pixels"),
        "{}",
        ran.stderr
    );
    assert!(ran.stdout.contains("limited by these"), "{}", ran.stdout);
    // More than the automatic maximum.
    assert_eq!(of(narrow, &["--resolution", "512"]).0, 512);
}

/// Bandwidths at 32 to 256 pixels are 6, 12, 20 and 38 cycles per radian.
#[test]
fn a_mirror_is_limited_and_that_is_said() {
    let Some(chrome) = shared_data("merl/chrome.binary") else { return };
    let folder = Folder::new();
    let arguments = ["bandwidth", chrome.to_str().unwrap(), "-o", "map.ktx2", "--json", "--resolution", "auto"];
    let ran = folder.run(&arguments).succeeded();
    let report = ran.json();
    assert_eq!(report["transformed"][0], 256);
    assert!(report["largest"].as_f64().unwrap() > 30.0 && report["limited"].as_f64().unwrap() > 0.01, "{report}");
    assert!(ran.stderr.contains("because lobes have only 256 x 256 pixels"), "{}", ran.stderr);
}

/// Ten times the threshold: means of 6.4, 5.9 and 5.3 cycles per radian.
#[test]
fn the_threshold_hardly_matters_in_a_real_environment() {
    let Some(museum) = shared_data("env/museum.exr") else { return };
    let folder = Folder::new();
    let [low, middle, high] = ["0.003", "0.01", "0.03"].map(|epsilon| {
        let (map, report) = map(&folder, museum.to_str().unwrap(), &["--epsilon", epsilon]);
        assert_eq!((map.size(), map.header().transformed), ([256, 128], [512, 256]));
        report["mean"].as_f64().unwrap()
    });
    // Ten times the threshold takes half an octave off.
    assert!(low / middle < 1.3 && middle / high < 1.3 && high <= middle && middle <= low, "{low} {middle} {high}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    stripes(&folder, "sky.exr");
    for input in ["synth:ward?ax=0.1&ay=0.4", "sky.exr"] {
        let bytes = ["1", "3"].map(|jobs| {
            map(&folder, input, &["--jobs", jobs]);
            folder.read("map.ktx2")
        });
        assert!(bytes[0] == bytes[1], "{input}");
    }
}

#[cfg(feature = "render")]
#[test]
fn a_rendering_shows_the_map() {
    let folder = Folder::new();
    map(&folder, "synth:ggx?alpha=0.3", &["--rendering", "map.png"]);
    let rendering = image::open(folder.path().join("map.png")).unwrap().into_rgb8();
    assert_eq!(rendering.dimensions(), (256, 256));
    let pale = rendering.pixels().filter(|pixel| pixel.0[1] > 200).count();
    assert!(pale > 0 && pale < 256 * 256 / 2, "{pale}");
}

#[test]
fn wrong_usage_and_wrong_inputs() {
    let folder = Folder::new();
    stripes(&folder, "cloth.png");
    folder.write("broken.exr", b"no image");
    folder.run(&["encode", "synth:lambert", "-o", "synth.ktx2", "--max-bytes", "4096"]).succeeded();
    image::DynamicImage::ImageRgb32F(image::Rgb32FImage::new(32, 32)).save(folder.path().join("square.exr")).unwrap();
    folder.write("broken.hdr", b"no image");
    let before = folder.files(".");
    for (code, input, more, expected) in [
        (2, "synth:ggx", &["--epsilon", "0.5"][..], "--epsilon: found 0.5, expected 0.0001 to 0.1"),
        (2, "synth:ggx", &["--epsilon", "NaN"], "--epsilon: found NaN, expected"),
        (2, "synth:ggx", &["--resolution", "48"], "--resolution: found 48, expected a power of two from 32 to 1024"),
        (2, "synth:ggx", &["--resolution", "2048"], "--resolution: found 2048, expected a power of two"),
        (3, "square.exr", &[], "square.exr: environment: found 32 x 32 pixels, expected a latitude-longitude image"),
        (3, "synth.ktx2", &["--kind", "environment"], "synth.ktx2: environment: found a table pack, expected"),
        (2, "synth:ggx", &["--kind", "texture"], "--kind: found texture for a material, expected brdf for materials"),
        (2, "synth:ggx", &["--size", "1x1"], "--size and --no-tile apply only to textures"),
        (2, "cloth.png", &[], "--size: required for textures; expected WIDTHxHEIGHT of the texture in metres"),
        (2, "cloth.png", &["--size", "1x0"], "--size: found 1x0, expected"),
        (2, "cloth.png", &["--size", "1xNaN"], "--size: found 1xNaN, expected"),
        (2, "cloth.png", &["--kind", "brdf"], "--kind: found brdf for an image"),
        (2, "cloth.png", &["--size", "1x1", "--resolution", "64"], "--resolution does not apply to images"),
        (3, "synth:nothing", &[], "synth:nothing: "),
        (3, "broken.exr", &[], "broken.exr: EXR: "),
        (3, "broken.hdr", &[], "broken.hdr: HDR: "),
        (4, "absent.hdr", &[], "absent.hdr: cannot read"),
        (4, "absent.binary", &[], "absent.binary: cannot read"),
    ] {
        let ran = folder.run(&[&["bandwidth", input, "-o", "map.ktx2"][..], more].concat());
        assert_eq!(ran.code, code, "{input} {more:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected) && ran.stdout.is_empty(), "{input} {more:?}: {}", ran.stderr);
    }
    let ran = folder.run(&["bandwidth", "cloth.png", "-o", "cloth.png", "--size", "1x1"]);
    assert!(ran.code == 2 && ran.stderr.contains("would overwrite the input "), "{}", ran.stderr);
    assert!(folder.files(".") == before);
}
