//! `brdfc pwt`, and uses of its packs.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::pwt::PwtPack;
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_pwt::ptm::spread_lights;

pub(super) const SIZE: [usize; 2] = [45, 38];

/// A bumpy, glossy surface under 40 lights, in `stack`.
pub(super) fn stack() -> Folder {
    let folder = Folder::new();
    let lights = spread_lights(40);
    write(&folder, "stack", &lights, |_, light| lights[light]);
    folder
}

/// Writes photographs of the surface. `seen` gives the light of a pixel: its direction, and its intensity as the length.
fn write(folder: &Folder, name: &str, lights: &[[f32; 3]], seen: impl Fn([f32; 2], usize) -> [f32; 3]) {
    let pixels = |light: usize| -> Vec<[f32; 3]> {
        let pixel = |k: usize| {
            let (x, y) = ((k % SIZE[0]) as f32, (k / SIZE[0]) as f32);
            let normal = [0.3 * (0.5 * x).sin(), 0.3 * (0.4 * y).cos(), 0.9];
            let vector = seen([x, y], light);
            let intensity = vector.iter().map(|c| c * c).sum::<f32>().sqrt();
            let cosine: f32 = normal.iter().zip(vector).map(|(a, b)| a * b / intensity).sum();
            let (diffuse, gloss) = (cosine.max(0.0), cosine.max(0.0).powi(12));
            [0.7, 0.4, 0.2].map(|colour| intensity * (colour * diffuse + 0.2 * gloss))
        };
        (0..SIZE[0] * SIZE[1]).map(pixel).collect()
    };
    write_rti_capture(&folder.path().join(name), lights, SIZE, StackFormat::Png, pixels).unwrap();
}

/// A list that states positions makes a better pack for distant lights than the same list without the line.
#[test]
fn near_lights_become_distant() {
    let folder = stack();
    // As far from the middle as the images are wide.
    let lights = spread_lights(40);
    write(&folder, "near", &lights, |[x, y], light| {
        let [width, height] = SIZE.map(|side| side as f32);
        let [a, b, c] = lights[light];
        let vector = [a - ((x + 0.5) / width - 0.5), b - (0.5 * height - y - 0.5) / width, c];
        let squared: f32 = vector.iter().map(|c| c * c).sum();
        vector.map(|c| c / squared.powf(1.5))
    });
    let psnr = |note: bool| {
        let report = folder.run(&["pwt", "near", "-o", "near.ktx2", "--json"]).succeeded().json();
        let notes = report["notes"]
            .as_array()
            .unwrap()
            .iter()
            .any(|text| text.as_str().unwrap().contains("near lights, at distances of 1 image"));
        assert_eq!(notes, note, "{report}");
        folder.run(&["compare", "stack", "near.ktx2", "--json"]).succeeded().json()["psnr"].as_f64().unwrap()
    };
    let as_directions = psnr(false);
    let mut list = String::from_utf8(folder.read("near/dirs.lp")).unwrap();
    list += "# positions in image widths\n";
    std::fs::write(folder.path().join("near/dirs.lp"), list).unwrap();
    let as_positions = psnr(true);
    assert!(as_positions > as_directions + 6.0, "{as_positions} {as_directions}");
    let info = folder.run(&["info", "near"]).succeeded();
    assert!(info.stdout.contains("near lights") && info.stdout.contains("1 image widths"), "{}", info.stdout);
    // Comparisons convert the photographs, too.
    let compared = folder.run(&["compare", "near", "near.ktx2", "--json"]).succeeded();
    assert!(compared.stderr.contains("near lights, at distances of 1 image widths"), "{compared:?}");
    assert!(compared.json()["psnr"].as_f64().unwrap() > 30.0, "{compared:?}");
    folder.run(&["pwt", "near", "--normals", "n.png", "--web", "web", "--hold-out", "5"]).succeeded();
    // One position in another unit.
    let list = String::from_utf8(folder.read("near/dirs.lp")).unwrap();
    let third = list.lines().nth(3).unwrap();
    std::fs::write(folder.path().join("near/dirs.lp"), list.replace(third, "0002.png 250 0 250")).unwrap();
    let refused = folder.run(&["pwt", "near", "-o", "x.ktx2"]);
    let text =
        "dirs.lp: line 4, position: found 353.553 image widths from the middle, expected at most 10; the nearest light";
    assert!(refused.code == 3 && refused.stderr.contains(text), "{refused:?}");
}

