//! Outputs of `brdfc pwt` for other programs: normals, albedo, and relightable images for web viewers.

use super::pwt::stack;
use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_pwt::ptm::spread_lights;
use brdfc_pwt::web::{WebImage, WebInfo};
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_readers::ptm::Ptm;
use brdfc_testing::browser::{File, result_of_page};
use std::path::{Path, PathBuf};

const SIZE: [usize; 2] = [31, 24];

/// Normal of a wavy surface; y goes up, rows go down.
fn normal(pixel: usize) -> [f32; 3] {
    let (x, y) = ((pixel % SIZE[0]) as f32, -((pixel / SIZE[0]) as f32));
    let n = [0.5 * (0.3 * x).sin(), 0.1 + 0.4 * (0.25 * y).sin(), 0.8];
    let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
    n.map(|c| c / length)
}

/// A Lambertian surface, in `matte`.
fn matte(lights: &[[f32; 3]]) -> Folder {
    let folder = Folder::new();
    let pixels = |light: usize| -> Vec<[f32; 3]> {
        let cosine = |n: [f32; 3]| n.iter().zip(lights[light]).map(|(a, b)| a * b).sum::<f32>().max(0.0);
        (0..SIZE[0] * SIZE[1]).map(|pixel| [0.8, 0.4, 0.2].map(|albedo| albedo * cosine(normal(pixel)))).collect()
    };
    write_rti_capture(&folder.path().join("matte"), lights, SIZE, StackFormat::Png, pixels).unwrap();
    folder
}

fn rgb(folder: &Folder, name: &str) -> image::RgbImage {
    image::load_from_memory(&folder.read(name)).unwrap().into_rgb8()
}

/// Mean difference of 8-bit levels between an image of normals and the known ones.
fn difference(normals: &image::RgbImage, known: impl Fn(usize) -> [f32; 3]) -> f32 {
    assert_eq!(normals.dimensions(), (SIZE[0] as u32, SIZE[1] as u32));
    let levels = |pixel| known(pixel).map(|c| 255.0 * (0.5 * c + 0.5));
    let off = |(pixel, found): (usize, &image::Rgb<u8>)| {
        found.0.iter().zip(levels(pixel)).map(|(a, b)| (f32::from(*a) - b).abs()).sum::<f32>()
    };
    normals.pixels().enumerate().map(off).sum::<f32>() / (3 * SIZE[0] * SIZE[1]) as f32
}

/// Known answer, from photographs, a map, a pack and next to a pack. Normals with y down are the negative control.
#[test]
fn normals_and_albedo_are_those_of_the_surface() {
    let folder = matte(&spread_lights(30));
    let report = folder.run(&["pwt", "matte", "--normals", "n.png", "--albedo", "a.png", "--json"]).succeeded().json();
    conforms("pwt", &report);
    assert_eq!((&report["kind"], &report["surface"]["lights"]), (&"images".into(), &30.into()));
    assert!(report["surface"]["outliers"].as_f64().unwrap() < 0.01, "{report}");
    let normals = rgb(&folder, "n.png");
    let down = difference(&normals, |pixel| [normal(pixel)[0], -normal(pixel)[1], normal(pixel)[2]]);
    assert!(difference(&normals, normal) < 0.5 && down > 10.0, "{} {down}", difference(&normals, normal));
    let expected = [0.8, 0.4, 0.2].map(encode_srgb_byte);
    for albedo in rgb(&folder, "a.png").pixels() {
        assert!(albedo.0.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "{albedo:?}");
    }
    let ran = folder.run(&["pwt", "matte", "-o", "p.ktx2", "--normals", "with.png"]).succeeded();
    assert!(ran.stdout.contains("dB held out") && ran.stdout.contains("outliers"), "{}", ran.stdout);
    assert_eq!(folder.read("with.png"), folder.read("n.png"));
    folder.run(&["pwt", "matte", "-o", "m.ptm"]).succeeded();
    for input in ["p.ktx2", "m.ptm"] {
        folder.run(&["pwt", input, "--normals", "again.png"]).succeeded();
        let found = difference(&rgb(&folder, "again.png"), normal);
        assert!(found < 6.0, "{input}: {found}");
    }
}

