//! `brdfc environment`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentPack};
use image::{DynamicImage, Rgb, Rgb32FImage};

/// Pixels per row of the test environments.
#[cfg(feature = "render")]
const WIDTH: u32 = 64;

/// Writes a grey sky of 64 x 32 pixels with a pixel of another radiance.
pub fn sky(folder: &Folder, name: &str, ambient: f32, sun: f32) {
    let pixel = |x: u32, y: u32| Rgb([if (x, y) == (20, 8) { sun } else { ambient }; 3]);
    DynamicImage::ImageRgb32F(Rgb32FImage::from_fn(64, 32, pixel)).save(folder.path().join(name)).unwrap();
}

/// Writes an environment without symmetry, turned by quarter turns, as a page turns it.
#[cfg(feature = "render")]
pub fn room(folder: &Folder, name: &str, quarters: u32) {
    let pixel = |x: u32, y: u32| {
        // A positive angle turns +z towards +x, against the azimuth of images.
        let x = (x + quarters * WIDTH / 4) % WIDTH;
        let lamp = |column: u32, row: u32| x.abs_diff(column) < 4 && y.abs_diff(row) < 3;
        let floor = if y > WIDTH / 4 { 0.3 } else { 1.0 };
        let wall = [0.1 + 0.4 * x as f32 / WIDTH as f32, 0.3, 0.6 - 0.4 * x as f32 / WIDTH as f32];
        let light = if lamp(12, 8) {
            12.0
        } else if lamp(40, 12) {
            4.0
        } else {
            0.0
        };
        Rgb(wall.map(|c| floor * c + light))
    };
    DynamicImage::ImageRgb32F(Rgb32FImage::from_fn(WIDTH, WIDTH / 2, pixel)).save(folder.path().join(name)).unwrap();
}

fn prefiltered(folder: &Folder, input: &str, more: &[&str]) -> (EnvironmentPack, serde_json::Value) {
    let ran = folder.run(&[&["environment", input, "-o", "e.ktx2", "--json"][..], more].concat()).succeeded();
    let report = ran.json();
    conforms("environment", &report);
    (EnvironmentPack::from_bytes(&folder.read("e.ktx2")).unwrap(), report)
}

#[test]
fn images_become_prefiltered_environments() {
    let folder = Folder::new();
    for name in ["sky.exr", "sky.hdr"] {
        sky(&folder, name, 0.5, 0.5);
        let (pack, report) = prefiltered(&folder, name, &[]);
        assert_eq!(
            (pack.header().side, &report["levels"], &report["image"]),
            (64, &4.into(), &serde_json::json!([64, 32]))
        );
        assert!((0..4).all(|level| pack.level(level).all(|texel| texel == [0.5; 3])));
        let output = folder.run(&["info", "e.ktx2", "--json"]).succeeded().json();
        conforms("info", &output);
        for key in ["kind", "side", "levels", "scale", "largest", "gpu_bytes"] {
            assert_eq!(output[key], report[key], "{key}");
        }
    }
    assert_eq!(prefiltered(&folder, "sky.hdr", &["--side", "16"]).0.header().side, 16);
    let ran = folder.run(&["environment", "sky.hdr", "-o", "e.ktx2"]).succeeded();
    assert!(ran.stdout.contains("6 faces of 64 x 64, 4 levels"), "{}", ran.stdout);
}

/// A sun of 10⁵ in one pixel keeps its light at all levels, in its direction.
#[test]
fn a_sun_neither_vanishes_nor_smears() {
    let folder = Folder::new();
    sky(&folder, "sun.exr", 0.1, 1e5);
    let (pack, report) = prefiltered(&folder, "sun.exr", &[]);
    let decoder = EnvironmentDecoder::new(&pack);
    assert!(report["largest"].as_f64().unwrap() > 5e4, "{report}");
    let unit = |x: f64, y: f64| {
        let (azimuth, colatitude) = (std::f64::consts::TAU * x / 64.0, std::f64::consts::PI * y / 32.0);
        let sine = colatitude.sin();
        [sine * azimuth.cos(), colatitude.cos(), sine * azimuth.sin()].map(|c| c as f32)
    };
    let towards = unit(20.5, 8.5);
    // The image's own filter: a tent of two pixels in both directions.
    let solid_angle =
        std::f64::consts::TAU / 64.0 * std::f64::consts::PI / 32.0 * (std::f64::consts::PI * 8.5 / 32.0).sin();
    for sharpness in 0..=4 {
        let seen = f64::from(decoder.radiance(towards, sharpness as f32)[0]);
        let behind = f64::from(decoder.radiance(towards.map(|c| -c), sharpness as f32)[0]);
        assert!((behind - 0.1).abs() < 2e-3, "{sharpness}: {behind}");
        let expected = match sharpness {
            0 => 0.1 + 1e5 * solid_angle / std::f64::consts::PI,
            4 => continue,
            _ => {
                let s = (15.75f64 / f64::from(1 << (sharpness - 1))).to_radians();
                // A tent has a variance of a sixth of a pixel, along each axis.
                let tent = std::f64::consts::PI / 32.0 / 6f64.sqrt();
                0.1 + 1e5 * solid_angle / (std::f64::consts::TAU * (s * s + tent * tent))
            }
        };
        assert!((seen / expected - 1.0).abs() < 0.12, "{sharpness}: {seen} {expected}");
    }
}

#[test]
fn wrong_sides_and_other_files_are_refused() {
    let folder = Folder::new();
    sky(&folder, "sky.hdr", 0.5, 0.5);
    folder.write("text.hdr", "no image");
    for (arguments, code, expected) in [
        (&["sky.hdr", "--side", "100"][..], 2, "--side: found 100, expected a power of two, 8 to 2048"),
        (&["sky.hdr", "--side", "4096"], 2, "--side: found 4096, expected a power of two, 8 to 2048"),
        (&["text.hdr"], 3, "text.hdr: HDR: "),
        (&["gone.exr"], 4, "gone.exr: cannot read"),
    ] {
        let ran = folder.run(&[&["environment"], arguments, &["-o", "e.ktx2"]].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
        assert!(!folder.path().join("e.ktx2").exists());
    }
}