#[test]
fn photographs_become_a_pack_that_is_right_at_unseen_lights() {
    let folder = stack();
    let report = folder.run(&["pwt", "stack", "-o", "p.ktx2", "--hold-out", "5", "--json"]).succeeded().json();
    conforms("pwt", &report);
    let pack = PwtPack::from_bytes(&folder.read("p.ktx2")).unwrap();
    assert_eq!(report["kind"], "pwt");
    assert_eq!(report["lights"], 35);
    assert_eq!(report["bytes_on_gpu"], pack.gpu_bytes());
    assert_eq!(report["bytes_on_disk"], folder.read("p.ktx2").len());
    assert_eq!(report["held_out"]["lights"].as_array().unwrap().len(), 5);
    let [fitted, unseen] = [&report["psnr"], &report["held_out"]["psnr"]].map(|psnr| psnr.as_f64().unwrap());
    assert!(fitted > 30.0 && unseen > 28.0, "{fitted} {unseen}");
    // The list of lights is the same input, and text on stdout has the same content.
    let ran = folder.run(&["pwt", "stack/dirs.lp", "-o", "q.ktx2", "--hold-out", "5"]).succeeded();
    assert!(folder.read("q.ktx2") == folder.read("p.ktx2"));
    assert!(ran.stdout.contains("dB held out") && ran.stdout.contains("hemisphere"), "{}", ran.stdout);
    // Negative control: other lights.
    let other =
        folder.run(&["pwt", "stack", "-o", "r.ktx2", "--hold-out", "5", "--seed", "1", "--json"]).succeeded().json();
    assert_ne!(other["held_out"]["lights"], report["held_out"]["lights"]);
}

#[test]
fn targets_are_met_or_reported() {
    let folder = stack();
    let made = |more: &[&str]| folder.run(&[&["pwt", "stack", "-o", "p.ktx2", "--json"][..], more].concat());
    let small = made(&["--max-bytes", "3KiB"]).succeeded().json();
    assert!(small["bytes_on_gpu"].as_u64().unwrap() <= 3072);
    let good = made(&["--quality", "33"]).succeeded().json();
    assert!(good["psnr"].as_f64().unwrap() >= 33.0);
    let seen = made(&["--max-delta-e", "2"]).succeeded().json();
    assert!(seen["delta_e"].as_f64().unwrap() <= 2.0);
    let energy = |share: &str| made(&["--energy", share]).succeeded().json()["bytes_on_gpu"].as_u64().unwrap();
    assert!(energy("90%") < energy("0.999"));
    let loss = |loss: &str| made(&["--loss", loss]).succeeded().json()["bytes_on_gpu"].as_u64().unwrap();
    assert!(loss("2") < loss("0.05"));
    let missed = made(&["--quality", "90"]);
    assert_eq!(missed.code, 1, "{missed:?}");
    assert!(
        missed.stderr.contains("--quality: found ") && missed.stderr.contains("expected at least 90 dB"),
        "{missed:?}"
    );
    assert_eq!(missed.json()["met"], false);
    assert!(PwtPack::from_bytes(&folder.read("p.ktx2")).is_ok());
    let missed = made(&["--max-bytes", "1"]);
    let smallest = PwtPack::from_bytes(&folder.read("p.ktx2")).unwrap().gpu_bytes();
    assert_eq!((missed.code, &missed.json()["bytes_on_gpu"]), (1, &smallest.into()), "{missed:?}");
    assert!(smallest < 3072 && missed.stderr.contains(&format!("--max-bytes: found {smallest} bytes")), "{missed:?}");
}