#[test]
fn lights_that_do_not_determine_normals_are_refused() {
    let lights = [[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [-0.8, 0.0, 0.6]];
    let folder = matte(&lights);
    let refused = folder.run(&["pwt", "matte", "--normals", "n.png"]);
    assert_eq!(refused.code, 3, "{refused:?}");
    assert!(
        refused.stderr.contains("matte: lights: found 4 almost in one plane or direction, expected 3 or more"),
        "{refused:?}"
    );
    assert!(!folder.path().join("n.png").exists());
}

#[test]
fn outputs_are_checked_before_work() {
    let folder = matte(&spread_lights(6));
    let refused = |arguments: &[&str], text: &str| {
        let refused = folder.run(&[&["pwt", "matte"][..], arguments].concat());
        assert_eq!(refused.code, 2, "{refused:?}");
        assert!(refused.stderr.contains(text), "{text}: {}", refused.stderr);
    };
    refused(&[], "--output");
    refused(&["--normals", "n.jpg"], "--normals: found n.jpg, expected a name that ends in .png");
    refused(&["--normals", "matte/0003.png"], "--normals: would overwrite the input matte/0003.png");
    refused(&["--normals", "n.png", "--albedo", "n.png"], "--normals and --albedo: both are n.png");
    refused(&["--normals", "n.png", "--quality", "30"], "--quality does not apply to normals");
    let allowed = "--hold-out does not apply to normals and albedo, only to packs and images for web viewers";
    refused(&["--normals", "n.png", "--hold-out", "2"], allowed);
    refused(&["--web", "w", "--hold-out", "6"], "--hold-out: ");
    folder.write("matte/plane_0.jpg", folder.read("matte/0000.png"));
    let list = String::from_utf8(folder.read("matte/dirs.lp")).unwrap();
    folder.write("matte/dirs.lp", list.replace("0000.png", "plane_0.jpg"));
    refused(&["--web", "matte"], "--web: would overwrite the input matte/plane_0.jpg");
}

/// JPEG files hold one column less than a map may have.
#[test]
fn maps_that_are_too_large_for_jpeg_files_are_refused() {
    let folder = Folder::new();
    for (width, code) in [(65_535, 0), (65_536, 3)] {
        let map = Ptm::from_coefficients_rgb([width, 1], &vec![[[0.0, 0.0, 0.0, 0.0, 0.0, 99.0]; 3]; width as usize]);
        folder.write("wide.ptm", map.unwrap().to_bytes());
        let ran = folder.run(&["pwt", "wide.ptm", "--web", "web"]);
        assert_eq!(ran.code, code, "{ran:?}");
        let text = "wide.ptm: size: found 65536 x 1, expected at most 65535 along each side, the limit of JPEG files";
        assert_eq!(ran.stderr.contains(text), code == 3, "{ran:?}");
    }
}

/// The exported image as our decoder reads it.
fn exported(folder: &Path) -> WebImage {
    let info: WebInfo = serde_json::from_slice(&std::fs::read(folder.join("info.json")).unwrap()).unwrap();
    let plane = |k: usize| image::open(folder.join(format!("plane_{k}.jpg"))).unwrap().into_rgb8().into_raw();
    WebImage { planes: (0..info.nplanes / 3).map(plane).collect(), info }
}

/// PSNR of 8-bit levels against values, dB.
fn psnr(found: &[[u8; 3]], expected: &[[f32; 3]]) -> f64 {
    let square = |(a, b): (&u8, &f32)| (f64::from(*a) / 255.0 - f64::from(b.clamp(0.0, 1.0))).powi(2);
    let (found, expected) = (found.as_flattened(), expected.as_flattened());
    assert_eq!(found.len(), expected.len());
    -10.0 * (found.iter().zip(expected).map(square).sum::<f64>() / found.len() as f64).log10()
}

#[test]
fn images_for_web_viewers_have_small_errors_at_unseen_lights() {
    let folder = stack();
    let report = folder.run(&["pwt", "stack", "--web", "web", "--hold-out", "5", "--json"]).succeeded().json();
    conforms("pwt", &report);
    let [fitted, unseen] = [&report["web"]["psnr"], &report["web"]["held_out"]["psnr"]].map(|v| v.as_f64().unwrap());
    assert!(fitted > 34.0 && unseen > 24.0, "{fitted} {unseen}");
    let web = exported(&folder.path().join("web"));
    assert_eq!((web.info.lights.len(), web.info.nplanes, web.planes.len()), (3 * 35, 9, 3));
    // Against a photograph that was held out; another one is the negative control.
    // The steepest, because the lowest ones have no neighbours.
    let held_out = report["web"]["held_out"]["lights"].as_array().unwrap();
    let light = held_out.iter().map(|light| light.as_u64().unwrap() as usize).min().unwrap();
    let photograph = |light: usize| -> Vec<[u8; 3]> {
        rgb(&folder, &format!("stack/{light:04}.png")).pixels().map(|pixel| pixel.0).collect()
    };
    let image = web.image(spread_lights(40)[light]);
    let (right, wrong) = (psnr(&photograph(light), &image), psnr(&photograph((light + 13) % 40), &image));
    assert!(right > 28.0 && wrong < right - 8.0, "{right} {wrong}");
    let bytes = ["1", "3"].map(|jobs| {
        folder.run(&["pwt", "stack", "--web", "web", "--jobs", jobs]).succeeded();
        ["info.json", "plane_0.jpg", "plane_2.jpg", "normals.jpg"].map(|name| folder.read(&format!("web/{name}")))
    });
    assert!(bytes[0] == bytes[1]);
}

/// `normals.jpg` is made of all photographs, like the normals of `--normals`, which are computed once for both.
#[test]
fn normals_for_web_viewers_are_those_of_all_photographs() {
    let folder = matte(&spread_lights(8));
    let normals = |more: &[&str]| {
        let arguments = ["pwt", "matte", "--web", "web", "--json"];
        let report = folder.run(&[&arguments[..], more].concat()).succeeded().json();
        assert_eq!(report["surface"].is_null(), !more.contains(&"--normals"), "{report}");
        assert_eq!(report["notes"], serde_json::json!([]));
        folder.read("web/normals.jpg")
    };
    let all = normals(&[]);
    assert!(difference(&rgb(&folder, "web/normals.jpg"), normal) < 2.0);
    assert!(normals(&["--normals", "n.png"]) == all && normals(&["--hold-out", "5"]) == all);
    // Lights in one plane determine no normals: an error only if they are requested.
    let folder = matte(&[[0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [-0.8, 0.0, 0.6]]);
    let ran = folder.run(&["pwt", "matte", "--web", "web", "--json"]).succeeded();
    let note = "no normals for web viewers: lights: found 4 almost in one plane or direction, expected 3 or more";
    assert!(ran.stderr.contains(&format!("note: matte: {note}")), "{}", ran.stderr);
    assert!(ran.json()["notes"][0].as_str().unwrap().starts_with(note), "{}", ran.stdout);
    assert!(!folder.path().join("web/normals.jpg").exists() && folder.path().join("web/info.json").exists());
    assert_eq!(folder.run(&["pwt", "matte", "--web", "web", "--albedo", "a.png"]).code, 3);
}

/// Photographs without variation have no components, and images for web viewers have planes of zeros, which viewers open.
#[test]
fn images_for_web_viewers_have_planes_without_variation() {
    let folder = Folder::new();
    for (level, lights) in [(0.0, 8), (1.0, 8), (0.0, 1), (1.0, 1)] {
        let (pixels, lights) = (vec![[level; 3]; SIZE[0] * SIZE[1]], spread_lights(lights));
        let format = StackFormat::Png;
        write_rti_capture(&folder.path().join("flat"), &lights, SIZE, format, |_| pixels.clone()).unwrap();
        let report = folder.run(&["pwt", "flat", "--web", "web", "--json"]).succeeded().json();
        assert_eq!(report["web"]["coefficients"], 9, "{level}, {} lights", lights.len());
        let web = exported(&folder.path().join("web"));
        let material = &web.info.materials[0];
        assert_eq!([web.planes.len(), material.scale.len(), material.bias.len(), material.range.len()], [3, 9, 9, 9]);
        let image = web.image(lights[0]);
        assert!(image.as_flattened().iter().all(|value| (value - level).abs() < 0.01), "{level}: {:?}", image[0]);
    }
}

/// OpenLIME as one module.
fn openlime() -> Option<Vec<u8>> {
    let installed = || brdfc_testing::repository().join("tests/openlime/node_modules/openlime/dist/js/openlime.esm.js");
    let path = std::env::var_os("BRDFC_OPENLIME").map_or_else(installed, PathBuf::from);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        println!("skipped: no image for web viewers is opened: no {}", path.display());
    }
    bytes
}

/// Canvases of OpenLIME that show a folder under some lights, row by row from the top. `None` without a browser.
fn canvases(openlime: &[u8], folder: &Path, lights: &[[f32; 3]]) -> Option<Vec<Vec<[u8; 3]>>> {
    let web = exported(folder);
    let (width, height) = (web.info.width, web.info.height);
    let page = include_str!("../../openlime/page.html").replace("WIDTH", &width.to_string());
    let lights: Vec<[f32; 2]> = lights.iter().map(|[x, y, _]| [*x, *y]).collect();
    let page = page.replace("HEIGHT", &height.to_string()).replacen("of LIGHTS", &format!("of {lights:?}"), 1);
    let mut files = vec![("openlime.js".to_owned(), openlime.to_vec()), (String::new(), page.into_bytes())];
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap()) {
        let name = format!("web/{}", entry.file_name().to_str().unwrap());
        files.push((name, std::fs::read(entry.path()).unwrap()));
    }
    let media = |name: &str| match name.rsplit('.').next() {
        Some("js") => "text/javascript",
        Some("json") => "application/json",
        Some("jpg") => "image/jpeg",
        _ => "text/html",
    };
    let served: Vec<File<'_>> =
        files.iter().map(|(name, bytes)| (name.as_str(), media(name), bytes.as_slice())).collect();
    let posted = result_of_page(&served)?;
    let pixels = posted.strip_prefix([width as u32, height as u32].map(u32::to_le_bytes).as_flattened());
    let pixels = pixels.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&posted)));
    let canvas = |bytes: &[u8]| -> Vec<[u8; 3]> {
        let rows = bytes.chunks_exact(4 * width).rev();
        rows.flat_map(|row| row.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]])).collect()
    };
    Some(pixels.chunks_exact(4 * width * height).map(canvas).collect())
}

