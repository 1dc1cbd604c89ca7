//! `brdfc environment`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::container::{Extent, TexelFormat, Texture};
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentPack};
use image::{DynamicImage, Rgb, Rgb32FImage};
use std::collections::BTreeMap;

/// Pixels per row of the test environments.
#[cfg(feature = "render")]
const WIDTH: u32 = 64;

/// Writes a grey sky of 64 x 32 pixels with a pixel of another radiance.
pub fn sky(folder: &Folder, name: &str, ambient: f32, sun: f32) {
    let pixel = |x: u32, y: u32| Rgb([if (x, y) == (20, 8) { sun } else { ambient }; 3]);
    DynamicImage::ImageRgb32F(Rgb32FImage::from_fn(64, 32, pixel)).save(folder.path().join(name)).unwrap();
}

/// A cube map of 32-bit floats, as another program would write it.
fn of_texels(side: u32, texels: &[[f32; 3]]) -> Texture {
    let texels = texels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 1.0]).flat_map(f32::to_le_bytes).collect();
    let (format, extent) = (TexelFormat::Rgba32Float, Extent::Cube(side));
    Texture { format, extent, entries: BTreeMap::new(), levels: 1, texels }
}

/// The finest level of a pack as a cube map of another program.
pub fn cube(pack: &EnvironmentPack) -> Texture {
    of_texels(pack.header().side, &pack.level(0).collect::<Vec<_>>())
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
            (pack.header().side, &report["levels"], &report["image"], &report["faces"]),
            (64, &4.into(), &serde_json::json!([64, 32]), &1.into())
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
    folder.write("sky.png", "no image");
    folder.run(&["bandwidth", "sky.hdr", "-o", "map.ktx2"]).succeeded();
    DynamicImage::ImageRgb32F(Rgb32FImage::new(32, 32)).save(folder.path().join("probe.exr")).unwrap();
    let mut texture = of_texels(8, &vec![[1.0; 3]; 6 * 64]);
    let whole = texture.to_bytes(false);
    folder.write("cut.ktx2", &whole[..whole.len() - 1]);
    let at = 16 * (3 * 64 + 8 + 2) + 4;
    texture.texels[at..at + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    folder.write("infinite.ktx2", texture.to_bytes(true));
    let flat = Texture { extent: Extent::D2([16, 24]), ..texture.clone() };
    folder.write("flat.ktx2", flat.to_bytes(true));
    let bytes = Texture { format: TexelFormat::Rgba8Unorm, texels: vec![9; 4 * 6 * 64], ..texture };
    folder.write("bytes.ktx2", bytes.to_bytes(true));
    for (arguments, code, expected) in [
        (&["sky.hdr", "--side", "100"][..], 2, "--side: found 100, expected a power of two, 8 to 2048"),
        (&["sky.hdr", "--side", "4096"], 2, "--side: found 4096, expected a power of two, 8 to 2048"),
        (&["text.hdr"], 3, "text.hdr: HDR: "),
        (&["probe.exr"], 3, "probe.exr: environment: found 32 x 32 pixels, expected a latitude-longitude image, twice"),
        (
            &["sky.png"],
            3,
            "sky.png: environment: found extension .png, expected a latitude-longitude image (.exr, .hdr),",
        ),
        (&["map.ktx2"], 3, "map.ktx2: environment: found a bandwidth map, expected a latitude-longitude image"),
        (&["flat.ktx2"], 3, "flat.ktx2: byte 36, faceCount: found 1, expected 6, a cube map"),
        (&["bytes.ktx2"], 3, "bytes.ktx2: byte 12, vkFormat: found 37, expected 97 (R16G16B16A16_SFLOAT), "),
        (&["cut.ktx2"], 3, "cut.ktx2: level 0: found 6144 bytes from byte "),
        (
            &["infinite.ktx2"],
            3,
            "infinite.ktx2: level 0: found [1.0, inf, 1.0] at texel (2, 1) of face -Y, expected finite",
        ),
        (&["gone.exr"], 4, "gone.exr: cannot read"),
    ] {
        let ran = folder.run(&[&["environment"], arguments, &["-o", "e.ktx2"]].concat());
        assert!(ran.code == code && ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
        assert!(!folder.path().join("e.ktx2").exists());
    }
}

/// Directions over the sphere, with the light from there at all sharpnesses.
fn light(pack: &EnvironmentPack) -> Vec<[f32; 3]> {
    let decoder = EnvironmentDecoder::new(pack);
    let seen = |at: usize| {
        let (y, turn) = (1.0 - 2.0 * (at as f32 + 0.5) / 3000.0, at as f32 * 2.4);
        let radius = (1.0 - y * y).sqrt();
        decoder.radiance([radius * turn.cos(), y, radius * turn.sin()], (at % 9) as f32 * 0.5)
    };
    (0..3000).map(seen).collect()
}

fn relative_error(found: &[[f32; 3]], expected: &[[f32; 3]]) -> f32 {
    let error = |(a, b): (&[f32; 3], &[f32; 3])| (a[1] - b[1]).abs() / b[1].max(1e-3);
    found.iter().zip(expected).map(error).fold(0.0, f32::max)
}

/// The finest level of a pack, read as a cube map, gives the light of the pack, also with a sun beyond the halves.
#[test]
fn cube_maps_keep_their_light() {
    let folder = Folder::new();
    sky(&folder, "sun.exr", 0.1, 1e5);
    let (pack, _) = prefiltered(&folder, "sun.exr", &[]);
    folder.write("pack.ktx2", folder.read("e.ktx2"));
    let texture = cube(&pack);
    folder.write("cube.ktx2", texture.to_bytes(true));
    // Negative control: +Z and -Z are exchanged.
    let face = texture.texels.len() / 6;
    let mut texels = texture.texels.clone();
    texels[4 * face..].rotate_left(face);
    folder.write("mirrored.ktx2", Texture { texels, ..texture }.to_bytes(false));
    for (name, side) in [("cube.ktx2", None), ("pack.ktx2", None), ("cube.ktx2", Some("128"))] {
        let (found, report) = prefiltered(&folder, name, &side.map_or(vec![], |side| vec!["--side", side]));
        assert_eq!((&report["image"], &report["faces"]), (&serde_json::json!([64, 64]), &6.into()));
        if side.is_none() {
            assert!(found.level(0).eq(pack.level(0)), "{name}: equal sides copy texels");
            let error = relative_error(&light(&found), &light(&pack));
            assert!(error < 0.01, "{name}: {error}");
        } else {
            // Twice as fine: the same light in wide kernels, except where the sun is at the horizon.
            let of = |pack: &EnvironmentPack| pack.irradiance().map(|texel| texel[1]).collect::<Vec<_>>();
            let (found_here, expected) = (of(&found), of(&pack));
            let largest = expected.iter().copied().fold(0.0, f32::max);
            let error = found_here.iter().zip(&expected).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f32::max);
            assert!(found.header().side == 128 && error < 0.02, "{error}");
        }
    }
    let (mirrored, _) = prefiltered(&folder, "mirrored.ktx2", &[]);
    assert!(relative_error(&light(&mirrored), &light(&pack)) > 0.9);
    // A build takes both kinds.
    for name in ["cube.ktx2", "pack.ktx2"] {
        let build = ["build", "synth:lambert", "--max-bytes", "1KiB", "--environment", name, "--out", "packs"];
        folder.run(&build).succeeded();
        prefiltered(&folder, name, &[]);
        assert!(folder.read("packs/environment.prefiltered.ktx2") == folder.read("e.ktx2"), "{name}");
    }
}

/// Faces are those of Vulkan's table: one bright texel on each, off the centre, in a known direction.
#[test]
fn faces_have_the_orientation_of_vulkan() {
    let folder = Folder::new();
    // Column 12 and row 3 of 16: s = 9/16 to the right, t = -9/16 down.
    let directions = [
        [1.0, 0.5625, -0.5625],
        [-1.0, 0.5625, 0.5625],
        [0.5625, 1.0, -0.5625],
        [0.5625, -1.0, 0.5625],
        [0.5625, 0.5625, 1.0],
        [-0.5625, 0.5625, -1.0],
    ];
    let mut texels = vec![[0.0; 3]; 6 * 256];
    (0..6).for_each(|face| texels[256 * face + 16 * 3 + 12] = [1.0 + face as f32, 0.0, 0.0]);
    folder.write("cube.ktx2", of_texels(16, &texels).to_bytes(true));
    let (pack, _) = prefiltered(&folder, "cube.ktx2", &["--side", "16"]);
    let decoder = EnvironmentDecoder::new(&pack);
    for (face, direction) in directions.into_iter().enumerate() {
        assert_eq!(decoder.radiance(direction, 2.0)[0], 1.0 + face as f32, "face {face}");
        // Mirrored, or with columns and rows exchanged, there is no light.
        let [x, y, z] = direction;
        for other in [[x, y, -z], [-x, y, z], [x, -y, z]] {
            let is_lit = directions.contains(&other);
            assert_eq!(decoder.radiance(other, 2.0)[0] > 0.0, is_lit, "{other:?}");
        }
    }
}