#[test]
fn photographs_of_one_light_do_not_predict_each_other() {
    let folder = stack();
    let list = String::from_utf8(folder.read("stack/dirs.lp")).unwrap();
    let lines: Vec<&str> = list.lines().skip(1).collect();
    for line in &lines {
        let image = line.split(' ').next().unwrap();
        folder.write(&format!("stack/copy_{image}"), folder.read(&format!("stack/{image}")));
    }
    let copies = lines.iter().map(|line| format!("copy_{line}\n")).collect::<String>();
    folder.write("stack/twice.lp", format!("{}\n{}\n{copies}", 2 * lines.len(), lines.join("\n")));
    for more in [&[][..], &["--hold-out", "5"]] {
        let once = folder.run(&[&["pwt", "stack/dirs.lp", "-o", "once.ktx2", "--json"][..], more].concat()).succeeded();
        let twice =
            folder.run(&[&["pwt", "stack/twice.lp", "-o", "twice.ktx2", "--json"][..], more].concat()).succeeded();
        assert!(twice.stderr.contains("80 photographs of 40 lights"), "{twice:?}");
        let unseen =
            |report: &serde_json::Value| [&report["left_out_psnr"], &report["held_out"]["psnr"]].map(|v| v.as_f64());
        assert_eq!(unseen(&once.json()), unseen(&twice.json()));
        assert_eq!(folder.read("once.ktx2"), folder.read("twice.ktx2"));
    }
}

#[test]
fn limits_hold_at_lights_that_were_held_out() {
    let folder = stack();
    // Many learned terms are far closer at the fitted lights.
    let arguments = ["pwt", "stack", "-o", "p.ktx2", "--hold-out", "10", "--terms", "learned", "--quality"];
    let report = folder.run(&[&arguments[..], &["90", "--json"]].concat()).json();
    let (fitted, unseen) = (report["psnr"].as_f64().unwrap(), report["held_out"]["psnr"].as_f64().unwrap());
    assert!(unseen < fitted - 3.0, "{unseen} {fitted}");
    let asked = format!("{:.3}", 0.5 * (unseen + fitted));
    let missed = folder.run(&[&arguments[..], &[&asked]].concat());
    assert_eq!(missed.code, 1, "{missed:?}");
    assert!(missed.stderr.contains("at held-out lights, expected at least"), "{missed:?}");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = stack();
    let bytes = ["1", "3"].map(|jobs| {
        folder.run(&["pwt", "stack", "-o", "p.ktx2", "--jobs", jobs]).succeeded();
        folder.read("p.ktx2")
    });
    assert!(bytes[0] == bytes[1]);
}

#[test]
fn what_is_asked_for_is_taken() {
    let folder = stack();
    let options = ["--terms", "paraboloid", "--degree", "3", "--domain", "cube-root", "--ridge", "1e-5"];
    let more = ["--wavelet", "cdf97", "--levels", "3", "--packets", "0", "--tile"];
    // Sides of a tile are halved exactly.
    let refused = folder.run(&[&["pwt", "stack", "-o", "p.ktx2"][..], &options, &more].concat());
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(refused.stderr.contains("--levels: found 3, expected 0 to 0 for 45 x 38"), "{refused:?}");
    let note = "note: stack: a tile of 45 x 38 pixels has no levels, because its sides are not both even\n";
    for (levels, has_note) in [(&[][..], true), (&["--levels", "0"], false)] {
        let ran = folder.run(&[&["pwt", "stack", "-o", "p.ktx2", "--tile"][..], &options, levels].concat()).succeeded();
        assert_eq!(ran.stderr.contains(note), has_note, "{levels:?}: {}", ran.stderr);
    }
    let report = folder.run(&[&["pwt", "stack", "-o", "p.ktx2", "--json"][..], &options, &more[..6]].concat());
    let report = report.succeeded().json();
    assert_eq!((&report["coordinates"], &report["degree"]), (&"paraboloid".into(), &3.into()));
    assert_eq!((&report["domain"], &report["ridge"]), (&"cube-root".into(), &1e-5.into()));
    assert_eq!(report["levels"].as_array().unwrap().len(), 4);
}