/// Another implementation of the layout: OpenLIME's canvas is the image of our decoder. The image under the other light
/// is the negative control.
#[test]
fn openlime_draws_the_image_of_the_decoder() {
    let Some(openlime) = openlime() else { return };
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "map.ptm", "--model", "lrgb"]).succeeded();
    let icon = brdfc_testing::shared_data("rti/icon");
    let inputs = ["stack".into(), "map.ptm".into()].into_iter().chain(icon);
    for input in inputs {
        let input = input.to_str().unwrap();
        folder.run(&["pwt", input, "--web", "web"]).succeeded();
        let folder = folder.path().join("web");
        let lights = [[0.28, 0.46, 0.843], [-0.62, 0.31, 0.721]];
        let Some(canvases) = canvases(&openlime, &folder, &lights) else { return };
        let images = lights.map(|light| exported(&folder).image(light));
        for (light, canvas) in canvases.iter().enumerate() {
            let [right, wrong] = [light, 1 - light].map(|other| psnr(canvas, &images[other]));
            println!("OpenLIME, {input}, {:?}: {right:.1} dB, the other light {wrong:.1} dB", lights[light]);
            assert!(right > 45.0 && wrong < 30.0, "{input}: {right} {wrong}");
        }
    }
}

/// A pack of photographs that are read as linear is compared and drawn with them read alike. Other inputs have no photographs.
#[test]
fn all_commands_read_photographs_alike() {
    let folder = matte(&spread_lights(16));
    let linear = ["--photographs", "linear"];
    folder.run(&[&["pwt", "matte", "-o", "p.ktx2"][..], &linear].concat()).succeeded();
    let compared = |more: &[&str]| {
        let ran = folder.run(&[&["compare", "matte", "p.ktx2", "--json"], more].concat()).succeeded();
        ran.json()["delta_e"].as_f64().unwrap()
    };
    assert!(compared(&linear) < 6.0 && compared(&[]) > 8.0, "{} {}", compared(&linear), compared(&[]));
    let page = |more: &[&str]| {
        folder.run(&[&["view", "p.ktx2", "matte", "-o", "v.html"], more].concat()).succeeded();
        folder.read("v.html")
    };
    assert_ne!(page(&linear), page(&[]));
    for (arguments, expected) in [
        (&["compare", "synth:lewis", "synth:lewis"][..], "--photographs does not apply to reflectances"),
        (&["view", "p.ktx2", "-o", "v.html"], "--photographs: found no RTI capture"),
    ] {
        let ran = folder.run(&[arguments, &linear].concat());
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{}", ran.stderr);
    }
}

/// A black background dilutes neither the error of a pack nor the doubt about normals.
#[test]
fn black_backgrounds_do_not_dilute_errors() {
    let (lights, size) = (spread_lights(24), SIZE);
    let figures = |share: usize| {
        let folder = Folder::new();
        // A glossy bump among pixels that are black but for noise.
        let pixels = |light: usize| -> Vec<[f32; 3]> {
            let pixel = |pixel: usize| {
                let n = normal(pixel);
                let half = [0, 1, 2].map(|k| lights[light][k] + [0.0, 0.0, 1.0][k]);
                let length = half.iter().map(|c| c * c).sum::<f32>().sqrt();
                let c = n.iter().zip(half).map(|(a, b)| a * b).sum::<f32>() / length;
                let noise = 0.001 * ((7 * pixel + 5 * light) % 5) as f32;
                let value = 0.05 + 0.8 * c.max(0.0).powi(60);
                if (pixel % size[0]) * 100 < share * size[0] { [value, 0.7 * value, 0.5 * value] } else { [noise; 3] }
            };
            (0..size[0] * size[1]).map(pixel).collect()
        };
        write_rti_capture(&folder.path().join("bump"), &lights, size, StackFormat::Png, pixels).unwrap();
        let report = folder.run(&["pwt", "bump", "-o", "p.ptm", "--normals", "n.png", "--json"]).succeeded().json();
        let surface = &report["surface"];
        [&report["delta_e"], &surface["between_halves"], &surface["outliers"]].map(|figure| figure.as_f64().unwrap())
    };
    let (whole, part) = (figures(100), figures(13));
    for (whole, part) in whole.into_iter().zip(part) {
        assert!(part > 0.5 * whole && part < 2.0 * whole, "{whole} {part}");
    }
}