#[test]
fn packs_are_compared_and_evaluated() {
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    let info = folder.run(&["info", "p.ktx2"]).succeeded().stdout;
    assert!(
        info.contains(" dB at lights outside the fit, estimated by cross-validation before pruning and rounding\n")
    );
    let report = folder.run(&["compare", "stack", "p.ktx2", "--json"]).succeeded().json();
    conforms("compare", &report);
    assert_eq!(report["photographs"].as_array().unwrap().len(), 40);
    assert!(report["psnr"].as_f64().unwrap() > 25.0, "{report}");
    let same = folder.run(&["compare", "stack", "stack", "--json"]).succeeded().json();
    assert_eq!(same["delta_e"], 0.0);
    let missed = folder.run(&["compare", "stack", "p.ktx2", "--max-delta-e", "0.01"]);
    assert_eq!(missed.code, 1, "{missed:?}");
    folder.write("texels.csv", "name,u,v,wi_x,wi_y,wi_z,r\nmiddle,0.5,0.5,0,0,1,9\nbelow,0.5,0.5,0,0.6,-0.8,9\n");
    let values = folder.run(&["eval", "p.ktx2", "--directions", "texels.csv"]).succeeded().stdout;
    let lines: Vec<&str> = values.lines().collect();
    assert_eq!(lines[0], "name,u,v,wi_x,wi_y,wi_z,r,g,b");
    assert!(lines[1].starts_with("middle,0.5,0.5,0,0,1,0.") && lines[2].ends_with(",0,0,0"), "{values}");
    let coarse = folder.run(&["eval", "p.ktx2", "--directions", "texels.csv", "--lod", "0"]).succeeded().stdout;
    assert_ne!(coarse, values);
    // Only tiles have values outside the image.
    folder.write("outside.csv", "u,v,wi_x,wi_y,wi_z\n1.5,0.5,0,0,1\n");
    let ran = folder.run(&["eval", "p.ktx2", "--directions", "outside.csv"]);
    let message = "outside.csv: line 2, u: found 1.5, expected 0 to 1: the image does not repeat\n";
    assert!(ran.code == 3 && ran.stderr.ends_with(message), "{ran:?}");
    folder.run(&["pwt", "stack", "-o", "tile.ktx2", "--tile"]).succeeded();
    folder.run(&["eval", "tile.ktx2", "--directions", "outside.csv"]).succeeded();
}

#[test]
fn views_of_btfs_become_packs() {
    let folder = Folder::new();
    let small = ["--texels", "16", "--flat-texels", "16", "--views", "grid:2x3@40", "--lights", "grid:3x6@60"];
    let flat = ["flatten", "synth:folds", "-o", "folds", "--reflectance", "factors", "--write-images", "images"];
    folder.run(&[&flat[..], &small].concat()).succeeded();
    for input in ["folds", "images"] {
        let first = folder.run(&["pwt", input, "-o", "v.ktx2", "--json"]).succeeded().json();
        let other = folder.run(&["pwt", input, "-o", "w.ktx2", "--view", "3", "--json"]).succeeded().json();
        assert_eq!((&first["lights"], &first["size"]), (&13.into(), &serde_json::json!([16, 16])));
        assert_ne!(first["psnr"], other["psnr"]);
        let refused = folder.run(&["pwt", input, "-o", "v.ktx2", "--view", "4"]);
        assert_eq!(refused.code, 2, "{refused:?}");
        assert!(refused.stderr.contains("--view: found 4, expected 0 to 3"), "{refused:?}");
    }
    let list = "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0.5,0.5,0,0,1,0,0,1\n";
    folder.write("texels.csv", list);
    let values = folder.run(&["eval", "folds", "--directions", "texels.csv"]).succeeded().stdout;
    assert!(values.lines().nth(1).is_some_and(|line| !line.ends_with(",0,0,0")), "{values}");
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = stack();
    folder.write("paint.brdf", "0 0 0 0 1");
    folder.run(&["encode", "synth:lewis", "-o", "lewis.ktx2"]).succeeded();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    folder.write("unlisted/IMG_1.png", folder.read("stack/0000.png"));
    for name in ["folder.ktx2", "empty"] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
    }
    for (code, arguments, expected) in [
        (2, &["stack", "-o", "x.png"][..], "x.png"),
        (2, &["stack", "-o", "x.ktx2", "--quality", "-1"], "--quality: found -1, expected 0 to 200"),
        (2, &["stack", "-o", "x.ktx2", "--quality", "30", "--max-bytes", "4"], "cannot be used with"),
        (
            2,
            &["stack", "-o", "x.ktx2", "--degree", "6"],
            "--degree: found 6, expected 0 to 5, or up to 35 with --terms learned",
        ),
        (
            2,
            &["stack", "-o", "x.ktx2", "--degree", "36", "--terms", "learned"],
            "--degree: found 36, expected 1 to 35\n",
        ),
        (
            2,
            &["stack", "-o", "x.ktx2", "--ridge", "1", "--terms", "learned"],
            "--ridge: does not apply to --terms learned, only to polynomials",
        ),
        (2, &["stack", "-o", "x.ktx2", "--hold-out", "40"], "--hold-out: found 40, expected 0 to 39"),
        (2, &["stack", "-o", "x.ktx2", "--view", "1"], "--view does not apply to an RTI capture, only to BTFs"),
        (2, &["stack", "-o", "x.ktx2", "--model", "rgb"], "--model does not apply to a pack, only to an output .ptm"),
        (2, &["p.ktx2", "-o", "x.ktx2"], "p.ktx2: already a pack; choose an --output that ends in .ptm"),
        (
            2,
            &["stack", "-o", "x.foo"],
            "--output: found x.foo, expected a name that ends in .ktx2 or .ptm, or - for stdout",
        ),
        (2, &["stack", "-o", "x.ktx2", "--levels", "7"], "--levels: found 7, expected 0 to 5 for 45 x 38"),
        (3, &["folder.ktx2", "-o", "x.ktx2"], "folder.ktx2: input: found a folder, expected a folder with a list"),
        (3, &["empty", "-o", "x.ktx2"], "empty: input: found a folder, expected a folder with a list of lights"),
        (3, &["unlisted", "-o", "x.ktx2"], "with angles in degrees; an RTI capture requires a list of lights (.lp)"),
        (3, &["lewis.ktx2", "-o", "x.ptm"], "pack: found a table pack, expected a polynomial wavelet tree"),
        (
            3,
            &["paint.brdf", "-o", "x.ktx2"],
            "paint.brdf: input: found a scan, expected a folder with a list of lights",
        ),
        (4, &["nothing", "-o", "x.ktx2"], "nothing: cannot read"),
    ] {
        let ran = folder.run(&[&["pwt"][..], arguments].concat());
        assert_eq!(ran.code, code, "{arguments:?}: {ran:?}");
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
        assert!(!folder.path().join("x.ktx2").exists() && !folder.path().join("x.ptm").exists());
    }
    let ran = folder.run(&["compare", "lewis.ktx2", "lewis.ktx2", "--max-delta-e", "1"]);
    assert_eq!(ran.code, 2, "{ran:?}");
    let order = "; for relightable images, A is the folder of photographs and B the pack, .ptm or .rti\n";
    for (a, b, has_hint) in [
        ("p.ktx2", "stack", true),
        ("p.ktx2", "p.ktx2", true),
        ("lewis.ktx2", "p.ktx2", true),
        ("lewis.ktx2", "stack", true),
        ("lewis.ktx2", "paint.brdf", false),
    ] {
        let ran = folder.run(&["compare", a, b]);
        assert!(ran.code == 3 && ran.stderr.ends_with(order) == has_hint, "{a} {b}: {ran:?}");
    }
}

#[test]
fn few_and_poor_lights_have_a_pack() {
    let folder = stack();
    let list = std::fs::read_to_string(folder.path().join("stack/dirs.lp")).unwrap();
    let rows: Vec<&str> = list.lines().skip(1).collect();
    let names: Vec<&str> = rows.iter().filter_map(|row| row.split_whitespace().next()).collect();
    for (name, lines) in [
        ("one", vec![rows[0].to_owned()]),
        ("three", rows[..3].iter().map(|row| (*row).to_owned()).collect()),
        ("equal", names[..9].iter().map(|name| format!("{name} 0 0 1")).collect()),
        ("line", names[..9].iter().enumerate().map(|(k, name)| format!("{name} {} 0 1", 0.2 * k as f64)).collect()),
    ] {
        folder.write(&format!("stack/{name}.lp"), format!("{}\n{}\n", lines.len(), lines.join("\n")));
        let ran = folder.run(&["pwt", &format!("stack/{name}.lp"), "-o", "p.ktx2", "--json"]).succeeded();
        let report = ran.json();
        assert_eq!(ran.stderr.contains("9 photographs of 1 light: "), name == "equal", "{}", ran.stderr);
        // Photographs of one light are averaged.
        let lights = if name == "equal" { 1 } else { lines.len() };
        assert_eq!(report["lights"], lights, "{name}");
        conforms("pwt", &report);
        assert_eq!(report["left_out_psnr"].is_null(), lights == 1, "{report}");
        assert!(
            report["condition"].as_f64().is_none_or(|condition| condition >= 1.0)
                && report["psnr"].as_f64().unwrap() > 10.0,
            "{report}"
        );
    }
}

/// Renderings of an ordinary BTF, of the flat one, its pack and its look-ups have one upper half.
#[test]
fn rows_of_flat_btfs_go_down() {
    let folder = Folder::new();
    let image = image::RgbImage::from_fn(16, 16, |_, row| image::Rgb(if row < 8 { [255, 0, 0] } else { [0, 255, 0] }));
    image.save(folder.path().join("colour.png")).unwrap();
    image::GrayImage::from_pixel(16, 16, image::Luma([128])).save(folder.path().join("heights.png")).unwrap();
    let surface =
        ["flatten", "heights.png", "--colour", "colour.png", "--material", "synth:lambert?kd=1", "-o", "flat"];
    let small = ["--texels", "16", "--flat-texels", "16", "--views", "grid:2x3@40", "--lights", "grid:3x6@60"];
    let factors = ["--reflectance", "factors", "--write-images", "images"];
    folder.run(&[&surface[..], &small, &factors].concat()).succeeded();
    for input in ["flat", "images"] {
        folder.run(&["pwt", input, "-o", &format!("{input}.ktx2"), "--quality", "30"]).succeeded();
    }
    folder.write(
        "places.csv",
        "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z
0.5,0.25,0,0,1,0,0,1
0.5,0.75,0,0,1,0,0,1
",
    );
    for asked in ["images.ktx2", "flat.ktx2", "flat"] {
        let table = folder.run(&["eval", asked, "--directions", "places.csv"]).succeeded().stdout;
        let mut lines = table.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let column = |name: &str| names.iter().position(|found| *found == name).unwrap();
        let is_red = |line: &str| {
            let number = |name: &str| line.split(',').nth(column(name)).unwrap().parse::<f32>().unwrap();
            number("r") > 2.0 * number("g")
        };
        assert_eq!(lines.map(is_red).collect::<Vec<_>>(), [true, false], "{asked}: {table}");
    }
}

/// Each file of a multi-file input is protected like a single input.
#[test]
fn photographs_are_not_written_over() {
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    let list = std::fs::read_to_string(folder.path().join("stack/dirs.lp")).unwrap();
    let name = list.lines().nth(1).unwrap().split_whitespace().next().unwrap().to_owned();
    let photograph = format!("stack/{name}");
    let before = folder.read(&photograph);
    std::fs::copy(folder.path().join(&photograph), folder.path().join("stack/packed.ktx2")).unwrap();
    folder.write("stack/packed.lp", "1\npacked.ktx2 0 0 1\n");
    std::fs::create_dir(folder.path().join("other")).unwrap();
    let refused = |arguments: &[&str], message: &str| {
        let ran = folder.run(arguments);
        assert_eq!(ran.code, 2, "{arguments:?}: {ran:?}");
        assert!(ran.stderr.contains(message), "{arguments:?}: {}", ran.stderr);
    };
    let over = "--output: would overwrite the input stack/packed.ktx2";
    refused(&["pwt", "stack/packed.lp", "-o", "stack/packed.ktx2"], over);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path().join(&photograph), folder.path().join("link.ktx2")).unwrap();
        refused(&["pwt", "stack/dirs.lp", "-o", "link.ktx2"], "--output: would overwrite the input link.ktx2");
    }
    #[cfg(feature = "render")]
    {
        let message = format!("--output: would overwrite the input {photograph}");
        refused(&["render", "p.ktx2", "--source", "stack/dirs.lp", "-o", &photograph], &message);
        let message = format!("--reference: would overwrite the input {photograph}");
        refused(
            &["render", "p.ktx2", "--source", "stack/dirs.lp", "-o", "x.png", "--reference", &photograph],
            &message,
        );
    }
    assert!(folder.read(&photograph) == before);
    // Files that are not photographs of the list may be overwritten.
    folder.write("stack/own.ktx2", "");
    folder.run(&["pwt", "stack/dirs.lp", "-o", "stack/own.ktx2"]).succeeded();
}

/// A flat BTF's folder may contain renderings of it, only factors have views, and a damaged file is reported as one.
#[test]
fn folders_of_flat_btfs() {
    let folder = Folder::new();
    let small = ["--texels", "16", "--flat-texels", "16", "--views", "grid:2x3@40", "--lights", "grid:2x3@60"];
    for (name, form) in [("folds", "factors"), ("brdf", "brdf")] {
        let flat = ["flatten", "synth:folds", "-o", name, "--reflectance", form];
        folder.run(&[&flat[..], &small].concat()).succeeded();
    }
    image::GrayImage::new(4, 4).save(folder.path().join("folds/drawn.png")).unwrap();
    folder.run(&["pwt", "folds", "-o", "v.ktx2"]).succeeded();
    folder.write("places.csv", "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0.5,0.25,0,0,1,0,0,1\n");
    for arguments in [&["pwt", "brdf", "-o", "w.ktx2"][..], &["pwt", "brdf", "-o", "w.ktx2", "--view", "1"]] {
        let ran = folder.run(arguments);
        assert_eq!(ran.code, 3, "{arguments:?}: {ran:?}");
        let expected = "brdf: flat BTF: no sampled views; expected a flat BTF made with --reflectance factors";
        assert!(ran.stderr.contains(expected), "{}", ran.stderr);
        assert!(!folder.path().join("w.ktx2").exists());
    }
    // Values at any directions do not need them.
    for name in ["folds", "brdf"] {
        let values = folder.run(&["eval", name, "--directions", "places.csv"]).succeeded().stdout;
        assert!(values.lines().nth(1).is_some_and(|line| !line.ends_with(",0,0,0")), "{name}: {values}");
    }
    let file = folder.read("folds/folds.ktx2");
    folder.write("folds/folds.ktx2", &file[..file.len() / 2]);
    let ran = folder.run(&["eval", "folds", "--directions", "places.csv"]);
    assert_eq!(ran.code, 3, "{ran:?}");
    assert!(ran.stderr.contains("folds/folds.ktx2: "), "{}", ran.stderr);
}

/// The pack on stdin is the one in a file.
#[test]
fn packs_are_evaluated_from_stdin() {
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    folder.write("places.csv", "u,v,wi_x,wi_y,wi_z\n0.5,0.25,0,0,1\n");
    let file = folder.run(&["eval", "p.ktx2", "--directions", "places.csv"]).succeeded().stdout;
    let mut command = folder.command(&["eval", "-", "--directions", "places.csv"]);
    let piped = command.write_stdin(folder.read("p.ktx2")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&piped.stdout), file);
}
